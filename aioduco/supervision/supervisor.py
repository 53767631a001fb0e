"""The supervision of one robot: its lanes, its heartbeat, and the way out."""

from __future__ import annotations

import logging
import time
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import anyio

from aioduco._wire.connection import Connection
from aioduco._wire.handoff import doorbell
from aioduco._wire.lane import Lane
from aioduco.errors import DucoError, RobotStateError, StopUnconfirmed
from aioduco.models.version import ControllerVersion
from aioduco.supervision.background import Background
from aioduco.supervision.changes import LoopBlocked
from aioduco.supervision.control import Control
from aioduco.supervision.events import Events
from aioduco.supervision.feed import Feed
from aioduco.supervision.guard.sides import (
    GuardedControl,
    GuardedHeartbeat,
    GuardedSignOfLife,
    Seat,
)
from aioduco.supervision.heartbeat import Heartbeat, HeartbeatStatistics, SignOfLife
from aioduco.supervision.insist import insist
from aioduco.supervision.keeper import Keeper
from aioduco.supervision.ladder import leave
from aioduco.supervision.lag import LagMonitor, Watched, monitors
from aioduco.supervision.launcher import Launcher
from aioduco.supervision.opening import open_lines
from aioduco.supervision.parting import Parting
from aioduco.supervision.patience import Patience
from aioduco.supervision.pulse import HeartbeatState
from aioduco.supervision.samples import Samples

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.lane import LaneStatistics
    from aioduco.supervision.heartbeat import Heart
    from aioduco.supervision.settings import Settings

_log = logging.getLogger(__name__)

#: signs of life of the event loop per stall limit
_SIGNS = 10
#: seconds between two signs of life at most
_SIGN_EVERY = 0.1
#: seconds for a thread to end
_GRACE = 1.0


