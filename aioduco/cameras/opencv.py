"""Real cameras, by OpenCV: of the computer, of the network, or a file of pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import cv2
import numpy as np

from aioduco.cameras.camera import CameraFrame
from aioduco.controller_clock import WallClock
from aioduco.errors import CameraError

if TYPE_CHECKING:
    from types import TracebackType
    from typing import Self

    from aioduco.cameras.camera import Intrinsics
    from aioduco.controller_clock import Clock

__all__ = ["OpenCvCamera"]


class OpenCvCamera:
    """A camera that OpenCV opens.

        with OpenCvCamera(0, intrinsics, clock=WallClock()) as camera:
            frame = camera.read()

    Args:
        source: number of a camera of this computer, address of one in the network, or a file.
        intrinsics: of the camera, from a calibration; pictures have its size.
        clock: the robot's, as given to `connect`; None for the time of this computer, which is
            that of every real controller.
        latency: by how much a picture is older than the moment at which it arrives [s].
    """

    def __init__(
        self,
        source: int | str,
        intrinsics: Intrinsics,
        *,
        clock: Clock | None = None,
        latency: float = 0.0,
    ) -> None:
        self._source, self._intrinsics = source, intrinsics
        self._clock = WallClock() if clock is None else clock
        self._latency = latency
        self._capture: cv2.VideoCapture | None = None

    def __repr__(self) -> str:
        return f"<OpenCvCamera {self._source!r}>"

    @property
    def intrinsics(self) -> Intrinsics:
        """How it maps what it sees to pixels."""
        return self._intrinsics

    def __enter__(self) -> Self:
        """Open it.

        Raises:
            CameraError: there is no such camera, or it has no pictures of this size.
        """
        capture = cv2.VideoCapture(self._source)
        if not capture.isOpened():
            raise CameraError(f"there is no camera at {self._source!r}, or another program has it")
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, self._intrinsics.width)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, self._intrinsics.height)
        # A queue of pictures would make each of them old.
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        self._capture = capture
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        capture, self._capture = self._capture, None
        if capture is not None:
            capture.release()

    def read(self) -> CameraFrame:
        """Take the next picture.

        Raises:
            CameraError: it is not open, gives none any more, or one of another size.
        """
        capture = self._capture
        if capture is None:
            raise CameraError(f"{self!r} is not open: enter it by `with`")
        grabbed = capture.grab()
        time = self._clock.now() - self._latency
        there, picture = capture.retrieve() if grabbed else (False, None)
        if not there or picture is None:
            raise CameraError(f"the camera at {self._source!r} gives no picture")
        size = self._intrinsics
        if picture.shape != (size.height, size.width, 3):
            raise CameraError(
                f"the camera at {self._source!r} gives pictures of shape {picture.shape}, but its "
                f"intrinsics are for {(size.height, size.width, 3)}"
            )
        image = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)
        return CameraFrame(image, None, time, size)
