"""A lane: connections to the controller for one purpose, awaited from the event loop."""

from __future__ import annotations

import asyncio
import math
import sys
import time
import warnings
import weakref
from collections import deque
from contextvars import copy_context
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

import anyio
from anyio import current_effective_deadline
from anyio.lowlevel import checkpoint_if_cancelled

from aioduco._process import trial
from aioduco._wire import codec, idl
from aioduco._wire.channel import Call, Channel, LaneCall, connect
from aioduco._wire.endpoint import Endpoint, Route
from aioduco._wire.forks import fork_hooks
from aioduco._wire.owner_loop import OwnerLoop
from aioduco._wire.pool import PoolThread, ThreadCalls
from aioduco._wire.rpc import AsyncRpc
from aioduco.errors import ConnectError, ConnectionLost, NotSent, UnknownFunction
from aioduco.models.host_port import host_port
from aioduco.models.trace import CallFinished, Trace, emit, tell

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import EllipsisType

    from aioduco._process.trial import Trial

_CLOSED: Final = "its lane was closed"

#: a function of the wire, and its arguments
Question: TypeAlias = tuple[str, tuple[Any, ...]]


class LaneStatistics(NamedTuple):
    """Figures of one lane.

    Attributes:
        calls: number of calls that were started.
        failed: number of calls that raised `ConnectionLost`, `ConnectError` or a subclass of them.
        waiting: number of calls that now wait for a connection.
        busy: number of connections that now carry a call.
        connections: number of connections that the lane uses, those included that it opens again
            when a call needs them.
        opened: number of connections that were opened.
        abandoned: number of calls that were cancelled while they were under way.
        stuck: 1 while the resolution of the host's name hangs in the operating system, else 0.
    """

    calls: int
    failed: int
    waiting: int
    busy: int
    connections: int
    opened: int
    abandoned: int
    stuck: int


