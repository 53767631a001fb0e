"""The pick and place of `aioduco demo`: its motions, what is shown meanwhile, table, plot, result.

All lines are relative to the pose that the controller reports at the start position, so that a
mounted tool is taken into account. However it ends, the arm stands.
"""

from __future__ import annotations

import json
import math
import time
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

import anyio
import anyio.to_thread
import numpy as np
import typer
from rich.box import SIMPLE_HEAD
from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

import aioduco
from aioduco.cli import extras
from aioduco.cli.command_terms import in_commands
from aioduco.cli.exit_codes import write_file, writing
from aioduco.cli.monitor.screen import arm_table
from aioduco.cli.monitor.view_state import MonitorState
from aioduco.cli.output import log_about, say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.safe_console import SafeConsole
from aioduco.cli.sessions import observing_session, require_same_state, require_still_at
from aioduco.cli.signals import receive_signals
from aioduco.cli.status import joints_line, look, states_line
from aioduco.devices.grippers import DigitalGripper, gripper_model
from aioduco.errors import DucoError, RobotStateError, TaskError
from aioduco.kinematics import forward
from aioduco.models.enums import Outcome
from aioduco.models.host_port import host_port
from aioduco.models.pose import Joints, Pose
from aioduco.models.whole_files import whole_file
from aioduco.sim import scene as things
from aioduco.supervision.concurrency import first_error

if TYPE_CHECKING:
    import signal
    from collections.abc import Callable

    from numpy.typing import NDArray

    from aioduco.cli.addresses import RobotAddress
    from aioduco.kinematics import Arm
    from aioduco.models.controller_clock import Clock
    from aioduco.robot import Robot
    from aioduco.supervision.command import MotionCommand
    from aioduco.supervision.state_feed import Snapshot
    from aioduco.supervision.task import Task

    #: returns the place of the simulated box [m]; it may block
    Look = Callable[[], tuple[float, float, float]]


OUTPUT = Path("-")
SCHEMA = 1
GRIPPER_NAME = "parallel"  # the simulated one
#: joints of the simulated arm at the start, as if someone had left it there [rad]
LEFT = (-0.7, -0.4, 1.2, 0.1, -1.1, 0.2)
_SAMPLES = 100.0  # samples of the arm per second
_PATIENCE = 30.0  # seconds within which the arm must begin to move
_GRIPPER = 1  # general digital output of the cabinet that closes a gripper
_PART = 0.04  # length of the edges of the box that is picked up [m]
#: the simulated gripper's inputs: it holds something, it is open; and seconds within which they
#: answer even on a busy computer
_SENSORS: Final[dict[str, Any]] = {
    "holds": 1, "opened": 2, "travel_time": 10.0, "max_age": _PATIENCE
}  # fmt: skip
#: height above the table at which the box is released [m]
_ABOVE = 0.001
#: number of looks at the box; distance that every arm exceeds when it lifts and carries it [m]
_LOOKS, _MOVED = 3, 0.05
_GHOSTS = 7  # number of arms that are drawn along the way
_STYLES = {Outcome.FINISHED: "green", Outcome.BLENDED: "cyan", Outcome.STOPPED: "yellow"}


class Choreography:
    """Places and speeds of the demonstration.

    Args:
        reach: how far the arm reaches [m]; all lengths are parts of it.
        careful: whether to use a quarter of the speeds and accelerations, for a real arm.

    Attributes:
        start: joints at the begin and the end of the demonstration [rad].
        aside: joints to which it turns, for the pause and for the stop [rad].
        width: distance along y from the start to the pick, and from the start to the place [m].
        depth: distance from the start down to the part [m].
        blend: blend radius of the first line of the blended pair [m].
        joint_speed: speed of joint moves [rad/s].
        joint_acceleration: acceleration of joint moves [rad/s²].
        line_speed: speed of straight lines [m/s].
        line_acceleration: acceleration of straight lines [m/s²].
    """

    def __init__(self, reach: float, *, careful: bool) -> None:
        right, pace = math.pi / 2, 0.25 if careful else 1.0
        self.start: Joints = Joints(0.0, 0.0, right, 0.0, -right, 0.0)
        self.aside: Joints = Joints(1.3, -0.2, right - 0.3, 0.2, -right, 0.6)
        self.width: float = 0.25 * reach
        self.depth: float = 0.12 * reach
        self.blend: float = 0.03 * reach
        self.joint_speed: float = 1.2 * pace
        self.joint_acceleration: float = 4.0 * pace
        self.line_speed: float = 0.4 * pace
        self.line_acceleration: float = 1.5 * pace


