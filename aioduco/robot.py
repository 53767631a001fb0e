"""The robot: `connect` creates a `Robot`, the object that a program works with."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterable
from contextlib import AsyncExitStack, contextmanager
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING

import anyio

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco.errors import (
    DucoError,
    MissingExtra,
    ParameterError,
    RobotStateError,
    StopsUnconfirmed,
)
from aioduco.models.address import host_alone
from aioduco.models.controller_clock import WallClock
from aioduco.models.host_port import host_port
from aioduco.models.names import ManualNames
from aioduco.models.ranges import OWN_NAME_OR_NONE, PORT
from aioduco.models.ranges import TIMEOUT as SECONDS
from aioduco.models.similar import MisspeltRefused
from aioduco.models.trace import ProcedureFinished, emit
from aioduco.supervision.concurrency import BackgroundTasks, DaemonThread
from aioduco.supervision.permits import asked_at_call
from aioduco.supervision.settings import RobotSettings

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from contextlib import AbstractContextManager
    from os import PathLike
    from types import TracebackType
    from typing import Any, Self

    from aioduco.api.blocking import BlockingMotions
    from aioduco.api.bus import Bus
    from aioduco.api.compound import Compound
    from aioduco.api.external_axes import ExternalAxes
    from aioduco.api.force import Force
    from aioduco.api.frames import Frames
    from aioduco.api.io import IO
    from aioduco.api.kinematics import Kinematics
    from aioduco.api.log import Log
    from aioduco.api.modbus import Modbus
    from aioduco.api.motion import Motion
    from aioduco.api.optimization import Optimization
    from aioduco.api.program import Program
    from aioduco.api.realtime import Realtime
    from aioduco.api.registers import Registers
    from aioduco.api.service import Service
    from aioduco.api.settings import Settings as SettingsSection
    from aioduco.api.state import State
    from aioduco.api.streams.servo import Servo
    from aioduco.api.streams.speed import Speed
    from aioduco.api.system import System
    from aioduco.api.track import Track
    from aioduco.api.version import Version
    from aioduco.envelope import Envelope
    from aioduco.kinematics.mounting import MountingLike
    from aioduco.models.controller_clock import Clock
    from aioduco.models.trace import Trace
    from aioduco.recording.recorder import Publication, Recording, RobotObserver
    from aioduco.sim.twin.limits import TwinLimits
    from aioduco.sim.twin.twin import Twin, TwinAction
    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.supervision.bringup import RecoverReport
    from aioduco.supervision.events import Events
    from aioduco.supervision.heartbeat import HeartbeatStatistics
    from aioduco.supervision.permits import Permits
    from aioduco.supervision.settings import ClosingSteps, GuardKind
    from aioduco.supervision.state_feed import Snapshot, StateFeed
    from aioduco.supervision.supervisor import SupervisorStatistics
    from aioduco.supervision.task import OnCancel, Task

__all__ = ["Robot", "connect", "stop_all"]

#: sections with functions of the wire; `Robot` declares their types, and makes each when it is
#: first used
_SECTIONS = (
    *("system", "program", "compound", "external_axes", "state", "io", "registers", "bus"),
    *("frames", "kinematics", "settings", "optimization", "force", "modbus", "log", "service"),
    "version",
)
#: sections with functions of the wire and with streams
_SECTIONS_WITH_STREAMS = ("motion", "track", "realtime")
#: the sections of which "blocking" has motions
_BLOCKED = ("motion", "program", "track", "external_axes", "force")
#: sections with streams alone
_STREAMS = ("servo", "speed")
#: what a robot that is open may need besides: it is loaded before
_NEEDED_OPEN = frozenset(
    {
        *("numpy", "aioduco._wire.thrift", "aioduco.streaming.endpoint"),
        *map("aioduco.api.{}".format, (*_SECTIONS, *_SECTIONS_WITH_STREAMS, "blocking")),
        *map("aioduco.api.streams.{}".format, _STREAMS),
    }
)
#: names of classes that do not follow from the section's
_CLASSES = {"io": "IO", "blocking": "BlockingMotions"}


def _load_needed() -> None:
    for module in sorted(_NEEDED_OPEN):
        import_module(module)


def _load(name: str) -> Callable[..., object]:
    """Import the class of a section: it has the section's name, as its module has."""
    module = import_module(f"aioduco.api.{'streams.' if name in _STREAMS else ''}{name}")
    kind: Callable[..., object] = getattr(module, _CLASSES.get(name, name.title().replace("_", "")))
    return kind


