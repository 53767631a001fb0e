"""The flange's acceleration by the speeds of the joints, as a reference for tests."""

from __future__ import annotations

import numpy as np

from aioduco.kinematics.forward import frames
from aioduco.kinematics.geometry import Geometry
from aioduco.models.rotation import Array


def bias_acceleration(geometry: Geometry, q: Array, qd: Array) -> Array:
    """Return the acceleration of the flange while the joints turn at constant speeds.

    It is the term that the Jacobian does not include: acceleration = J·qdd + bias.

    Args:
        geometry: the arm's lengths [m].
        q: joint angles [rad]. Shape (..., 6).
        qd: joint speeds [rad/s]. Shape (..., 6).

    Returns:
        Linear [m/s²], then angular [rad/s²]. Shape (..., 6).
    """
    chain = frames(geometry, q)
    omega = np.zeros((*q.shape[:-1], 3))
    alpha = np.zeros_like(omega)
    linear = np.zeros_like(omega)
    for i in range(6):
        turn = chain[..., i, :3, 2] * qd[..., i, None]
        alpha += np.cross(omega, turn)
        omega += turn
        arm = chain[..., i + 1, :3, 3] - chain[..., i, :3, 3]
        linear += np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
    return np.concatenate([linear, alpha], axis=-1)
