"""What every camera gives: a picture, its time, and how pixels and directions belong together."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol, Self, runtime_checkable

import numpy as np

from aioduco.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType

    from numpy.typing import NDArray

__all__ = ["CameraDevice", "CameraFrame", "Intrinsics"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Intrinsics:
    """How a camera maps what is in front of it to pixels.

    The camera's frame is the one of OpenCV: z along its view, x to the right, y down. Pixels count
    from the middle of the upper left one.

    Attributes:
        width, height: of pictures [pixels].
        fx, fy: focal lengths [pixels].
        cx, cy: where the axis is [pixels].
        distortion: coefficients as OpenCV has them, k1, k2, p1, p2, ...; none for a lens without.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("width", "height", "fx", "fy"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ParameterError(name, value, "above 0")

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix. Shape (3, 3)."""
        return np.array(((self.fx, 0.0, self.cx), (0.0, self.fy, self.cy), (0.0, 0.0, 1.0)))

    def project(self, points: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
        """Give the pixels of points, without the lens's distortion.

        Args:
            points: in the camera's frame, in front of it [m]. Shape (..., 3).

        Returns:
            Columns and rows. Shape (..., 2).
        """
        x, y, z = np.moveaxis(np.asarray(points, dtype=np.float64), -1, 0)
        return np.stack([self.fx * x / z + self.cx, self.fy * y / z + self.cy], axis=-1)

    def point(self, column: float, row: float, depth: float) -> NDArray[np.float64]:
        """Give the point at a pixel, without the lens's distortion.

        Args:
            column, row: the pixel.
            depth: along the camera's axis, as in `CameraFrame.depth` [m].

        Returns:
            In the camera's frame [m]. Shape (3,).
        """
        x, y = (column - self.cx) / self.fx, (row - self.cy) / self.fy
        return depth * np.array((x, y, 1.0))


class CameraFrame(NamedTuple):
    """One picture.

    Attributes:
        image: red, green, blue. Shape (height, width, 3), uint8.
        depth: distances along the camera's axis [m], shape (height, width); None without them.
        time: when it was taken, on the robot's clock [s].
        intrinsics: of the camera.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32] | None
    time: float
    intrinsics: Intrinsics


@runtime_checkable
class CameraDevice(Protocol):
    """A camera; `with` opens it and closes it. For a camera of your own, write these."""

    @property
    def intrinsics(self) -> Intrinsics:
        """How it maps what it sees to pixels."""
        ...

    def read(self) -> CameraFrame:
        """Take a picture, and return when it is there.

        In a program that awaits: `await anyio.to_thread.run_sync(camera.read)`.

        Raises:
            CameraError: there is none.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...
