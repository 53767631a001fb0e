"""An offset of the flange between set-points of the motions and those of the drives.

The offset is how far force control has moved the flange. It is kept in the base frame, whatever
tool and axes were in use, so that these can change at any time without a jump.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.forward import frames
from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array

__all__ = ["FlangeOffset", "OutOfReach", "motion_of"]

_FASTER = 1.02  # share of a joint's largest speed that a set-point may have, for rounding
_BRAKING = 0.5  # share of the drives' acceleration that slowing down uses
_NOWHERE = np.zeros(3)
_STRAIGHT = np.eye(3)
_NOWHERE.flags.writeable = _STRAIGHT.flags.writeable = False


class OutOfReach(Exception):
    """The joints cannot follow the offset."""


def motion_of(chain: Array, qd: Array) -> tuple[list[float], list[float]]:
    """Give speed [m/s] and angular speed [rad/s] of the last frame of a chain, in the base.

    Args:
        chain: as `kinematics.forward.frames` gives it. Shape (7, 4, 4).
        qd: joint speeds [rad/s]. Shape (6,).
    """
    jacobian = _jacobian(chain)
    twist: list[float] = jacobian.dot(qd).tolist()
    return twist[:3], twist[3:]


def _jacobian(chain: Array) -> Array:
    axes, arms = chain[:6, :3, 2].tolist(), (chain[6, :3, 3] - chain[:6, :3, 3]).tolist()
    columns = [
        (y * c - z * b, z * a - x * c, x * b - y * a, x, y, z)
        for (x, y, z), (a, b, c) in zip(axes, arms, strict=True)
    ]
    return np.array(columns).T


def _turned(a: float, b: float, c: float, time: float) -> Array:
    """Give the rotation matrix after some time [s] at an angular speed [rad/s]."""
    rate = math.sqrt(a * a + b * b + c * c) or 1.0
    a, b, c = a / rate, b / rate, c / rate
    sine, cosine = math.sin(rate * time), math.cos(rate * time)
    d = 1.0 - cosine
    return np.array(
        (
            (cosine + d * a * a, d * a * b - sine * c, d * a * c + sine * b),
            (d * a * b + sine * c, cosine + d * b * b, d * b * c - sine * a),
            (d * a * c - sine * b, d * b * c + sine * a, cosine + d * c * c),
        )
    )


class FlangeOffset:
    """Adds the motion of the flange by force control to set-points, cycle by cycle.

    Small matrices are multiplied by `dot`, which takes a third of the time of `@`.

    Args:
        arm: the arm.
        cycle: time between two set-points [s].
    """

    def __init__(self, arm: Arm, cycle: float) -> None:
        self._arm = arm
        self._cycle = cycle
        self._fastest = [_FASTER * speed for speed in arm.velocity]
        self._braking = [_BRAKING * rate for rate in arm.acceleration]
        self._hard = np.array(self._braking)
        self._shift: Array = _NOWHERE
        self._turn: Array = _STRAIGHT
        self._speed = (0.0,) * 6
        self._twist: Sequence[float] = (0.0,) * 6
        self._none = True
        self._last = JointSetPoint.at_rest(np.zeros(6))
        self._at: Array = np.zeros(6)
        self._chain: Array = frames(arm.geometry, self._at)
        self.flange: Array = _STRAIGHT

    @property
    def setpoint(self) -> JointSetPoint:
        """The latest set-point of the drives."""
        return self._last

    @property
    def shifted(self) -> bool:
        """Whether there is an offset."""
        return not self._none

    def begin(self, setpoint: JointSetPoint) -> None:
        """Begin without an offset, at a set-point of the motions."""
        self.drop_offset()
        self._twist = (0.0,) * 6
        self._last = setpoint
        self.flange = self._frames(setpoint.q)[6, :3, :3]

    def drop_offset(self) -> None:
        """Drop the offset: the motions restart from where the offset has moved the arm."""
        self._shift, self._turn, self._none = _NOWHERE, _STRAIGHT, True
        self._speed = (0.0,) * 6

    def move(self, twist: Sequence[float], tip: Array) -> None:
        """Move the tool's tip for one cycle.

        Args:
            twist: speed of the tip at the end of the cycle [m/s], then its angular speed [rad/s],
                in the base frame.
            tip: the tip in the flange's frame [m]. Shape (3,).
        """
        u, v, w, a, b, c = twist
        mean = [0.5 * (before + now) for before, now in zip(self._twist, twist, strict=True)]
        self._twist = twist
        step = self._cycle * np.array(mean[:3])
        if a or b or c or any(mean[3:]):
            # The rotation is about the tip: the flange moves round it.
            arm = self.flange.dot(tip)
            x, y, z = arm.tolist()
            turned = _turned(mean[3], mean[4], mean[5], self._cycle)
            step += arm - turned.dot(arm)
            self._turn = turned.dot(self._turn)
            u, v, w = u - (b * z - c * y), v - (c * x - a * z), w - (a * y - b * x)
        self._shift = self._shift + step
        self._speed = (u, v, w, a, b, c)
        self._none = False

    def apply(self, setpoint: JointSetPoint) -> JointSetPoint:
        """Give the set-point of the drives for one of the motions.

        Raises:
            OutOfReach: a joint would have to turn too fast, or beyond its limit.
        """
        if self._none:
            self._last = setpoint
            self.flange = self._frames(setpoint.q)[6, :3, :3]
            return setpoint
        last = self._last
        if setpoint.q is self._at and not (any(self._speed) or last.qd.any() or setpoint.qd.any()):
            return last
        nominal = self._frames(setpoint.q)
        speed = np.array(self._speed)
        if setpoint.qd.any():
            linear, angular = motion_of(nominal, setpoint.qd)
            speed[:3] += linear
            speed[3:] += self._turn.dot(angular)
        flange = self._turn.dot(nominal[6, :3, :3])
        guess = last.q + self._cycle * (last.qd + 0.5 * self._cycle * last.qdd)
        chain = frames(self._arm.geometry, guess)
        (_, c, d), (e, _, f), (g, h, _) = flange.dot(chain[6, :3, :3].T).tolist()
        x, y, z = (nominal[6, :3, 3] + self._shift - chain[6, :3, 3]).tolist()
        # One step of Newton's method from the extrapolated last cycle: its error is negligible.
        wanted = np.empty((6, 2))
        wanted[:, 0] = (x, y, z, 0.5 * (h - f), 0.5 * (d - g), 0.5 * (e - c))
        wanted[:, 1] = speed
        try:
            steps = np.linalg.solve(_jacobian(chain), wanted)
        except np.linalg.LinAlgError as exc:
            raise OutOfReach("force control comes to a singularity") from exc
        q, qd = guess + steps[:, 0], np.array(steps[:, 1], dtype=float)
        self._check(q, qd)
        self._last = JointSetPoint(q, qd, (qd - last.qd) / self._cycle)
        self._speed = (0.0,) * 6
        self.flange = flange
        return self._last

    def slow_down(self) -> JointSetPoint:
        """Slow the joints down for one cycle, whatever the set-points of the motions."""
        last = self._last
        left = float((np.abs(last.qd) / self._hard).max())
        if left <= self._cycle:
            self._last = JointSetPoint.at_rest(last.q + 0.5 * left * last.qd)
        else:
            qd = last.qd * (1.0 - self._cycle / left)
            q = last.q + 0.5 * self._cycle * (last.qd + qd)
            self._last = JointSetPoint(q, qd, -last.qd / left)
        return self._last

    def _frames(self, q: Array) -> Array:
        if q is not self._at:
            self._at, self._chain = q, frames(self._arm.geometry, q)
        return self._chain

    def _check(self, q: Array, qd: Array) -> None:
        # Plain floats: half the time of arrays of six.
        for i, (angle, rate) in enumerate(zip(q.tolist(), qd.tolist(), strict=True)):
            speed = abs(rate)
            if not speed <= self._fastest[i]:
                raise OutOfReach(
                    f"force control: joint {i + 1} would have to turn at {speed:.3f} rad/s"
                )
            # The joint must be able to stop before its limit.
            rest = angle + 0.5 * rate * speed / self._braking[i]
            if not self._arm.lower[i] <= rest <= self._arm.upper[i]:
                raise OutOfReach(f"force control: joint {i + 1} comes to its limit")
