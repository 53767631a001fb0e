"""The supervision of one robot: its connections, its heartbeat, and the closing steps.

Guarantees:
- Each closing step is carried out to its end even if closing is cancelled, once or more; the
  cancellation is raised afterwards.
- A step that fails is logged, and the next one follows. The first failure is raised at the end.
- Closing waits for log handlers only after the connections are closed, and for a limited time.
- The heartbeat beats until the arm was seen to stand, or until that has failed.
- If a program exits without closing its robot, because it forgot to or because repeated interrupts
  broke its event loop, the arm is stopped when the interpreter exits.
"""

from __future__ import annotations

import atexit
import math
import os
import random
import sys
import time
from collections import deque
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import anyio

from aioduco._process.platform import boot_time
from aioduco._process.reporting import BackgroundLogger, reporter
from aioduco._process.spawn import started_in_place_of
from aioduco._wire.endpoint import Endpoint, Route
from aioduco._wire.failures import resource_error
from aioduco._wire.lane import LaneStatistics, WireLane
from aioduco._wire.own_connection import OwnConnection
from aioduco._wire.owner_loop import OwnerLoop, loop_callback
from aioduco._wire.way_out import WAY_OUT, prepare
from aioduco.errors import (
    ConnectError,
    ConnectionLost,
    ConnectTimeout,
    ControllerError,
    DucoError,
    GuardLost,
    HeartbeatLost,
    NotAController,
    NotSent,
    RobotStateError,
    StopUnconfirmed,
)
from aioduco.models.ranges import TIMEOUT as SECONDS
from aioduco.models.samples import Samples
from aioduco.models.version import ControllerVersion
from aioduco.supervision.concurrency import BackgroundTasks, on_grid, run_to_completion
from aioduco.supervision.dispatcher import Dispatcher
from aioduco.supervision.envelope_keeper import EnvelopeKeeper
from aioduco.supervision.envelope_watch import EnvelopeWatch
from aioduco.supervision.events import Events, LoopBlocked
from aioduco.supervision.gate import Gate, PermitEnding
from aioduco.supervision.heartbeat import Heartbeat, HeartbeatState, HeartbeatStatistics
from aioduco.supervision.loop_watchdog import Liveness, keep_alives, watchdogs
from aioduco.supervision.opening_and_closing import (
    carry_out,
    log_written,
    until_beating,
    version_of,
)
from aioduco.supervision.permits import Permits
from aioduco.supervision.retry import pauses, retried
from aioduco.supervision.state_feed import StateFeed
from aioduco.supervision.stop_channel import StopChannel
from aioduco.supervision.stop_coordinator import StopCoordinator

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco._wire.rpc import AsyncRpc
    from aioduco.models.trace import Trace
    from aioduco.supervision.guard.guarded import GuardClient
    from aioduco.supervision.opening_and_closing import ClosingStep
    from aioduco.supervision.settings import RobotSettings
    from aioduco.supervision.task import Task


_log = BackgroundLogger(__name__)

#: seconds within which a stop must be accepted at the interpreter's exit
_EXIT_LIMIT = 2.0
#: seconds for a thread to end
_GRACE = 1.0
#: why nothing beats until another guard does
_GUARD_GONE = "the guard's process is gone; another is being started"
_PORT = "the controller's port is 7003"
#: closing is never skipped; each of its parts has a limit of its own
_NO_LIMIT = math.inf


class SupervisorStatistics(NamedTuple):
    """Statistics of a robot.

    Attributes:
        lanes: statistics of each lane, by name.
        heartbeat: statistics of the heartbeat; None without a heartbeat.
        tasks: number of tasks that the controller accepted.
        live_tasks: number of tasks that are live now.
        polls: number of polls for the state of a task.
        stops: number of stops that the controller accepted.
        stop_attempts: number of stops that were sent, repeats included.
        longest_stall: longest delay of a task that was due on the event loop [s].
    """

    lanes: dict[str, LaneStatistics]
    heartbeat: HeartbeatStatistics | None
    tasks: int
    live_tasks: int
    polls: int
    stops: int
    stop_attempts: int
    longest_stall: float


