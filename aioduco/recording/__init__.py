"""Recordings of a robot: MCAP files that are written, read, drawn and replayed; live publication.

    async with aioduco.connect("192.168.1.10", record="run.mcap") as robot:
        ...

    run = aioduco.recording.read("run.mcap")
    run.arrays("/joint_states")["position"]  # shape (n, 6) [rad]

`recorder` collects the robot's data, `channels` encodes it as messages, and `writer` writes them to
the file, on a thread; `publication` sends the same messages to watchers. These modules build on the
feed, the events and the streams, and `robot` starts them.
The modules that read, `run` and `container`, use no robot. The package needs the extra `record`,
which is loaded at its first use.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aioduco.recording.recorder import (
        Publication,
        PublicationStatistics,
        Recording,
        RecordingStatistics,
    )
    from aioduco.recording.run import RecordedMessage, RecordedRun, read

__all__ = [
    "Publication",
    "PublicationStatistics",
    "RecordedMessage",
    "RecordedRun",
    "Recording",
    "RecordingStatistics",
    "read",
]

_HOMES = {
    "recorder": ("Publication", "PublicationStatistics", "Recording", "RecordingStatistics"),
    "run": ("RecordedMessage", "RecordedRun", "read"),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Load a name on first use: a process that uses a part of this package loads that alone."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