class WireLane:
    """Connections to the controller for one purpose, never shared with another.

    The connections belong to the event loop: a call is sent by the task that makes it, and its
    answer is read by a callback of the loop. For calls that block at the controller, each
    connection belongs to a thread instead.

    A call that is cancelled, or times out, closes its connection at once, and the next call opens a
    new one. So an answer can only reach its own call. No call outlives its deadline.

    Args:
        name: purpose of the lane.
        host: name or address of the controller.
        port: its TCP port.
        size: maximum number of connections. With one, calls wait for each other, in order.
        connect_timeout: seconds within which a connection must be opened.
        call_timeout: default time limit of a call [s], which includes the wait for a connection.
        trace: hook that gets an event for each call and each connection.
        owner_loop: owner loop that the lane shares with other lanes. By default the lane has its
            own: the loop on which it is opened, or, after that was closed, the next loop that
            uses the lane.
        blocks: whether its calls block at the controller: each connection then has a thread, and
            is opened when a call needs it.
        spare: whether `open` also opens a connection for `call_from_thread`.
        route: the way to the host, which the lane shares with others; by default it has its own.

    Attributes:
        closed: whether it was closed.
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
        blocks: bool = False,
        spare: bool = False,
        route: Route | None = None,
    ) -> None:
        self.name = name
        self.host = host
        self.port = port
        self.size = size
        self.call_timeout = call_timeout
        self.rpc: AsyncRpc = AsyncRpc(self.call)
        self.version: str = ""
        self.observers: list[Trace] = []
        self.owner_loop: OwnerLoop = OwnerLoop() if owner_loop is None else owner_loop
        self._trace = trace
        self._open = False
        self.closed: bool = False
        self._functions = idl.functions()
        self._endpoint = Endpoint(host, port, connect_timeout, name, route, trace)
        self._make: type[Channel | PoolThread] = PoolThread if blocks else Channel
        self._wants_spare = spare
        self._threads = ThreadCalls(self._endpoint)
        #: the loop on which its connections are
        self._loop: asyncio.AbstractEventLoop | None = None
        self._carriers: list[Channel | PoolThread] = []
        self._waiting: deque[LaneCall] = deque()
        self._deadlines = _Deadlines(weakref.WeakMethod(self._expired))
        self._calls = 0
        self._failed = 0
        self._abandoned = 0
        fork_hooks.add(self)

    def statistics(self) -> LaneStatistics:
        """Figures since the lane was made."""
        return LaneStatistics(
            calls=self._calls,
            failed=self._failed,
            waiting=len(self._waiting),
            busy=sum(carrier.call is not None for carrier in self._carriers),
            connections=len(self._carriers),
            opened=self._endpoint.opened,
            abandoned=self._abandoned,
            stuck=int(self._endpoint.hanging),
        )

    @property
    def is_open(self) -> bool:
        """Whether it was opened, and is not closed: without that no call can be sent."""
        return self._open

    @property
    def connection(self) -> int | None:
        """Number of the connection of a lane that has one; None while it is not open."""
        open_now = any(isinstance(each, Channel) and each.connected for each in self._carriers)
        return self._endpoint.opened if open_now else None

    def __repr__(self) -> str:
        figures = self.statistics()
        state = "OPEN" if self._open else "CLOSED" if self.closed else "NEW"
        return (
            f"<Lane {self.name} {host_port(self.host, self.port)} {state}, "
            f"{figures.busy} of {self.size} busy, {figures.waiting} waiting>"
        )

    def __del__(self) -> None:
        if sys.is_finalizing():
            return  # a thread that ended in mid-work may hold a lock for ever
        if getattr(self, "_open", False) and not self.owner_loop.in_forked_child:
            unclosed = f"unclosed {self!r}"
            self._threads.close()
            for carrier in self._carriers:
                # the garbage collector may run on any thread
                self.owner_loop.run(carrier.forget)
            # last, since it raises if warnings are turned into errors
            warnings.warn(unclosed, ResourceWarning, source=self, stacklevel=2)

    def forked(self) -> None:
        """In a forked child: close the child's copies of the sockets; the parent's stay open."""
        for carrier in self._carriers:
            carrier.forked()

    async def open(self) -> None:
        """Open the first connection; the others open when calls need them.

        Raises:
            ConnectError: there is no controller, or it does not answer in time.
        """
        if self.closed or self._open:
            raise RuntimeError(f"{self!r} can be opened once")
        loop = self._loop = self.owner_loop.require("open")
        self._open = True
        seconds = self._endpoint.connect_timeout
        try:
            await self._carrier(loop).open(time.monotonic() + seconds)
            if self._wants_spare:
                spare = await connect(loop, self._endpoint, time.monotonic() + seconds)
                self._threads.keep(spare)
        except BaseException:
            await self.aclose()
            raise

    async def aclose(self) -> None:
        """Close every connection and end every thread. Calls under way fail."""
        if self.closed:
            return
        self._open, self.closed = False, True
        self._deadlines.stop()
        self._threads.close()
        while self._waiting:
            call = self._waiting.popleft()
            call.end(error=ConnectionLost(f"{call.name} was not sent, since {_CLOSED}"))
        if self._moved():
            return
        for carrier in self._carriers:
            carrier.close(_CLOSED)
        with anyio.CancelScope(shield=True), trial.untimed():
            for carrier in self._carriers:
                await carrier.closed()

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
        timeout: float | EllipsisType | None = ...,
        permit: Callable[[], object] | None = None,
    ) -> Any:
        """Call a function of the wire and wait for its answer.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: time limit of the whole call [s]; None: no limit; `...`: the lane's limit.
            permit: called as the very last thing before the bytes are handed to the socket. It
                raises a `DucoError` if the call may not be sent any more; that error is raised
                here, nothing was sent, and the connection stays usable.

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
        call = self.prepare(name, args, timeout, permit)
        # A task whose scope is already cancelled must send nothing. From here to the send there is
        # no other checkpoint that would detect this.
        if current_effective_deadline() == -math.inf:
            await checkpoint_if_cancelled()
        self._calls += 1
        if trial.current is not None:
            _tell(call, trial.current)
        try:  # as `send`, without its frame
            if (carrier := self._take(call)) is not None:
                carrier.send(call)
        except BaseException:
            call.abandon()
            raise
        return await call.answer()

    def prepare(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | EllipsisType | None = ...,
        permit: Callable[[], object] | None = None,
    ) -> LaneCall:
        """Make a call, which `send` then sends. It does not end with a task that waits for it.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: as for `call`, from now on.
            permit: as for `call`.

        Raises:
            ParameterError: a value cannot be sent.
            ConnectionLost: the lane is not open.
            WrongLoop: the lane belongs to another event loop.
            WrongProcess: the lane belongs to the process that forked this one.
        """
        function = self._functions[name]
        # Encode first. A value that cannot be sent then costs no connection, and a value that the
        # caller changes later is sent unchanged.
        encoded = codec.encode(function, args)
        self._require_open(name)
        loop = self.owner_loop.require(name)
        begun = time.monotonic()
        seconds = self.call_timeout if timeout is ... else timeout
        deadline = None if seconds is None else begun + seconds
        over, ended = loop.create_future(), self._end_of_call()
        return LaneCall(
            function, encoded, deadline, permit, args=args, over=over, ended=ended, begun=begun
        )

    def send(self, call: LaneCall) -> None:
        """Send a call before any other code of the event loop runs, if a connection is free.

        It is over if it cannot be sent. An interrupt abandons it.
        """
        self._calls += 1 + len(call.further)
        if trial.current is not None and not call.further:  # `ask` only reads
            _tell(call, trial.current)
        try:
            if (carrier := self._take(call)) is not None:
                carrier.send(call)
        except BaseException:  # what a signal handler raises
            call.abandon()
            raise

    async def ask(self, *questions: Question) -> list[codec.ReadResult]:
        """Call functions that only read, in one batch on one connection.

        The calls are sent in one piece; the controller reads and answers them in their order, as
        it does the calls of any client. They share the lane's time limit. If a connection that was
        already in use is lost before that time, all are sent once more on a new one.

        Args:
            questions: the functions, at least two, each with its arguments.

        Returns:
            Their answers; any of them may be the controller's error.

        Raises:
            The errors of `call`, except `ControllerError` and `OutcomeUnknown`.
        """
        call = self.prepare(*questions[0])
        begin = call.begun
        further = [(self._functions[name], args) for name, args in questions[1:]]
        call.further = [(function, codec.encode(function, args)) for function, args in further]
        try:
            self.send(call)
            answers: list[codec.ReadResult] = await call.answer()
        except BaseException as exc:
            self.report(*questions[0], None, exc, begin)
            raise
        if self._trace is not None or self.observers:
            for (name, args), answer in zip(questions, answers, strict=True):
                self.report(name, args, answer.value, answer.error, begin, answer.at)
                begin = answer.at
        return answers

    def call_from_thread(
        self,
        name: str,
        args: tuple[Any, ...],
        timeout: float | None,
        permit: Callable[[], object] | None = None,
    ) -> Any:
        """Call a function of the wire and block until its answer has arrived.

        Any thread may call it, and a signal handler at any point of the program, since it waits for
        no lock and needs no event loop. It never waits behind another call: it uses connections of
        its own, the first of which `open` can open beforehand. If a `stop` is not answered within
        0.1 s, it is also sent on another connection.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: time limit of the whole call [s]; None: no limit.
            permit: as for `call`.

        Returns:
            The result; None for a function without one.

        Raises:
            The errors of `call`, except `WrongLoop`: any thread may use it, under any event loop.
        """
        function = self._functions[name]
        encoded = codec.encode(function, args)
        self.owner_loop.require_process(name)
        self._require_open(name)
        self._calls += 1
        begin = time.monotonic()
        deadline = None if timeout is None else begin + timeout
        ended = None if trial.current is None else trial.current.call(name, args)
        value: Any = None
        error: BaseException | None = None
        try:
            value = self._threads.call(Call(function, encoded, deadline, permit))
        except BaseException as exc:
            self._failed += isinstance(exc, ConnectionLost | ConnectError)
            error = exc
            raise
        finally:
            self.report(name, args, value, error, begin)
            if ended is not None:
                ended(value, error)
        return value

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

    # One call

    def _require_open(self, name: str) -> None:
        if not self._open:
            state = "closed" if self.closed else "not open yet"
            raise ConnectionLost(
                f"{name} was not sent, since its connection to {host_port(self.host, self.port)} "
                f"is {state}: use the robot inside its block"
            )

    def _take(self, call: LaneCall) -> Channel | PoolThread | None:
        """Give a call to a free connection, or queue it; return the connection if it must send."""
        loop = call.over.get_loop()
        if loop is not self._loop:
            self._moved()
            self._loop = loop
        self._deadlines.add(call)
        for carrier in self._carriers:
            if carrier.call is None:
                return carrier if carrier.take(call) else None
        if len(self._carriers) < self.size:
            self._carrier(loop).take(call)
        else:
            self._waiting.append(call)
        return None

    def _carrier(self, loop: asyncio.AbstractEventLoop) -> Channel | PoolThread:
        made = self._make(loop, self._endpoint, self._waiting)
        self._carriers.append(made)
        return made

    def _end_of_call(self) -> Callable[[LaneCall], object]:
        """What a call does at its end: a hook gets the caller's context, such as its span."""
        if self._trace is None:
            return self._ended
        context = copy_context()
        return lambda call: context.run(self._ended, call)

    def _ended(self, call: LaneCall) -> None:
        """Count and report a call that is over."""
        self._deadlines.discard(call)
        error = call.error
        if call.abandoned:
            if call.carrier is not None:
                self._abandoned += 1 + len(call.further)
            elif call in self._waiting:
                self._waiting.remove(call)
        elif isinstance(error, ConnectionLost | ConnectError):
            self._failed += 1 + len(call.further)
        elif isinstance(error, UnknownFunction):
            error = call.error = error.of(self.version)
        if not call.further:  # `ask` reports each of its functions
            value = call.value
            if call.over.cancelled():
                value, error = None, asyncio.CancelledError()
            self.report(call.name, call.args, value, error, call.begun)

    def _expired(self, call: LaneCall) -> None:
        """Fail a call whose deadline has passed."""
        if call.carrier is not None:
            call.carrier.expire(call)
            return
        self._waiting.remove(call)
        place = host_port(self.host, self.port)
        call.end(error=NotSent(f"{call.name} was not sent: no connection to {place} was free"))

    def _moved(self) -> bool:
        """Forget the connections if their loop was closed; return whether it was."""
        if self._loop is None or not self._loop.is_closed():
            return False
        for carrier in self._carriers:
            carrier.forget()
        self._carriers.clear()
        self._waiting.clear()
        self._deadlines.stop()
        return True


