"""Inverse kinematics of one pose in plain floats, where arrays take twenty times as long.

It uses the same closed form as `inverse`, which explains it; the solutions have the same order.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from aioduco.kinematics.forward import fkine
from aioduco.kinematics.inverse import EDGE, NEAR_WRIST, REACH, ROUNDING, WRIST, closed_form
from aioduco.models.bounds import least, most

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics.geometry import Geometry


Configuration: TypeAlias = tuple[float, float, float, float, float, float]
"""Six joint angles [rad]."""

Rows: TypeAlias = "Sequence[Sequence[float]]"
"""A homogeneous matrix by its rows. Shape (4, 4)."""

_TURN = 2 * math.pi
_EDGE = 1e-10  # by how much rounding may move a joint outside its limit [turns]


def solutions(geometry: Geometry, flange: Rows, q6: float = 0.0) -> list[Configuration]:
    """Return all solutions for a pose of the flange.

    Args:
        geometry: the arm's lengths [m].
        flange: homogeneous matrix in the base frame, by rows.
        q6: angle of joint 6 for the wrist singularity, where any angle is a solution [rad].

    Returns:
        Joint angles [rad], not wrapped, ordered by shoulder, elbow and wrist; up to eight.
    """
    if geometry.corrections is not None:
        found = closed_form(geometry, np.array(flange), q6)
        return [tuple(q) for q in found[~np.isnan(found).any(axis=-1)].tolist()]
    (r00, r01, r02, x), (r10, r11, r12, y), (r20, r21, r22, z) = flange[:3]
    d1, d2, a2, a3, d5, d6 = geometry.lengths
    # The wrist's centre, d6 behind the flange.
    x, y, z = x - d6 * r02, y - d6 * r12, z - d6 * r22 - d1
    away = math.hypot(x, y)
    if not (away > 0.0 and abs(d2) <= away * (1 + REACH)):
        return []
    turn = math.asin(_clip(d2 / away))
    toward = math.atan2(y, x)
    solved: list[Configuration] = []
    for q1 in (toward - turn, toward - math.pi + turn):
        c1, s1 = math.cos(q1), math.sin(q1)
        # Components of the flange's axes along the normal of the arm's plane, and along the
        # horizontal direction in it.
        ax, ay, az = c1 * r10 - s1 * r00, c1 * r11 - s1 * r01, c1 * r12 - s1 * r02
        hx, hy, hz = c1 * r00 + s1 * r10, c1 * r01 + s1 * r11, c1 * r02 + s1 * r12
        ahead = c1 * x + s1 * y
        sine = math.hypot(ax, ay)
        singular = sine < WRIST
        wrists: list[tuple[Configuration, Configuration] | None] = []
        for sign in (1.0, -1.0):
            if singular:
                q, c6, s6 = q6, math.cos(q6), math.sin(q6)
                q5 = math.atan2(c6 * ax - s6 * ay, az)  # as near as possible with this joint 6
            else:
                q5 = sign * math.atan2(sine, az)
                q = math.atan2(-sign * ay, sign * ax)
                c6, s6 = math.cos(q), math.sin(q)
            c5, s5 = math.cos(q5), math.sin(q5)
            q234 = math.atan2(
                -(s6 * hx + c6 * hy) - c5 * (c6 * r20 - s6 * r21) + s5 * r22,
                -(s6 * r20 + c6 * r21) + c5 * (c6 * hx - s6 * hy) - s5 * hz,
            )
            if sine < NEAR_WRIST:
                turned = _into_reach(geometry, ahead, z, q234)
                if singular or abs(turned) * sine <= ROUNDING:
                    q, q234 = q - c5 * turned, q234 + turned
            # Position of joint 4 in the arm's plane, from joint 2.
            u, w = ahead - d5 * math.sin(q234), z - d5 * math.cos(q234)
            cosine = (u * u + w * w - a2 * a2 - a3 * a3) / (2 * a2 * a3)
            if not abs(cosine) <= 1 + REACH:
                wrists.append(None)
                continue
            bend = math.acos(_clip(cosine))
            point = math.atan2(u, w)
            lead = math.atan2(a3 * math.sin(bend), a2 + a3 * math.cos(bend))
            down, up = point - lead, point + lead
            wrists.append(
                (
                    (q1, down, bend, q234 - down - bend, q5, q),
                    (q1, up, -bend, q234 - up + bend, q5, q),
                )
            )
        solved += [pair[elbow] for elbow in (0, 1) for pair in wrists if pair is not None]
    return solved


def _clip(ratio: float) -> float:
    return ratio if abs(ratio) < 1.0 - EDGE else math.copysign(1.0, ratio)


def _into_reach(g: Geometry, u: float, w: float, q234: float) -> float:
    """Return the smallest rotation of joint 5's axis with which joint 5 is in reach [rad]."""
    away = max(math.hypot(u, w), 1e-12)

    def opening(reach: float) -> float:
        # Angle between joint 5's axis and the wrist's direction if joint 4 is at this distance from
        # joint 2.
        return math.acos(_clip((away * away + g.d5 * g.d5 - reach * reach) / (2 * g.d5 * away)))

    off = math.remainder(q234 - math.atan2(u, w), _TURN)
    size = min(max(abs(off), opening(abs(g.a2 - g.a3))), opening(g.a2 + g.a3))
    return math.copysign(size, off) - off


