"""Recordings of a robot: written as MCAP files, read back, drawn and replayed; published live.

    async with aioduco.connect("192.168.1.10", record="run.mcap") as robot:
        ...

    run = aioduco.recording.read("run.mcap")
    run.arrays("/joint_states")["position"]  # shape (n, 6) [rad]

What records is in `recorder` (what of the robot), `channels` (as what messages) and `writer` (to
the file, on a thread); `publication` gives the same to watchers. It stands above the feed, the
events and the streams, and `robot` starts it.
What reads, `run` and `container`, knows no robot. Needs the extra `record`, which is loaded when it
is used.
"""

from __future__ import annotations

from aioduco.recording.publication import Publication, PublicationStatistics
from aioduco.recording.recorder import Recording, RecordingStatistics
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
