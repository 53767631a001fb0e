"""Real cameras, by OpenCV: at this computer, in the network, or a file of images."""

from __future__ import annotations

import threading
from typing import Self

import numpy as np

from aioduco._process.copying import Uncopied
from aioduco.devices.cameras.camera import CameraFrame, Intrinsics
from aioduco.errors import CameraError, MissingExtra

with MissingExtra.named("OpenCvCamera", "camera"):
    import cv2
from aioduco.models.controller_clock import Clock, WallClock
from aioduco.models.ranges import WAIT


class OpenCvCamera(Uncopied):
    """A camera that OpenCV opens.

        with OpenCvCamera(0, intrinsics, clock=WallClock()) as camera:
            frame = camera.read()

    Args:
        source: number of a camera of this computer, address of one in the network, or a file.
        intrinsics: intrinsics of the camera, from a calibration; they contain the image size.
        clock: the robot's clock, as given to `connect`; None for the clock of this computer, which
            is used with every real controller.
        latency: time between taking an image and its arrival, from 0 [s].

    Raises:
        ParameterError: `latency` is out of range.
    """

    def __init__(
        self,
        source: int | str,
        intrinsics: Intrinsics,
        *,
        clock: Clock | None = None,
        latency: float = 0.0,
    ) -> None:
        latency = WAIT("latency", latency)
        self._source, self._intrinsics = source, intrinsics
        self._clock = WallClock() if clock is None else clock
        self._latency = latency
        self._capture: cv2.VideoCapture | None = None
        #: OpenCV's capture is for one thread: two that use it at once crash the interpreter
        self._lock = threading.Lock()

    def __repr__(self) -> str:
        return f"<OpenCvCamera {self._source!r}>"

    @property
    def intrinsics(self) -> Intrinsics:
        """Mapping of points to pixels."""
        return self._intrinsics

    def __enter__(self) -> Self:
        """Open the camera.

        Raises:
            CameraError: there is no such camera, another program uses it, or it is open already.
        """
        if self._capture is not None:
            raise CameraError(f"{self!r} is open already: nothing was changed")
        capture = cv2.VideoCapture(self._source)
        if not capture.isOpened():
            raise CameraError(f"there is no camera at {self._source!r}, or another program has it")
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, self._intrinsics.width)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, self._intrinsics.height)
        # With a longer queue, each image would be older when it is read.
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        self._capture = capture
        return self

    def __exit__(self, *_: object) -> None:
        """Close the camera, once a thread that reads has its image."""
        with self._lock:
            capture, self._capture = self._capture, None
            if capture is not None:
                capture.release()

    def read(self) -> CameraFrame:
        """Take the next image; several threads that read get one after another.

        Raises:
            CameraError: the camera is not open, or returns no image or one of another size.
        """
        with self._lock:
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
