"""Calls that block a thread or a signal handler, without a lock and without an event loop."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from aioduco._wire.handoff import BlockingCall
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.worker import AbandonOutcome, hung
from aioduco.errors import ConnectError, ConnectionLost

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection_factory import ConnectionFactory
    from aioduco._wire.idl import Function
    from aioduco._wire.worker import Worker
    from aioduco._wire.worker_pool import WorkerPool

#: seconds after which a stop is sent on a second connection as well
_SECOND_STOP_AFTER: Final = 0.1


class BlockingCalls:
    """The blocking calls of one lane.

    A call takes a connection of the lane if one is free. Otherwise it opens a connection of its
    own, so it never waits behind another call.

    Args:
        pool: the lane's threads.
        connections: factory that makes a connection for one call.

    Attributes:
        released: callback that a worker's thread calls when it is free again.
    """

    def __init__(self, pool: WorkerPool[Worker, Any], connections: ConnectionFactory) -> None:
        self._pool = pool
        self._connections = connections
        self.released: Callable[[], None] = _no_waiter

    def call(self, function: Function, arguments: bytes, deadline: float | None) -> Any:
        """Call a function of the wire and block until its answer has arrived.

        Args:
            function: the function.
            arguments: its encoded arguments.
            deadline: time of `time.monotonic()` by which the answer must have arrived, or None.
        """
        call = BlockingCall(function, arguments, deadline, self.released)
        workers = tuple(self._pool.workers)
        try:
            for worker in workers:
                if worker.claim(call):
                    break
            else:
                return self._on_own_connection(function, arguments, deadline)
            try:
                worker.start()
            except RuntimeError:
                # the system has no more threads
                worker.recover(call)
                return self._on_own_connection(function, arguments, deadline)
            worker.submit(call)
            if call_kind(function.name) is CallKind.STOP:
                return self._stop_with_fallback(call, function)
            answered = call.wait()
        except BaseException:  # also what a signal handler raises, between any two steps
            for worker in workers:
                worker.recover(call)
                if call_kind(function.name) is not CallKind.STOP:
                    worker.abandon(call, "the call was interrupted")
            raise
        if not answered:
            raise hung(function.name, worker.abandon(call, "its thread hangs"))
        return call.outcome()

    def _stop_with_fallback(self, call: BlockingCall, function: Function) -> Any:
        """Wait for a stop that is under way. If it hangs, send a second stop."""
        if call.wait(_SECOND_STOP_AFTER):
            return call.outcome()
        try:
            return self._on_own_connection(function, call.arguments, call.deadline)
        except (ConnectError, ConnectionLost):
            if call.wait():
                return call.outcome()
            raise hung(function.name, AbandonOutcome.UNKNOWN) from None

    def _on_own_connection(
        self, function: Function, arguments: bytes, deadline: float | None
    ) -> Any:
        """Call on a new connection that the calling thread opens and closes."""
        connection = self._connections.make()
        try:
            connection.open(deadline)
            return connection.exchange(function, arguments, deadline)
        finally:
            connection.close()


def _no_waiter() -> None:
    """Do nothing: before the lane is open, no call waits."""
