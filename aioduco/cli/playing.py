"""One file that `aioduco play` checks, and plays on a simulated or a real arm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

import aioduco.sync
from aioduco.cli.exit_codes import fail
from aioduco.cli.output import say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import (
    control_session,
    observing_session,
    reported_arm,
    require_same_state,
    require_still_at,
)
from aioduco.kinematics import arm
from aioduco.recording.playback import RecordedPath, WaypointFile, check_path
from aioduco.recording.playback.path_check import check_waypoints, fastest
from aioduco.recording.playback.player import for_another_arm

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from aioduco.cli.addresses import RobotAddress
    from aioduco.envelope import Envelope
    from aioduco.models.pose import Joints
    from aioduco.sync import Robot
    from aioduco.sync._generated_objects import Recording


#: speed of the joint that turns farthest, on the way to the start of a recording [rad/s]
_APPROACH = 0.3
_NOTHING = "nothing speaks against it"


@dataclass(frozen=True, slots=True)
class PlayedFile:
    """One file, played on one robot or two.

    Attributes:
        content: the recording or the waypoints.
        model: name of the arm; None for the one that the controller reports.
        speed: factor on the speeds of waypoints.
        outputs: whether the digital outputs of a recording are set, too.
        record: file to which the arm is recorded; None for none.
        envelope: limits to keep; None for none.
    """

    content: RecordedPath | WaypointFile
    model: str | None
    speed: float
    outputs: bool
    record: Path | None
    envelope: Envelope | None

    def check(self) -> None:
        """Check it without a robot."""
        if self.model is None:
            fail("it does not say for which arm it is: --model says so")
        known, limits = arm(self.model), self.envelope
        if other := for_another_arm(self.content.arm, known.name):
            fail(other)
        if isinstance(self.content, RecordedPath):
            _report(check_path(self.content, known, envelope=limits))
        else:
            _report(check_waypoints(self.content, known, envelope=limits))
        say(_NOTHING)

    def simulate(self, around: dict[str, Any], address: RobotAddress | None) -> Joints | None:
        """Play it on a simulated arm, such as the one at an address; errors there are raised.

        Returns:
            Where the one at the address is, and the simulated one began [rad]; None without one.
        """
        from aioduco.sim import Simulator  # noqa: PLC0415 - it loads MuJoCo

        told, here = (None, None) if address is None else _seen(address)
        model = self.model or told or "gcr5_910"
        say(f"on a simulated {model}: {self}")
        options = {**around, "model": model}
        if here is not None:
            options["joints"] = list(here)
        elif isinstance(self.content, RecordedPath):
            options["joints"] = list(self.content.start)
        record = self.record if address is None else None
        with (
            Simulator.spawn(**options) as sim,
            aioduco.sync.connect(sim.host, sim.port, clock=sim.clock, record=record) as robot,
        ):
            _say_where(robot.recording)
            robot.bring_up()
            robot.envelope = self.envelope
            self._play(robot)
        return here

    def on_arm(
        self, address: RobotAddress, here: Joints | None, *, only_check: bool, yes: bool
    ) -> None:
        """Check it, ask, and play it on the real arm, if this still is where it was rehearsed.

        Args:
            address: address of its controller.
            here: where it was at the rehearsal [rad]; None without one.
            only_check: whether to end after the check.
            yes: whether not to ask.
        """
        # No heartbeat: another program may still lead the arm.
        with observing_session(address) as robot:
            _report(self._against(robot))
            if only_check:
                say(_NOTHING)
                return
            states = robot.state.get_robot_state()
            here = here or robot.state.get_actual_joints_position()
            text = f"{self} at {address} ({states}): {self._announced(here)}\n{SAFE}"
        ask(text, "Move the arm?", yes=yes)
        with control_session(address) as robot:
            require_same_state(robot, states.robot, states.safety)
            require_still_at(robot, here)
            robot.bring_up()
            robot.envelope = self.envelope
            if self.record is None:
                self._play(robot)
            else:
                with robot.record(self.record) as recording:
                    _say_where(recording)
                    self._play(robot)

    def _against(self, robot: Robot) -> Iterable[object]:
        """Reasons against playing it on a robot."""
        limits: dict[str, Any] = {"arm": self.model, "envelope": self.envelope}
        if isinstance(self.content, RecordedPath):
            return aioduco.sync.check_path_on(robot, self.content, **limits)
        return aioduco.sync.check_waypoints_on(robot, self.content, **limits)

    def __str__(self) -> str:
        content = self.content
        if isinstance(content, RecordedPath):
            return f"{content.source.name}, {content.duration:.2f} s of motion"
        count = len(content.waypoints)
        return f"{content.title}, {count} waypoint{'' if count == 1 else 's'}"

    def _announced(self, here: Joints) -> str:
        """Announcement of the motion from where the arm is, as text."""
        content = self.content
        if isinstance(content, RecordedPath):
            first, then = content.start, f"joints turn at up to {fastest(content):.2f} rad/s"
        else:
            first, then = content.waypoints[0].joints, f"{len(content.waypoints)} waypoints"
        far = np.rad2deg(np.abs(first.array - here.array))
        joint = int(far.argmax())
        return f"joint {joint + 1} turns by {far[joint]:.1f}° to the begin, then {then}."

    def _play(self, robot: Robot) -> None:
        if isinstance(self.content, RecordedPath):
            result = aioduco.sync.play(
                robot, self.content, approach=_APPROACH, outputs=self.outputs, arm=self.model
            )
            worst = max(result.path_error.max(), abs(result.goal_error).max())
            say(f"played in {result.duration:.2f} s, {worst * 1e3:.2f} mrad off at most")
            return
        count = aioduco.sync.run_waypoints(robot, self.content, arm=self.model, speed=self.speed)
        say("1 waypoint was reached" if count == 1 else f"{count} waypoints were reached")


def _seen(address: RobotAddress) -> tuple[str | None, Joints]:
    """The model that a controller reports, None if it is no known one, and where its arm is."""
    with observing_session(address) as robot:
        found = reported_arm(robot)
        return None if found is None else found.name, robot.state.get_actual_joints_position()


def _say_where(recording: Recording | None) -> None:
    """Tell the file, which has another name than was asked for if that existed."""
    if recording is not None:
        say(f"recording to {recording.path}")


def _report(found: Iterable[object]) -> None:
    """Print the reasons against playing a file, and end the command if there are any."""
    lines = "\n".join(map(str, found))
    if lines:
        fail(lines)