class Supervisor:
    """Supervises one robot.

    `aclose` stops only motions of this program: a program that only observes stops no arm.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        settings: times and limits.

    Attributes:
        version: the version of the controller's software.
        calls: the lane of all calls that are neither motions nor supervision.
        rpc: the functions of the wire on that lane; reads are retried while the connection is lost.
        blocking: the lane of calls that the controller answers only when it has finished.
        poll: the lane on which tasks and the arm's standstill are polled.
        gate: decides what may move the arm.
        permits: permits to move it.
        samples: makes samples of the state.
        stop_channel: sends stop, pause, resume, abort.
        stop_coordinator: brings the arm to rest.
        dispatcher: starts motions and other tasks.
        heartbeat: the heartbeat; None without one.
        guard: the robot's side of the guard; None without a guard.
        feed: samples of the robot's state.
        events: events of the robot.
        envelope: keeps the arm within its operating envelope.
    """

    def __init__(self, host: str, port: int, settings: RobotSettings) -> None:
        self.host = host
        self.port = port
        self.settings = settings
        self.version: ControllerVersion = ControllerVersion("")
        #: the event loop on which it is opened; it can be used only there
        self.owner_loop: OwnerLoop = OwnerLoop("the robot", moves=False)
        #: the way to the host, for all its connections
        self._route = Route()
        self.samples: Samples = Samples()
        #: all lanes, that of the stop first
        self.lanes: list[WireLane] = []
        self._stop_lane = self._lane("stop", spare=True)
        self._control_lane = self._lane("control")
        self.poll: WireLane = self._lane("poll")
        self._motion_lane = self._lane("motion")
        self._feed_lane = self._lane("feed")
        self.calls: WireLane = self._lane("call", size=settings.pool_size)
        self.blocking: WireLane = self._lane("blocking", size=settings.pool_size, blocks=True)
        self.rpc: AsyncRpc = retried(self.calls)
        self._background = BackgroundTasks(self._crashed, self._stop_at_loop_end)
        self.guard: GuardClient | None = None
        self.heartbeat: Heartbeat | GuardClient | None = None
        if settings.guard is not None:
            from aioduco.supervision.guard import guarded  # noqa: PLC0415  # few robots have one

            self.guard = guarded.GuardClient(host, port, settings, self._guard_lost, self._beaten)
        self._liveness = Liveness(None if self.guard is None else self.guard.touch)
        self.stop_channel: StopChannel = StopChannel(self._stop_lane, self._control_lane, self.poll)
        if settings.heartbeat is not None:
            end = Endpoint(host, port, settings.connect_timeout, route=self._route)
            self.heartbeat = self.guard or Heartbeat(
                *(OwnConnection(end), settings.heartbeat, self._liveness),
                *(settings.loop_stall_limit, self._beaten),
            )
        self.gate: Gate = Gate(
            settings.heartbeat, settings.loop_stall_limit, boot_time(), self._permits_ended
        )
        self.permits: Permits = Permits(self.gate)
        self._stalls = 0
        self.stop_coordinator: StopCoordinator = StopCoordinator(
            self.stop_channel,
            self.poll,
            self._background,
            settings,
            self._liveness,
            lambda: self.heartbeat is not None and self.heartbeat.lapsed,
            self.permits,
        )
        self.dispatcher: Dispatcher = Dispatcher(self._motion_lane, self.stop_coordinator, settings)
        self.feed: StateFeed = StateFeed(
            *(self._feed_lane, self.samples, self._background, settings.state_rate),
            self.stop_coordinator.follower.due_before,
        )
        self.events: Events = Events(
            *(self.feed, self._feed_lane, self._background),
            lambda: self.heartbeat.state if self.heartbeat else HeartbeatState.OFF,
        )
        arm = self.stop_coordinator, self.rpc, self.feed
        watch = EnvelopeWatch(*arm, self.events, self._background, settings)
        self.envelope: EnvelopeKeeper = EnvelopeKeeper(*arm, watch)
        self.stop_coordinator.require_samples = watch.require_samples
        self.dispatcher.check = self.envelope.check
        self.dispatcher.require_opened = self._require_opened
        self.dispatcher.check_software = self._check_software
        #: the connection for motions since which the version is known
        self._motions_over: int | None = None
        self._replacing_guard = False
        self._process = os.getpid()
        #: ends the watch over the event loop; waits so many seconds for the end of its thread
        self._unwatch: Callable[[float], None] = lambda _: None
        self._opened = False
        self._closed = False
        #: set when the closing that is in progress is over; None: none is
        self._closing: anyio.Event | None = None
        self._close_error: Exception | None = None
        self._stopped_at_exit = False

    def _permits_ended(self, ending: PermitEnding) -> None:
        """Tell the streams, and the tasks of a program that hung, that their permit has ended."""
        self.stop_coordinator.permits_ended(ending)

    def _beaten(self, heartbeat: Heartbeat | GuardClient) -> None:
        """Pass a report of the heartbeat on to the gate; on the heartbeat's thread."""
        stalls, sent = heartbeat.statistics().stalls, heartbeat.sent
        if stalls > self._stalls:
            self.gate.hang()
        self._stalls = stalls
        if sent:
            self.gate.beaten(sent)
            for stream in tuple(self.stop_coordinator.streams):
                stream.renew(self.gate.lease)

    def _lane(
        self, name: str, size: int = 1, *, blocks: bool = False, spare: bool = False
    ) -> WireLane:
        lane = WireLane(
            name,
            self.host,
            self.port,
            size=size,
            connect_timeout=self.settings.connect_timeout,
            call_timeout=self.settings.call_timeout,
            trace=self.settings.trace,
            owner_loop=self.owner_loop,
            route=self._route,
            blocks=blocks,
            spare=spare,
        )
        self.lanes.append(lane)
        return lane

    @property
    def state(self) -> str:
        """State of the supervision in a word."""
        if self.owner_loop.in_forked_child:
            return "of the process that forked this one"
        if self._closed:
            return "closed"
        return "open" if self._opened else "not open"

    def check_open(self, name: str) -> None:
        """Check that the robot is open, and that its event loop runs here.

        Raises:
            RobotStateError: it is not; `name` was not sent.
            WrongLoop: this is another event loop; `name` was not sent.
            WrongProcess: this is a forked child; `name` was not sent.
        """
        self.check_usable(name)
        self.owner_loop.require(name)

    def check_permitted(self, name: str) -> None:
        """Check that a function that can move the arm may be sent, before anything is read for it.

        Raises:
            RobotStateError, HeartbeatLost, TaskStopped, WrongLoop, WrongProcess: it may not; `name`
                was not sent.
        """
        self.check_open(name)
        self.permits.ask(name)

    def check_usable(self, name: str) -> None:
        """Check that the robot is open; from any thread.

        Raises:
            RobotStateError: it is not; `name` was not sent.
            WrongProcess: this is a forked child; `name` was not sent.
        """
        self.owner_loop.require_process(name)
        if self._closed:
            raise self._unusable(name)
        self._require_opened(name)

    def _require_opened(self, name: str) -> None:
        if not self._opened:
            raise self._unusable(name)

    def _unusable(self, name: str) -> RobotStateError:
        return RobotStateError(
            f"{name} was not sent: the robot is {self.state}; "
            "use it inside its block, `async with aioduco.connect(...) as robot` or "
            "`with aioduco.sync.connect(...) as robot`"
        )

    def observe(self, calls: Trace, tasks: Callable[[Task], object]) -> Callable[[], None]:
        """Report calls and tasks from now on; for the package's own code, such as a recorder.

        The calls of the feed and of the task follower are not reported: they are many, and change
        nothing.

        Args:
            calls: called with each call that has ended, on its thread. It must not raise or wait.
            tasks: called with each task that is accepted, changes its state or ends, on the event
                loop. It must not raise or wait.

        Returns:
            A function that ends the reports.
        """
        lanes = [lane for lane in self.lanes if lane not in (self.poll, self._feed_lane)]
        follower = self.stop_coordinator.follower

        def end() -> None:
            # New lists instead of changed ones: a thread may be iterating over them.
            for lane in lanes:
                lane.observers = [other for other in lane.observers if other != calls]
            follower.observers = [other for other in follower.observers if other != tasks]

        for lane in lanes:
            lane.observers = [*lane.observers, calls]
        follower.observers = [*follower.observers, tasks]
        return end

    def statistics(self) -> SupervisorStatistics:
        """Return statistics since the robot was opened."""
        return SupervisorStatistics(
            lanes={lane.name: lane.statistics() for lane in self.lanes},
            heartbeat=self.heartbeat.statistics() if self.heartbeat else None,
            tasks=self.dispatcher.accepted,
            live_tasks=len(self.stop_coordinator.follower.tasks),
            polls=self.stop_coordinator.follower.polls,
            stops=self.stop_channel.stops,
            stop_attempts=self.stop_channel.attempts,
            longest_stall=self._liveness.longest_stall,
        )

    async def open(self) -> None:
        """Connect, check that a controller answers, and begin to supervise.

        Raises:
            ConnectError: there is no controller.
            WrongLoop: no event loop of asyncio runs here.
        """
        self.owner_loop.require("open")
        if self._opened or self._closed:
            raise RobotStateError("a robot is opened once: make another one by connect()")
        if started := started_in_place_of():
            raise RobotStateError(
                f"nothing was sent: this program was started in place of {started}, since its "
                "executable is no Python interpreter; connect without a guard, and open streams "
                'with run_in="thread"'
            )
        prepare(WAY_OUT)
        # Before the first beat, which uses it to judge whether the event loop hangs.
        self._background.start(self._live(on_grid(time.monotonic())), "aioduco keep-alive")
        try:
            self._note_version(await self._open_lanes())
            self._watch_loop()
        except BaseException as exc:
            self._closed = True
            await run_to_completion(self._close_lanes)
            lack = resource_error(exc)
            if lack and not isinstance(exc, GuardLost):
                raise ConnectError(self.host, self.port, f"{lack}. No motion was sent") from exc
            raise
        self._opened = True
        self.envelope.begin()
        atexit.register(self._at_exit)  # this also keeps alive what the stop needs
        self._background.start(self.stop_coordinator.follower.run(), "aioduco task follower")
        self._background.start(self.dispatcher.note_rest(), "aioduco rest")
        if self.guard is not None and not self.guard.alive:
            self._guard_lost()  # while the robot was being opened

    async def _open_lanes(self) -> ControllerVersion:
        """Open every lane, read state and version, start a guard if wanted, and the heartbeat.

        Returns:
            The version of the controller's software.

        Raises:
            ConnectError: the host is unknown, the port is closed, or nothing answers.
            NotAController: something else answers.
            ConnectTimeout: something accepts connections, but does not answer.
            GuardLost: the guard cannot be started.
        """
        for lane in self.lanes:
            await lane.open()
        timeout, where = self.settings.call_timeout, (self.host, self.port)
        try:
            await self.poll.call("get_robot_state", ())
            version = await version_of(self.poll)
            await self._start_guard()
            self.gate.rearm(boot_time())  # opening may have taken long: it moved nothing
            if self.heartbeat is not None:
                self.heartbeat.start()
                if not await until_beating(self.heartbeat, self.gate, timeout, opening=True):
                    silent = TimeoutError("the heartbeat was not answered")
                    raise silent from self.heartbeat.error
        except TimeoutError as exc:
            raise ConnectTimeout(
                *where,
                f"it accepts connections, but did not answer within {timeout:g} s; "
                "is the controller still starting, or does it hang?",
            ) from exc
        except ControllerError as exc:
            reason = f"it speaks Thrift, but does not know the controller's functions ({exc})"
            raise NotAController(*where, f"{reason}; {_PORT}") from exc
        except ConnectionLost as exc:
            reason = f"what answers there is no controller, or one that is still starting ({exc})"
            raise NotAController(*where, f"{reason}; {_PORT}") from exc
        return version

    def _note_version(self, version: ControllerVersion) -> None:
        self.version = version
        self.envelope.manual = version.manual
        for lane in self.lanes:
            lane.version = version.text
        self._motions_over = self._motion_lane.connection

    async def _check_software(self, name: str) -> None:
        """Check before a motion that the controller means the same by it as when it was opened.

        While a controller gets other software, its connections end. So its version is read again
        when motions have a new connection.

        Raises:
            RobotStateError: it has other software, by which another manual applies.
            ConnectError, NotSent: its version cannot be read; nothing was sent.
        """
        lane = self._motion_lane
        if self._motions_over is not None and lane.connection == self._motions_over:
            return
        try:
            version = await version_of(lane)
        except ConnectionLost as exc:
            raise NotSent(f"{name} was not sent: {exc}") from exc
        if version.manual != self.version.manual:
            raise RobotStateError(
                f"{name} was not sent: the controller's software was {self.version} when this "
                f"robot was opened, and is {version} now, which means other things by some "
                "arguments. Leave the robot, and connect again"
            )
        self._note_version(version)

    async def rearm_heartbeat(self, timeout: float) -> None:
        """Resume the beats after a stall of the event loop; see `Robot.rearm_heartbeat`."""
        limit = SECONDS("timeout", timeout)
        self.check_open("rpc_heartbeat")
        if self.heartbeat is None:
            return
        self.heartbeat.rearm()
        self.gate.rearm(boot_time())
        if not await until_beating(self.heartbeat, self.gate, limit):
            raise HeartbeatLost(
                "the event loop hung again; call robot.rearm_heartbeat() once more"
                if self.gate.hung
                else f"no heartbeat was answered within {timeout:g} s"
            )

    def _watch_loop(self) -> None:
        if self.settings.lag_limit is not None:
            # The time that opening took does not count: the loop is watched from now on.
            self._liveness.touch(time.monotonic())
            limit = self.settings.lag_limit
            self._unwatch = watchdogs.watch(self._liveness, limit, self._loop_blocked())

    def forget(self) -> bool:
        """Stop what moves, and end the heartbeat, after the program dropped an open robot.

        A section or a motion of it that the program kept can move the arm no more. Nothing is left
        to do as the interpreter ends: the arm was stopped at exit, and a thread that ended in
        mid-work may hold a lock for ever. Returns whether it was stopped, and is to be closed.
        """
        if self.owner_loop.in_forked_child or sys.is_finalizing():
            return False
        self.gate.close(
            "the robot was dropped without being closed: keep what connect() returned as long as "
            "you use any part of it"
        )
        self._stop_at_exit()
        if self.heartbeat is not None:
            self.heartbeat.end()
        # One that could not be stopped stays with the guard, which stops it.
        stands = self._stopped_at_exit or not self.stop_coordinator.moving
        if self.guard is not None and stands:
            self.guard.forget()
        return stands and not self.owner_loop.closed

    def _at_exit(self) -> None:
        self._stop_at_exit()
        # Last, the messages of this program are written; the stop does not wait for that.
        reporter.flush()

    def _stop_at_exit(self) -> None:
        """Stop the arm if it may be moving: the program will not close the robot properly."""
        atexit.unregister(self._at_exit)
        # In a forked child the connections are the parent's.
        if not self._opened or self._stopped_at_exit or os.getpid() != self._process:
            return
        # A thread of the program may run its event loop until the process has ended.
        self.gate.close("the program ends")
        if not self.stop_coordinator.moving:
            return
        try:
            self.stop_coordinator.stop_now(_EXIT_LIMIT)
        except DucoError as exc:
            _log.critical(
                "the program ends without having left the robot, and it could not be stopped: %s",
                exc,
            )
        else:
            self._stopped_at_exit = True
            _log.critical("the program ends without having left the robot: the arm was stopped")

    def _loop_blocked(self) -> Callable[[float, str], None]:
        """Return the callback that the loop's watchdog calls on its thread."""
        seen: deque[LoopBlocked] = deque()
        ring = loop_callback(lambda: self.events.tell(seen.popleft()))

        def blocked(seconds: float, where: str) -> None:
            seen.append(LoopBlocked(time.monotonic(), seconds, where))
            ring()

        return blocked

    async def aclose(self) -> None:
        """Carry out the closing steps: stop what moves, wait until it stands, close.

        If the robot's own event loop has been closed, this runs on the present one. In a forked
        child it does nothing: the robot belongs to the parent.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
            WrongLoop: the robot's own event loop is another one, which is still open.
        """
        if not self._opened or self.owner_loop.in_forked_child:
            return
        if self._closed:
            await self._closed_by_another()
            return
        if self.owner_loop.closed:
            _log.warning("the robot's event loop was closed before the robot: it is left on this")
            self.owner_loop.move("aclose")
        self.owner_loop.require("aclose")
        closing = anyio.Event()
        over = False
        cancelled: BaseException | None = None
        try:
            self._closed, self._closing, self._close_error = True, closing, None
            self.gate.close("the robot is closed, or is being closed")
            for name, limit, step in self._closing_steps():
                error, again = await carry_out(name, limit, step)
                self._close_error, cancelled = self._close_error or error, again or cancelled
            _, again = await run_to_completion(log_written)
            over = True
        finally:
            # If there was no memory, or a signal's handler raised, it can be closed once more.
            self._closed, self._closing = over, None
            closing.set()
        if self._close_error is not None:
            raise self._close_error
        if (cancelled := again or cancelled) is not None:
            raise cancelled

    async def _closed_by_another(self) -> None:
        """Wait until the task that closes the robot has done so; raise what it raises."""
        if self._closing is None or self.owner_loop.closed:
            return
        self.owner_loop.require("aclose")
        _, cancelled = await run_to_completion(self._closing.wait)
        if self._close_error is not None:
            raise self._close_error
        if cancelled is not None:
            raise cancelled

    def _closing_steps(self) -> Iterator[ClosingStep]:
        """Yield the closing steps; each depends on what the ones before it have done."""
        steps, coordinator = self.settings.steps, self.stop_coordinator
        yield "answers", steps.answers, self.dispatcher.quiet
        if coordinator.moving:
            yield "stop", steps.stop, self._stop_to_leave
            yield "standstill", steps.standstill, partial(self._stand_to_leave, steps.stop)
        if coordinator.modes.any:
            yield "modes", steps.modes, coordinator.leave_modes
        # a stop that another task waits for would otherwise not learn that it was accepted
        if coordinator.gate.stopping and self._close_error is None:
            yield "stops", steps.standstill, self.permits.stops_ended
        yield "close", _NO_LIMIT, lambda _: self._close_lanes()

    async def _stop_to_leave(self, timeout: float) -> None:
        """Stop the arm; the motions that this ends have been stopped, and have not finished."""
        self.gate.end(PermitEnding.STOPPED)
        await self.stop_coordinator.send_stop(timeout)

    async def _stand_to_leave(self, stop_timeout: float | None, timeout: float) -> None:
        """Wait until the arm stands, and until it was seen how its motions have ended."""
        await self.stop_coordinator.rest(stop_timeout, timeout)
        await self.stop_coordinator.follower.motions_ended()

    async def _close_lanes(self) -> None:
        """End everything that runs for the robot, and close its connections."""
        self.stop_coordinator.closed = True
        atexit.unregister(self._at_exit)
        if self.heartbeat is not None:
            self.heartbeat.end()
        self.feed.close()
        self.events.close()
        await self._background.aclose()
        self._unwatch(_GRACE)
        if self.guard is not None:
            await self.guard.release()
        for lane in self.lanes:
            await lane.aclose()
        if self.heartbeat is not None:
            self.heartbeat.join(_GRACE)

    async def _start_guard(self) -> None:
        """Let the guard take over the heartbeat, if a guard is wanted."""
        if self.guard is not None:
            self._stalls = 0
            await self.guard.acquire()
            self._liveness.touch(time.monotonic())

    def _guard_lost(self) -> None:
        """Stop the arm, and start another guard, since the guard and its heartbeat have ended."""
        if self._closed or self.guard is None or not self._opened:
            return
        if self._replacing_guard or self.guard.alive:
            return  # another is being started, or is there: this call was on its way meanwhile
        self._replacing_guard = True
        self.gate.lapse(_GUARD_GONE)
        self._background.start(self._new_guard(self.guard), "aioduco new guard")
        _log.critical(
            "the guard of %s:%d is gone: the arm is stopped, and another guard is started",
            self.host,
            self.port,
        )

    async def _new_guard(self, guard: GuardClient) -> None:
        backoff = pauses(random.Random())
        failed = ""
        while not guard.alive:
            why = f" (the last attempt failed: {failed})" if failed else ""
            self.gate.lapse(f"{_GUARD_GONE}{why}")
            if self.stop_coordinator.moving:
                try:
                    await self.stop_coordinator.halt()
                except StopUnconfirmed as exc:
                    _log.critical("the guard is gone, and %s", exc)
            await guard.release()
            try:
                await self._start_guard()
            except (DucoError, MemoryError) as exc:
                if failed != (failed := str(exc) or type(exc).__name__):
                    _log.critical("no other guard could be started yet: %s", failed)
                await anyio.sleep(next(backoff))
        self._replacing_guard = False
        _log.warning("another guard supervises %s:%d", self.host, self.port)

    async def _live(self, due: float) -> None:
        """Send keep-alives of the event loop, first at `due`, and look whether the arm is done."""
        async for turn in keep_alives(self.settings.loop_stall_limit, due, self.settings.lag_limit):
            self._liveness.touch(turn, counts=self.gate.alive(boot_time()))
            self.dispatcher.look()

    def _crashed(self, error: BaseException) -> None:
        """End the heartbeat after a failure of the supervision: the controller stops the arm."""
        why = f"the supervision of the robot failed ({error!r}); open it anew"
        self.gate.close(why, PermitEnding.FAILED)
        if self.heartbeat is not None:
            self.heartbeat.end()

    def _stop_at_loop_end(self) -> None:
        """Stop the arm, because the event loop ends, and with it the supervision.

        Before the interpreter exits, code of the program may run: an excepthook may take any time.
        So the arm is stopped now.
        """
        if self._closed or self.gate.closed:
            return
        self.gate.close("the event loop of the robot has ended; open it anew")
        self.forget()
