"""A lane: connections on threads of their own, awaited from the event loop."""

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

    from aioduco.trace import Trace

#: seconds that `aclose` waits for threads; each comes back at once unless it hangs in the system
_CLOSE_LIMIT: Final = 1.0

#: threads per connection that may be on their way out at one time; they could hang in the system
_LEAVING_LIMIT: Final = 4


class _Default(enum.Enum):
    """The lane's own time limit, where None already means no limit."""

    LIMIT = "the lane's limit"


class LaneState(enum.Enum):
    """State of a lane."""

    NEW = "new"
    OPEN = "open"
    CLOSED = "closed"


class LaneStatistics(NamedTuple):
    """Figures of one lane.

    Attributes:
        calls: calls that were begun.
        failed: calls that raised, application errors of the controller not counted.
        waiting: calls that wait for a connection now.
        busy: calls that are with a thread now.
        workers: threads, each with at most one connection.
        opened: connections that were opened.
        abandoned: calls that were cancelled, or given up, while they were under way.
        stuck: threads that lost their call more than a second ago and have not ended: they hang
            in the operating system, for instance in the resolution of a name.
    """

    calls: int
    failed: int
    waiting: int
    busy: int
    workers: int
    opened: int
    abandoned: int
    stuck: int


#: awaits the answer of a call that was begun, once; raises the errors of `WireLane.call`
BegunCall: TypeAlias = "Callable[[], Coroutine[Any, Any, Any]]"


