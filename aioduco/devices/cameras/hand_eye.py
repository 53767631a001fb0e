"""Pose of a camera on the arm, or beside it, from views of a board (hand-eye calibration).

OpenCV solves the problem. This module checks the result: with it, the board must be at the same
place in all views.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

import cv2
import numpy as np

from aioduco.errors import CalibrationError, ParameterError
from aioduco.models.rotation import rotvec_from_matrix

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.devices.cameras.camera import CameraFrame

    Matrix = NDArray[np.float64]

__all__ = ["BoardSize", "HandEye", "calibrate_hand_eye", "find_board"]

_MIN_VIEWS = 4  # number of views: three determine the pose, and the fourth verifies it
_MIN_ROTATION = 0.1  # minimum rotation between views, about two axes [rad]


class BoardSize(NamedTuple):
    """Size of a chessboard, whose origin is its first inner corner.

    Attributes:
        columns, rows: numbers of inner corners; one must be even and the other odd, since the board
            otherwise looks the same from two sides.
        square: edge length of a square [m].
    """

    columns: int
    rows: int
    square: float


class HandEye(NamedTuple):
    """Pose of a camera, and how well the views agree on it.

    Attributes:
        camera: its frame in the flange's, or in the base for one beside the arm. Shape (4, 4).
        board: the board's frame in the base, or in the flange's for a camera beside the arm.
        distances: for each view, the distance of the board's place in this view from `board` [m].
        angles: for each view, the angle between the board's orientation in this view and `board`
            [rad].
    """

    camera: Matrix
    board: Matrix
    distances: tuple[float, ...]
    angles: tuple[float, ...]


def find_board(frame: CameraFrame, size: BoardSize) -> Matrix | None:
    """Find a chessboard in an image.

    Args:
        frame: the image.
        size: size of the board.

    Returns:
        The board's frame in the camera's, shape (4, 4); None if the board is not completely
        visible.
    """
    grey = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY)
    found, corners = cv2.findChessboardCorners(grey, (size.columns, size.rows))
    if not found:
        return None
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-3)
    corners = cv2.cornerSubPix(grey, corners, (5, 5), (-1, -1), criteria)
    points = np.zeros((size.columns * size.rows, 3))
    points[:, :2] = size.square * np.mgrid[: size.columns, : size.rows].T.reshape(-1, 2)
    lens = np.array(frame.intrinsics.distortion) if frame.intrinsics.distortion else None
    solved, turn, place = cv2.solvePnP(points, corners, frame.intrinsics.matrix, lens)
    if not solved:
        return None
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], place.ravel()
    return pose


def calibrate_hand_eye(
    flanges: Sequence[Matrix] | Matrix,
    boards: Sequence[Matrix] | Matrix,
    *,
    mounted: Literal["flange", "beside"] = "flange",
    limits: tuple[float, float] = (0.005, 0.02),
) -> HandEye:
    """Compute the pose of a camera from views of one board.

    Take ten or more views that are rotated by at least 0.3 rad about different axes.

    Args:
        flanges: for each view, the flange in the base, such as `arm.fkine(q)`. Shape (n, 4, 4).
        boards: for each view, the board in the camera, from `find_board`. Shape (n, 4, 4).
        mounted: "flange": the camera is on the flange and the board stands still; "beside": the
            camera stands beside the arm and the board is on the flange.
        limits: maximum deviation of the board in a view [m, rad].

    Returns:
        The pose of the camera, and how well the views agree on it.

    Raises:
        ParameterError: an argument has a wrong shape or value, or there are fewer than four views.
        CalibrationError: the views are rotated too little, or disagree by more than the limits.
    """
    hands, seen = np.asarray(flanges, dtype=float), np.asarray(boards, dtype=float)
    if hands.ndim != 3 or hands.shape[1:] != (4, 4) or len(hands) < _MIN_VIEWS:
        raise ParameterError("flanges", hands.shape, f"of shape (n, 4, 4), n from {_MIN_VIEWS}")
    if seen.shape != hands.shape or not (np.isfinite(seen).all() and np.isfinite(hands).all()):
        raise ParameterError("boards", seen.shape, f"finite, of shape {hands.shape}")
    if mounted not in ("flange", "beside"):
        raise ParameterError("mounted", mounted, '"flange" or "beside"')
    turns = np.array([rotvec_from_matrix(hands[0, :3, :3].T @ one[:3, :3]) for one in hands])
    if np.linalg.svd(turns, compute_uv=False)[1] < _MIN_ROTATION:
        raise CalibrationError(
            "the views are turned about no more than one axis: turn the flange about two"
        )
    moved = hands if mounted == "flange" else np.linalg.inv(hands)
    turn, place = cv2.calibrateHandEye(
        list(moved[:, :3, :3]), list(moved[:, :3, 3]), list(seen[:, :3, :3]), list(seen[:, :3, 3]),
        method=cv2.CALIB_HAND_EYE_PARK,
    )  # fmt: skip
    camera = np.eye(4)
    camera[:3, :3], camera[:3, 3] = turn, np.ravel(place)
    return _checked(camera, moved @ camera @ seen, limits)


def _checked(camera: Matrix, places: Matrix, limits: tuple[float, float]) -> HandEye:
    """Check how well the places of the board agree."""
    board = np.eye(4)
    u, _, vt = np.linalg.svd(places[:, :3, :3].sum(axis=0))
    board[:3, :3] = u @ np.diag((1.0, 1.0, np.linalg.det(u @ vt))) @ vt
    board[:3, 3] = places[:, :3, 3].mean(axis=0)
    distances = np.linalg.norm(places[:, :3, 3] - board[:3, 3], axis=1)
    angles = np.array(
        [np.linalg.norm(rotvec_from_matrix(board[:3, :3].T @ one[:3, :3])) for one in places]
    )
    if not (distances.max() <= limits[0] and angles.max() <= limits[1]):
        worst = int(np.argmax(distances / limits[0] + angles / limits[1]))
        raise CalibrationError(
            f"the views disagree on where the board is: in view {worst} it is "
            f"{distances[worst]:.4f} m and {angles[worst]:.4f} rad off, at most "
            f"{limits[0]:g} m and {limits[1]:g} rad are allowed. Leave views out that are blurred, "
            "and check the size of the squares, the intrinsics and which joints go with which view"
        )
    return HandEye(camera, board, tuple(distances.tolist()), tuple(angles.tolist()))