def connect(
    host: str,
    port: int = 7003,
    *,
    call_timeout: float = 2.0,
    connect_timeout: float = 3.0,
    pool_size: int = 4,
    heartbeat: float | None = 1.0,
    loop_stall_limit: float = 1.0,
    on_cancel: OnCancel = "stop",
    stop_timeout: float = 5.0,
    standstill_timeout: float = 5.0,
    unanswered_timeout: float = 60.0,
    closing_steps: ClosingSteps | None = None,
    guard: GuardKind | None = None,
    state_rate: float = 50.0,
    lag_limit: float | None = 0.25,
    trace: Trace | None = None,
    record: str | PathLike[str] | None = None,
    clock: Clock | None = None,
) -> Robot:
    """Create a robot; `async with` connects to it, and leaves the arm standing at the end.

        async with aioduco.connect("192.168.1.10") as robot:
            await robot.bring_up()
            await robot.motion.movej2(home, v=1.0, a=1.0)

    Args:
        host: name or address of the controller; 192.168.1.10 by the factory setting.
        port: its TCP port.
        call_timeout: maximum seconds for a call, the wait for a connection included.
        connect_timeout: maximum seconds for opening a connection.
        pool_size: maximum number of connections for calls other than motions and supervision, 1 to
            64.
        heartbeat: seconds without a heartbeat of this program after which the controller
            stops the arm, 0.2 to 60; None for no heartbeat: a lost connection then stops
            nothing, and only a guard stops the arm of a program that hangs or is killed.
        loop_stall_limit: seconds for which the event loop may fail to run, from 0.05. After that
            the program counts as hung, and the heartbeat is withheld.
        on_cancel: what happens to the arm when the await of a motion is cancelled: "stop",
            "pause", or "detach" (it moves on).
        stop_timeout: seconds within which the controller must accept a stop.
        standstill_timeout: seconds within which the arm must stand after that.
        unanswered_timeout: maximum seconds, after its call_timeout, to wait for the answer to a
            motion. The arm is stopped at once, but the motion may reach the controller late, and
            an await of it returns only when that is ruled out.
        closing_steps: the steps when the robot is closed, with a time limit for each; None for all
            steps, with the times above.
        guard: "process" to send the heartbeat from a small separate process, one for all robots
            of the program, which stops the arm at once when the program dies. None: from a thread
            of the program.
        state_rate: samples of the state per second, once `robot.feed` is used, up to 1000 [Hz].
        lag_limit: seconds for which the event loop may be blocked before a warning names the
            blocking line, from 0.01; None for no warnings.
        trace: a hook that is called for each call and each connection, see `aioduco.models.trace`.
        record: a file, such as "run.mcap", to which the robot is recorded from its opening to its
            closing; `Robot.recording` is that recording. An existing file is kept: a number is
            added to the name. None for no recording; `Robot.record` makes one at any time.
        clock: the controller's clock, by which times of the arm are measured: how long a jog
            lasts, deadlines of motions, how long they have run. None for the clock of this
            computer, which is right for every real arm; a simulated arm that runs faster has its
            own, `Simulator.clock`. Time-outs, heartbeat and stops use this computer's clock.

    Returns:
        The robot, not connected yet.

    Raises:
        ParameterError: an argument is out of range.

    Manual section 1.3.1.
    """
    return Robot(
        host,
        port,
        RobotSettings(
            call_timeout=call_timeout,
            connect_timeout=connect_timeout,
            pool_size=pool_size,
            heartbeat=heartbeat,
            loop_stall_limit=loop_stall_limit,
            on_cancel=on_cancel,
            stop_timeout=stop_timeout,
            standstill_timeout=standstill_timeout,
            unanswered_timeout=unanswered_timeout,
            closing_steps=closing_steps,
            guard=guard,
            state_rate=state_rate,
            lag_limit=lag_limit,
            trace=trace,
            record=record,
            clock=WallClock() if clock is None else clock,
        ),
    )


