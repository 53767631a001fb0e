"""Forward kinematics, Jacobian and singularities, for one configuration or many at once.

Frames follow the standard Denavit-Hartenberg convention,
T_i = Rz(q_i + theta_i)·Tz(d_i)·Tx(a_i)·Rx(alpha_i). All results are in the base frame.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from aioduco.kinematics.geometry import Geometry
    from aioduco.models.rotation import Array


_BASE = np.eye(4)
_BASE.flags.writeable = False


@lru_cache(maxsize=64)
def _table(geometry: Geometry) -> tuple[Array, ...]:
    """Return theta [rad], the cosines and sines of alpha, a and d [m], each of shape (6,)."""
    theta, twist, a, d = (
        np.array(column, dtype=np.float64)
        for column in (geometry.theta, geometry.alpha, geometry.a, geometry.d)
    )
    ca: Array = np.cos(twist)
    sa: Array = np.sin(twist)
    if geometry.corrections is None:
        # All twists are 0 or ±π/2; rounding makes the cosines and sines exact.
        ca, sa = ca.round(), sa.round()
    table = theta, ca, sa, a, d
    for column in table:
        column.flags.writeable = False
    return table


def frames(geometry: Geometry, q: Array) -> Array:
    """Return the frames of the base and the six links.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad]. Shape (..., 6).

    Returns:
        Homogeneous matrices; the first is the base, the last the flange. Shape (..., 7, 4, 4).
    """
    theta, ca, sa, a, d = _table(geometry)
    angle = q + theta
    c, s = np.cos(angle), np.sin(angle)
    step = np.zeros((*angle.shape, 4, 4))
    step[..., 0, 0] = c
    step[..., 0, 1] = -s * ca
    step[..., 0, 2] = s * sa
    step[..., 1, 0] = s
    step[..., 1, 1] = c * ca
    step[..., 1, 2] = -c * sa
    step[..., 2, 1] = sa
    step[..., 2, 2] = ca
    step[..., 0, 3] = c * a
    step[..., 1, 3] = s * a
    step[..., 2, 3] = d
    step[..., 3, 3] = 1.0
    chain = np.empty((*angle.shape[:-1], 7, 4, 4))
    chain[..., 0, :, :] = _BASE
    if angle.ndim == 1:
        for i in range(6):
            np.dot(chain[i], step[i], out=chain[i + 1])  # takes a third of the time of matmul
        return chain
    for i in range(6):
        np.matmul(chain[..., i, :, :], step[..., i, :, :], out=chain[..., i + 1, :, :])
    return chain


def fkine(geometry: Geometry, q: Array) -> Array:
    """Return the flange in the base frame for joint angles [rad] of shape (..., 6): (..., 4, 4)."""
    flange: Array = frames(geometry, q)[..., 6, :, :]
    return flange


def jacobian(geometry: Geometry, q: Array) -> Array:
    """Return the geometric Jacobian of the flange.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad]. Shape (..., 6).

    Returns:
        Rows 0 to 2: velocity of the flange per joint speed [m/rad]; rows 3 to 5: its angular
        velocity [rad/rad]. Shape (..., 6, 6).
    """
    chain = frames(geometry, q)
    return _jacobian(chain)


def _jacobian(chain: Array) -> Array:
    axis = chain[..., :6, :3, 2]
    arm = chain[..., 6:7, :3, 3] - chain[..., :6, :3, 3]
    columns = np.concatenate([np.cross(axis, arm), axis], axis=-1)
    return np.swapaxes(columns, -1, -2)


def singular_values(geometry: Geometry, q: Array) -> Array:
    """Return the distances of an arm from its three singularities.

    The Jacobian's determinant is -a2·a3·(a2 + a3 + d5) times the product of the three.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad]. Shape (..., 6).

    Returns:
        Three signed numbers from -1 to 1, each zero at its singularity. Shoulder: distance of the
        wrist's centre from the axis of joint 1 in the arm's plane, divided by the length of the
        arm. Elbow: sine of joint 3. Wrist: sine of joint 5. The sign changes when the arm passes
        through the singularity. Shape (..., 3).
    """
    q2, q23 = q[..., 1], q[..., 1] + q[..., 2]
    g = geometry
    ahead = g.a2 * np.sin(q2) + g.a3 * np.sin(q23) + g.d5 * np.sin(q23 + q[..., 3])
    return np.stack([ahead / (g.a2 + g.a3 + g.d5), np.sin(q[..., 2]), np.sin(q[..., 4])], axis=-1)
