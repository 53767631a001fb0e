"""Cameras: images with times on the robot's clock, and the pose of a camera on the arm.

Simulated cameras (`SimulatedCamera`) and real ones (`OpenCvCamera`) have the same protocol,
`CameraDevice`. `calibrate_hand_eye` computes the pose of a camera from views of a board, and
`find_board` detects the board in an image. `OpenCvCamera` and `find_board` need the extra `camera`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aioduco.devices.cameras.board import BoardSize, find_board
    from aioduco.devices.cameras.camera import CameraDevice, CameraFrame, Intrinsics
    from aioduco.devices.cameras.hand_eye import HandEye, calibrate_hand_eye
    from aioduco.devices.cameras.opencv import OpenCvCamera
    from aioduco.devices.cameras.simulated import SimulatedCamera

__all__ = [
    "BoardSize",
    "CameraDevice",
    "CameraFrame",
    "HandEye",
    "Intrinsics",
    "OpenCvCamera",
    "SimulatedCamera",
    "calibrate_hand_eye",
    "find_board",
]

_MODULES = {
    **dict.fromkeys(("CameraDevice", "CameraFrame", "Intrinsics"), "camera"),
    **dict.fromkeys(("BoardSize", "find_board"), "board"),
    **dict.fromkeys(("HandEye", "calibrate_hand_eye"), "hand_eye"),
    "OpenCvCamera": "opencv",
    "SimulatedCamera": "simulated",
}


def __getattr__(name: str) -> Any:
    """Import a module that needs OpenCV or MuJoCo only when one of its names is used."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_MODULES[name]}"), name)