async def stop_all(robots: Iterable[Robot]) -> None:
    """Stop several arms (停止所有机械臂), and wait until all stand.

    All stops are sent before anything else runs on the event loop, however busy it is. Each stop
    then continues to its end, as `Robot.stop`, whatever happens to the others.

    Args:
        robots: the robots, all of this event loop.

    Raises:
        ParameterError: this is no list of robots; no stop was sent.
        StopsUnconfirmed: it is not known that some of the arms stand, or their robots were not
            open, or are no robots: press their emergency stops. The other arms stand.

    Manual section 1.3.3.
    """
    if isinstance(robots, Robot):  # in place of a list: what is meant as a stop stops
        robots = (robots,)
    if not isinstance(robots, Iterable):
        raise ParameterError("robots", robots, "a list of robots")
    chosen = tuple(robots)
    known = [isinstance(robot, Robot) for robot in chosen]
    errors: list[DucoError | None] = [None] * len(chosen)
    for index, robot in enumerate(chosen):
        if not known[index]:  # the others are stopped nevertheless
            errors[index] = RobotStateError(f"{robot!r} is no robot that `connect` returned")
            continue
        try:
            robot._supervisor.check_open("stop")
            robot._supervisor.stop_coordinator.begin_stop()
        except DucoError as exc:
            errors[index] = exc

    async def stop(index: int) -> None:
        try:
            await chosen[index].stop()
        except DucoError as exc:
            errors[index] = exc

    async with anyio.create_task_group() as tasks:
        for index, error in enumerate(errors):
            if error is None:
                tasks.start_soon(stop, index)
    if (first := next(filter(None, errors), None)) is not None:
        places = [
            host_port(robot.host, robot.port) if known[index] else f"robots[{index}]"
            for index, robot in enumerate(chosen)
        ]
        raise StopsUnconfirmed.of(places, errors) from first


