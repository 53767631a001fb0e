"""A chessboard in an image, by OpenCV."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.devices.cameras.camera import CameraFrame
from aioduco.errors import MissingExtra, ParameterError
from aioduco.models.rules import LONGEST_ARM, Number, is_whole, stored

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Matrix = NDArray[np.float64]


_SQUARE = Number(0.0, unit="m", open_low=True, plausible=LONGEST_ARM, source="this package")
_WIDEST = 5  # half of the window in which a corner's place is refined, at most [pixels]
_LEAST_CORNERS = 3  # inner corners along a side that OpenCV looks for, at least


@dataclass(frozen=True, slots=True)
class BoardSize:
    """Size of a chessboard, whose origin is its first inner corner.

    Attributes:
        columns, rows: numbers of inner corners, from 3; one must be even and the other odd, since
            the board otherwise looks the same from two sides.
        square: edge length of a square [m].

    Raises:
        ParameterError: a value is out of range.
    """

    columns: int
    rows: int
    square: float

    def __post_init__(self) -> None:
        for name in ("columns", "rows"):
            value = getattr(self, name)
            if not is_whole(value) or value < _LEAST_CORNERS:
                raise ParameterError(name, value, f"a whole number from {_LEAST_CORNERS}")
            object.__setattr__(self, name, int(value))
        if (self.columns + self.rows) % 2 == 0:
            raise ParameterError(
                "rows", self.rows, f"{'odd' if self.columns % 2 == 0 else 'even'}, as there are "
                f"{self.columns} columns: this board looks the same when it is turned round",
            )  # fmt: skip
        stored(self, square=_SQUARE)


def find_board(frame: CameraFrame, size: BoardSize) -> Matrix | None:
    """Find a chessboard in an image.

    Args:
        frame: the image, of the size of its intrinsics, in colours or grey.
        size: size of the board.

    Returns:
        The board's frame in the camera's, shape (4, 4); None if the board is not completely
        visible.

    Raises:
        MissingExtra: OpenCV is not installed.
        ParameterError: the image is of another size, shape or type.
    """
    with MissingExtra.named("finding a board", "camera"):
        import cv2  # noqa: PLC0415 - for this function alone

    if not isinstance(size, BoardSize):
        raise ParameterError("size", size, "a BoardSize")
    grey = _grey(frame, cv2)
    found, corners = cv2.findChessboardCorners(grey, (size.columns, size.rows))
    if not found:
        return None
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-3)
    # A wider window has a neighbour of the corner in it, and moves the corner there.
    grid = corners.reshape(size.rows, size.columns, 2)
    near = min(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1))
    half = max(1, min(_WIDEST, int(0.5 * near)))
    corners = cv2.cornerSubPix(grey, corners, (half, half), (-1, -1), criteria)
    points = np.zeros((size.columns * size.rows, 3))
    points[:, :2] = size.square * np.mgrid[: size.columns, : size.rows].T.reshape(-1, 2)
    lens = np.array(frame.intrinsics.distortion) if frame.intrinsics.distortion else None
    solved, turn, place = cv2.solvePnP(points, corners, frame.intrinsics.matrix, lens)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turn)[0], place.ravel()
    return pose if solved and np.isfinite(pose).all() else None


def _grey(frame: CameraFrame, cv2: Any) -> Any:
    """The image in shades of grey. Shape (height, width)."""
    if not isinstance(frame, CameraFrame):
        raise ParameterError("frame", type(frame).__name__, "a CameraFrame, which has the lens")
    image, lens = np.asarray(frame.image), frame.intrinsics
    size = (lens.height, lens.width)
    channels = image.shape[2] if image.ndim == 3 else 1
    if image.dtype != np.uint8 or image.shape[:2] != size or channels not in (1, 3, 4):
        raise ParameterError(
            "frame", f"an image of shape {image.shape} and type {image.dtype}",
            f"of shape {(*size, 3)} or {size}, as its intrinsics say, and type uint8",
        )  # fmt: skip
    if channels == 1:
        return np.ascontiguousarray(image.reshape(size))
    code = cv2.COLOR_RGB2GRAY if channels == 3 else cv2.COLOR_RGBA2GRAY
    return cv2.cvtColor(np.ascontiguousarray(image), code)