def _tell(call: LaneCall, trial: Trial) -> None:
    """Tell a trial of a call that is about to be sent, and then of its end."""
    note, ended = call.ended, trial.call(call.name, call.args)

    def over(call: LaneCall) -> None:
        note(call)
        ended(call.value, call.error)

    call.ended = over


class _Deadlines:
    """Ensures that no call outlives its deadline.

    One timer serves all calls of a lane: it is set for the earliest deadline, and set again when it
    expires. A timer for each call would take a tenth of the time of a call. The event loop holds
    the timer, so the timer holds no lane.

    Args:
        expired: method that gets a call whose deadline has passed.
    """

    def __init__(self, expired: weakref.WeakMethod[Callable[[LaneCall], None]]) -> None:
        self._expired = expired
        self._calls: set[LaneCall] = set()
        self._timer: asyncio.TimerHandle | None = None
        self._expires_at = math.inf

    def add(self, call: LaneCall) -> None:
        """Watch a call until it is discarded."""
        if call.deadline is None:
            return
        self._calls.add(call)
        if call.deadline < self._expires_at:
            self._set(call.over.get_loop(), call.deadline)

    def discard(self, call: LaneCall) -> None:
        """Stop watching a call. The timer stays as it is: the next call will use it."""
        self._calls.discard(call)

    def stop(self) -> None:
        """Stop watching all calls."""
        self._calls.clear()
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None
        self._expires_at = math.inf

    def _set(self, loop: asyncio.AbstractEventLoop, at: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._expires_at = at
        self._timer = loop.call_later(max(0.0, at - time.monotonic()), self._check, loop)

    def _check(self, loop: asyncio.AbstractEventLoop) -> None:
        self._timer, self._expires_at = None, math.inf
        now = time.monotonic()
        expired = self._expired()
        try:
            for call in [call for call in self._calls if (call.deadline or now) <= now]:
                self._calls.discard(call)
                if expired is not None and not call.over.done():
                    expired(call)
        finally:
            at = min((call.deadline or now for call in self._calls), default=math.inf)
            if at < math.inf:
                self._set(loop, at)
