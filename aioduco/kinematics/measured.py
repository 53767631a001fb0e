"""What calibrations share: measured frames, and how sure a result of least squares is."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models.pose import Pose
from aioduco.models.ranges import POSE

if TYPE_CHECKING:
    from aioduco.models.rotation import Array


_RIGID = 1e-3  # largest error of a rotation matrix
#: 0.95 quantiles of Fisher's F for 1 and 3 numbers, and the degrees of freedom with which their
#: variances were estimated
_FREEDOMS = (6, 8, 10, 12, 15, 20, 30, 60, 1e9)
_ONE = (5.987, 5.318, 4.965, 4.747, 4.543, 4.351, 4.171, 4.001, 3.841)
_THREE = (4.757, 4.066, 3.708, 3.490, 3.287, 3.098, 2.922, 2.758, 2.605)


def bound(covariance: Array, freedoms: int) -> float:
    """Return how far a result may be from the true one: in 95 of 100 cases it is not further.

    Args:
        covariance: covariance of the result, of one to three numbers. Shape (n, n).
        freedoms: degrees of freedom with which it was estimated, at least 6.
    """
    variances = np.linalg.eigvalsh(covariance)
    if not variances.sum() > 0.0:
        return 0.0  # readings without any error, as of a simulator without a load
    # The squared distance is spread as if it came from so many numbers of the same variance.
    count = variances.sum() ** 2 / (variances**2).sum()
    one, three = (
        np.interp(1.0 / freedoms, [1.0 / each for each in _FREEDOMS[::-1]], quantiles[::-1])
        for quantiles in (_ONE, _THREE)
    )
    return float(np.sqrt(variances.sum() * np.interp(count, (1.0, 3.0), (one, three))))


def rigid_frames(name: str, given: Any, each: str) -> Array:
    """Return measured frames as matrices. Shape (n, 4, 4).

    Args:
        name: the argument's name, for errors.
        given: matrices of shape (4, 4), or poses [m, rad].
        each: what one of them is, such as "view".

    Raises:
        ParameterError: one of them is no rigid frame.
    """
    found = []
    if not isinstance(given, Iterable):
        raise ParameterError(name, given, f"a frame for each {each}")
    for number, one in enumerate(given):
        expected = f"in {each} {number} a rigid frame of shape (4, 4), or a pose"
        try:
            numbers = one if isinstance(one, Pose) else np.asarray(one, dtype=np.float64)
            pose = None if np.shape(numbers) == (4, 4) else Pose.of(numbers)
            frame = np.array(numbers) if pose is None else pose.matrix
        except (TypeError, ValueError, OverflowError) as error:
            told = (
                f"None: leave out every {each} without one" if one is None else type(one).__name__
            )
            raise ParameterError(name, told, expected) from error
        if pose is not None:
            POSE(f"{name}[{number}]", pose)
        turn = frame[:3, :3]
        if not (
            np.isfinite(frame).all()
            and np.abs(frame[3] - (0.0, 0.0, 0.0, 1.0)).max() < _RIGID
            and np.abs(turn @ turn.T - np.eye(3)).max() < _RIGID
            and np.linalg.det(turn) > 0.0
        ):
            raise ParameterError(name, frame.tolist(), expected)
        frame[:3, :3] = nearest_rotation(turn)
        found.append(frame)
    return np.array(found).reshape(-1, 4, 4)


def nearest_rotation(matrix: Array) -> Array:
    """Return the rotation that is nearest to a matrix. Shape (3, 3)."""
    u, _, vt = np.linalg.svd(matrix)
    found: Array = u @ np.diag((1.0, 1.0, np.linalg.det(u @ vt))) @ vt
    return found
