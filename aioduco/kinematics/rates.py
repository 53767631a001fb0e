"""Speeds of flange and joints of one configuration, in plain floats and in closed form.

For a caller that needs both directions once a cycle this takes a tenth of the time of matrices.
The directions of its vectors turn with joint 1: e, forward in the arm's plane; h, the plane's
normal and the direction of joints 2, 3 and 4; and up. An arm with corrections takes the matrices.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from aioduco.kinematics.forward import fkine, jacobian

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics.geometry import Geometry
    from aioduco.models.rotation import Array


Triple: TypeAlias = tuple[float, float, float]


class ArmRates:
    """The flange of an arm, and how its speed and the joints' speeds depend on each other.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad]. Six.

    Attributes:
        position: the flange's origin in the base frame [m].
        rotation: the flange's rotation in the base frame, by rows.
    """

    __slots__ = ("_lengths", "_matrix", "_plane", "_turns", "position", "rotation")

    def __init__(self, geometry: Geometry, q: Sequence[float]) -> None:
        #: the Jacobian of an arm with corrections, for which the closed form does not hold
        self._matrix: Array | None = None
        if geometry.corrections is not None:
            angles = np.array(q)
            self._matrix = jacobian(geometry, angles)
            first, second, third, _ = map(tuple, fkine(geometry, angles).tolist())
            self.position: Triple = first[3], second[3], third[3]
            self.rotation: tuple[Triple, Triple, Triple] = first[:3], second[:3], third[:3]
            return
        self._lengths = d1, d2, a2, a3, d5, d6 = geometry.lengths
        q1, q2, q3, q4, q5, q6 = q
        sin, cos = math.sin, math.cos
        c1, s1, c2, s2 = cos(q1), sin(q1), cos(q2), sin(q2)
        q23 = q2 + q3
        q234 = q23 + q4
        c23, s23, c, s = cos(q23), sin(q23), cos(q234), sin(q234)
        c5, s5, c6, s6 = cos(q5), sin(q5), cos(q6), sin(q6)
        # From joint 4 to the flange, and from the axis of joint 1 to the wrist's centre.
        ahead, above = d5 * s - d6 * s5 * c, d5 * c + d6 * s5 * s
        out = a2 * s2 + a3 * s23
        x, y = out + ahead, d2 + d6 * c5
        self._turns = c1, s1, c2, s2, c23, s23, c, s, c5, s5, math.sin(q3)
        self._plane = x, y, ahead, above, out + d5 * s
        self.position = (
            c1 * x - s1 * y,
            s1 * x + c1 * y,
            d1 + a2 * c2 + a3 * c23 + above,
        )
        # Along e, h and up: the flange's x is c6 (c5 f + s5 h) - s6 w, and so on, where w is the
        # axis of joint 5 and f = h × w.
        xe, xh, xu = c6 * c5 * c - s6 * s, c6 * s5, -c6 * c5 * s - s6 * c
        ye, yh, yu = -s6 * c5 * c - c6 * s, -s6 * s5, s6 * c5 * s - c6 * c
        ze, zh, zu = -s5 * c, c5, s5 * s
        self.rotation = (
            (c1 * xe - s1 * xh, c1 * ye - s1 * yh, c1 * ze - s1 * zh),
            (s1 * xe + c1 * xh, s1 * ye + c1 * yh, s1 * ze + c1 * zh),
            (xu, yu, zu),
        )

    def of_flange(self, qd: Sequence[float]) -> tuple[float, ...]:
        """Give the flange's speed [m/s] and angular speed [rad/s] for joint speeds [rad/s]. Six."""
        if self._matrix is not None:
            return tuple((self._matrix @ qd).tolist())
        _, _, a2, a3, _, d6 = self._lengths
        c1, s1, c2, s2, c23, s23, c, s, c5, s5, _ = self._turns
        x, y, ahead, above, _ = self._plane
        r1, r2, r3, r4, r5, r6 = qd
        r23 = r2 + r3
        r234 = r23 + r4
        u = r2 * a2 * c2 + r23 * a3 * c23 + r234 * above - r1 * y - d6 * c5 * c * r5
        v = r1 * x - d6 * s5 * r5
        w = -r2 * a2 * s2 - r23 * a3 * s23 - r234 * ahead + d6 * c5 * s * r5
        wu = s * r5 - s5 * c * r6
        wv = r234 + c5 * r6
        ww = r1 + c * r5 + s5 * s * r6
        return (c1 * u - s1 * v, s1 * u + c1 * v, w, c1 * wu - s1 * wv, s1 * wu + c1 * wv, ww)

    def of_joints(self, twist: Sequence[float]) -> tuple[float, ...]:
        """Give the joint speeds [rad/s] for a speed and angular speed of the flange. Six.

        Raises:
            ZeroDivisionError: the arm is at a singularity.
        """
        if self._matrix is not None:
            try:
                return tuple(np.linalg.solve(self._matrix, twist).tolist())
            except np.linalg.LinAlgError as error:
                raise ZeroDivisionError from error
        _, _, a2, a3, _, d6 = self._lengths
        c1, s1, c2, s2, c23, s23, c, s, c5, s5, s3 = self._turns
        _, y, ahead, above, centre = self._plane
        vx, vy, w, wx, wy, ww = twist
        u, v = c1 * vx + s1 * vy, c1 * vy - s1 * vx
        wu, wv = c1 * wx + s1 * wy, c1 * wy - s1 * wx
        # Joints 2, 3 and 4 act in the plane: what is across it, and about its directions, tells
        # the speeds of the other three.
        about = s * wu + c * ww
        r1 = (v + d6 * s5 * about) / centre
        r5 = about - c * r1
        r6 = -(c * wu - s * ww + s * r1) / s5
        r234 = wv - c5 * r6
        u += y * r1 + d6 * c5 * c * r5 - r234 * above
        w += r234 * ahead - d6 * c5 * s * r5
        r2 = (u * s23 + w * c23) / (a2 * s3)
        r23 = -(u * s2 + w * c2) / (a3 * s3)
        return (r1, r2, r23 - r2, r234 - r23, r5, r6)
