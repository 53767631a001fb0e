"""Rotations as arrays: matrices, roll-pitch-yaw, quaternions and rotation vectors.

The conversions take and return arrays with any number of leading axes, so that a whole path can be
converted in one call. Roll-pitch-yaw is the controller's convention, R = Rz(rz)·Ry(ry)·Rx(rx).
Quaternions are in the order w, x, y, z.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

from aioduco.models.numpy_on_use import np
from aioduco.models.quaternions import from_rpy, inverse, product

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


Array: TypeAlias = "NDArray[np.float64]"

_GIMBAL = 1e-12  # below this cosine of ry, rx and rz rotate about the same axis


def matrix_from_rpy(rpy: Array) -> Array:
    """Return the rotation matrices of roll-pitch-yaw angles.

    Args:
        rpy: rx, ry, rz [rad]. Shape (..., 3).

    Returns:
        R = Rz(rz)·Ry(ry)·Rx(rx). Shape (..., 3, 3).
    """
    cx, cy, cz = np.moveaxis(np.cos(rpy), -1, 0)
    sx, sy, sz = np.moveaxis(np.sin(rpy), -1, 0)
    matrix = np.empty((*cx.shape, 3, 3))
    matrix[..., 0, 0] = cz * cy
    matrix[..., 0, 1] = cz * sy * sx - sz * cx
    matrix[..., 0, 2] = cz * sy * cx + sz * sx
    matrix[..., 1, 0] = sz * cy
    matrix[..., 1, 1] = sz * sy * sx + cz * cx
    matrix[..., 1, 2] = sz * sy * cx - cz * sx
    matrix[..., 2, 0] = -sy
    matrix[..., 2, 1] = cy * sx
    matrix[..., 2, 2] = cy * cx
    return matrix


def rpy_from_matrix(matrix: Array) -> Array:
    """Return the roll-pitch-yaw angles of rotation matrices.

    rz is computed first, and its rotation is removed before rx and ry are computed. So the three
    angles reproduce the matrix to machine precision, also close to ry = ±π/2, where each angle
    alone is ill conditioned. At that singularity itself rz is zero.

    Args:
        matrix: rotation matrices. Shape (..., 3, 3).

    Returns:
        rx in [-π, π], ry in [-π/2, π/2], rz in [-π, π] [rad]. Shape (..., 3).
    """
    r = matrix
    singular = np.hypot(r[..., 0, 0], r[..., 1, 0]) < _GIMBAL
    rz = np.where(singular, 0.0, np.arctan2(r[..., 1, 0], r[..., 0, 0]))
    c, s = np.cos(rz), np.sin(rz)
    ry = np.arctan2(-r[..., 2, 0], c * r[..., 0, 0] + s * r[..., 1, 0])
    rx = np.arctan2(
        s * r[..., 0, 2] - c * r[..., 1, 2],
        c * r[..., 1, 1] - s * r[..., 0, 1],
    )
    return np.stack([rx, ry, rz], axis=-1)


def matrix_from_quaternion(quaternion: Array) -> Array:
    """Return the rotation matrices of unit quaternions.

    Args:
        quaternion: w, x, y, z, of length one. Shape (..., 4).

    Returns:
        Rotation matrices. Shape (..., 3, 3).
    """
    w, x, y, z = np.moveaxis(np.asarray(quaternion), -1, 0)
    matrix = np.empty((*w.shape, 3, 3))
    matrix[..., 0, 0] = 1 - 2 * (y * y + z * z)
    matrix[..., 0, 1] = 2 * (x * y - w * z)
    matrix[..., 0, 2] = 2 * (x * z + w * y)
    matrix[..., 1, 0] = 2 * (x * y + w * z)
    matrix[..., 1, 1] = 1 - 2 * (x * x + z * z)
    matrix[..., 1, 2] = 2 * (y * z - w * x)
    matrix[..., 2, 0] = 2 * (x * z - w * y)
    matrix[..., 2, 1] = 2 * (y * z + w * x)
    matrix[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return matrix


def quaternion_from_matrix(matrix: Array) -> Array:
    """Return the unit quaternions of rotation matrices.

    The matrix 4·q·qᵀ is linear in R. Its row with the largest diagonal element is the quaternion
    times a factor. This row is never close to zero, so no rotation is ill conditioned.

    Args:
        matrix: rotation matrices. Shape (..., 3, 3).

    Returns:
        w, x, y, z with w not negative. Shape (..., 4).
    """
    r = matrix
    xx, yy, zz = r[..., 0, 0], r[..., 1, 1], r[..., 2, 2]
    outer = np.empty((*xx.shape, 4, 4))
    outer[..., 0, 0] = 1 + xx + yy + zz
    outer[..., 1, 1] = 1 + xx - yy - zz
    outer[..., 2, 2] = 1 - xx + yy - zz
    outer[..., 3, 3] = 1 - xx - yy + zz
    outer[..., 0, 1] = outer[..., 1, 0] = r[..., 2, 1] - r[..., 1, 2]
    outer[..., 0, 2] = outer[..., 2, 0] = r[..., 0, 2] - r[..., 2, 0]
    outer[..., 0, 3] = outer[..., 3, 0] = r[..., 1, 0] - r[..., 0, 1]
    outer[..., 1, 2] = outer[..., 2, 1] = r[..., 0, 1] + r[..., 1, 0]
    outer[..., 1, 3] = outer[..., 3, 1] = r[..., 0, 2] + r[..., 2, 0]
    outer[..., 2, 3] = outer[..., 3, 2] = r[..., 1, 2] + r[..., 2, 1]
    largest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    row: Array = np.take_along_axis(outer, largest[..., None, None], axis=-2)[..., 0, :]
    row /= np.linalg.norm(row, axis=-1, keepdims=True)
    return np.where(row[..., :1] < 0, -row, row)


def rotvec_from_matrix(matrix: Array) -> Array:
    """Return the rotation vectors (axis times angle) of rotation matrices.

    Args:
        matrix: rotation matrices. Shape (..., 3, 3).

    Returns:
        Rotation vectors with an angle in [0, π] [rad]. Shape (..., 3).
    """
    quaternion = quaternion_from_matrix(matrix)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, quaternion[..., :1])
    scale = np.where(sine > 1e-15, angle / np.where(sine > 1e-15, sine, 1.0), 2.0)
    return quaternion[..., 1:] * scale


def matrix_from_rotvec(rotvec: Array) -> Array:
    """Return the rotation matrices of rotation vectors (axis times angle).

    Args:
        rotvec: rotation vectors [rad]. Shape (..., 3).

    Returns:
        Rotation matrices. Shape (..., 3, 3).
    """
    half = 0.5 * np.asarray(rotvec)
    angle = np.linalg.norm(half, axis=-1, keepdims=True)
    # np.sinc is sin(πx)/(πx), and one at zero.
    return matrix_from_quaternion(
        np.concatenate([np.cos(angle), half * np.sinc(angle / np.pi)], axis=-1)
    )


def transform(rotation: Array, position: Array) -> Array:
    """Return the homogeneous transforms of rotations and positions.

    Args:
        rotation: rotation matrices. Shape (..., 3, 3).
        position: positions [m]. Shape (..., 3).

    Returns:
        Transforms. Shape (..., 4, 4).
    """
    made = np.zeros((*np.shape(position)[:-1], 4, 4))
    made[..., :3, :3] = rotation
    made[..., :3, 3] = position
    made[..., 3, 3] = 1.0
    return made


def slerp(start: Array, end: Array, t: Array) -> Array:
    """Interpolate between two orientations at a constant rate, the shorter way.

    Args:
        start: rotation matrix at t = 0. Shape (3, 3).
        end: rotation matrix at t = 1. Shape (3, 3).
        t: fractions of the rotation. Shape (...,).

    Returns:
        Rotation matrices. Shape (..., 3, 3).
    """
    turn = rotvec_from_matrix(start.T @ end)
    return start @ matrix_from_rotvec(np.asarray(t)[..., None] * turn)


def turn_between(start: Sequence[float], end: Sequence[float]) -> float:
    """Return the angle of the rotation from one orientation to another.

    Args:
        start: rx, ry, rz [rad].
        end: rx, ry, rz [rad].

    Returns:
        The angle, 0 to π [rad].
    """
    # plain floats: for one pair, arrays take ten times as long
    w, x, y, z = product(inverse(from_rpy(*start)), from_rpy(*end))
    return 2.0 * math.atan2(math.hypot(x, y, z), abs(w))


def crossing(vectors: Array) -> Array:
    """Return matrices of the cross product with vectors. Shape (..., 3) to (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    none = np.zeros_like(x)
    rows = ((none, -z, y), (z, none, -x), (-y, x, none))
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))
