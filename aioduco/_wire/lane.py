"""A lane: connections on their own threads, awaited from the event loop."""

from __future__ import annotations

import enum
import math
import time
import warnings
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import anyio
from anyio import current_effective_deadline
from anyio.lowlevel import checkpoint_if_cancelled

from aioduco._wire import codec, idl
from aioduco._wire.blocking import BlockingCalls
from aioduco._wire.connection_factory import ConnectionFactory
from aioduco._wire.handoff import (
    AwaitedCall,
    Deadlines,
    OwnerLoop,
    ThreadEnd,
    loop_callback,
)
from aioduco._wire.rpc import AsyncRpc
from aioduco._wire.worker import AbandonOutcome, Worker, hung
from aioduco._wire.worker_pool import WorkerPool
from aioduco.errors import ConnectError, ConnectionLost, NotSent, UnknownFunction
from aioduco.trace import CallFinished, emit, tell

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from aioduco._wire.host import Route
    from aioduco.trace import Trace

#: seconds that `aclose` waits for threads; each ends at once unless it hangs in the system
_CLOSE_LIMIT: Final = 1.0

#: maximum number of dismissed threads per connection that have not ended, since they may hang
_DISMISSED_LIMIT: Final = 4


class _Default(enum.Enum):
    """Default of a time limit, for parameters where None already means no limit."""

    LIMIT = "the lane's limit"


class LaneState(enum.Enum):
    """State of a lane."""

    NEW = "new"
    OPEN = "open"
    CLOSED = "closed"


class LaneStatistics(NamedTuple):
    """Figures of one lane.

    Attributes:
        calls: number of calls that were started.
        failed: number of calls that raised `ConnectionLost`, `ConnectError` or a subclass of them.
        waiting: number of calls that now wait for a connection.
        busy: number of calls that a thread now carries out.
        workers: number of threads, each with at most one connection.
        opened: number of connections that were opened.
        abandoned: number of calls that were cancelled or abandoned while they were under way.
        stuck: number of threads whose call was abandoned more than a second ago and that have not
            ended: they hang in the operating system, for instance in the resolution of a name.
    """

    calls: int
    failed: int
    waiting: int
    busy: int
    workers: int
    opened: int
    abandoned: int
    stuck: int


#: function that returns the coroutine that awaits the answer to a started call; to be called once;
#: the coroutine raises the errors of `WireLane.call`
BegunCall: TypeAlias = "Callable[[], Coroutine[Any, Any, Any]]"


