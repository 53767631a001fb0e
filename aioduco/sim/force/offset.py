"""An offset of the flange between set-points of the motions and those of the drives.

The offset is how far force control has moved the flange. It is kept in the base frame, whatever
tool and axes were in use, so that these can change at any time without a jump.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.rates import ArmRates
from aioduco.models.bounds import least, most
from aioduco.sim.planner.path import JointSetPoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.kinematics.single import Rows
    from aioduco.models.rotation import Array


_FASTER = 1.02  # share of a joint's largest speed that a set-point may have, for rounding
_BRAKING = 0.5  # share of the drives' acceleration that slowing down uses
_NOWHERE = (0.0, 0.0, 0.0)
_NOTHING = (0.0,) * 6
_STRAIGHT = np.eye(3)
_STRAIGHT.flags.writeable = False


class OutOfReach(Exception):
    """The joints cannot follow the offset."""


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

    Plain floats, and `dot` for small matrices: for so few numbers arrays take several times as
    long, and `@` takes three times as long as `dot`.

    Args:
        arm: the arm.
        cycle: time between two set-points [s].
    """

    def __init__(self, arm: Arm, cycle: float) -> None:
        self._arm = arm
        self._cycle = cycle
        fastest = [_FASTER * speed for speed in arm.velocity]
        braking = [_BRAKING * rate for rate in arm.acceleration]
        bounds = map(least, arm.lower), map(most, arm.upper)
        self._bounds = tuple(zip(range(1, 7), fastest, braking, *bounds, strict=True))
        self._hard = np.array(braking)
        self._shift: Sequence[float] = _NOWHERE
        self._turn: Array = _STRAIGHT
        self._speed: Sequence[float] = _NOTHING
        self._twist: Sequence[float] = _NOTHING
        self._none = True
        #: the latest set-point of the drives
        self.setpoint: JointSetPoint = JointSetPoint.at_rest(np.zeros(6))
        self._at: Array = self.setpoint.q
        self._nominal = ArmRates(arm.geometry, self._at.tolist())
        self.flange: Array = _STRAIGHT

    @property
    def shifted(self) -> bool:
        """Whether there is an offset."""
        return not self._none

    def begin(self, setpoint: JointSetPoint) -> None:
        """Begin without an offset, at a set-point of the motions."""
        self.drop_offset()
        self._twist = _NOTHING
        self.setpoint = setpoint
        self.flange = np.array(self._of_motions(setpoint.q).rotation)

    def drop_offset(self) -> None:
        """Drop the offset: the motions restart from where the offset has moved the arm."""
        self._shift, self._turn, self._none = _NOWHERE, _STRAIGHT, True
        self._speed = _NOTHING

    def move(self, twist: Sequence[float], tip: Array) -> None:
        """Move the tool's tip for one cycle.

        Args:
            twist: speed of the tip at the end of the cycle [m/s], then its angular speed [rad/s],
                in the base frame.
            tip: the tip in the flange's frame. Shape (4, 4).
        """
        u, v, w, a, b, c = twist
        r, s, t, i, j, k = self._twist
        half = 0.5 * self._cycle
        x, y, z = self._shift
        x, y, z = x + half * (r + u), y + half * (s + v), z + half * (t + w)
        self._twist = twist
        if a or b or c or i or j or k:
            # The rotation is about the tip: the flange moves round it.
            arm = self.flange.dot(tip[:3, 3])
            turned = _turned(0.5 * (i + a), 0.5 * (j + b), 0.5 * (k + c), self._cycle)
            dx, dy, dz = (arm - turned.dot(arm)).tolist()
            x, y, z = x + dx, y + dy, z + dz
            self._turn = turned.dot(self._turn)
            dx, dy, dz = arm.tolist()
            u, v, w = u - (b * dz - c * dy), v - (c * dx - a * dz), w - (a * dy - b * dx)
        self._shift = (x, y, z)
        self._speed = (u, v, w, a, b, c)
        self._none = False

    def apply(self, setpoint: JointSetPoint) -> JointSetPoint:
        """Give the set-point of the drives for one of the motions.

        Raises:
            OutOfReach: a joint would have to turn too fast, or beyond its limit.
        """
        same = setpoint.q is self._at
        nominal = self._of_motions(setpoint.q)
        rotation: Rows = nominal.rotation
        flange = np.array(rotation)
        if self._none:
            self.setpoint, self.flange = setpoint, flange
            return setpoint
        speed = self._speed
        moving = any(rates := setpoint.qd.tolist())
        if same and not (moving or any(speed) or self.setpoint.qd.any()):
            return self.setpoint
        turned = self._turn is not _STRAIGHT
        if turned:
            flange = self._turn.dot(flange)
            rotation = flange.tolist()
        if moving:
            u, v, w, a, b, c = nominal.of_flange(rates)
            if turned:
                a, b, c = self._turn.dot((a, b, c)).tolist()
            x, y, z, i, j, k = speed
            speed = (x + u, y + v, z + w, a + i, b + j, c + k)
        q, qd = self._solve(nominal.position, rotation, speed)
        self._check(q, qd)
        cycle = self._cycle
        qdd = [(b - a) / cycle for a, b in zip(self.setpoint.qd.tolist(), qd, strict=True)]
        self.setpoint = JointSetPoint(np.array(q), np.array(qd), np.array(qdd))
        self._speed = _NOTHING
        self.flange = flange
        return self.setpoint

    def _solve(
        self, at: Sequence[float], rotation: Rows, speed: Sequence[float]
    ) -> tuple[list[float], tuple[float, ...]]:
        """Give joints and joint speeds for a flange by the motions, and its speed with the offset.

        It is one step of Newton's method from the extrapolated last cycle: its error is negligible.
        """
        cycle, last = self._cycle, self.setpoint
        curve = 0.5 * cycle * cycle
        guess = [
            q + cycle * qd + curve * qdd
            for q, qd, qdd in zip(last.q.tolist(), last.qd.tolist(), last.qdd.tolist(), strict=True)
        ]
        near = ArmRates(self._arm.geometry, guess)
        (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation
        (n00, n01, n02), (n10, n11, n12), (n20, n21, n22) = near.rotation
        x, y, z = at
        dx, dy, dz = self._shift
        nx, ny, nz = near.position
        missing = (
            x + dx - nx,
            y + dy - ny,
            z + dz - nz,
            0.5 * (n10 * r20 + n11 * r21 + n12 * r22 - n20 * r10 - n21 * r11 - n22 * r12),
            0.5 * (n20 * r00 + n21 * r01 + n22 * r02 - n00 * r20 - n01 * r21 - n02 * r22),
            0.5 * (n00 * r10 + n01 * r11 + n02 * r12 - n10 * r00 - n11 * r01 - n12 * r02),
        )
        try:
            steps, qd = near.of_joints(missing), near.of_joints(speed)
        except ZeroDivisionError as exc:
            raise OutOfReach("force control comes to a singularity") from exc
        return [q + step for q, step in zip(guess, steps, strict=True)], qd

    def slow_down(self) -> JointSetPoint:
        """Slow the joints down for one cycle, whatever the set-points of the motions."""
        self.setpoint = self.setpoint.slowed(self._hard, self._cycle)
        return self.setpoint

    def _of_motions(self, q: Array) -> ArmRates:
        if q is not self._at:
            self._at, self._nominal = q, ArmRates(self._arm.geometry, q.tolist())
        return self._nominal

    def _check(self, q: Sequence[float], qd: Sequence[float]) -> None:
        for angle, rate, bound in zip(q, qd, self._bounds, strict=True):
            joint, fastest, braking, lower, upper = bound
            speed = rate if rate >= 0.0 else -rate
            if not speed <= fastest:
                raise OutOfReach(
                    f"force control: joint {joint} would have to turn at {speed:.3f} rad/s"
                )
            # The joint must be able to stop before its limit.
            if not lower <= angle + 0.5 * rate * speed / braking <= upper:
                raise OutOfReach(f"force control: joint {joint} comes to its limit")
