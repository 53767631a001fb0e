"""What is published of an arm: plain values, made from samples of its state. No I/O."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from aioduco import ProgramState, RobotState, SafetyState

if TYPE_CHECKING:
    from aioduco import Pose, RobotStatus, Snapshot
    from aioduco.errors import DucoError

__all__ = [
    "ArmReading",
    "Diagnosis",
    "DiagnosisLevel",
    "PlacedFrame",
    "diagnosis",
    "joint_reading",
    "placed_frames",
]


class ArmReading(NamedTuple):
    """Joint states, as `sensor_msgs/JointState` has them.

    Attributes:
        position: [rad], six.
        velocity: [rad/s], six.
        effort: currents of the motors, per rated current, six: the controller tells no torques.
    """

    position: tuple[float, ...]
    velocity: list[float]
    effort: list[float]


class PlacedFrame(NamedTuple):
    """A frame in the frame of the arm's base.

    Attributes:
        name: of the frame.
        position: x, y, z [m].
        quaternion: x, y, z, w.
    """

    name: str
    position: list[float]
    quaternion: list[float]


class DiagnosisLevel(IntEnum):
    """Levels of `diagnostic_msgs/DiagnosticStatus`."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


class Diagnosis(NamedTuple):
    """How the arm and the driver are.

    Attributes:
        level: how bad.
        message: what to do, or that all is well.
        values: names and values of what was looked at.
    """

    level: DiagnosisLevel
    message: str
    values: dict[str, str]


def joint_reading(status: RobotStatus) -> ArmReading:
    """The joints in a sample."""
    return ArmReading(
        tuple(status.joints), status.joint_speeds.tolist(), (status.joint_currents / 1e3).tolist()
    )


def placed_frames(status: RobotStatus, tcp_offset: Pose | None, prefix: str) -> list[PlacedFrame]:
    """The frames of tool tip and flange, as the controller has them.

    Args:
        status: a sample.
        tcp_offset: pose of the tool's tip in the flange's frame; None if it is not known, and then
            there is no flange.
        prefix: before the frames' names.
    """
    tip = status.pose
    frames = [(prefix + "tcp_controller", tip)]
    if tcp_offset is not None:
        frames.append((prefix + "flange_controller", tip @ tcp_offset.inverse()))
    return [
        PlacedFrame(name, [pose.x, pose.y, pose.z], pose.quaternion("xyzw").tolist())
        for name, pose in frames
    ]


def diagnosis(
    snapshot: Snapshot | None, error: DucoError | None, now: float, rate: float
) -> Diagnosis:
    """How the arm is, from the newest sample of its state.

    Args:
        snapshot: the newest; None before the first.
        error: why the last question was not answered; None if it was.
        now: the time, on the clock of `time.monotonic` [s].
        rate: samples a second that came of late [Hz].
    """
    if snapshot is None or error is not None:
        age = "never" if snapshot is None else f"{now - snapshot.received_at:.1f} s ago"
        values = {"last sample": age, "error": str(error or "")}
        return Diagnosis(DiagnosisLevel.STALE, "the controller does not answer", values)
    states, status = snapshot.states, snapshot.status
    values = {
        "robot": states.robot.name,
        "program": states.program.name,
        "safety": states.safety.name,
        "mode": states.mode.name,
        "controller error": str(status.error),
        "hottest joint [C]": f"{status.joint_temperatures.max():.1f}",
        "samples a second": f"{rate:.1f}",
    }
    down = states.robot < RobotState.DISABLE
    unsafe = states.safety not in (SafetyState.RUN, SafetyState.REDUCE, SafetyState.MODEL)
    paused = states.program in (ProgramState.PAUSED, ProgramState.PAUSING)
    # The first that holds: what a person must do comes before what a call can do.
    rules = (
        (status.emergency_stop, DiagnosisLevel.ERROR, "emergency stop pressed: release it"),
        (
            status.collision,
            DiagnosisLevel.ERROR,
            f"collision at joint {status.collision_axis}: call recover",
        ),
        (down, DiagnosisLevel.WARN, f"robot {states.robot.name}: call bring_up"),
        (unsafe, DiagnosisLevel.ERROR, f"safety {states.safety.name}: call recover"),
        (
            states.robot is not RobotState.ENABLE,
            DiagnosisLevel.WARN,
            f"robot {states.robot.name}: call bring_up",
        ),
        (paused, DiagnosisLevel.WARN, "paused: call resume, or stop"),
        (True, DiagnosisLevel.OK, "ready"),
    )
    level, message = next((level, text) for holds, level, text in rules if holds)
    return Diagnosis(level, message, values)
