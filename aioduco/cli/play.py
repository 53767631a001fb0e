"""`aioduco play`: play a recording or waypoints on a simulated or a real arm."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, Port, RobotAddress, robot_at
from aioduco.cli.cell_file import is_cell, load_cell
from aioduco.cli.exit_codes import FAILED, ended_by_errors
from aioduco.cli.output import say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import control_session, observing_session

if TYPE_CHECKING:
    from aioduco.envelope import Envelope
    from aioduco.recording.playback import RecordedPath, WaypointFile
    from aioduco.sync import Robot

__all__ = ["play"]

#: speed of the joint that turns farthest, on the way to the start of a recording [rad/s]
_APPROACH = 0.3


def play(
    file: Annotated[Path, typer.Argument(help="A recording, .mcap, or waypoints, .toml.")],
    host: Annotated[
        str | None,
        typer.Argument(help="A controller's address, or its name. Without it: a simulated arm."),
    ] = None,
    port: Port = None,
    cell: CellFile = None,
    model: Annotated[
        str | None, typer.Option(help="The arm. Default: from the controller or the file.")
    ] = None,
    speed: Annotated[
        float, typer.Option(min=0.01, max=10.0, help="Times as fast; waypoints: up to 1.")
    ] = 1.0,
    begin: Annotated[
        float | None, typer.Option("--from", min=0.0, help="Begin there in the recording [s].")
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", min=0.0, help="End there in the recording [s].")
    ] = None,
    bridge: Annotated[
        float,
        typer.Option(
            min=0.0, max=0.1, help="Bridge gaps in which the arm is known to within this [rad]."
        ),
    ] = 0.005,
    outputs: Annotated[
        bool, typer.Option("--outputs", help="Also set the digital outputs that changed.")
    ] = False,
    record: Annotated[
        Path | None, typer.Option(help="Record what the arm does to this file.")
    ] = None,
    scene: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="MJCF file: what stands around the arm."),
    ] = None,
    envelope: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="Limits to keep to: TOML, see docs."),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Print the reasons against playing it; move nothing.")
    ] = False,
    rehearse: Annotated[
        bool, typer.Option(help="Play it on a simulated arm before a real one.")
    ] = True,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before an arm moves.")] = False,
) -> None:
    """Move an arm along a recording or through waypoints: a simulated arm, or the one at HOST.

    Before a real arm moves, the file is checked (arm, joint limits, speeds,
    accelerations, the envelope), played on a simulated arm, and you are asked. Ctrl-C brings the
    arm to rest.

    aioduco play run.mcap

    aioduco play run.mcap 192.168.1.10 --speed 0.5 --from 2 --to 8.5

    aioduco play points.toml 192.168.1.10 --envelope limits.toml

    aioduco play run.mcap left --cell cell.toml

    Exit codes: 0 it was played; 1 it was not, or not to its end; 2 wrong options; 3 not confirmed;
    4 it is not known that the arm stands; 130, 143 Ctrl-C or SIGTERM: the arm was brought to rest.
    """
    simulates = not check and (host is None or rehearse)
    extras.need("record", *(("sim",) if simulates else ()))
    if model is not None:
        extras.arm(model)
    from aioduco.recording import read  # noqa: PLC0415
    from aioduco.recording.playback import (  # noqa: PLC0415 - for this command alone
        RecordedPath,
        WaypointFile,
        read_envelope,
    )
    from aioduco.recording.playback.sample_times import gaps_in_words  # noqa: PLC0415

    with ended_by_errors():
        what: RecordedPath | WaypointFile
        if file.suffix == ".toml":
            cell = file if cell is None and is_cell(file) else cell
            what = load_cell(file).waypoints if is_cell(file) else WaypointFile.read(file)
        else:
            what = RecordedPath.of(read(file), begin=begin, end=end, speed=speed, bridge=bridge)
            if what.gaps:
                say(f"bridged: {gaps_in_words(what.gaps)}")
        told = model or _model_of(what)
        around = {} if scene is None else {"scene": str(scene.resolve())}
        limits = None
        if cell is not None:
            found = load_cell(cell)
            limits = found.envelope(host)
            around = {**found.simulator_options(host), **around}
            told = model or found.robot(host).model if found.robots else told
        if envelope is not None:
            limits = read_envelope(envelope, arm=told)
        if limits is not None:
            told = limits.arm.name
        task = _Playing(what, told, speed, outputs, record, limits)
        if check and host is None:
            task.check(told)
            return
        if simulates:
            task.simulate(around, keep=host is None)
        if host is not None:
            task.on_arm(robot_at(host, port, cell), only_check=check, yes=yes)


class _Playing:
    """One file, played on one robot or two."""

    def __init__(
        self,
        what: RecordedPath | WaypointFile,
        model: str | None,
        speed: float,
        outputs: bool,
        record: Path | None,
        envelope: Envelope | None,
    ) -> None:
        self._envelope = envelope
        self._what = what
        self._model = model
        self._speed = speed
        self._outputs = outputs
        self._record = record

    def check(self, model: str | None) -> None:
        """Check it without a robot."""
        from aioduco.kinematics import arm  # noqa: PLC0415
        from aioduco.recording.playback import RecordedPath, check_path  # noqa: PLC0415
        from aioduco.recording.playback.path_check import check_waypoints  # noqa: PLC0415

        if model is None:
            say("it does not say for which arm it is: --model says so", error=True)
            raise typer.Exit(FAILED)
        limits = self._envelope
        if isinstance(self._what, RecordedPath):
            found = [str(each) for each in check_path(self._what, arm(model), envelope=limits)]
        else:
            found = check_waypoints(self._what, arm(model), envelope=limits)
        _report(found)

    def simulate(self, around: dict[str, Any], *, keep: bool) -> None:
        """Play it on a simulated arm; errors there are raised."""
        import aioduco.sync  # noqa: PLC0415
        from aioduco.recording.playback import RecordedPath  # noqa: PLC0415
        from aioduco.sim import Simulator  # noqa: PLC0415 - it loads MuJoCo

        say(f"on a simulated {self._model or 'gcr5_910'}: {self._called()}")
        start = self._what.start if isinstance(self._what, RecordedPath) else None
        options = {**around, "model": self._model or "gcr5_910"}
        if start is not None:
            options["joints"] = list(start)
        with (
            Simulator.spawn(**options) as sim,
            aioduco.sync.connect(
                sim.host, sim.port, clock=sim.clock, record=self._record if keep else None
            ) as robot,
        ):
            robot.bring_up()
            robot.envelope = self._envelope
            self._play(robot)

    def on_arm(self, address: RobotAddress, *, only_check: bool, yes: bool) -> None:
        """Check it, ask, and play it on the real arm."""
        # No heartbeat: another program may still lead the arm.
        with observing_session(address) as robot:
            _report(self._against(robot), only=only_check)
            if only_check:
                return
            states = robot.state.get_robot_state()
            text = f"{self._called()} at {address} ({states}): {self._announced(robot)}\n{SAFE}"
        ask(text, "Move the arm?", yes=yes)
        with control_session(address) as robot:
            robot.bring_up()
            robot.envelope = self._envelope
            if self._record is None:
                self._play(robot)
            else:
                with robot.record(self._record):
                    self._play(robot)

    def _against(self, robot: Robot) -> list[str]:
        import aioduco.sync  # noqa: PLC0415
        from aioduco.recording.playback import RecordedPath  # noqa: PLC0415

        if isinstance(self._what, RecordedPath):
            found = aioduco.sync.check_path_on(
                robot, self._what, arm=self._model, envelope=self._envelope
            )
            return [str(each) for each in found]
        return aioduco.sync.check_waypoints_on(
            robot, self._what, arm=self._model, envelope=self._envelope
        )

    def _called(self) -> str:
        """What is played, for people."""
        from aioduco.recording.playback import RecordedPath  # noqa: PLC0415

        if isinstance(self._what, RecordedPath):
            return f"{self._what.source.name}, {self._what.duration:.2f} s of motion"
        count = len(self._what.waypoints)
        return f"{self._what.title}, {count} waypoint{'' if count == 1 else 's'}"

    def _announced(self, robot: Robot) -> str:
        """Announcement of the motion, as text."""
        import numpy as np  # noqa: PLC0415

        from aioduco.recording.playback import RecordedPath  # noqa: PLC0415
        from aioduco.recording.playback.path_check import fastest  # noqa: PLC0415

        here = np.asarray(robot.state.get_actual_joints_position())
        if isinstance(self._what, RecordedPath):
            first, then = self._what.start, f"joints turn at up to {fastest(self._what):.2f} rad/s"
        else:
            first = self._what.waypoints[0].joints
            then = f"{len(self._what.waypoints)} waypoints"
        far = np.rad2deg(np.abs(first.array - here))
        joint = int(far.argmax())
        return f"joint {joint + 1} turns by {far[joint]:.1f}° to the begin, then {then}."

    def _play(self, robot: Robot) -> None:
        import aioduco.sync  # noqa: PLC0415
        from aioduco.recording.playback import RecordedPath  # noqa: PLC0415

        if isinstance(self._what, RecordedPath):
            result = aioduco.sync.play(
                robot, self._what, approach=_APPROACH, outputs=self._outputs, arm=self._model
            )
            worst = max(result.path_error.max(), abs(result.goal_error).max())
            say(f"played in {result.duration:.2f} s, {worst * 1e3:.2f} mrad off at most")
            return
        count = aioduco.sync.run_waypoints(
            robot, self._what, arm=self._model, speed=min(self._speed, 1.0)
        )
        say(f"{count} waypoints were reached")


def _model_of(what: RecordedPath | WaypointFile) -> str | None:
    """The model that a file is for; None if the file names none or an unknown one."""
    from aioduco.kinematics.catalogue import model_named  # noqa: PLC0415

    found = model_named(what.arm)
    return None if found is None else found.name


def _report(found: list[str], *, only: bool = True) -> None:
    for each in found:
        say(each, error=True)
    if found:
        raise typer.Exit(FAILED)
    if only:
        say("nothing speaks against it")
