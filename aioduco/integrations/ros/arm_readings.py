"""Published data of an arm: plain values, made from samples of its state. No I/O."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco import ProgramState, RobotState, SafetyState
from aioduco.models.quaternions import from_rpy, inverse, product, rotated

if TYPE_CHECKING:
    from aioduco import Load, Pose, RobotStatus, Snapshot
    from aioduco.errors import DucoError


#: topics of the states' names
STATE_NAMES = (
    "io_and_status_controller/robot_mode",
    "io_and_status_controller/safety_mode",
    "io_and_status_controller/program_state",
    "io_and_status_controller/operation_mode",
)


class ArmReading(NamedTuple):
    """Joint states, as `sensor_msgs/JointState` has them.

    Attributes:
        position: joint angles [rad], six.
        velocity: joint speeds [rad/s], six.
        effort: motor currents per rated current, six; the controller reports no torques.
    """

    position: tuple[float, ...]
    velocity: list[float]
    effort: list[float]


class PlacedFrame(NamedTuple):
    """A frame in the frame of the arm's base.

    Attributes:
        name: name of the frame.
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
    """Condition of the arm and the driver.

    Attributes:
        level: severity.
        message: what to do, or that the arm is ready.
        values: names and values of the readings.
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
    """The frames of tool tip and flange, as the controller reports them.

    Args:
        status: a sample.
        tcp_offset: pose of the tool's tip in the flange's frame; None if it is not known: then the
            flange is left out.
        prefix: prefix of the frames' names.
    """
    # Plain numbers, because arrays would take most of the time of a joint state.
    x, y, z, *angles = status.pose
    w, *axis = turn = from_rpy(*angles)
    frames = [PlacedFrame(prefix + "tcp_controller", [x, y, z], [*axis, w])]
    if tcp_offset is not None:
        w, *axis = flange = product(turn, inverse(from_rpy(*tcp_offset[3:])))
        dx, dy, dz = rotated(flange, tcp_offset[:3])
        place = [x - dx, y - dy, z - dz]
        frames.append(PlacedFrame(prefix + "flange_controller", place, [*axis, w]))
    return frames


def diagnosis(
    snapshot: Snapshot | None, error: DucoError | None, now: float, rate: float
) -> Diagnosis:
    """Diagnose the arm from the newest sample of its state.

    Args:
        snapshot: the newest sample; None before the first.
        error: why the last request failed; None if it was answered.
        now: the time, on the clock of `time.monotonic` [s].
        rate: recently received joint states per second [Hz].
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
    # The first rule that holds: actions of a person come before actions by a call.
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


def robot_state_fields(snapshot: Snapshot) -> dict[str, Any]:
    """The fields of a message with the states of robot, program, safety and mode."""
    states, status = snapshot.states, snapshot.status
    return {
        "robot_state": int(states.robot),
        "program_state": int(states.program),
        "safety_state": int(states.safety),
        "operation_mode": int(states.mode),
        "text": str(states),
        "enabled": all(status.enabled),
        "collision": bool(status.collision),
        "collision_joint": int(status.collision_axis),
        "emergency_stop": bool(status.emergency_stop),
        "error": int(status.error),
    }


def state_names(snapshot: Snapshot) -> dict[str, str]:
    """The names of the states by their topics."""
    states = snapshot.states
    each = (states.robot, states.safety, states.program, states.mode)
    return {topic: state.name for topic, state in zip(STATE_NAMES, each, strict=True)}


def tool_data_fields(snapshot: Snapshot, offset: Pose, load: Load) -> dict[str, Any]:
    """The fields of a message of the tool in use.

    Args:
        snapshot: a sample.
        offset: pose of the tool's tip in the flange's frame.
        load: mass and centre of mass of the tool.
    """
    mass, *centre = load
    io = snapshot.io
    return {
        "offset": [float(each) for each in offset],
        "mass": float(mass),
        "centre": [float(each) for each in centre],
        "inputs": [bool(each) for each in io.tool_inputs],
        "outputs": [bool(each) for each in io.tool_outputs],
    }


def io_state_fields(snapshot: Snapshot) -> dict[str, Any]:
    """The fields of a message with inputs and outputs; the first of each list has the number 1."""
    io = snapshot.io
    return {
        "digital_inputs": [bool(each) for each in io.digital_inputs],
        "digital_outputs": [bool(each) for each in io.digital_outputs],
        "tool_inputs": [bool(each) for each in io.tool_inputs],
        "tool_outputs": [bool(each) for each in io.tool_outputs],
        "voltage_inputs": [float(each) for each in io.analog_voltage_inputs],
        "voltage_outputs": [float(each) for each in io.analog_voltage_outputs],
        "current_inputs": [float(each) for each in io.analog_current_inputs],
        "current_outputs": [float(each) for each in io.analog_current_outputs],
    }