class WireLane:
    """Connections to the controller for one purpose, never shared with another.

    A call that is cancelled, or times out, loses its connection: the socket is closed at once,
    and the next call opens a new one. So an answer can only reach the call that it answers.
    No await outlives its deadline by more than half a second, even if its thread hangs.

    Args:
        name: what the lane is for; it names the threads.
        host: name or address of the controller.
        port: its TCP port.
        size: most connections. With one, calls wait for each other, in order.
        connect_timeout: most seconds that opening a connection takes.
        call_timeout: most seconds that a call takes if nothing else is said, the wait for a
            connection included.
        trace: a hook that sees each call and each connection.
        owner_loop: the event loop to which it belongs, if it shares that with others; else the one
            that it is opened on, or, when that has been closed, the next that uses it.

    Attributes:
        version: version of the controller's software, for errors; empty as long as it is not known.
        observers: called with each call that is over, on its thread: the package's own, which
            neither raise nor wait, as a program's hook may.
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
        self._connections = ConnectionFactory(name, host, port, connect_timeout, trace)
        self._pool: WorkerPool[Worker, AwaitedCall] = WorkerPool(size, self._connections.worker)
        self._blocking = BlockingCalls(self._pool, self._connections)
        self.owner_loop: OwnerLoop = OwnerLoop() if owner_loop is None else owner_loop
        self._deadlines = Deadlines(self._expired)
        self._leaving: list[Worker] = []
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
            stuck=sum(worker.stuck for worker in self._leaving),
        )

    def __repr__(self) -> str:
        figures = self.statistics()
        return (
            f"<Lane {self.name} {self.host}:{self.port} {self._state.name}, "
            f"{figures.busy} of {self._pool.size} busy, {figures.waiting} waiting>"
        )

    def __del__(self) -> None:
        if getattr(self, "_state", None) is LaneState.OPEN and not self.owner_loop.forked_off:
            unclosed = f"unclosed {self!r}"
            for worker in self._pool.workers:
                worker.abandon(None, "the lane was forgotten")
                worker.dismiss()
            # last: where warnings are errors, it raises
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
        workers = [*self._pool.workers, *self._leaving]
        for worker in workers:
            worker.abandon(None, "its lane was closed")
        ends = [ThreadEnd() for _ in workers]
        for worker, end in zip(workers, ends, strict=True):
            worker.dismiss(end.report)
        with anyio.move_on_after(_CLOSE_LIMIT, shield=True):
            for end in ends:
                await end.wait()
        for worker, end in zip(workers, ends, strict=True):
            # a thread that reported its end is past its last wait, so this takes no time
            if end.reported:
                worker.join(_CLOSE_LIMIT)
        for call in self._deadlines.calls:
            # its thread hangs, and will find the connection given up when it comes back
            call.fail(hung(call.name, AbandonOutcome.UNKNOWN))
        self._deadlines.stop()

    def within(self, timeout: float | None) -> AsyncRpc:
        """The functions of the wire with another time limit.

        Args:
            timeout: most seconds for a call; None: no limit, for functions that block.
        """
        return AsyncRpc(lambda name, args: self.call(name, args, timeout))

    async def call(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | _Default | None = _Default.LIMIT,
        begun: Callable[[AwaitedCall], object] | None = None,
    ) -> Any:
        """Call a function of the wire and wait for its answer.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: most seconds for the whole call; None: no limit. By default the lane's.
            begun: is given the call before it is handed to a thread, to see how far it comes.

        Returns:
            The result; None for a function without one.

        Raises:
            ParameterError: a value cannot be sent.
            ControllerError: the controller answered by an error.
            ConnectError: no connection could be made; nothing was sent.
            NotSent: the time was over before anything was sent.
            ConnectionLost: nothing was sent, or a function that only reads was not answered.
            OutcomeUnknown: a command was sent and its answer did not come.
            WrongLoop: the lane belongs to another event loop; nothing was sent.
            WrongProcess: the lane belongs to the process that forked this one; nothing was sent.
        """
        function = self._functions[name]
        # encoded before anything else: a value that cannot be sent costs no connection, and one
        # that the caller changes meanwhile is sent as it was
        encoded = codec.encode(function, args)
        if self._state is not LaneState.OPEN:
            raise ConnectionLost(f"{name} was not sent, since {self!r} is not open")
        seconds = self.call_timeout if timeout is _Default.LIMIT else timeout
        begin = time.monotonic()
        deadline = None if seconds is None else begin + seconds
        call = AwaitedCall(self.owner_loop, function, encoded, deadline, self._finished)
        # a task whose scope is cancelled already sends nothing: from here to the thread there is
        # no other point at which it would notice
        if current_effective_deadline() == -math.inf:
            await checkpoint_if_cancelled()
        self._calls += 1
        if begun is not None:
            begun(call)
        if self._trace is None and not self.observers:
            return await self._carry_out(call)
        return await self._reported(name, args, begin, self._carry_out(call))

    def begin(self, name: str, args: tuple[Any, ...], timeout: float) -> BegunCall:
        """Send a call before anything else of the event loop gets to run.

        It is sent when this returns, if a connection is free.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: most seconds for the whole call.

        Returns:
            The call, whose answer must be awaited.

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
        """Ask functions that only read and take nothing, all at once on one connection.

        They are sent in one piece; the controller reads and answers them in their order, as it
        does the calls of any client. They are one way to the thread and back, and have the lane's
        time limit together. If the connection is lost, all are asked again on another one.

        Args:
            names: the functions, two at least.

        Returns:
            Their answers, of which any may be the controller's error.

        Raises:
            The errors of `call`, but for `ControllerError` and `OutcomeUnknown`.
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
        """Tell the hook and the observers that a call is over; from any thread."""
        if self._trace is None and not self.observers:
            return
        if end is None:
            end = time.monotonic()
        event = CallFinished(end, self.name, name, args, value, error, end - begin)
        if self._trace is not None:
            emit(self._trace, event)
        tell(self.observers, event)

    def _hand_over(self, call: AwaitedCall) -> None:
        """Have a connection send it now, or as soon as one is free."""
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
            if isinstance(exc, ConnectionLost | ConnectError):
                self._failed += 1
            elif not isinstance(exc, Exception):
                self._give_up(call)
            elif isinstance(exc, UnknownFunction):
                raise exc.of(self.version) from None
            raise
        finally:
            self._deadlines.discard(call)
            call.over()

    def _give_up(self, call: AwaitedCall) -> None:
        """The task that waited was cancelled or interrupted: nothing of the call stays behind."""
        self._withdraw(call)
        if call.worker is not None:
            self._drop(call.worker, call, "the call was cancelled")

    def _withdraw(self, call: AwaitedCall) -> None:
        """Take back a call that no thread has, wherever an interrupt left it."""
        self._pool.forget(call)
        for worker in self._pool.workers:
            worker.recover(call)

    def _drop(self, worker: Worker, call: AwaitedCall, reason: str) -> AbandonOutcome:
        """Abandon a call that is under way, and the thread with it."""
        dropped = worker.abandon(call, reason)
        if dropped is AbandonOutcome.OVER:
            return dropped
        self._abandoned += 1
        # The next call gets a new thread at once, and need not wait for this one to notice. But
        # if many hang, or there are no more threads to be had, this one is kept: calls wait for
        # it, or fail at their deadlines.
        self._leaving = [leaving for leaving in self._leaving if leaving.alive]
        if len(self._leaving) < _LEAVING_LIMIT * self._pool.size and self._replace(worker):
            self._leaving.append(worker)
            worker.dismiss()
            self._dispatch()
        return dropped

    def _replace(self, worker: Worker) -> bool:
        """Put another thread in the place of one; whether there is one."""
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
            worker.submit(call)
        except RuntimeError as exc:
            worker.recover(call)
            self._pool.discard(worker)
            lost = ConnectionLost(f"{call.name} was not sent: no thread for it ({exc})")
            lost.__cause__ = exc
            call.fail(lost)

    def _dispatch(self) -> None:
        for worker, call in self._pool.assign():
            self._submit(worker, call)

    def _finished(self, call: AwaitedCall) -> None:
        """A thread is done with a call: its worker is free already, so it goes on first."""
        if self._pool.waiting:
            self._dispatch()
        call.settle()

    def _expired(self, call: AwaitedCall, again: bool) -> None:
        """The time of a call is over: it waits for a connection, or its thread is late with it."""
        worker = call.worker
        if worker is None:
            self._withdraw(call)
            call.fail(NotSent(f"{call.name} was not sent: no connection of {self!r} was free"))
        elif again and not call.refused:
            dropped = self._drop(worker, call, "its thread hangs")
            if dropped is AbandonOutcome.OVER:
                # the loop was too busy for its notice, or was interrupted while it took it
                call.settle()
            else:
                call.fail(hung(call.name, dropped))

    def call_from_thread(self, name: str, args: tuple[Any, ...], timeout: float | None) -> Any:
        """Call a function of the wire and block until its answer is there.

        It may be called from any thread, and from a signal handler in the middle of anything,
        since it waits for no lock and needs no event loop. It never waits behind another call:
        if every connection is taken, it opens one of its own for this call. A `stop` that is
        not answered within 0.1 s is sent on a connection of its own as well.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: most seconds for the whole call; None: no limit.

        Returns:
            The result; None for a function without one.

        Raises:
            The errors of `call`; but it is for any thread, and any event loop.
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
