"""Pose of a camera on the arm, or beside it, from views of a board (hand-eye calibration).

With the camera's pose X and the board's B, each view says that M X S = B, where M is the flange (or
its inverse, for a camera beside the arm) and S the board in the camera. First the rotations of X
and B are found together by linear algebra, without logarithms of rotations, whose sign is arbitrary
at half turns. Then Newton's method makes the errors of all views smallest, rotations and distances
each weighed by how far the views disagree. The uncertainty is that of the jackknife: how much the
result depends on each view. So it also holds where errors are not the same in all directions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from aioduco.errors import CalibrationError, Described, ParameterError
from aioduco.kinematics.measured import bound, nearest_rotation, rigid_frames
from aioduco.models.rotation import crossing, matrix_from_rotvec, rotvec_from_matrix, transform
from aioduco.models.rules import Number, Vector
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.models.pose import PoseLike

    Matrix = NDArray[np.float64]


_LIMITS = Vector(Number(0.0, unit="m or rad", open_low=True, source="this package"), length=2)
_MIN_VIEWS = 4  # number of views: three determine the pose, and the fourth verifies it
_MIN_ROTATION = 0.05  # minimum rotation between views, about two axes [rad]
_STEPS = 30  # of Newton's method, at most
_SMALLEST = 1e-9  # spread of the views that is not told from none [rad, m]


class HandEye(NamedTuple):
    """Pose of a camera, how well the views agree on it, and how sure it is.

    Attributes:
        camera: its frame in the flange's, or in the base for one beside the arm. Shape (4, 4).
        board: the board's frame in the base, or in the flange's for a camera beside the arm.
        distances: for each view, the distance of the board's place in this view from `board` [m].
        angles: for each view, the angle between the board's orientation in this view and `board`
            [rad].
        uncertainty: how far the camera's place and orientation may be from the true ones; in 95 of
            100 calibrations they are not further [m, rad]. Errors that all views share, such as a
            wrong size of the squares, are not in it.
    """

    camera: Matrix
    board: Matrix
    distances: tuple[float, ...]
    angles: tuple[float, ...]
    uncertainty: tuple[float, float]


def calibrate_hand_eye(
    flanges: Sequence[PoseLike | Matrix] | Matrix,
    boards: Sequence[PoseLike | Matrix] | Matrix,
    *,
    mounted: Literal["flange", "beside"] = "flange",
    limits: tuple[float, float] = (0.005, 0.02),
) -> HandEye:
    """Compute the pose of a camera from views of one board.

    Take ten or more views that are rotated by at least 0.3 rad about different axes. Half turns are
    no rotations in this sense: a view may differ by one, but not all by half turns alone.

    Args:
        flanges: for each view, the flange in the base, such as `arm.fkine(q)` or
            `await robot.state.get_flange_pose()`: matrices of shape (4, 4), or poses [m, rad].
        boards: for each view, the board in the camera, from `find_board`, likewise.
        mounted: "flange": the camera is on the flange and the board stands still; "beside": the
            camera stands beside the arm and the board is on the flange.
        limits: maximum deviation of the board in a view [m, rad].

    Returns:
        The pose of the camera, how well the views agree on it, and how sure it is.

    Raises:
        ParameterError: an argument has a wrong shape or value, or there are fewer than four views.
        CalibrationError: the views are rotated too little, or by half turns alone, or disagree by
            more than the limits.
    """
    hands = rigid_frames("flanges", flanges, "view")
    seen = rigid_frames("boards", boards, "view")
    if len(hands) < _MIN_VIEWS:
        raise ParameterError("flanges", Described(f"{len(hands)} views"), f"{_MIN_VIEWS} or more")
    if len(seen) != len(hands):
        raise ParameterError(
            "boards", Described(f"{len(seen)} views"), f"{len(hands)}, as many as flanges"
        )
    one_of("mounted", mounted, ("flange", "beside"))
    farthest, widest = _LIMITS("limits", limits)
    moved: Matrix = hands if mounted == "flange" else np.linalg.inv(hands).astype(np.float64)
    _check_turns(moved[:, :3, :3])
    camera, board, spread = _fitted(moved, seen, *_first(moved, seen))
    errors = _errors(moved, seen, camera, board)
    distances = np.linalg.norm(errors[:, 3:], axis=1)
    angles = np.linalg.norm(errors[:, :3], axis=1)
    if not (distances.max() <= farthest and angles.max() <= widest):
        worst = int(np.argmax(distances / farthest + angles / widest))
        raise CalibrationError(
            f"the views disagree on where the board is: in view {worst} it is "
            f"{distances[worst]:.4f} m and {angles[worst]:.4f} rad off, at most "
            f"{farthest:g} m and {widest:g} rad are allowed. Leave views out that are blurred, "
            "and check the size of the squares, the intrinsics and which joints go with which view"
        )
    turn, place = (
        bound(spread[part, part], 3 * len(moved) - 6) for part in (slice(0, 3), slice(3, 6))
    )
    return HandEye(camera, board, tuple(distances.tolist()), tuple(angles.tolist()), (place, turn))


def _check_turns(turns: Matrix) -> None:
    """Refuse views whose rotations do not determine the camera's."""
    between = np.einsum("aij,bik->abjk", turns, turns).reshape(-1, 3, 3)
    # Axis times sine of each rotation between two views: none for half turns, which leave open
    # whether the camera is turned by one, too.
    skew = 0.5 * (between - np.swapaxes(between, 1, 2))
    sines = skew[:, (2, 0, 1), (1, 2, 0)]
    scale = np.sqrt(2.0 * len(turns))
    if np.linalg.svd(sines, compute_uv=False)[1] / scale >= _MIN_ROTATION:
        return
    whole = rotvec_from_matrix(between)
    if np.linalg.svd(whole, compute_uv=False)[1] / scale >= _MIN_ROTATION:
        raise CalibrationError(
            "the views are turned about two axes by half turns alone, which leaves open whether "
            "the camera is turned by one, too: add views that are turned by 0.3 to 2.5 rad about "
            "two axes"
        )
    raise CalibrationError(
        "the views are turned about no more than one axis: turn the flange about two"
    )