class WireLane:
    """Connections to the controller for one purpose, never shared with another.

    A call that is cancelled, or times out, closes its connection at once, and the next call opens a
    new one. So an answer can only reach its own call. No await lasts more than half a second beyond
    its deadline, even if its thread hangs.

    Args:
        name: purpose of the lane; the names of its threads contain it.
        host: name or address of the controller.
        port: its TCP port.
        size: maximum number of connections. With one, calls wait for each other, in order.
        connect_timeout: seconds within which a connection must be opened.
        call_timeout: default time limit of a call [s], which includes the wait for a connection.
        trace: hook that gets an event for each call and each connection.
        owner_loop: owner loop that the lane shares with other lanes. By default the lane has its
            own: the loop on which it is opened, or, after that was closed, the next loop that
            uses the lane.
        route: the way to the host, which the lane shares with others; by default it has its own.

    Attributes:
        version: version of the controller's software, for errors; empty while it is unknown.
        observers: callbacks of this package, called with each finished call, on the thread that
            made it. They must neither raise nor wait; a program's hook may do both.
    """

    def __init__(
        self,
        name: str,
        host: str,
        port: int,
        *,
        size: int = 1,
        connect_timeout: float = 3.0,
        call_timeout: float = 2.0,
        trace: Trace | None = None,
        owner_loop: OwnerLoop | None = None,
        route: Route | None = None,
    ) -> None:
        self.name = name
        self.host = host
        self.port = port
        self.call_timeout = call_timeout
        self.rpc: AsyncRpc = AsyncRpc(self.call)
        self.version: str = ""
        self.observers: list[Trace] = []
        self._trace = trace
        self._state = LaneState.NEW
        self._functions = idl.functions()
        self._connections = ConnectionFactory(name, host, port, connect_timeout, trace, route)
        self._pool: WorkerPool[Worker, AwaitedCall] = WorkerPool(size, self._connections.worker)
        self._blocking = BlockingCalls(self._pool, self._connections)
        self.owner_loop: OwnerLoop = OwnerLoop() if owner_loop is None else owner_loop
        self._deadlines = Deadlines(self._expired)
        self._dismissed: list[Worker] = []
        self._calls = 0
        self._failed = 0
        self._abandoned = 0

    @property
    def state(self) -> LaneState:
        """State of the lane."""
        return self._state

    def statistics(self) -> LaneStatistics:
        """Figures since the lane was made."""
        workers = self._pool.workers
        return LaneStatistics(
            calls=self._calls,
            failed=self._failed,
            waiting=self._pool.waiting,
            busy=sum(worker.busy for worker in workers),
            workers=len(workers),
            opened=self._connections.count,
            abandoned=self._abandoned,
            stuck=sum(worker.stuck for worker in self._dismissed),
        )

    def __repr__(self) -> str:
        figures = self.statistics()
        return (
            f"<Lane {self.name} {self.host}:{self.port} {self._state.name}, "
            f"{figures.busy} of {self._pool.size} busy, {figures.waiting} waiting>"
        )

    def __del__(self) -> None:
        if getattr(self, "_state", None) is LaneState.OPEN and not self.owner_loop.in_forked_child:
            unclosed = f"unclosed {self!r}"
            for worker in self._pool.workers:
                worker.abandon(None, "the lane was forgotten")
                worker.dismiss()
            # last, since it raises if warnings are turned into errors
            warnings.warn(unclosed, ResourceWarning, source=self, stacklevel=2)

    async def open(self) -> None:
        """Open the first connection; the others open when calls need them.

        Raises:
            ConnectError: there is no controller, or it does not answer in time.
        """
        if self._state is not LaneState.NEW:
            raise RuntimeError(f"{self!r} can be opened once")
        self.owner_loop.require("open")
        self._state = LaneState.OPEN
        self._blocking.released = loop_callback(self._dispatch)
        deadline = time.monotonic() + self._connections.connect_timeout
        try:
            await self._carry_out(AwaitedCall(self.owner_loop, None, b"", deadline, self._finished))
        except BaseException as exc:
            await self.aclose()
            if isinstance(exc, TimeoutError):
                raise ConnectError(self.host, self.port, "no answer in time") from exc
            raise

    async def aclose(self) -> None:
        """Close every connection and end every thread. Calls under way fail."""
        if self._state is LaneState.CLOSED:
            return
        self._state = LaneState.CLOSED
        for call in self._pool.drain():
            call.fail(ConnectionLost(f"{call.name} was not sent, since its lane was closed"))
        workers = [*self._pool.workers, *self._dismissed]
        for worker in workers:
            worker.abandon(None, "its lane was closed")
        ends = [ThreadEnd() for _ in workers]
        for worker, end in zip(workers, ends, strict=True):
            worker.dismiss(end.report)
        with anyio.move_on_after(_CLOSE_LIMIT, shield=True):
            for end in ends:
                await end.wait()
        for worker, end in zip(workers, ends, strict=True):
            # a thread that reported its end waits for nothing any more, so this returns at once
            if end.reported:
                worker.join(_CLOSE_LIMIT)
        for call in self._deadlines.calls:
            # its thread hangs; when it continues, it finds that the connection was abandoned
            call.fail(hung(call.name, AbandonOutcome.UNKNOWN))
        self._deadlines.stop()

    def within(self, timeout: float | None) -> AsyncRpc:
        """The functions of the wire with another time limit.

        Args:
            timeout: time limit of a call [s]; None: no limit, for functions that block.
        """
        return AsyncRpc(lambda name, args: self.call(name, args, timeout))

    async def call(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | _Default | None = _Default.LIMIT,
        begun: Callable[[AwaitedCall], object] | None = None,
        permit: Callable[[], object] | None = None,
    ) -> Any:
        """Call a function of the wire and wait for its answer.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: time limit of the whole call [s]; None: no limit. By default the lane's limit.
            begun: callback that gets the call before a thread does, to observe its progress.
            permit: called last, before the first byte is sent, on the thread that sends it. What
                it raises is raised here: nothing was sent.

        Returns:
            The result; None for a function without one.

        Raises:
            ParameterError: a value cannot be sent.
            ControllerError: the controller answered with an error.
            ConnectError: no connection could be made; nothing was sent.
            NotSent: the deadline passed before anything was sent.
            ConnectionLost: nothing was sent, or a function that only reads was not answered.
            OutcomeUnknown: a command was sent and not answered.
            WrongLoop: the lane belongs to another event loop; nothing was sent.
            WrongProcess: the lane belongs to the process that forked this one; nothing was sent.
        """
        function = self._functions[name]
        # Encode first. A value that cannot be sent then costs no connection, and a value that the
        # caller changes later is sent unchanged.
        encoded = codec.encode(function, args)
        if self._state is not LaneState.OPEN:
            raise ConnectionLost(f"{name} was not sent, since {self!r} is not open")
        seconds = self.call_timeout if timeout is _Default.LIMIT else timeout
        begin = time.monotonic()
        deadline = None if seconds is None else begin + seconds
        call = AwaitedCall(self.owner_loop, function, encoded, deadline, self._finished)
        call.permit = permit
        # A task whose scope is already cancelled must send nothing. From here to the thread there
        # is no other checkpoint that would detect this.
        if current_effective_deadline() == -math.inf:
            await checkpoint_if_cancelled()
        self._calls += 1
        if begun is not None:
            begun(call)
        if self._trace is None and not self.observers:
            return await self._carry_out(call)
        return await self._reported(name, args, begin, self._carry_out(call))

    def begin(self, name: str, args: tuple[Any, ...], timeout: float) -> BegunCall:
        """Send a call before any other code of the event loop runs.

        If a connection is free, the call has been sent when this returns.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: time limit of the whole call [s].

        Returns:
            The started call, whose answer must be awaited.

        Raises:
            ParameterError: a value cannot be sent.
            ConnectionLost: the lane is not open; nothing was sent.
            WrongLoop: the lane belongs to another event loop; nothing was sent.
            WrongProcess: the lane belongs to the process that forked this one; nothing was sent.
        """
        function = self._functions[name]
        encoded = codec.encode(function, args)
        if self._state is not LaneState.OPEN:
            raise ConnectionLost(f"{name} was not sent, since {self!r} is not open")
        begin = time.monotonic()
        call = AwaitedCall(self.owner_loop, function, encoded, begin + timeout, self._finished)
        self._calls += 1
        self._hand_over(call)

        def answer() -> Coroutine[Any, Any, Any]:
            return self._reported(name, args, begin, self._carry_out(call, handed_over=True))

        return answer

    async def _reported(
        self, name: str, args: tuple[Any, ...], begin: float, rest: Coroutine[Any, Any, Any]
    ) -> Any:
        value: Any = None
        error: BaseException | None = None
        try:
            value = await rest
        except BaseException as exc:
            error = exc
            raise
        finally:
            self.report(name, args, value, error, begin)
        return value

    async def ask(self, *names: str) -> list[codec.ReadResult]:
        """Call functions that only read and have no parameters, in one batch on one connection.

        The calls are sent in one piece; the controller reads and answers them in their order, as
        it does the calls of any client. They need only one hand-over to the thread and back, and
        share the lane's time limit. If a connection that was already in use is lost before that
        time, all are sent once more on a new one.

        Args:
            names: the functions, at least two.

        Returns:
            Their answers; any of them may be the controller's error.

        Raises:
            The errors of `call`, except `ControllerError` and `OutcomeUnknown`.
        """
        questions = [
            (self._functions[name], codec.encode(self._functions[name], ())) for name in names
        ]
        if self._state is not LaneState.OPEN:
            raise ConnectionLost(f"{names[0]} was not sent, since {self!r} is not open")
        begin = time.monotonic()
        (function, encoded), *further = questions
        call = AwaitedCall(
            self.owner_loop, function, encoded, begin + self.call_timeout, self._finished
        )
        call.further = further
        if current_effective_deadline() == -math.inf:
            await checkpoint_if_cancelled()  # as in `call`
        self._calls += len(names)
        try:
            answers: list[codec.ReadResult] = await self._carry_out(call)
        except BaseException as exc:
            self.report(names[0], (), None, exc, begin)
            raise
        for name, answer in zip(names, answers, strict=True):
            self.report(name, (), answer.value, answer.error, begin, answer.at)
            begin = answer.at
        return answers

    def report(
        self,
        name: str,
        args: tuple[Any, ...],
        value: Any,
        error: BaseException | None,
        begin: float,
        end: float | None = None,
    ) -> None:
        """Notify the hook and the observers of a finished call; from any thread."""
        if self._trace is None and not self.observers:
            return
        if end is None:
            end = time.monotonic()
        event = CallFinished(end, self.name, name, args, value, error, end - begin)
        if self._trace is not None:
            emit(self._trace, event)
        tell(self.observers, event)

    def _hand_over(self, call: AwaitedCall) -> None:
        """Send a call on a free connection, or queue it until one is free."""
        self._deadlines.add(call)
        worker = self._pool.take(call)
        if worker is not None:
            self._submit(worker, call)
        else:
            self._dispatch()

    async def _carry_out(self, call: AwaitedCall, *, handed_over: bool = False) -> Any:
        try:
            if not handed_over:
                self._hand_over(call)
            return await call
        except BaseException as exc:
            if not isinstance(exc, Exception) or not call.settled:
                # not its outcome: it was cancelled, or a signal handler raised this
                self._give_up(call)
            elif isinstance(exc, ConnectionLost | ConnectError):
                self._failed += 1 + len(call.further)
            elif isinstance(exc, UnknownFunction):
                raise exc.of(self.version) from None
            raise
        finally:
            self._deadlines.discard(call)
            call.release_error()

    def _give_up(self, call: AwaitedCall) -> None:
        """Remove every trace of a call whose waiting task was cancelled or interrupted."""
        call.cancel()
        self._withdraw(call)
        if call.worker is not None:
            self._drop(call.worker, call, "the call was cancelled")

    def _withdraw(self, call: AwaitedCall) -> None:
        """Withdraw a call that no thread has, also if an interrupt left it half submitted."""
        self._pool.forget(call)
        for worker in self._pool.workers:
            worker.recover(call)

    def _drop(self, worker: Worker, call: AwaitedCall, reason: str) -> AbandonOutcome:
        """Abandon a call that is under way, and dismiss its thread."""
        dropped = worker.abandon(call, reason)
        if dropped is AbandonOutcome.OVER:
            return dropped
        self._abandoned += 1 + len(call.further)
        # The next call gets a new thread at once, and need not wait until this one has noticed. But
        # if many threads hang, or the system has no more threads, this one is kept: calls wait for
        # it, or fail at their deadlines.
        self._dismissed = [leaving for leaving in self._dismissed if leaving.alive]
        if len(self._dismissed) < _DISMISSED_LIMIT * self._pool.size and self._replace(worker):
            self._dismissed.append(worker)
            worker.dismiss()
            self._dispatch()
        return dropped

    def _replace(self, worker: Worker) -> bool:
        """Replace a worker by a new one; return whether that was possible."""
        if worker not in self._pool.workers:
            return False
        other = self._connections.worker()
        try:
            other.start()
        except RuntimeError:
            return False
        self._pool.discard(worker)
        self._pool.workers.append(other)
        return True

    def _submit(self, worker: Worker, call: AwaitedCall) -> None:
        try:
            worker.start()
        except RuntimeError as exc:
            worker.recover(call)
            self._pool.discard(worker)
            lost = ConnectionLost(f"{call.name} was not sent: no thread for it ({exc})")
            lost.__cause__ = exc
            call.fail(lost)
            return
        worker.submit(call)

    def _dispatch(self) -> None:
        for worker, call in self._pool.assign():
            self._submit(worker, call)

    def _finished(self, call: AwaitedCall) -> None:
        """Handle a finished call. Its worker is already free, so it first gets the next call."""
        if self._pool.waiting:
            self._dispatch()
        call.settle()

    def _expired(self, call: AwaitedCall, second_time: bool) -> None:
        """Fail a call whose deadline has passed: no connection was free, or its thread is late."""
        worker = call.worker
        if worker is None:
            self._withdraw(call)
            call.fail(NotSent(f"{call.name} was not sent: no connection of {self!r} was free"))
        elif second_time and not call.settled:
            dropped = self._drop(worker, call, "its thread hangs")
            if dropped is AbandonOutcome.OVER:
                # the loop was too busy to handle its notification, or was interrupted meanwhile
                call.settle()
            else:
                call.fail(hung(call.name, dropped))

    def call_from_thread(self, name: str, args: tuple[Any, ...], timeout: float | None) -> Any:
        """Call a function of the wire and block until its answer has arrived.

        Any thread may call it, and a signal handler at any point of the program, since it waits for
        no lock and needs no event loop. It never waits behind another call: if every connection is
        in use, it opens another one for this call. If a `stop` is not answered within 0.1 s, it is
        also sent on another connection.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: time limit of the whole call [s]; None: no limit.

        Returns:
            The result; None for a function without one.

        Raises:
            The errors of `call`, except `WrongLoop`: any thread may use it, under any event loop.
        """
        function = self._functions[name]
        encoded = codec.encode(function, args)
        self.owner_loop.require_process(name)
        if self._state is not LaneState.OPEN:
            raise ConnectionLost(f"{name} was not sent, since {self!r} is not open")
        self._calls += 1
        begin = time.monotonic()
        deadline = None if timeout is None else begin + timeout
        value: Any = None
        error: BaseException | None = None
        try:
            value = self._blocking.call(function, encoded, deadline)
        except BaseException as exc:
            self._failed += isinstance(exc, ConnectionLost | ConnectError)
            error = exc
            raise
        finally:
            self.report(name, args, value, error, begin)
        return value