def scene(arm: Arm, plan: Choreography) -> list[things.Thing]:
    """The box that a simulated arm picks up, and the table under the box."""
    flange = arm.fkine(plan.start)
    x, y, z = (float(value) for value in flange[:3, 3])
    middle = z - plan.depth - gripper_model(GRIPPER_NAME).length
    turn = math.atan2(flange[1, 1], flange[0, 1])
    box = things.Box(
        at=(x, y - plan.width, middle, 0.0, 0.0, turn),
        size=(_PART, _PART, _PART),
        mass=0.2,
        colour=(0.85, 0.3, 0.2),
        name="part",
    )
    size = (0.3 * arm.reach, 2.0 * plan.width + 0.2)
    return [things.Table(at=(x, y, middle - 0.5 * _PART), size=size), box]


@dataclass(slots=True)
class DemoMotion:
    """A motion of the demonstration.

    Attributes:
        name: purpose of the motion.
        function: the function of the wire protocol that moves the arm.
        expected: the expected outcome.
        task: its task; None until the controller accepts it.
        message: the error message if it did not end as expected.
    """

    name: str
    function: str
    expected: Outcome
    task: Task | None = None
    message: str = ""

    @property
    def outcome(self) -> Outcome | None:
        """The actual outcome; None while it runs, or if it never began."""
        return None if self.task is None else self.task.outcome

    @property
    def ok(self) -> bool:
        """Whether it ended as expected."""
        return self.outcome is self.expected

    @property
    def state(self) -> str:
        """The last observed state of its task."""
        return "sent" if self.task is None else self.task.state.name.lower()

    def told(self) -> Text:
        """Its outcome, or the state of its task while it runs."""
        if self.outcome is None:
            return Text(self.state, style="bold")
        if self.ok:
            return Text(self.outcome.value, style=_STYLES.get(self.outcome, "red"))
        return Text(f"{self.outcome.value}, expected {self.expected.value}", style="bold red")


