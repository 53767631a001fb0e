"""Inverse kinematics in closed form, for many poses at once; `single` does the same for one pose.

Joints 2, 3 and 4 of every DUCO arm are parallel. The arm from joint 2 to joint 5 therefore moves
in a plane that turns with joint 1 at a distance d2 from its axis. Let `across` be the normal of
that plane, `ahead` its horizontal direction, and `wrist` the point d6 behind the flange. Then:

- wrist·across = d2 has two solutions for joint 1 (shoulder),
- the components of the flange's axes along `across` are (sin q5·cos q6, -sin q5·sin q6, cos q5),
  which gives two signs of joint 5 (wrist), each with one joint 6,
- the direction of joint 5's axis in the plane gives q2 + q3 + q4. Then two links must reach a point
  of the plane: two signs of joint 3 (elbow).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.forward import _jacobian, frames
from aioduco.models.rotation import Array, rotvec_from_matrix

if TYPE_CHECKING:
    from aioduco.kinematics.geometry import Geometry


BRANCHES = 8
"""Solutions of a pose, since shoulder, elbow and wrist have two each.

A solution's place is 4·shoulder + 2·elbow + wrist.
"""

WRIST = 1e-9
"""Sine of joint 5 below which any joint 6 is a solution, to that many radians."""

REACH = 1e-9
"""How far outside its range a sine or cosine may be by rounding."""

EDGE = 1e-15
"""How far inside its range a sine or cosine counts as its end.

Rounding there turns an angle by 5e-8 rad, which moves the flange by no more than rounding does. So
one function finds what another finds of a pose in which the shoulder or the elbow is singular.
"""

NEAR_WRIST = 1e-6
"""Sine of joint 5 below which rounding may turn joint 6 so far that a pose seems out of reach."""

ROUNDING = 1e-13
"""Change of the flange's orientation by which such a turn is undone [rad]."""


_BENT = 0.99  # largest size of a sine or cosine from which a solution is improved
_REACHES = 1.05  # largest one of a pose that corrections may bring into reach
_CORRECTINGS = 5  # times two steps that improve a solution of an arm with corrections
_REACHED = 1e-9  # error of the flange's pose below which such a solution is one [m, rad]


def closed_form(geometry: Geometry, flange: Array, q6: Array | float = 0.0) -> Array:
    """Return all solutions for poses of the flange.

    Args:
        geometry: the arm's lengths [m].
        flange: homogeneous matrices in the base frame. Shape (..., 4, 4).
        q6: angle of joint 6 for the wrist singularity, where any angle is a solution [rad].
            Broadcast to the leading axes.

    Returns:
        Joint angles [rad], not wrapped, NaN where a branch has no solution. Shape (..., 8, 6).
    """
    solve = _of_lengths if geometry.corrections is None else _corrected
    return solve(geometry, flange, q6)


