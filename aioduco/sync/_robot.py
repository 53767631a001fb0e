"""The robot for blocking programs."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

from aioduco import robot as aio_robot
from aioduco.models import ranges
from aioduco.sync._feeds import Events, Feed
from aioduco.sync._generated import Sections
from aioduco.sync._recording import Publication, Recording
from aioduco.sync._runner import Runner
from aioduco.sync._tasks import Task

if TYPE_CHECKING:
    from contextlib import AbstractContextManager
    from os import PathLike
    from types import TracebackType
    from typing import Self

    from aioduco.controller_clock import Clock
    from aioduco.envelope import Envelope
    from aioduco.supervision.heartbeat import HeartbeatStatistics
    from aioduco.supervision.settings import ExitLadder, GuardKind
    from aioduco.supervision.supervisor import SupervisorStatistics
    from aioduco.supervision.task import OnCancel
    from aioduco.trace import Trace

__all__ = ["Robot", "connect"]


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
    exit_ladder: ExitLadder | None = None,
    guard: GuardKind | None = None,
    state_rate: float = 50.0,
    lag_limit: float | None = 0.25,
    trace: Trace | None = None,
    record: str | PathLike[str] | None = None,
    clock: Clock | None = None,
    hold_limit: float | None = 1.0,
    program_limit: float | None = None,
) -> Robot:
    """Create a robot; `with` connects to it, and stops the arm when its block is left.

        with aioduco.sync.connect("192.168.1.10") as robot:
            robot.bring_up()
            robot.motion.movej2(home, v=1.0, a=1.0)

    The robot runs in an event loop on a thread of its own. So the heartbeat shows the controller
    that this thread is alive, not that the program's own thread is. `hold_limit` and
    `program_limit` stop motions when the program's own thread makes no calls.

    Args:
        host: name or address of the controller; 192.168.1.10 by the factory setting.
        port: its TCP port.
        call_timeout: maximum seconds for a call, the wait for a connection included.
        connect_timeout: maximum seconds for opening a connection.
        pool_size: maximum number of connections for calls other than motions and supervision, 1 to
            64.
        heartbeat: seconds without a heartbeat of the robot's thread after which the controller
            stops the arm, 0.2 to 60; None for no heartbeat: a lost connection then stops nothing.
        loop_stall_limit: seconds for which the robot's thread may fail to run. After that the
            program counts as hung, and the heartbeat is withheld.
        on_cancel: what happens to the arm when a wait for a motion is interrupted: "stop",
            "pause", or "detach" (it moves on).
        stop_timeout: seconds within which the controller must accept a stop.
        standstill_timeout: seconds within which the arm must stand after that.
        unanswered_timeout: maximum seconds to wait, after its call_timeout, for a motion that was
            sent and not answered. The arm is stopped at once, but the motion may reach the
            controller late, and no wait for it returns before that is ruled out.
        exit_ladder: the steps when the robot is closed, and the time for each of them; None for
            all of them, with the times above.
        guard: "process" to run stop and heartbeat in a small process of their own, one for all
            robots of the program. None: on threads of the program.
        state_rate: samples of the state per second, once `robot.feed` is used, up to 1000 [Hz].
        lag_limit: seconds for which the robot's thread may be blocked without a warning that
            says where; None for no warnings.
        trace: a hook for each call and each connection, see `aioduco.trace`; it is called on the
            robot's threads.
        record: a file, such as "run.mcap", to which the robot is recorded from its opening to its
            closing; `Robot.recording` is that recording. An existing file is kept: a number is
            added to the name. None for no recording; `Robot.record` makes one at any time.
        clock: the controller's time, by which times of the arm are measured; None for the time of
            this computer, which is right for every real arm. It is read on the robot's thread.
        hold_limit: seconds for which the thread that started a motion without an end of its own (a
            jog, a velocity, with `time=None`) may make no call on the robot. After that the motion
            is stopped. None for no limit. A call in progress counts, and so does `Robot.sleep`.
        program_limit: the same for every motion that was started; None for no limit: a motion
            to a target then continues to its target, whatever the program does.

    Returns:
        The robot, not connected yet.

    Raises:
        ParameterError: an argument is out of range.

    Manual section 1.3.1.
    """
    for name, limit in (("hold_limit", hold_limit), ("program_limit", program_limit)):
        if limit is not None:
            ranges.TIMEOUT(name, limit)
    robot = aio_robot.connect(
        host,
        port,
        call_timeout=call_timeout,
        connect_timeout=connect_timeout,
        pool_size=pool_size,
        heartbeat=heartbeat,
        loop_stall_limit=loop_stall_limit,
        on_cancel=on_cancel,
        stop_timeout=stop_timeout,
        standstill_timeout=standstill_timeout,
        unanswered_timeout=unanswered_timeout,
        exit_ladder=exit_ladder,
        guard=guard,
        state_rate=state_rate,
        lag_limit=lag_limit,
        trace=trace,
        record=record,
        clock=clock,
    )
    return Robot(Runner(robot, hold_limit, program_limit))


class Robot(Sections):
    """A robot arm and its controller. Made by `connect`, used in `with`.

    Any thread may use it. Calls return when they are done; an interrupt (Ctrl-C) in a call that
    waits for a motion stops the arm before it is raised. Leaving the `with` block stops this
    program's motions, waits until the arm stands, and closes the robot. The end of a program that
    did not close the robot does the same.
    """

    def __init__(self, runner: Runner) -> None:
        super().__init__(runner, runner.robot)
        self._feed: Feed | None = None
        self._events: Events | None = None

    def __repr__(self) -> str:
        return repr(self._robot)

    def __del__(self) -> None:
        runner = getattr(self, "_runner", None)
        if runner is not None and runner.running:
            warnings.warn(f"unclosed {self!r}", ResourceWarning, source=self, stacklevel=2)
            runner.ask_to_close()

    @property
    def host(self) -> str:
        """Name or address of the controller."""
        return self._robot.host

    @property
    def port(self) -> int:
        """Its TCP port."""
        return self._robot.port

    def open(self) -> None:
        """Connect, check that a controller answers, and start the heartbeat.

        This is for notebooks and interactive prompts: between two cells, and while a cell computes,
        the heartbeat continues. Programs use `with`, which closes the robot in every case.

        Raises:
            ConnectError: the host is unknown, the port is closed, or nothing answers.
            NotAController: something other than a controller answers.
            ConnectTimeout: something accepts connections, but does not answer.
            RobotStateError: it was opened before.
        """
        self._runner.open()

    def close(self) -> None:
        """Stop this program's motions, wait until the arm stands, end the heartbeat, close.

        This runs to its end even if it is interrupted.

        Raises:
            StopUnconfirmed: it is not known that the arm stands.
        """
        self._runner.close()

    if not TYPE_CHECKING:  # hidden from type checkers, since these methods only raise an error

        async def __aenter__(self) -> None:
            raise TypeError(
                "this robot is for programs that do not await: write `with aioduco.sync.connect(…) "
                "as robot`, or `async with aioduco.connect(…) as robot`. Nothing was sent"
            )

        async def __aexit__(self, *_: object) -> None:
            """Do nothing: Python looks this method up before it calls `__aenter__`."""

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks of this program that have not ended, in the order of their acceptance."""
        return tuple(Task(self._runner, task) for task in self._robot.tasks)

    @property
    def heartbeat(self) -> HeartbeatStatistics | None:
        """State and figures of the heartbeat; None without one."""
        return self._robot.heartbeat

    def statistics(self) -> SupervisorStatistics:
        """Figures of lanes, tasks, stops and heartbeat since the robot was opened."""
        return self._runner.call_sync(self._robot.statistics)

    @property
    def feed(self) -> Feed:
        """Samples of the robot's state at a steady rate; the sampling begins at the first use."""
        if self._feed is None:
            self._feed = Feed(self._runner, self._robot.feed)
        return self._feed

    @property
    def events(self) -> Events:
        """The robot's events, as they are observed."""
        if self._events is None:
            self._events = Events(self._runner, self._robot.events)
        return self._events

    @property
    def envelope(self) -> Envelope | None:
        """The limits within which the arm is kept; see `aioduco.Robot.envelope`."""
        return self._robot.envelope

    @envelope.setter
    def envelope(self, envelope: Envelope | None) -> None:
        def use() -> None:
            self._robot.envelope = envelope

        self._runner.call_sync(use)

    def record(self, path: str | PathLike[str], *, forces: bool = True) -> Recording:
        """Record the robot to an MCAP file: `with robot.record("run.mcap"):`.

        The file gets the samples of the feed at its rate, commands with their answers, tasks,
        events, figures and set-points of streams, and this package's log lines. Nothing waits for
        the file; if it cannot be written any more, the recording ends, and the program continues.

        Args:
            path: the file. An existing file is kept: a number is added to the name.
            forces: whether samples include forces: two more calls to the controller for each
                sample, see `Feed.forces`.

        Returns:
            The recording, not started yet. Closing the robot ends it.

        Raises:
            ParameterError: the path is not the name of a file.
        """
        made = self._runner.call_sync(lambda: self._robot.record(path, forces=forces))
        return Recording(self._runner, made)

    def publish(
        self, port: int = 8765, *, host: str = "127.0.0.1", forces: bool = True
    ) -> Publication:
        """Publish the robot live on a WebSocket: `with robot.publish():`.

        Every watcher that connects gets the data that `record` writes to a file, on the same
        channels. Foxglove and Lichtblick show it, and any program with Foxglove's protocol reads
        it. Watchers cannot send commands. Nothing waits for them: a watcher that is too slow loses
        messages.

        Args:
            port: port to listen on; 0 for a free one, see `Publication.port`.
            host: address of this computer to listen on. An address other than loopback lets
                everybody in that network watch: there is no password.
            forces: whether samples include forces: two more calls to the controller for each
                sample, see `Feed.forces`.

        Returns:
            The publication, not started yet. Closing the robot ends it.

        Raises:
            ParameterError: an argument is out of range.
        """
        made = self._runner.call_sync(lambda: self._robot.publish(port, host=host, forces=forces))
        return Publication(self._runner, made)

    @property
    def recording(self) -> Recording | None:
        """The recording that `connect(record=)` asked for; None without one."""
        made = self._robot.recording
        return None if made is None else Recording(self._runner, made)

    def sleep(self, seconds: float) -> None:
        """Wait. Unlike `time.sleep`, this counts as a call: see `hold_limit` of `connect`.

        Args:
            seconds: duration of the wait [s].

        Raises:
            ParameterError: the duration is below 0.
        """
        self._runner.sleep(ranges.WAIT("seconds", seconds))

    def permit(self, name: str = "block") -> AbstractContextManager[None]:
        """Tie all that moves the arm in a block together: after a stop, nothing of it is sent.

        It works as `aioduco.Robot.permit`, for the calls of this thread.

        Args:
            name: what the block does, for messages.

        Raises:
            RobotStateError: the robot is not open.
            HeartbeatLost: the heartbeat does not beat, or the program hung.
            TaskStopped: an outer block has ended.
        """
        return self._robot.permit(name)

    def stop_now(self, timeout: float = 2.0) -> None:
        """Send a stop from any thread or signal handler; it needs no event loop.

        It returns when the controller has accepted the stop; the arm is then slowing down.

        Args:
            timeout: seconds within which a stop must be accepted.

        Raises:
            StopUnconfirmed: no stop was accepted: press the emergency stop.

        Manual section 1.3.3.
        """
        self._robot.stop_now(timeout)