class Demonstration:
    """Runs motions on a robot, shows them, and keeps what was observed.

    On a terminal a panel shows the arm while it moves; elsewhere, each event is a line.

    Args:
        model: name of the arm.
        controller: `host:port` that it runs on.
        console: where it is shown.
        speed: how many times faster than the wall clock a simulated controller runs.
        look: gives the place of the simulated box; None on an arm that is there.

    Attributes:
        samples: the samples that were taken.
        error: the error that ended the demonstration early; empty without one.
    """

    def __init__(
        self,
        model: str,
        controller: str,
        console: SafeConsole,
        *,
        speed: float = 1.0,
        look: Look | None = None,
    ) -> None:
        self._model, self._controller, self._speed = model, controller, speed
        self._console = console
        self._look = look
        self._origin = time.monotonic()
        self._motions: list[DemoMotion] = []
        self._notes: list[str] = []
        self._part: list[tuple[float, float, float]] = []
        self.samples: list[Snapshot] = []
        self.error: str = ""
        self.live: Live | None = None
        if console.is_terminal:
            self.live = Live(
                console=console, get_renderable=self._panel, refresh_per_second=12, transient=True
            )
        else:
            kind = "the arm" if look is None else "a simulated arm"
            self.note(f"demo on {kind} {model} at {controller}")

    # -- what the choreography does --------------------------------------------------------------

    async def watch(self, robot: Robot) -> None:
        """Take the samples of the arm until cancelled."""
        with robot.feed.subscribe() as samples:
            async for sample in samples:
                self.samples.append(sample)

    def note(self, text: str) -> None:
        """Show an event."""
        if self.live is None:
            self._console.print(text, soft_wrap=True)
        else:
            self._notes.append(text)

    async def see(self, where: str) -> None:
        """Record where the box is, if there is a simulated one; `where` describes the place."""
        if self._look is not None:
            self._part.append(await anyio.to_thread.run_sync(self._look))
            told = ", ".join(f"{1e3 * value:.0f}" for value in self._part[-1])
            self.note(f"the box: {where} at {told} mm")

    async def start(
        self, name: str, motion: MotionCommand, *, expect: Outcome = Outcome.FINISHED
    ) -> DemoMotion:
        """Send a motion, and return as soon as the controller accepted it."""
        made = DemoMotion(name, motion.command.name, expect)
        self._motions.append(made)
        made.task = await motion.start()
        return made

    async def finish(self, motion: DemoMotion) -> None:
        """Follow a motion to its end.

        Raises:
            TaskError: it did not end as expected.
        """
        assert motion.task is not None
        try:
            await motion.task
        except TaskError as error:
            if not motion.ok:
                motion.message = str(error)
                raise
        finally:
            if self.live is None:
                row = self._row(motion)
                self.note(
                    f"{motion.name}: {motion.told().plain} after {row['duration']:.2f} s, "
                    f"tracking error {_milliradians(row['tracking_error'])}"
                )

    async def move(self, name: str, motion: MotionCommand) -> None:
        """Make a motion and follow it to its end.

        Raises:
            TaskError: it did not finish.
        """
        await self.finish(await self.start(name, motion))

    def gripper(self, robot: Robot) -> DigitalGripper:
        """The gripper; a simulated one has sensors."""
        sensors = {} if self._look is None else _SENSORS
        return DigitalGripper(robot, _GRIPPER, timeout=_PATIENCE, **sensors)

    # -- what was observed -----------------------------------------------------------------------

    def curves(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Times [s], joints, and commanded minus actual joints [rad]. Shapes (n,), (n, 6)."""
        statuses = [sample.status for sample in self.samples]
        actual = np.array([each.joints for each in statuses], dtype=float).reshape(-1, 6)
        expected = np.array([each.expected_joints for each in statuses], dtype=float)
        times = np.array([each.received_at - self._origin for each in statuses])
        return times, actual, expected.reshape(-1, 6) - actual

    def _row(self, motion: DemoMotion) -> dict[str, Any]:
        """A motion with plain values."""
        task, begin, end = motion.task, 0.0, 0.0
        if task is not None:
            begin = task.accepted_at - self._origin
            end = (task.ended_at or time.monotonic()) - self._origin
        times, _, behind = self.curves()
        within = np.abs(behind[(begin <= times) & (times <= end)])
        return {
            "name": motion.name,
            "function": motion.function,
            "expected": motion.expected.value,
            "outcome": motion.outcome and motion.outcome.value,
            "state": motion.state,
            "task_id": None if task is None else task.id,
            "begin": begin,
            "end": end,
            "tracking_error": float(within.max()) if len(within) else None,
            "message": motion.message,
            "duration": end - begin,
            "ok": motion.ok,
        }

    def as_json(self) -> dict[str, Any]:
        """The result with plain values, without the samples themselves."""
        carried: bool | None = None
        if len(self._part) >= _LOOKS:
            (_, y, z), (_, _, lifted), (_, there, down) = self._part
            carried = lifted - z > _MOVED and there - y > _MOVED and abs(down - z) < 0.1 * _MOVED
        motions = [self._row(motion) for motion in self._motions]
        well = not self.error and bool(motions) and all(motion["ok"] for motion in motions)
        seen = [m["tracking_error"] for m in motions if m["tracking_error"] is not None]
        return {
            "schema": SCHEMA,
            "ok": well and carried is not False,
            "model": self._model,
            "controller": self._controller,
            "simulated": self._look is not None,
            "speed": self._speed,
            "error": self.error,
            "samples": len(self.samples),
            "part": [list(place) for place in self._part],
            "carried": carried,
            "greatest_tracking_error": max(seen, default=None),
            "motions": motions,
            "units": {"begin, end, duration": "s", "tracking_error": "rad", "part": "m"},
        }

    # -- pictures --------------------------------------------------------------------------------

    def _panel(self) -> Group:
        """What a terminal shows: the arm, the latest motions with their states, and notes."""
        title = Text(f"{self._model} at {self._controller}", "bold")
        tasks = Table(box=None, show_header=False, padding=(0, 1))
        for motion in self._motions[-6:]:
            number = "" if motion.task is None else str(motion.task.id)
            tasks.add_row(number, motion.function, motion.name, motion.told())
        notes = [Text(note, style="dim") for note in self._notes[-3:]]
        if not self.samples:
            return Group(title, tasks, *notes)
        newest = self.samples[-1]
        title.append(f"  {newest.status.state.name.lower()}", "not bold dim")
        arm = arm_table(MonitorState(""), newest, self._console.width)
        return Group(title, arm, tasks, *notes)

    def table(self) -> Table:
        """The table at the end: each motion with outcome, duration and greatest tracking error."""
        table = Table(
            title=f"aioduco demo: {self._model} at {self._controller}",
            caption="tracking error: the greatest difference of commanded and actual joints",
            box=SIMPLE_HEAD,
        )
        for heading in ("motion", "function", "outcome"):
            table.add_column(heading, no_wrap=True)
        for heading in ("duration", "tracking error"):
            table.add_column(heading, justify="right", no_wrap=True)
        for motion in self._motions:
            row = self._row(motion)
            took, error = f"{row['duration']:.2f} s", _milliradians(row["tracking_error"])
            table.add_row(motion.name, motion.function, motion.told(), took, error)
        return table

    def plot(self, arm: Arm, path: Path) -> None:
        """Draw the path in space, commanded against actual joints, and the difference, as a PNG."""
        from matplotlib.figure import Figure  # noqa: PLC0415 - takes half a second to load

        from aioduco.recording import figures  # noqa: PLC0415

        times, actual, behind = self.curves()
        figure = Figure(figsize=(13, 6), dpi=80, layout="constrained")
        where = self._controller if self._look is None else "simulated"
        name = self._model.upper().replace("_", "-")
        figure.suptitle(f"aioduco demo: {name} ({where})", fontsize=11)
        parts: Any = figure.subfigures(1, 2, width_ratios=(0.8, 1.2))
        space, joints = parts
        self._draw_space(space.add_subplot(projection="3d"), arm, actual)
        begun = [self._row(motion) for motion in self._motions if motion.task is not None]
        marks = [(row["begin"], row["name"]) for row in begun]
        shown = [
            figures.joint_panel("joint angles", times, actual, actual + behind),
            figures.joint_panel("behind the set-points", times, behind),
        ]
        figures.draw_panels(joints, shown, marks, times[-1], "motions: grey lines")
        with whole_file(path) as file:
            figure.savefig(file, format="png", pil_kwargs={"optimize": True})

    def _draw_space(self, axes: Any, arm: Arm, actual: NDArray[np.float64]) -> None:
        """Draw the arm and the tool's path, and the box where it lay, was carried and lies."""
        tcp = np.array([sample.status.pose[:3] for sample in self.samples])
        points = [tcp, np.zeros((1, 3))]
        rows = np.linspace(0, len(actual) - 1, _GHOSTS).astype(int)
        for row, weight in zip(rows, np.linspace(0.15, 1.0, _GHOSTS), strict=True):
            joints = forward.frames(arm.geometry, actual[row])[:, :3, 3]
            points.append(joints)
            axes.plot(*joints.T, color=(0.2, 0.25, 0.3, weight), lw=3, marker="o", ms=4)
        axes.plot(*tcp.T, color="#d95f02", lw=1.5)
        places = np.asarray(self._part).reshape(-1, 3)
        axes.plot(*places.T, color="#c0392b", lw=1.0, ls=":")
        for place, text in zip(places, ("picked up", "carried", "put down"), strict=False):
            axes.bar3d(*(place - 0.5 * _PART), _PART, _PART, _PART, color="#c0392b", alpha=0.7)
            axes.text(*(place - (0.0, 0.0, 1.6 * _PART)), text, fontsize=7, color="#c0392b")
        every = np.concatenate(points)
        low, high = every.min(axis=0), every.max(axis=0)
        middle, half = (low + high) / 2, (high - low).max() / 2
        for axis, centre in zip("xyz", middle, strict=True):
            getattr(axes, f"set_{axis}lim")(centre - half, centre + half)
            getattr(axes, f"set_{axis}label")(f"{axis} [m]", fontsize=8)
        axes.tick_params(labelsize=7)
        axes.set_box_aspect((1, 1, 1))
        axes.view_init(elev=20, azim=-60)


def _milliradians(error: float | None) -> str:
    return "not seen" if error is None else f"{error * 1e3:.2f} mrad"


# -- the choreography ------------------------------------------------------------------------------


async def perform(robot: Robot, plan: Choreography, shown: Demonstration) -> signal.Signals | None:
    """Connect, bring the arm up, and go through the choreography.

    Args:
        robot: the robot, not connected yet; its modules are loaded before the event loop runs.
        plan: places and speeds.
        shown: shows the progress; the error that ends it is written there.

    Returns:
        The signal that ended it, after the arm was stopped; None without a signal.
    """
    told: signal.Signals | None = None
    work = anyio.CancelScope()

    async def end_on_signal() -> None:
        nonlocal told
        async for number in signals:
            told = told or number
            shown.note("stopping the arm; this needs a moment")
            work.cancel()

    # Signals are received for longer than the work: a second Ctrl-C does not interrupt the stop.
    with receive_signals() as signals:
        async with anyio.create_task_group() as listening:
            listening.start_soon(end_on_signal)
            with work:
                try:
                    async with robot, anyio.create_task_group() as watching:
                        await robot.bring_up()
                        watching.start_soon(shown.watch, robot)
                        async with shown.gripper(robot) as gripper:
                            await _pick_and_place(robot, shown, plan, gripper)
                        watching.cancel_scope.cancel()
                except* DucoError as group:
                    where = host_port(robot.host, robot.port)
                    shown.error = in_commands(first_error(group), where)
            listening.cancel_scope.cancel()
    if work.cancelled_caught:
        shown.error = "interrupted: the arm was stopped, and stands"
    return told


async def _pick_and_place(
    robot: Robot, shown: Demonstration, plan: Choreography, gripper: DigitalGripper
) -> None:
    """Pick a part up, put it down, pause and resume, stop in mid motion, and go back."""

    def joint(to: Joints) -> MotionCommand:
        return robot.motion.movej2(to, v=plan.joint_speed, a=plan.joint_acceleration)

    def line(to: Pose, blend: float = 0.0) -> MotionCommand:
        return robot.motion.movel(to, v=plan.line_speed, a=plan.line_acceleration, r=blend)

    await shown.move("to the start", joint(plan.start))
    start = await robot.state.get_tcp_pose()
    over_pick = replace(start, y=start.y - plan.width)
    over_place = replace(start, y=start.y + plan.width)

    await shown.move("over the pick", line(over_pick))
    await shown.move("down to pick", line(over_pick.shifted(z=-plan.depth)))
    await shown.see("it lies")
    closed = await gripper.close()
    gripped = {None: "closes", True: "holds the box", False: "closes on nothing"}[closed.holding]
    shown.note(f"digital output {_GRIPPER} on: the gripper {gripped}")

    # If the part is lost on its way, the arm is stopped.
    async with gripper.carrying():
        lift = await shown.start(
            "lift, and blend", line(over_pick, plan.blend), expect=Outcome.BLENDED
        )
        across = await shown.start("across", line(over_place))
        await shown.finish(lift)
        await shown.finish(across)
    await shown.see("it is carried")
    await shown.move("down to place", line(over_place.shifted(z=_ABOVE - plan.depth)))
    await gripper.open()
    shown.note(f"digital output {_GRIPPER} off: the gripper opens")
    await shown.move("up again", line(over_place))
    await shown.see("it was put down")

    turn = await shown.start("turn aside, with a pause", joint(plan.aside))
    await _moved(robot, 0.2)
    await robot.pause()
    shown.note("paused: the arm stands on its path")
    await anyio.sleep(0.5)
    await robot.resume()
    await shown.finish(turn)

    back = await shown.start("turn back, and be stopped", joint(plan.start), expect=Outcome.STOPPED)
    await _moved(robot, 0.4)
    await robot.stop()
    shown.note("stopped: the arm stands on its path")
    await shown.finish(back)

    await shown.move("to the start again", joint(plan.start))


async def _moved(robot: Robot, angle: float) -> None:
    """Wait until a joint has moved by an angle [rad] from where it is now."""
    begin = (await robot.feed.latest()).status.joints.array

    def has_moved(sample: Snapshot) -> bool:
        return bool(np.abs(sample.status.joints.array - begin).max() > angle)

    try:
        await robot.wait_for(has_moved, timeout=_PATIENCE)
    except TimeoutError as error:
        raise RobotStateError(f"no joint moved by {angle:g} rad in {_PATIENCE:g} s") from error


# -- the command -----------------------------------------------------------------------------------


def run(
    address: RobotAddress | None,
    model: str,
    speed: float,
    plot: Path | None,
    result: Path | None,
    *,
    yes: bool,
) -> NoReturn:
    """Make the pick and place, show it, write the result, and end the program.

    Args:
        address: address of a controller; None for a simulated arm.
        model: the arm to simulate, or that is there.
        speed: speed of a simulated arm, as a multiple of the wall clock.
        plot: where to write the plot; None for none.
        result: where to write the result; None for nowhere.
        yes: whether a real arm moves without a question.
    """
    extras.need(*(() if address else ("sim",)), *(() if plot is None else ("plot",)))
    arm = extras.arm(model)
    console = SafeConsole(stderr=result == OUTPUT)
    plan = Choreography(arm.reach, careful=address is not None)
    if address is not None:
        if not yes:
            found = look(address)
            ask(_warning(address, model, plan, found), "Move the arm?", yes=False)
            with observing_session(address) as robot:
                require_same_state(robot, found["robot"], found["safety"])
                require_still_at(robot, found["joints"])
        shown = Demonstration(model, str(address), console)
        ended_by = _performed(address.host, address.port, plan, shown)
    else:
        from aioduco.sim import Simulator  # noqa: PLC0415 - MuJoCo is for this case alone

        cell = {"scene": scene(arm, plan), "gripper": GRIPPER_NAME}
        with Simulator.spawn(model=model, speed=speed, joints=LEFT, **cell) as sim:

            def see() -> tuple[float, float, float]:
                x, y, z = sim.positions[-7:-4].tolist()  # the box comes last, with its quaternion
                return x, y, z

            where = host_port(sim.host, sim.port)
            shown = Demonstration(model, where, console, speed=speed, look=see)
            ended_by = _performed(sim.host, sim.port, plan, shown, sim.clock)

    console.print(shown.table())
    if shown.error:
        console.print(f"error: {shown.error}", style="bold red")
    if plot is not None and shown.samples:
        with writing(plot):
            shown.plot(arm, plot)
        console.print(f"plot: {plot}")
    told = shown.as_json()
    if result is not None:
        write_result(told, result)
    if ended_by is not None:
        raise typer.Exit(128 + ended_by)  # as in a shell: 130 for Ctrl-C
    raise typer.Exit(0 if told["ok"] else 1)


def _performed(
    host: str, port: int, plan: Choreography, shown: Demonstration, clock: Clock | None = None
) -> signal.Signals | None:
    log_about(host_port(host, port))
    options: dict[str, Any] = {"state_rate": _SAMPLES}
    if clock is not None:  # a simulated arm can hurt nobody: a busy computer may stand still
        options |= {"clock": clock, "heartbeat": 20.0, "loop_stall_limit": 15.0}
    robot = aioduco.connect(host, port, **options)
    with shown.live or nullcontext():
        return anyio.run(perform, robot, plan, shown)


def _warning(address: RobotAddress, model: str, plan: Choreography, found: dict[str, Any]) -> str:
    """The warning before the arm moves."""
    far = np.rad2deg(np.abs(plan.start.array - found["joints"]))
    joint = int(far.argmax())
    return f"""\
controller at {address}: {states_line(found)}
the arm:       {found["arm"] or "not told by the controller"}; this plan is for a {model}
joints now:    {joints_line(found["joints"])}
joints first:  {joints_line(plan.start)}   (joint {joint + 1} turns by {far[joint]:.0f}°)
joints aside:  {joints_line(plan.aside)}
The arm will be powered on and enabled if it is not. It goes to the first joints, picks and places
{plan.width * 1e3:.0f} mm to each side of there and {plan.depth * 1e3:.0f} mm below, and turns \
aside and back. Joints turn at {np.rad2deg(plan.joint_speed):.0f} °/s, lines are made at \
{plan.line_speed * 1e3:.0f} mm/s. Digital output 1 switches.
{SAFE}"""


def write_result(result: dict[str, Any], path: Path) -> None:
    """Write a result as JSON, to a file or to the standard output."""
    text = json.dumps(result, indent=2)
    if path == OUTPUT:
        say(text)
    else:
        write_file(path, text + "\n")