def _of_lengths(g: Geometry, flange: Array, q6: Array | float, *, near: bool = False) -> Array:
    arc = _near_arc if near else _arc
    rotation, point = flange[..., :3, :3], flange[..., :3, 3]
    wrist = point - g.d6 * rotation[..., :, 2]
    out = np.empty((*flange.shape[:-2], 2, 2, 2, 6))
    x, y = wrist[..., 0], wrist[..., 1]
    away = np.hypot(x, y)
    with np.errstate(invalid="ignore", divide="ignore"):
        turn = arc(np.arcsin, g.d2 / away)
    toward = np.arctan2(y, x)
    # [..., shoulder]
    q1 = np.stack([toward - turn, toward - math.pi + turn], axis=-1)
    c1, s1 = np.cos(q1), np.sin(q1)
    # Components of the flange's axes along `across` and `ahead`: [..., shoulder, axis]
    r = rotation[..., None, :, :]
    across = c1[..., None] * r[..., 1, :] - s1[..., None] * r[..., 0, :]
    ahead = c1[..., None] * r[..., 0, :] + s1[..., None] * r[..., 1, :]
    sine = np.hypot(across[..., 0], across[..., 1])
    singular = (sine < WRIST)[..., None]
    # [..., shoulder, wrist]
    sign = np.array([1.0, -1.0])
    q6_read = np.arctan2(-sign * across[..., 1, None], sign * across[..., 0, None])
    q6_taken = np.broadcast_to(np.asarray(q6, dtype=float), flange.shape[:-2])[..., None, None]
    q6s = np.where(singular, q6_taken, q6_read)
    c6, s6 = np.cos(q6s), np.sin(q6s)
    # If joint 6 is given, joint 5 comes as near as possible to the flange's axis.
    sine5 = np.where(
        singular, c6 * across[..., 0, None] - s6 * across[..., 1, None], sign * sine[..., None]
    )
    q5 = np.arctan2(sine5, across[..., 2, None])
    c5, s5 = np.cos(q5), np.sin(q5)

    def fourth(axes: Array) -> Array:
        # Component of joint 5's axis: the flange's y axis, without the rotation of joint 6.
        component: Array = -(s6 * axes[..., 0, None] + c6 * axes[..., 1, None])
        return component

    def fifth(axes: Array) -> Array:
        # Component of the x axis of joint 4's frame, which is perpendicular to joint 5's axis.
        straight = c6 * axes[..., 0, None] - s6 * axes[..., 1, None]
        component: Array = c5 * straight - s5 * axes[..., 2, None]
        return component

    # The frame of joint 4 is turned by q2 + q3 + q4 in the plane. Both axes measure this angle;
    # their sum avoids components that are small.
    up = np.broadcast_to(r[..., 2, :], ahead.shape)
    q234 = np.arctan2(fourth(ahead) - fifth(up), fourth(up) + fifth(ahead))
    u = np.broadcast_to((c1 * x[..., None] + s1 * y[..., None])[..., None], q234.shape)
    w = np.broadcast_to((wrist[..., 2] - g.d1)[..., None, None], q234.shape)
    if (sine < NEAR_WRIST).any():
        # Here joint 6 and the sum of joints 2 to 4 rotate about the same axis, in the same or in
        # opposite directions. Beside it, such a turn changes the orientation by its product with
        # the sine.
        turned = _into_reach(g, u, w, q234, sine[..., None])
        q6s, q234 = q6s - c5 * turned, q234 + turned
    u, w = u - g.d5 * np.sin(q234), w - g.d5 * np.cos(q234)
    with np.errstate(invalid="ignore"):
        bend = arc(np.arccos, (u * u + w * w - g.a2**2 - g.a3**2) / (2 * g.a2 * g.a3))
    for elbow, q3 in enumerate((bend, -bend)):
        q2 = np.arctan2(u, w) - np.arctan2(g.a3 * np.sin(q3), g.a2 + g.a3 * np.cos(q3))
        solution = out[..., :, elbow, :, :]
        solution[..., 0] = q1[..., None]
        solution[..., 1] = q2
        solution[..., 2] = q3
        solution[..., 3] = q234 - q2 - q3
        solution[..., 4] = q5
        solution[..., 5] = q6s
    out = out.reshape((*flange.shape[:-2], BRANCHES, 6))
    out[np.isnan(out).any(axis=-1)] = np.nan
    return out


def _corrected(geometry: Geometry, flange: Array, q6: Array | float) -> Array:
    """Return all solutions for an arm with corrections: those of its lengths, improved."""
    offsets = np.array(geometry.corrections.theta if geometry.corrections else (0.0,) * 6)
    near = _of_lengths(geometry, flange, q6 + offsets[5], near=True) - offsets
    goal = flange[..., None, :, :]
    found: Array = near
    tried = ~np.isnan(near).any(axis=-1)
    reached = np.zeros_like(tried)
    for _ in range(_CORRECTINGS):
        found = refine(geometry, found, goal)
        with np.errstate(invalid="ignore"):
            reached = np.abs(residual(geometry, found, goal)).max(axis=-1) < _REACHED
        if not (tried & ~reached).any():
            break
    found[~reached] = np.nan
    return found


