"""Samples of the robot's state: frozen, each with its time of receipt and a sequence number."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self, TypeAlias

from aioduco._process import trial
from aioduco._process.copying import Frozen
from aioduco.errors import StaleState
from aioduco.models.enums import SafetyState
from aioduco.models.numpy_on_use import np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from aioduco.models.enums import OperationMode, ProgramState, RobotState
    from aioduco.models.pose import Joints, Pose

__all__ = [
    "ForceStatus",
    "IOStatus",
    "JointTorques",
    "RobotStates",
    "RobotStatus",
    "Sample",
    "Vector",
    "vector",
    "vectors",
]

Vector: TypeAlias = "NDArray[np.float64]"
#: joint and tool speeds below which an arm counts as standing [rad/s, m/s]
_STANDS = 1e-3
_STOPS = (SafetyState.STOP0, SafetyState.STOP1, SafetyState.STOP2, SafetyState.FAIL)


def vector(values: Sequence[float], length: int | None = 6) -> Vector:
    """Return the first `length` values, None for all, as a read-only array; NaN for missing ones.

    Some controllers send longer lists (external axes) or no list (older software). A value that was
    not sent is NaN, and is never invented.
    """
    fitted = values if length is None else _fitted(values, length)
    array = np.array(fitted, dtype=np.float64)
    array.setflags(write=False)
    return array


def vectors(*lists: Sequence[float], length: int = 6) -> list[Vector]:
    """Return each list as `vector` does; for many lists this takes a third of the time."""
    sizes = {len(values) for values in lists}
    if len(sizes) > 1 or min(sizes) < length:
        lists = tuple(_fitted(values, length) for values in lists)
    array = np.array(lists, dtype=np.float64)
    array.setflags(write=False)
    return list(array[:, :length])


def _fitted(values: Sequence[float], length: int) -> Sequence[float]:
    return [*values[:length], *[math.nan] * (length - len(values))]


@dataclass(frozen=True, slots=True, eq=False)
class Sample(Frozen):
    """Base class of all samples.

    Attributes:
        sequence: number of the sample, which increases by one for each sample of its kind.
        received_at: time of receipt, on the clock of `time.monotonic` [s].
    """

    sequence: int
    received_at: float

    def __post_init__(self) -> None:
        if trial.current is not None:
            object.__setattr__(self, "received_at", trial.moment(self.received_at))

    @property
    def age(self) -> float:
        """Seconds since the sample was received."""
        return time.monotonic() - trial.wall(self.received_at)


@dataclass(frozen=True, slots=True, eq=False)
class RobotStates(Sample):
    """The four states of the controller (manual 1.3.7, get_robot_state).

    Attributes:
        robot: state of the robot.
        program: state of the program.
        safety: state of the safety controller.
        mode: operation mode.
    """

    robot: RobotState
    program: ProgramState
    safety: SafetyState
    mode: OperationMode

    def __str__(self) -> str:
        return (
            f"robot {self.robot.name}, program {self.program.name}, "
            f"safety {self.safety.name}, mode {self.mode.name}"
        )


class _Late(Sample):
    """A sample whose values are made when they are used: a few of many are."""

    __slots__ = ("_make",)

    #: makes the value of a slot, and others with it if that costs no more; None once all are there
    _make: Callable[[str], Mapping[str, object]] | None

    @classmethod
    def of(
        cls, sequence: int, received_at: float, make: Callable[[str], Mapping[str, object]]
    ) -> Self:
        """Make a sample.

        Args:
            sequence: its number.
            received_at: when it was received [s of `time.monotonic`].
            make: makes the value with this name, or that and others; it cannot fail.
        """
        made = object.__new__(cls)
        object.__setattr__(made, "_make", make)
        object.__setattr__(made, "sequence", sequence)
        object.__setattr__(made, "received_at", received_at)
        made.__post_init__()
        return made

    if not TYPE_CHECKING:

        def __getattr__(self, name):
            """Make a value; only called for what is not there."""
            names = type(self).__match_args__[2:]
            if name in names and self._make is not None:
                made = self._make(name)
                for each, value in made.items():
                    object.__setattr__(self, each, value)
                if len(made) == len(names):
                    object.__setattr__(self, "_make", None)
            return object.__getattribute__(self, name)

    def _content(self) -> dict[str, object]:
        return {name: getattr(self, name) for name in type(self).__match_args__}


@dataclass(frozen=True, slots=True, eq=False)
class JointTorques:
    """What controllers of manual 4.3 add to getRobotStatus. The manual prints no units.

    Arrays are read-only, of shape (6,); a value that the controller did not send is NaN.

    Attributes:
        auxiliary_positions: positions of the joints' second encoders (jointAuxiliaryPosition).
        dynamic: torques by the arm's dynamics (jointDynamicTorque).
        gravity: torques by gravity (jointGravityTorque).
        actual: actual torques (jointActualTorque).
        extra: further torques (jointExtraTorque).
    """

    auxiliary_positions: Vector
    dynamic: Vector
    gravity: Vector
    actual: Vector
    extra: Vector


@dataclass(frozen=True, slots=True, eq=False)
class RobotStatus(_Late):
    """Position and motion of the arm (manual 1.3.7, getRobotStatus).

    Arrays are read-only, of shape (6,); a value that the controller did not send is NaN.
    Poses, speeds and accelerations of the tool are in the world frame.

    Attributes:
        joints: actual joint angles [rad].
        joint_speeds: actual joint speeds [rad/s].
        joint_accelerations: actual joint accelerations [rad/s²].
        joint_currents: actual joint currents, in thousandths of the motor's rated current.
        joint_temperatures: temperatures of the joints [°C].
        driver_temperatures: temperatures of the joints' drive boards [°C].
        pose: actual pose of the tool [m, rad].
        tool_speed: actual speed of the tool [m/s, rad/s].
        tool_acceleration: actual acceleration of the tool [m/s², rad/s²].
        expected_joints: commanded joint angles [rad].
        expected_joint_speeds: commanded joint speeds [rad/s].
        expected_joint_accelerations: commanded joint accelerations [rad/s²].
        expected_pose: commanded pose of the tool [m, rad].
        expected_tool_speed: commanded speed of the tool [m/s, rad/s].
        expected_tool_acceleration: commanded acceleration of the tool [m/s², rad/s²].
        enabled: for each joint, whether it is enabled.
        collision: whether a collision was detected and not reset.
        collision_axis: the joint that detected it, 1 to 6; 0 without a collision.
        emergency_stop: whether an emergency stop is pressed.
        state: state of the robot.
        error: the controller's error code.
        torques: the joints' torques; None if the controller is older than manual 4.3.
    """

    joints: Joints
    joint_speeds: Vector
    joint_accelerations: Vector
    joint_currents: Vector
    joint_temperatures: Vector
    driver_temperatures: Vector
    pose: Pose
    tool_speed: Vector
    tool_acceleration: Vector
    expected_joints: Joints
    expected_joint_speeds: Vector
    expected_joint_accelerations: Vector
    expected_pose: Pose
    expected_tool_speed: Vector
    expected_tool_acceleration: Vector
    enabled: tuple[bool, ...]
    collision: bool
    collision_axis: int
    emergency_stop: bool
    state: RobotState
    error: int
    torques: JointTorques | None = None


@dataclass(frozen=True, slots=True, eq=False)
class ForceStatus(Sample):
    """External forces on the arm (manual 1.3.7).

    Arrays are read-only, of shape (6,); a value that the controller did not send is NaN.

    Attributes:
        tool: force and torque at the tool [N, N·m] (get_tcp_force); NaN without a force sensor.
        external_torques: observed external torques of the joints [N·m] (get_ext_torque); NaN if
            the controller's software does not have the function.
    """

    tool: Vector
    external_torques: Vector


@dataclass(frozen=True, slots=True, eq=False)
class IOStatus(_Late):
    """Inputs, outputs and registers (manual 1.3.7, getRobotIOStatus).

    `input`, `output`, `tool_input` and `tool_output` use the controller's numbers of signals:
    `status.input(1)` is DI1. In the tuples, channel 1 of the cabinet or the tool, and register 1,
    have index 0: `status.digital_inputs[0]` is also DI1.

    Attributes:
        analog_current_outputs: output currents [mA].
        analog_voltage_outputs: output voltages [V].
        analog_current_inputs: input currents [mA].
        analog_voltage_inputs: input voltages [V].
        digital_inputs: general inputs of the cabinet.
        digital_outputs: general outputs of the cabinet.
        tool_inputs: inputs of the tool.
        tool_outputs: outputs of the tool.
        tool_buttons: the buttons T and S at the tool.
        function_inputs: input function registers.
        function_outputs: output function registers.
        bool_inputs: input bool registers.
        bool_outputs: output bool registers.
        word_inputs: input word registers, signed: -32768 to 32767.
        word_outputs: output word registers, signed: 40000, as it was written and as
            `read_word_reg` may return it, is -25536 here.
        float_inputs: input float registers.
        float_outputs: output float registers.
    """

    analog_current_outputs: tuple[float, ...]
    analog_voltage_outputs: tuple[float, ...]
    analog_current_inputs: tuple[float, ...]
    analog_voltage_inputs: tuple[float, ...]
    digital_inputs: tuple[bool, ...]
    digital_outputs: tuple[bool, ...]
    tool_inputs: tuple[bool, ...]
    tool_outputs: tuple[bool, ...]
    tool_buttons: tuple[bool, ...]
    function_inputs: tuple[bool, ...]
    function_outputs: tuple[bool, ...]
    bool_inputs: tuple[bool, ...]
    bool_outputs: tuple[bool, ...]
    word_inputs: tuple[int, ...]
    word_outputs: tuple[int, ...]
    float_inputs: tuple[float, ...]
    float_outputs: tuple[float, ...]

    def input(self, num: int) -> bool:
        """Whether a general input of the cabinet is on.

        Args:
            num: number of the input on the controller, from 1.

        Raises:
            ParameterError: there is no such input.
            StaleState: the controller sent none of them.
        """
        return _numbered(num, self.digital_inputs)

    def output(self, num: int) -> bool:
        """Whether a general output of the cabinet is on; the number is as for `input`."""
        return _numbered(num, self.digital_outputs)

    def tool_input(self, num: int) -> bool:
        """Whether an input of the tool is on; the number is as for `input`."""
        return _numbered(num, self.tool_inputs)

    def tool_output(self, num: int) -> bool:
        """Whether an output of the tool is on; the number is as for `input`."""
        return _numbered(num, self.tool_outputs)


def _numbered(num: int, signals: tuple[bool, ...]) -> bool:
    """Return the signal with this number on the controller, where numbers begin with 1."""
    from aioduco.models.rules import Integer  # noqa: PLC0415 - a stop from a shell needs none

    if not signals:
        raise StaleState(
            "the controller sent none of these signals: it is still starting; ask again"
        )
    return signals[Integer(1, len(signals), source="1.3.7")("num", num) - 1]


def alarm_of(status: RobotStatus, states: RobotStates) -> str:
    """What has stopped an arm, in capitals; empty if nothing has."""
    if status.emergency_stop:
        return "EMERGENCY STOP PRESSED"
    if status.collision:
        return f"COLLISION AT JOINT {status.collision_axis}"
    return f"SAFETY {states.safety.name}" if states.safety in _STOPS else ""


def standing(status: RobotStatus) -> bool | None:
    """Whether a sample's speeds are those of an arm that stands; None if they were not sent."""
    joints, tool = status.joint_speeds.tolist(), status.tool_speed.tolist()
    if any(abs(speed) >= _STANDS for speed in (*joints, *tool)):
        return False
    return None if any(map(math.isnan, joints)) and any(map(math.isnan, tool)) else True
