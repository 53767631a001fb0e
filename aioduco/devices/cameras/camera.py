"""Data of every camera: an image, its time, and the relation of pixels to directions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol, Self, runtime_checkable

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.numpy_on_use import number_array
from aioduco.models.rules import Integer, stored

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import TracebackType

    from numpy.typing import NDArray


_COEFFICIENTS = (0, 4, 5, 8, 12, 14)  # numbers of coefficients that OpenCV's lens models have


@dataclass(frozen=True, slots=True, kw_only=True)
class Intrinsics:
    """Mapping of points in front of a camera to pixels.

    The camera's frame is that of OpenCV: z along the viewing direction, x to the right, y down. The
    origin of pixel coordinates is the centre of the upper left pixel.

    Attributes:
        width, height: size of images [pixels].
        fx, fy: focal lengths [pixels].
        cx, cy: position of the optical axis in the image [pixels].
        distortion: OpenCV's coefficients k1, k2, p1, p2, ..., as `cv2.calibrateCamera` gives them:
            4, 5, 8, 12 or 14 numbers; empty for a lens without distortion.

    Raises:
        ParameterError: a value is not a finite number, or out of range.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: Sequence[float] | NDArray[np.float64] = ()

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            size = Integer(1, 1 << 16, "pixels", source="this package")
            object.__setattr__(self, name, size(name, getattr(self, name)))
        stored(self, fx=ranges.ABOVE, fy=ranges.ABOVE, cx=ranges.FINITE, cy=ranges.FINITE)
        # OpenCV gives an array of one row.
        given = () if self.distortion is None else self.distortion
        found = tuple(number_array("distortion", given, "a list of numbers").ravel().tolist())
        if len(found) not in _COEFFICIENTS:
            raise ParameterError("distortion", found, "0, 4, 5, 8, 12 or 14 numbers")
        object.__setattr__(self, "distortion", found)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix. Shape (3, 3)."""
        return np.array(((self.fx, 0.0, self.cx), (0.0, self.fy, self.cy), (0.0, 0.0, 1.0)))

    def project(self, points: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the pixels of points, ignoring the distortion of the lens.

        Args:
            points: points in front of the camera, in its frame [m]. Shape (..., 3).

        Returns:
            Columns and rows. Shape (..., 2).
        """
        x, y, z = np.moveaxis(np.asarray(points, dtype=np.float64), -1, 0)
        return np.stack([self.fx * x / z + self.cx, self.fy * y / z + self.cy], axis=-1)

    def point(self, column: float, row: float, depth: float) -> NDArray[np.float64]:
        """Return the point at a pixel, ignoring the distortion of the lens.

        Args:
            column, row: the pixel.
            depth: distance along the camera's axis, as in `CameraFrame.depth` [m].

        Returns:
            The point in the camera's frame [m]. Shape (3,).
        """
        x, y = (column - self.cx) / self.fx, (row - self.cy) / self.fy
        return depth * np.array((x, y, 1.0))


class CameraFrame(NamedTuple):
    """One image of a camera.

    Attributes:
        image: colours red, green, blue. Shape (height, width, 3), uint8.
        depth: distances along the camera's axis [m], shape (height, width); None if not measured.
        time: time at which the image was taken, on the robot's clock [s].
        intrinsics: intrinsics of the camera.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32] | None
    time: float
    intrinsics: Intrinsics


@runtime_checkable
class CameraDevice(Protocol):
    """A camera; `with` opens and closes it. Implement these methods for your own camera."""

    @property
    def intrinsics(self) -> Intrinsics:
        """Mapping of points to pixels."""
        ...

    def read(self) -> CameraFrame:
        """Take an image and block until it is available.

        In an async program: `await anyio.to_thread.run_sync(camera.read)`.

        Raises:
            CameraError: the camera returns no image.
        """
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
        /,
    ) -> None: ...