class SupervisorStatistics(NamedTuple):
    """Figures of a robot.

    Attributes:
        lanes: figures of each lane, by name.
        heartbeat: figures of the heartbeat; None without one.
        tasks: tasks that the controller accepted.
        live_tasks: tasks that live now.
        polls: questions for the state of a task.
        stops: stops that the controller accepted.
        stop_attempts: stops that were sent, repeats included.
        longest_stall: how late the event loop came to a task that was due, at most [s].
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

    `aclose` stops what this program moved and nothing else: a program that only looks on stops
    nobody's arm.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        settings: times and limits.

    Attributes:
        version: the version of the controller's software.
        calls: the lane of all calls that are neither motions nor supervision.
        patient: the calls of that lane, with reads that wait for a lost connection.
        poll: the lane on which tasks and the arm's standstill are asked about.
        samples: makes samples of the state.
        control: sends stop, pause, resume, abort.
        keeper: brings the arm to rest.
        launcher: starts motions and other tasks.
        heartbeat: the heartbeat; None without one.
        guard: the robot's place with the guard; None without one.
        feed: samples of the robot's state.
        events: what happens to the robot.
    """

    def __init__(self, host: str, port: int, settings: Settings) -> None:
        self.host = host
        self.port = port
        self.settings = settings
        self.version: ControllerVersion = ControllerVersion("")
        self.samples: Samples = Samples()
        self.calls: Lane = self._lane("call", size=settings.pool_size)
        self.patient: Patience = Patience(self.calls)
        self.poll: Lane = self._lane("poll")
        self._stop_lane = self._lane("stop")
        self._control_lane = self._lane("control")
        self._motion_lane = self._lane("motion")
        self._feed_lane = self._lane("feed")
        self._background = Background(self._crashed)
        self.guard: Seat | None = None
        self.heartbeat: Heart | None = None
        self.control: Control
        if settings.guard is None:
            self._life = SignOfLife()
            self.control = Control(self._stop_lane, self._control_lane, self.poll)
            if settings.heartbeat is not None:
                self.heartbeat = Heartbeat(
                    self._line, settings.heartbeat, self._life, settings.loop_stall_limit
                )
        else:
            self.guard = Seat(host, port, settings)
            self._life = GuardedSignOfLife(self.guard)
            self.control = GuardedControl(
                self.guard, self._stop_lane, self._control_lane, self.poll
            )
            if settings.heartbeat is not None:
                self.heartbeat = GuardedHeartbeat(self.guard)
        self.keeper: Keeper = Keeper(self.control, self.poll, self._background, settings)
        self.launcher: Launcher = Launcher(
            self._motion_lane, self.keeper, self._background, self.heartbeat, settings
        )
        self.feed: Feed = Feed(self._feed_lane, self.samples, self._background, settings.state_rate)
        self.events: Events = Events(
            self.feed, self._feed_lane, self._background, self._heartbeat_state
        )
        self._parting: Parting | None = None
        self._lag: LagMonitor | None = None
        self._watched: Watched | None = None
        self._opened = False
        self._closed = False

    def _heartbeat_state(self) -> HeartbeatState:
        return HeartbeatState.OFF if self.heartbeat is None else self.heartbeat.state

    def _lane(self, name: str, size: int = 1) -> Lane:
        return Lane(
            name,
            self.host,
            self.port,
            size=size,
            connect_timeout=self.settings.connect_timeout,
            call_timeout=self.settings.call_timeout,
            trace=self.settings.trace,
        )

    def _line(self) -> Connection:
        return Connection(self.host, self.port, connect_timeout=self.settings.connect_timeout)

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """All lanes, that of the stop first."""
        return (
            self._stop_lane,
            self._control_lane,
            self.poll,
            self._motion_lane,
            self._feed_lane,
            self.calls,
        )

    @property
    def state(self) -> str:
        """State of the supervision in a word."""
        if self._closed:
            return "closed"
        return "open" if self._opened else "not open"

    def check_open(self, name: str) -> None:
        """See that the robot is open.

        Raises:
            RobotStateError: it is not; `name` was not sent.
        """
        if not self._opened or self._closed:
            raise RobotStateError(
                f"{name} was not sent: the robot is {self.state}; "
                "use it inside `async with aioduco.connect(...) as robot`"
            )

    async def admit_stream(self, name: str) -> None:
        """See that a stream of set-points may begin.

        Args:
            name: what it is called.

        Raises:
            RobotStateError: the robot is not open, or something moves the arm.
            HeartbeatLost: the heartbeat does not beat.
        """
        self.check_open(name)
        await self.launcher.admit_stream(name)

    def statistics(self) -> SupervisorStatistics:
        """Figures since the robot was opened."""
        return SupervisorStatistics(
            lanes={lane.name: lane.statistics() for lane in self.lanes},
            heartbeat=self.heartbeat.statistics() if self.heartbeat else None,
            tasks=self.launcher.accepted,
            live_tasks=len(self.keeper.poller.tasks),
            polls=self.keeper.poller.polls,
            stops=self.control.stops,
            stop_attempts=self.control.attempts,
            longest_stall=self._life.longest_stall,
        )

    async def open(self) -> None:
        """Connect, see that a controller answers, and begin to supervise.

        Raises:
            ConnectError: there is no controller.
        """
        if self._opened or self._closed:
            raise RuntimeError("a robot can be opened once; call aioduco.connect again")
        try:
            self.version = ControllerVersion(await open_lines(self))
        except BaseException:
            self._closed = True
            await insist(self.close_lines)
            raise
        for lane in self.lanes:
            lane.version = self.version.text
        self._opened = True
        self._parting = Parting(self.keeper)
        self._background.start(self._live(time.monotonic()), "aioduco sign of life")
        self._background.start(self.keeper.poller.run(), "aioduco poller")
        if self.settings.lag_limit is not None:
            self._watched = Watched(self._life, self.settings.lag_limit, self._loop_blocked())
            self._lag = monitors.watch(self._watched)

    def forget(self) -> None:
        """The robot was forgotten while it was open: stop what moves, and end the heartbeat."""
        if self._parting is not None:
            self._parting.take()
        if self.heartbeat is not None:
            self.heartbeat.end()

    def _loop_blocked(self) -> Callable[[float, str], None]:
        """What the lag monitor calls, on its thread."""
        seen: deque[LoopBlocked] = deque()
        ring = doorbell(lambda: self.events.tell(seen.popleft()))

        def blocked(seconds: float, where: str) -> None:
            seen.append(LoopBlocked(time.monotonic(), seconds, where))
            ring()

        return blocked

    async def aclose(self) -> None:
        """Leave by the ladder, see `ladder`: stop what moves, see it stand, close.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
        """
        if self._closed or not self._opened:
            return
        self._closed = True
        self.launcher.closed = "the robot is closed, or is being closed"
        await leave(self, self.settings.ladder)

    async def close_lines(self) -> None:
        """End everything that runs for the robot, and close its connections."""
        if self._parting is not None:
            self._parting.call_off()
        if self.heartbeat is not None:
            self.heartbeat.end()
        self.feed.close()
        self.events.close()
        await self._background.aclose()
        if self._lag is not None and self._watched is not None:
            monitors.leave(self._lag, self._watched, _GRACE)
            self._lag = None
        if self.guard is not None:
            await self.guard.give_up()
        for lane in self.lanes:
            await lane.aclose()
        if self.heartbeat is not None:
            self.heartbeat.join(_GRACE)

    async def under_guard(self) -> None:
        """Have the guard look after the robot, if there is to be one."""
        if self.guard is not None:
            await self.guard.take(self._guard_lost)
            self._life.touch(time.monotonic())

    def _guard_lost(self) -> None:
        """The guard is gone: its heartbeat has ended. Stop the arm, and start another guard."""
        if self._closed or self.guard is None:
            return
        _log.critical(
            "the guard of %s:%d is gone: the arm is stopped, and another guard is started",
            self.host,
            self.port,
        )
        self._background.start(self._new_guard(self.guard), "aioduco new guard")

    async def _new_guard(self, guard: Seat) -> None:
        if self.keeper.moving:
            try:
                await self.keeper.halt()
            except StopUnconfirmed as exc:
                _log.critical("the guard is gone, and %s", exc)
        await guard.give_up()
        try:
            await guard.take(self._guard_lost)
        except DucoError as exc:
            _log.critical("no other guard could be started: %s", exc)

    async def _live(self, due: float) -> None:
        """Show that the event loop runs, first at `due`."""
        every = min(self.settings.loop_stall_limit / _SIGNS, _SIGN_EVERY)
        while True:
            self._life.touch(due)
            now = time.monotonic()
            due = max(due + every, now)
            await anyio.sleep(due - now)

    def _crashed(self, error: BaseException) -> None:
        """Part of the supervision failed: without a heartbeat the controller stops the arm."""
        self.launcher.closed = f"the supervision of the robot failed ({error!r}); open it anew"
        if self.heartbeat is not None:
            self.heartbeat.end()