def _first(moved: Matrix, seen: Matrix) -> tuple[Matrix, Matrix]:
    """Give the camera and the board by linear algebra (Shah's method)."""
    turns, looks = moved[:, :3, :3], seen[:, :3, :3]
    # Each view says that X = M^T B S^T: a linear map of the numbers of B to those of X.
    together = np.einsum("nki,njl->ijkl", turns, looks).reshape(9, 9)
    left, _, right = np.linalg.svd(together)
    one, other = left[:, 0].reshape(3, 3), right[0].reshape(3, 3)
    sign = np.sign(np.linalg.det(one))
    camera, board = np.eye(4), np.eye(4)
    camera[:3, :3], board[:3, :3] = nearest_rotation(sign * one), nearest_rotation(sign * other)
    rows = np.hstack([turns.reshape(-1, 3), np.tile(-np.eye(3), (len(turns), 1))])
    away = (turns @ camera[:3, :3] @ seen[:, :3, 3:])[:, :, 0] + moved[:, :3, 3]
    places = np.linalg.lstsq(rows, -away.ravel(), rcond=None)[0]
    camera[:3, 3], board[:3, 3] = places[:3], places[3:]
    return camera, board


def _fitted(
    moved: Matrix, seen: Matrix, camera: Matrix, board: Matrix
) -> tuple[Matrix, Matrix, Matrix]:
    """Give the camera and the board for which all errors are smallest.

    Returns:
        The two, and the covariance of the camera's rotation and place, in its frame. Shape (6, 6).
    """
    count = len(moved)
    scales = np.full(6, 1e-3)
    back, away = np.swapaxes(seen[:, :3, :3], 1, 2), seen[:, :3, 3]
    # Derivatives of each view's error by a small motion of the camera, and of the board.
    slopes = np.zeros((count, 6, 12))
    slopes[:, :3, :3] = slopes[:, 3:, 3:6] = back
    slopes[:, 3:, :3] = -back @ crossing(away)
    slopes[:, :, 6:] = -np.eye(6)
    scaled, weighed, inverse = slopes, np.zeros((count, 6)), np.eye(12)
    for _ in range(_STEPS):
        errors = _errors(moved, seen, camera, board)
        scaled, weighed = slopes / scales[:, None], errors / scales
        inverse = np.linalg.inv(np.einsum("nij,nik->jk", scaled, scaled))
        step = -inverse @ np.einsum("nij,ni->j", scaled, weighed)
        camera, board = camera @ _small(step[:6]), board @ _small(step[6:])
        before = scales
        spread = np.sqrt((errors.reshape(count, 2, 3) ** 2).sum(axis=(0, 2)) / (3 * count - 6))
        scales = np.maximum(spread, _SMALLEST).repeat(3)
        if np.abs(step).max() < _SMALLEST and np.abs(scales / before - 1.0).max() < 1e-3:
            break
    # The jackknife, by the leverage of each view.
    across = np.swapaxes(scaled, 1, 2)
    left = np.linalg.pinv(np.eye(6) - scaled @ inverse @ across, rcond=1e-3)
    moves = (inverse @ across @ left @ weighed[:, :, None])[:, :6, 0]
    return camera, board, (count - 1) / count * moves.T @ moves


def _errors(moved: Matrix, seen: Matrix, camera: Matrix, board: Matrix) -> Matrix:
    """For each view, the board's rotation and place in it against `board`. Shape (n, 6)."""
    off = np.linalg.inv(board) @ moved @ camera @ seen
    return np.hstack([rotvec_from_matrix(off[:, :3, :3]), off[:, :3, 3]])


def _small(step: Matrix) -> Matrix:
    return transform(matrix_from_rotvec(step[:3]), step[3:])