def pose_error(geometry: Geometry, q: Configuration, flange: Rows) -> float:
    """Return the error of the flange's pose.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad].
        flange: the pose to reach in the base frame, by rows.

    Returns:
        The largest difference of an element of the two matrices.
    """
    if geometry.corrections is not None:
        return float(np.abs(fkine(geometry, np.array(q)) - np.array(flange)).max())
    q1, q2, q3, q4, q5, q6 = q
    d1, d2, a2, a3, d5, d6 = geometry.lengths
    q23 = q2 + q3
    q234 = q23 + q4
    c1, s1, c, s = math.cos(q1), math.sin(q1), math.cos(q234), math.sin(q234)
    c5, s5, c6, s6 = math.cos(q5), math.sin(q5), math.cos(q6), math.sin(q6)
    # Components of the flange's axes and position along the horizontal direction in the arm's
    # plane, along its normal, and upwards.
    xh, xa, xu = c6 * c5 * c - s6 * s, c6 * s5, -c6 * c5 * s - s6 * c
    yh, ya, yu = -s6 * c5 * c - c6 * s, -s6 * s5, s6 * c5 * s - c6 * c
    zh, za, zu = -s5 * c, c5, s5 * s
    ph = a2 * math.sin(q2) + a3 * math.sin(q23) + d5 * s + d6 * zh
    pa = d2 + d6 * za
    pu = d1 + a2 * math.cos(q2) + a3 * math.cos(q23) + d5 * c + d6 * zu
    (r00, r01, r02, px), (r10, r11, r12, py), (r20, r21, r22, pz) = flange[:3]
    return max(
        abs(c1 * xh - s1 * xa - r00),
        abs(c1 * yh - s1 * ya - r01),
        abs(c1 * zh - s1 * za - r02),
        abs(c1 * ph - s1 * pa - px),
        abs(s1 * xh + c1 * xa - r10),
        abs(s1 * yh + c1 * ya - r11),
        abs(s1 * zh + c1 * za - r12),
        abs(s1 * ph + c1 * pa - py),
        abs(xu - r20),
        abs(yu - r21),
        abs(zu - r22),
        abs(pu - pz),
    )


def nearest_turns(
    q: Sequence[float], near: Sequence[float], lower: Sequence[float], upper: Sequence[float]
) -> list[float] | None:
    """Add whole turns so that each joint is as close to `near` as its limits allow.

    Args:
        q: joint angles [rad], six.
        near: joint angles to be close to [rad], six.
        lower: lower limits [rad], six.
        upper: upper limits [rad], six.

    Returns:
        Joint angles [rad]; None if a joint is outside its limits with any number of turns.
    """
    wrapped = []
    for angle, close, low, high in zip(q, near, lower, upper, strict=True):
        best = angle + _TURN * round((close - angle) / _TURN)
        if not low <= best <= high:
            fewest = math.ceil((least(low) - angle) / _TURN - _EDGE)
            largest = math.floor((most(high) - angle) / _TURN + _EDGE)
            if fewest > largest:
                return None
            turns = min(max(round((close - angle) / _TURN), fewest), largest)
            # Rounding must not move a joint at its limit by a whole turn.
            best = min(max(angle + _TURN * turns, low), high)
        wrapped.append(best)
    return wrapped
