"""Arguments that motions have in common: each group is checked, in the order of the wire."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.models import ranges
from aioduco.models.op import Op, wire_op

if TYPE_CHECKING:
    from aioduco._wire import rpc
    from aioduco.models.pose import JointsLike
    from aioduco.models.rules import Number, Real


def limits(
    speed: Number, acceleration: Number, v: Real, a: Real, r: Real
) -> tuple[float, float, float]:
    """Speed and acceleration by their ranges, and the blend radius [m]."""
    return speed("v", v), acceleration("a", a), ranges.BLEND_RADIUS("r", r)


def line(v: Real, a: Real, r: Real) -> tuple[float, float, float]:
    """Speed [m/s], acceleration [m/s²] and blend radius [m] of a path of the tool."""
    return limits(ranges.LINE_SPEED, ranges.LINE_ACCELERATION, v, a, r)


def frames(q_near: JointsLike | None, tool: str, wobj: str) -> tuple[list[float], str, str]:
    """The joints to which the solution is to be near, the names of tool and work object."""
    near = ranges.JOINTS_NEAR("q_near", q_near)
    return near, ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)


def gains(kp: Real, kd: Real, smooth_vel: Real, smooth_acc: Real) -> list[float]:
    """The four gains of a servo function."""
    return [
        ranges.SERVO_KP("kp", kp),
        ranges.SERVO_KD("kd", kd),
        ranges.SERVO_SMOOTH_VELOCITY("smooth_vel", smooth_vel),
        ranges.SERVO_SMOOTH_ACCELERATION("smooth_acc", smooth_acc),
    ]


def outputs(
    op: Op | None, def_acc: bool, *, joint_motion: bool = False
) -> tuple[bool, rpc.Op, bool]:
    """False for `block`, the outputs to set, and whether the acceleration is the default."""
    return False, wire_op("op", op, joint_motion=joint_motion), ranges.FLAG("def_acc", def_acc)