class Robot(Uncopied, ManualNames, MisspeltRefused):
    """A robot arm and its controller. Created by `connect`, used in `async with`.

    Entering the block connects, reads the controller's state and version, and starts the
    heartbeat. Leaving it runs the steps of `ClosingSteps`, each with a deadline, whatever happened
    inside: the robot stops what this program moves and waits until the arm stands, leaves the modes
    that the program entered, ends the heartbeat, and closes the connections.

    Attributes:
        host: name or address of the controller.
        port: its TCP port.
        system: power, brakes, operation mode.
        motion: motions, jogs, hand guiding, joint trajectories.
        blocking: motions by the manual's blocking calls, which return the state of their task.
        servo: streams of positions to follow.
        speed: streams of speeds.
        program: programs and files of the controller.
        track: the track pool, and streams into it.
        compound: the weave that is superimposed on motions.
        external_axes: external axes.
        realtime: streams through the realtime queue, and the queue call by call.
        state: state of the arm and of the controller.
        io: inputs and outputs.
        registers: registers and variables of the controller.
        bus: RS-485 and CAN.
        frames: tools, work objects, loads.
        kinematics: kinematics, as the controller computes it.
        settings: speeds, collision detection, simulation, pendant.
        optimization: how motions are optimized.
        force: force control.
        modbus: signals over Modbus.
        log: the controller's log and its pendant.
        service: functions for the factory: only to be used by its instructions.
        version: type of the arm, version of the software.
    """

    system: System
    motion: Motion
    blocking: BlockingMotions
    servo: Servo
    speed: Speed
    program: Program
    track: Track
    compound: Compound
    external_axes: ExternalAxes
    realtime: Realtime
    state: State
    io: IO
    registers: Registers
    bus: Bus
    frames: Frames
    kinematics: Kinematics
    settings: SettingsSection
    optimization: Optimization
    force: Force
    modbus: Modbus
    log: Log
    service: Service
    version: Version

    def __init__(self, host: str, port: int, settings: RobotSettings) -> None:
        host = host_alone(host)
        port = PORT("port", port)
        # Loaded here and not at import: `import aioduco` stays quick.
        from aioduco.supervision.supervisor import Supervisor  # noqa: PLC0415

        self.host = host
        self.port = port
        if trial.current is not None:
            host, port, _ = trial.current.endpoint(host, port, settings.connect_timeout)
            settings = trial.current.settings(settings)
        self._supervisor = Supervisor(host, port, settings)
        self._record = settings.record
        if self._record is not None:
            import_module("aioduco.recording.recorder")  # here it blocks no event loop
        self._recording: Recording | None = None
        self._observers: list[RobotObserver] = []
        self._twins: list[Twin] = []

    if not TYPE_CHECKING:  # a type checker would otherwise accept every name

        def __getattr__(self, name: str) -> object:
            """Make a section when it is first used."""
            if name in _SECTIONS:
                section = _load(name)(self._supervisor)
            elif name in _SECTIONS_WITH_STREAMS:
                section = _load(name)(self._supervisor, self._endpoint)
            elif name == "blocking":
                others = (getattr(self, other) for other in _BLOCKED)
                section = _load(name)(self._supervisor, *others)
            elif name in _STREAMS:
                section = _load(name)(self._endpoint)
            else:
                return super().__getattr__(name)
            return vars(self).setdefault(name, section)  # another thread may have made it, too

    def __dir__(self) -> list[str]:
        made = (*_SECTIONS, *_SECTIONS_WITH_STREAMS, *_STREAMS, "blocking")
        return sorted({*super().__dir__(), *made})

    @cached_property
    def _endpoint(self) -> StreamEndpoint:
        """The end of the streams."""
        from aioduco.streaming.endpoint import StreamEndpoint  # noqa: PLC0415  # with the streams

        return StreamEndpoint.of(self._supervisor)

    @property
    def _permits(self) -> Permits:
        return self._supervisor.permits

    def __repr__(self) -> str:
        where, tasks = host_port(self.host, self.port), len(self.tasks)
        return f"<Robot {where} {self._supervisor.state}, {tasks} live tasks>"

    def __del__(self) -> None:
        supervisor = getattr(self, "_supervisor", None)
        if supervisor is not None and supervisor.state == "open":
            unclosed = f"unclosed {self!r}"
            if supervisor.forget():
                closing = BackgroundTasks(lambda _: None)
                supervisor.owner_loop.run(
                    lambda: closing.start(supervisor.aclose(), "aioduco close")
                )
            # Last: it may raise or block if the program makes warnings errors, or shows them.
            warnings.warn(unclosed, ResourceWarning, source=self, stacklevel=2)

    async def open(self) -> None:
        """Connect, check that a controller answers, and start the heartbeat.

        For fixtures, and for applications that call `aclose` in a `finally`; programs use `async
        with`, which always closes the robot. Not for notebooks, which use `aioduco.sync`: a cell
        that computes, or waits for a person, blocks the event loop, and with it the heartbeat, so
        that the controller stops the arm.
        From now on the robot belongs to the event loop that runs: on any other loop, an await of it
        raises `WrongLoop` before anything is sent.

        Raises:
            WrongLoop: no event loop of asyncio runs here; a loop of trio does not count.
            ConnectError: the host is unknown, the port is closed, or nothing answers.
            NotAController: something other than a controller answers.
            ConnectTimeout: something accepts connections, but does not answer.
            RecordingError: the file of `connect(record=)` cannot be written.
        """
        self._supervisor.owner_loop.require("open")
        with trial.untimed():
            await self._load()
            await self._supervisor.open()
        if self._record is not None:
            try:
                self._recording = await self.record(self._record).start()
            except BaseException:
                await self.aclose()
                raise

    async def _load(self) -> None:
        """Load what an open robot may need, on a thread: later no import blocks the event loop."""
        if sys.modules.keys() >= _NEEDED_OPEN:
            return
        try:
            thread = DaemonThread("aioduco-load")
        except RuntimeError:  # there are no more threads
            _load_needed()
            return
        _, cancelled = await thread.run(_load_needed)
        thread.end()
        if cancelled is not None:
            raise cancelled

    async def aclose(self) -> None:
        """Stop what this program moves, wait until it stands, end the heartbeat, and close.

        It runs to its end even if it is cancelled. While another task closes the robot, it waits
        for the end of that. If the robot's own event loop has been closed, it may run on any other
        one. In a forked child it does nothing.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
            WrongLoop: the robot belongs to another event loop, which must close it.
        """
        try:
            await self._supervisor.aclose()
        finally:
            # The recordings last, so that the closing of the robot is recorded, too.
            async with AsyncExitStack() as ends:  # each ends, whatever another one raises
                for observer in self._observers:
                    ends.push_async_callback(observer.stop)
                for twin in self._twins:
                    ends.push_async_callback(twin.stop)

    if not TYPE_CHECKING:  # hidden from type checkers, which then report their use

        def __enter__(self) -> None:
            raise TypeError(
                "this robot is for programs that await: write `async with aioduco.connect(…) as "
                "robot`, or `with aioduco.sync.connect(…) as robot` in a program that does not. "
                "Nothing was sent"
            )

        def __exit__(self, *_: object) -> None:
            """Do nothing: Python needs this method before it calls `__enter__`."""

        def __await__(self) -> None:
            raise TypeError(
                "a robot is not awaited: write `async with aioduco.connect(…) as robot`, or "
                "`robot = aioduco.connect(…)` and `await robot.open()`. Nothing was sent"
            )

    async def __aenter__(self) -> Self:
        await self.open()
        return self

    async def __aexit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        await self.aclose()

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The live tasks of this program, in the order of their acceptance."""
        return self._supervisor.stop_coordinator.follower.tasks

    @property
    def heartbeat(self) -> HeartbeatStatistics | None:
        """State and statistics of the heartbeat; None without a heartbeat."""
        heartbeat = self._supervisor.heartbeat
        return heartbeat.statistics() if heartbeat is not None else None

    def statistics(self) -> SupervisorStatistics:
        """Return statistics of lanes, tasks, stops and heartbeat since the robot was opened."""
        return self._supervisor.statistics()

    async def bring_up(self, *, timeout: float = 30.0) -> RecoverReport:
        """Bring the arm into a state in which it can move: power on, enable, clear.

        A safety stop is cleared by powering off and on, a collision by its reset. Each step is
        taken when the controller's states require it, and has ended when they show its effect. A
        motion or a program that is paused or runs is left alone: see `recover`, `stop`, `resume`.

        A controller that enables its arm tares the force sensor. If the arm touches something
        then, as after a collision, it measures that force as zero: the report's `advice` says so.

        Args:
            timeout: seconds in which the arm must be ready.

        Returns:
            The states, enabled and with no program running, and what to do before forces are
            measured.

        Raises:
            RobotStateError: a person has to do something first, such as to release the emergency
                stop; something is paused or runs; or the arm is not ready in time. The message says
                which.
            TaskStopped: the robot was stopped or paused meanwhile; no further step was sent.
        """
        from aioduco.supervision.bringup import bring_up  # noqa: PLC0415  # loaded with Thrift

        with self._traced("bring_up"):
            return await bring_up(self._supervisor, timeout)

    async def recover(self, *, timeout: float = 30.0) -> RecoverReport:
        """Bring the arm out of a stop: clear, power off and on if needed, enable.

        It works as `bring_up`, and returns the same. In addition, it ends a motion or a program
        that is paused or runs in the controller, and restarts a heartbeat that was withheld. It
        moves nothing.

        Args:
            timeout: seconds in which the arm must be ready.

        Returns:
            The states, enabled and with no program running, and what to do before forces are
            measured.

        Raises:
            PersonNeeded: a person has to do something first: the message says what.
            RobotStateError: the arm is not ready in time.
            TaskStopped: the robot was stopped or paused meanwhile; no further step was sent.
            HeartbeatLost: no heartbeat was answered.
        """
        from aioduco.supervision.bringup import recover  # noqa: PLC0415  # loaded with Thrift

        with self._traced("recover"):
            report = await recover(self._supervisor, timeout)
            await self.rearm_heartbeat()
        return report

    @contextmanager
    def _traced(self, name: str) -> Iterator[None]:
        """Report the end of a procedure to the trace hook."""
        trace = self._supervisor.settings.trace
        if trace is None:
            yield
            return
        begin = time.monotonic()
        error: BaseException | None = None
        try:
            yield
        except BaseException as exc:
            error = exc
            raise
        finally:
            now = time.monotonic()
            emit(trace, ProcedureFinished(now, "", name, error, now - begin))

    @property
    def feed(self) -> StateFeed:
        """Samples of the robot's state at a steady rate; it starts on first use."""
        return self._supervisor.feed

    @property
    def events(self) -> Events:
        """Events of the robot, reported when they are detected."""
        return self._supervisor.events

    def record(self, path: str | PathLike[str], *, forces: bool = True) -> Recording:
        """Record the robot to an MCAP file: `async with robot.record("run.mcap"):`.

        It records the samples of the feed at its rate, commands with their answers, tasks,
        events, statistics and set-points of streams, and this package's log lines. Nothing waits
        for the file; if it cannot be written any more, the recording ends, and the program
        continues.

        Args:
            path: the file. An existing file is kept: a number is added to the name.
            forces: whether samples have forces, too: two more reads from the controller for each,
                see `StateFeed.forces`.

        Returns:
            The recording, not started yet. Closing the robot ends it.

        Raises:
            ParameterError: the path is not the name of a file.
        """
        from aioduco.recording.recorder import Recording  # noqa: PLC0415  # with its extra

        recording = Recording(self._supervisor, path, forces)
        self._observed(recording)
        return recording

    def publish(
        self, port: int = 8765, *, host: str = "127.0.0.1", forces: bool = True
    ) -> Publication:
        """Publish the robot live on a WebSocket: `async with robot.publish():`.

        Every client that connects gets what `record` writes to a file, on the same channels:
        Foxglove and Lichtblick show it, and any program that speaks Foxglove's protocol can read
        it. Clients can only read. Nothing waits for them: a client that is too slow loses messages.

        Args:
            port: port to listen on; 0 for a free one, which is then in `Publication.port`.
            host: address of this computer to listen on. With anything but loopback, everybody in
                that network can read: there is no password.
            forces: whether samples have forces, too: two more reads from the controller for each,
                see `StateFeed.forces`.

        Returns:
            The publication, not started yet. Closing the robot ends it.

        Raises:
            ParameterError: an argument is out of range.
        """
        from aioduco.recording.recorder import Publication  # noqa: PLC0415  # with its extra

        publication = Publication(self._supervisor, port, host, forces)
        self._observed(publication)
        return publication

    def twin(
        self,
        limits: TwinLimits | None = None,
        *,
        action: TwinAction = "report",
        arm: str | None = None,
        mounting: MountingLike | None = None,
        commands: bool = True,
    ) -> Twin:
        """Watch the arm beside a simulated one: `async with robot.twin(limits):`.

        The simulated controller gets the same commands at the same time, and the arm's model its
        states. Where the two part by more than the limits, the event `TwinDiverged` says what,
        where, since when and the probable cause. Recordings of this robot have the differences,
        too. It runs in a process of its own, and reads forces with each sample.

        Args:
            limits: the limits, from `aioduco.sim.twin.learn`; None for wide ones.
            action: what happens when they part: "report", or also "pause" or "stop", as
                `Robot.pause` and `Robot.stop`. Otherwise the twin never commands the arm.
            arm: the arm, such as "gcr5_910"; None for the one that the controller reports.
            mounting: "floor", "wall" or "ceiling", as of a simulator, or pose of the base in the
                world [m, rad]; None for on the floor.
            commands: whether this program alone commands the arm. If not, nothing is said about
                paths, delays and other programs.

        Returns:
            The twin, not started yet. Closing the robot ends it.

        Raises:
            ParameterError: an argument is out of range.
            MissingExtra: the extra `sim` is not installed.
        """
        with MissingExtra.named("a twin", "sim"):
            import_module("mujoco")  # the twin's process needs it
        from aioduco.sim.twin.twin import Twin  # noqa: PLC0415  # with its extra

        def tell(topic: str, at: float, values: dict[str, Any]) -> None:
            for observer in self._observers:
                observer.tell(topic, at, values)

        twin = Twin(self._supervisor, tell, limits, action, arm, mounting, commands)
        self._twins = [other for other in self._twins if not other.over] + [twin]
        return twin

    def _observed(self, observer: RobotObserver) -> None:
        """Register a recording or publication, which ends when the robot is closed."""
        self._observers = [other for other in self._observers if not other.over] + [observer]

    @property
    def recording(self) -> Recording | None:
        """The recording that `connect(record=)` asked for; None without one."""
        return self._recording

    @property
    def envelope(self) -> Envelope | None:
        """The limits within which the arm is kept: zones, speeds, margins, forces; None for none.

            robot.envelope = Envelope("gcr5_910", Zone.plane((0, 0, 0.02), (0, 0, 1)))

        Each motion, and each set-point of a stream, is checked before it is sent, as far as its
        path is known. During all other movement, such as jogs and hand guiding, the state is
        watched, and the arm is stopped. Beyond a limit, only what is known to lead back is sent.
        The envelope may be set at any time; a stream keeps the one with which it was opened. The
        first motion is refused, with `ParameterError`, if the envelope is for another arm.

        Raises:
            ParameterError: the value is neither an Envelope nor None.
        """
        return self._supervisor.envelope.envelope

    @envelope.setter
    def envelope(self, envelope: Envelope | None) -> None:
        self._supervisor.envelope.use(envelope)

    async def wait_for(
        self, predicate: Callable[[Snapshot], bool], *, timeout: float | None = None
    ) -> Snapshot:
        """Wait for a sample of the state for which the predicate is true, and return it.

            await robot.wait_for(lambda s: s.io.input(3), timeout=5.0)

        Args:
            predicate: called with each new sample.
            timeout: seconds for which to wait; None for no limit.

        Raises:
            ParameterError: the time is not above 0, or the predicate is no function, or none that
                returns at once whether it holds.
            TimeoutError: no such sample came in time.
            RobotStateError: the robot was closed meanwhile.
        """
        self._supervisor.check_open("wait_for")
        return await self._supervisor.feed.wait_for(predicate, timeout=timeout)

    async def stop(self) -> None:
        """Stop the arm, all tasks included (停止所有任务), and wait until it stands.

        The stop never waits behind another call. It is repeated over fresh connections until the
        controller accepts it, and continues to its end even if this is cancelled. It also applies
        to a motion that is on its way to the controller. The awaits of running motions raise
        `TaskStopped`.

        Raises:
            StopUnconfirmed: it is not known that the arm stands: press the emergency stop.

        Manual section 1.3.3.
        """
        self._supervisor.check_open("stop")
        await self._supervisor.stop_coordinator.stop()

    def stop_now(self, timeout: float = 2.0) -> None:
        """Send a stop from any thread or signal handler; it needs no event loop.

        It returns when the controller has accepted the stop; the arm is then slowing down.

        Args:
            timeout: seconds within which the controller must accept a stop.

        Raises:
            ParameterError: the time is not above 0; nothing was sent.
            WrongProcess: this is a forked child; nothing was sent.
            StopUnconfirmed: it accepted none: press the emergency stop.

        Manual section 1.3.3.
        """
        self._supervisor.check_usable("stop")
        self._supervisor.stop_coordinator.stop_now(SECONDS("timeout", timeout))

    async def pause(self) -> bool:
        """Pause all tasks (暂停所有任务), and wait until the arm stands.

        An open stream ends, and the arm is stopped: nothing that it has sent goes on later. Beside
        a call of `robot.blocking`, it is stopped if nothing is said to be paused within
        `call_timeout`: the call may still come.

        Returns:
            Whether anything is paused, as far as the controller says it. If not, the next motion
            of any program is carried out at once.

        Raises:
            TaskError: the controller did not pause.
            StopUnconfirmed: the arm does not stand.

        Manual section 1.3.3.
        """
        self._supervisor.check_open("pause")
        return await self._supervisor.stop_coordinator.pause()

    @asked_at_call
    async def resume(self) -> bool:
        """Resume all paused tasks (恢复所有暂停的任务).

        If this raises after it was sent, the arm is stopped.

        Returns:
            Whether anything was paused, as far as the controller says it. If not, nothing changes.

        Raises:
            StaleState: the envelope is not watched; nothing was sent.
            TaskError: the controller did not resume.

        Manual section 1.3.3.
        """
        self._supervisor.check_open("resume")
        return await self._supervisor.stop_coordinator.resume()

    async def abort(self) -> None:
        """End the running motion and those read ahead, and wait until the arm stands.

        Manual 3.8 does not have it, but its wire does; manual 4.3 describes it. If it is
        interrupted, or the controller does not abort, the arm is stopped.

        Raises:
            TaskError: the controller did not abort: the arm was stopped.
            StopUnconfirmed: the arm does not stand.
        """
        self._supervisor.check_open("abort")
        await self._supervisor.stop_coordinator.abort()

    def permit(self, name: str = "block") -> AbstractContextManager[None]:
        """Tie all that moves the arm in a block together: after a stop, nothing of it is sent.

            with robot.permit("pick"):
                place = await find_part()
                await robot.motion.movel(place, v=0.2, a=0.5)
                await gripper.close()

        A motion that the program asks for after a stop is a new command, and is sent. In such a
        block it is refused if the arm was stopped, or the heartbeat lost, since the block was
        entered: for sequences that no one watches between their steps. It holds in the tasks that
        the block starts, too. A pause does not end it.

        Args:
            name: what the block does, for messages.

        Raises:
            ParameterError: the name is no text.
            RobotStateError: the robot is not open.
            HeartbeatLost: the heartbeat does not beat, or the program hung.
            TaskStopped: an outer block has ended.
        """
        OWN_NAME_OR_NONE("name", name)
        self._supervisor.check_usable(name)
        return self._supervisor.permits.undertaking(name)

    async def rearm_heartbeat(self, *, timeout: float = 2.0) -> None:
        """Resume the heartbeat after the event loop hung and the heartbeat was withheld.

        The controller has stopped the arm by then. This moves nothing; afterwards motions may be
        started again.

        Args:
            timeout: seconds within which a beat must be answered.

        Raises:
            ParameterError: the time is not above 0.
            HeartbeatLost: no beat was answered in time, or the event loop hung again.
        """
        await self._supervisor.rearm_heartbeat(timeout)
