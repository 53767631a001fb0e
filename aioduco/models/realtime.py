"""Commands of realtime control (实时控制, manual 1.3.15)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from aioduco._wire import rpc
from aioduco.models.named_int import NamedInt
from aioduco.models.rules import Choice, JointsRule, Number, PoseRule, Vector, VectorLike

_SOURCE = "1.3.15"
_JOINTS = JointsRule(source=_SOURCE)
_POSE = PoseRule(source=_SOURCE)
# The manual gives no ranges in 1.3.15: those of speedj and speedl (1.3.5) apply.
#: speedj: the manual prints the range of a speed's magnitude, [0.01π/180, 1.25π]; a joint may also
#: stand or turn backwards
JOINT_VELOCITIES = Vector(Number(-1.25 * pi, 1.25 * pi, "rad/s", source="1.3.5"), length=6)
#: speedl: the manual prints the range of a speed's magnitude, [0.00001, 5] m/s, and both (0, 1.25π]
#: and (0, 2π] rad/s; a component may be zero or negative, and the stricter limit applies
TWIST = Vector(
    *[Number(-5.0, 5.0, "m/s", source="1.3.5")] * 3,
    *[Number(-1.25 * pi, 1.25 * pi, "rad/s", source="1.3.5")] * 3,
)
_TORQUES = Vector(Number(unit="N·m", source=_SOURCE), length=6)
#: by mode, the rule of its values
_RULES = (_JOINTS, JOINT_VELOCITIES, _TORQUES, _POSE, TWIST)


class RealtimeMode(NamedInt):
    """Kind of set-point that realtime control follows (manual 1.3.15)."""

    JOINT_POSITION = 0
    JOINT_VELOCITY = 1
    JOINT_TORQUE = 2
    POSE = 3
    TWIST = 4


_MODE = Choice({int(each): each.name for each in RealtimeMode}, source=_SOURCE)
#: by mode, the field of the wire's struct
_FIELDS = (
    *("joint_pos_cmd", "joint_vel_cmd", "joint_torq_cmd"),
    *("cart_pos_tool_wobj_cmd", "cart_vel_tool_wobj_cmd"),
)


@dataclass(frozen=True, slots=True)
class RealtimePoint:
    """One command of realtime control, made by the class method of its mode.

    Attributes:
        mode: the mode that follows the command; commands of another mode have no effect in it.
        values: six numbers in the units of the mode.

    Raises:
        ParameterError: the mode is none, or the values are not as its class method takes them.
    """

    mode: RealtimeMode
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        mode = RealtimeMode(_MODE("mode", self.mode))
        object.__setattr__(self, "mode", mode)
        object.__setattr__(self, "values", tuple(_RULES[mode]("values", self.values)))

    @classmethod
    def joint_position(cls, q: VectorLike) -> RealtimePoint:
        """Command joint positions.

        Args:
            q: joint positions [rad], -2π to 2π. Shape (6,).

        Raises:
            ParameterError: not six numbers, or one out of range.
        """
        return cls(RealtimeMode.JOINT_POSITION, tuple(_JOINTS("q", q)))

    @classmethod
    def joint_velocity(cls, qd: VectorLike) -> RealtimePoint:
        """Command joint velocities.

        Args:
            qd: joint velocities [rad/s], -1.25π to 1.25π. Shape (6,).

        Raises:
            ParameterError: not six numbers, or one out of range.
        """
        return cls(RealtimeMode.JOINT_VELOCITY, tuple(JOINT_VELOCITIES("qd", qd)))

    @classmethod
    def joint_torque(cls, torque: VectorLike) -> RealtimePoint:
        """Command joint torques; manual 3.8 calls them reserved: a controller may ignore them.

        Args:
            torque: joint torques [N·m]. Shape (6,).

        Raises:
            ParameterError: not six finite numbers.
        """
        return cls(RealtimeMode.JOINT_TORQUE, tuple(_TORQUES("torque", torque)))

    @classmethod
    def pose(cls, pose: VectorLike) -> RealtimePoint:
        """Command a pose of the tool in the work object.

        Args:
            pose: x, y, z [m], rx, ry, rz [rad], angles -2π to 2π. Shape (6,).

        Raises:
            ParameterError: not six numbers, or one out of range.
        """
        return cls(RealtimeMode.POSE, tuple(_POSE("pose", pose)))

    @classmethod
    def twist(cls, twist: VectorLike) -> RealtimePoint:
        """Command a velocity of the tool in the work object.

        Args:
            twist: linear [m/s], -5 to 5, then angular [rad/s], -1.25π to 1.25π. Shape (6,).

        Raises:
            ParameterError: not six numbers, or one out of range.
        """
        return cls(RealtimeMode.TWIST, tuple(TWIST("twist", twist)))

    def wire(self) -> rpc.RealTimeControlData:
        """Return the struct of the wire, marked as a new command."""
        command = rpc.RealTimeControlData(status=True)
        setattr(command, _FIELDS[self.mode], list(self.values))
        return command
