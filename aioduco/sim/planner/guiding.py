"""Hand guiding (牵引示教, manual 1.3.5, teach_mode): the arm carries its weight and gives way."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.forward import fkine, jacobian
from aioduco.sim.planner.follower import TargetFollower
from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array

    #: for joints [rad], the matrix that gives the yielding part of a joint motion. Shape (6, 6)
    Giving = Callable[[Array], Array]


_GIVING = 0.8  # share of a joint's speed that the drives do not resist; an assumption
_STICKING = 0.01  # the joints are held when all are slower than this [rad/s]
_LOOSE = 0.001  # the held joints are released when one is pushed further than this [rad]
_FLAT = 1e-3  # singular values below this share of the largest count as zero


class HandGuidingFollower(TargetFollower):
    """Commands the joints to their actual positions, as far as they give way.

    The drives compensate gravity in any case. The commanded speed is a part of the actual speed,
    and the difference damps the motion. Once all joints hardly move, they are held until one of
    them is pushed away.

    Args:
        arm: the arm.
        q: joints at the start, where the arm stands [rad]. Shape (6,).
        cycle: time between two ticks [s].
        giving: the part of a motion that gives way; None for all of it.
    """

    def __init__(self, arm: Arm, q: Array, cycle: float, giving: Giving | None = None) -> None:
        super().__init__(arm, q, cycle)
        self._giving = giving
        self._held: Array | None = None

    def _next(self, q: Array, qd: Array) -> JointSetPoint:
        if self._giving is not None:
            allowed, last = self._giving(q), self.setpoint.q
            q, qd = last + allowed @ (q - last), allowed @ qd
        if self._held is None:
            if float(np.abs(qd).max()) < _STICKING:
                self._held = q
        elif float(np.abs(q - self._held).max()) > _LOOSE:
            self._held = None
        if self._held is not None:
            return JointSetPoint.at_rest(self._held)
        return JointSetPoint(q + self._cycle * qd, _GIVING * qd, np.zeros(6))


def joint_giving(joints: Sequence[bool]) -> Giving:
    """Let some of the joints give way."""
    matrix = np.diag(np.array(joints, dtype=float))
    return lambda _q: matrix


def cartesian_giving(
    arm: Arm, directions: Sequence[bool], tool: Array, frame: Array | None
) -> Giving:
    """Let the tool give way along and about some axes.

    Args:
        arm: the arm.
        directions: whether it gives way along x, y, z and about them.
        tool: tool centre point in the frame of the flange. Shape (4, 4).
        frame: orientation of the axes in the base; None for the tool's own. Shape (3, 3).
    """
    mask = np.diag(np.array(directions, dtype=float))

    def giving(q: Array) -> Array:
        flange = fkine(arm.geometry, q)
        at_tip = jacobian(arm.geometry, q).copy()
        at_tip[:3] += np.cross(at_tip[3:], flange[:3, :3] @ tool[:3, 3], axis=0)
        axes = ((flange @ tool)[:3, :3] if frame is None else frame).T
        turned = np.concatenate([axes @ at_tip[:3], axes @ at_tip[3:]])
        matrix: Array = np.linalg.pinv(turned, rcond=_FLAT) @ mask @ turned
        return matrix

    return giving