def _into_reach(g: Geometry, u: Array, w: Array, q234: Array, sine: Array) -> Array:
    """Return the smallest rotation of joint 5's axis with which joint 5 is in reach [rad].

    It is 0 where it would change the flange's orientation.

    Args:
        g: the arm's lengths [m].
        u: distance of the wrist's centre ahead of joint 2, in the arm's plane [m].
        w: height of the wrist's centre above joint 2 [m].
        q234: direction of joint 5's axis from the vertical [rad].
        sine: sine of joint 5.
    """
    away = np.maximum(np.hypot(u, w), 1e-12)
    toward = np.arctan2(u, w)

    def opening(reach: float) -> Array:
        # Angle between joint 5's axis and the wrist's direction if joint 4 is at this distance from
        # joint 2.
        cosine = (away**2 + g.d5**2 - reach**2) / (2 * g.d5 * away)
        angle: Array = np.arccos(np.clip(cosine, -1.0, 1.0))
        return angle

    off = wrap(q234 - toward)
    size = np.clip(np.abs(off), opening(abs(g.a2 - g.a3)), opening(g.a2 + g.a3))
    turned = np.copysign(size, off) - off
    return np.where((sine < WRIST) | (np.abs(turned) * sine <= ROUNDING), turned, 0.0)


def _arc(function: np.ufunc, ratio: Array) -> Array:
    size = np.abs(ratio)
    ended = np.where(size >= 1 - EDGE, np.sign(ratio), ratio)
    angle: Array = function(np.where(size <= 1 + REACH, ended, np.nan))
    return angle


def _near_arc(function: np.ufunc, ratio: Array) -> Array:
    """An angle from which steps lead to that of an arm whose corrections change its reach.

    At the end of the range itself they would lead nowhere, or to the other branch.
    """
    size = np.abs(ratio)
    angle: Array = function(np.where(size <= _REACHES, np.clip(ratio, -_BENT, _BENT), np.nan))
    return angle


def residual(geometry: Geometry, q: Array, flange: Array) -> Array:
    """Return the error of the flange's pose: position [m], then rotation [rad].

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad]. Shape (..., 6).
        flange: poses to reach, in the base frame. Shape (..., 4, 4).

    Returns:
        A twist in the base frame. Shape (..., 6).
    """
    return _residual(frames(geometry, q)[..., 6, :, :], flange)


def _residual(reached: Array, flange: Array) -> Array:
    turn = flange[..., :3, :3] @ np.swapaxes(reached[..., :3, :3], -1, -2)
    return np.concatenate(
        [flange[..., :3, 3] - reached[..., :3, 3], rotvec_from_matrix(turn)], axis=-1
    )


def refine(geometry: Geometry, q: Array, flange: Array, rounds: int = 2) -> Array:
    """Improve solutions by damped Newton steps; near a singularity they do not change.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles near solutions [rad]. Shape (..., 6).
        flange: poses to reach, in the base frame. Shape (..., 4, 4).
        rounds: number of steps.

    Returns:
        Joint angles [rad]. Shape (..., 6).
    """
    damping = 1e-12 * np.eye(6)
    for _ in range(rounds):
        chain = frames(geometry, q)
        error = _residual(chain[..., 6, :, :], flange)
        matrix = _jacobian(chain)
        back = np.swapaxes(matrix, -1, -2)
        q = q + (back @ np.linalg.solve(matrix @ back + damping, error[..., None]))[..., 0]
    return q


def shortfall(geometry: Geometry, flange: Array) -> float:
    """Return the minimum distance by which a pose without a solution is out of reach [m].

    Args:
        geometry: the arm's lengths [m].
        flange: the pose in the base frame. Shape (4, 4).
    """
    g = geometry
    wrist = flange[:3, 3] - g.d6 * flange[:3, 2]
    away = math.hypot(wrist[0], wrist[1])
    if away < g.d2:
        return g.d2 - away
    # Joint 5 can be anywhere on a circle, or only at one point of it. The result is the minimum for
    # all points of the circle.
    ahead = math.sqrt(away**2 - g.d2**2)
    distance = math.hypot(ahead, wrist[2] - g.d1)
    return max(distance - (g.a2 + g.a3 + g.d5), abs(g.a2 - g.a3) - g.d5 - distance, 0.0)


def wrap(q: Array) -> Array:
    """Return the same angles in [-π, π] [rad], without a loss of precision inside that range."""
    turned: Array = q - 2 * np.pi * np.floor((q + np.pi) / (2 * np.pi))
    return np.clip(turned, -np.pi, np.pi)
