"""Stored motions: recordings that an arm replays, and taught waypoints.

    path = RecordedPath.of(aioduco.recording.read("run.mcap"))
    await play(robot, path)

    await run_waypoints(robot, WaypointFile.read("cell.toml"))

`recorded_path` makes a path from a recording, with the times of `sample_times`; `path_check` checks
it, `waypoints` is the file of waypoints, `envelope_file` the file of limits: all without a robot.
`player` moves a robot with them, through its public interface alone. Blocking programs use
`aioduco.sync.play` and `aioduco.sync.run_waypoints`.
"""

from __future__ import annotations

from aioduco.recording.playback.envelope_file import read_envelope
from aioduco.recording.playback.path_check import PathFinding, check_path
from aioduco.recording.playback.player import check_path_on, check_waypoints_on, play, run_waypoints
from aioduco.recording.playback.recorded_path import RecordedOutput, RecordedPath
from aioduco.recording.playback.sample_times import RecordedGap
from aioduco.recording.playback.waypoints import Waypoint, WaypointFile

__all__ = [
    "PathFinding",
    "RecordedGap",
    "RecordedOutput",
    "RecordedPath",
    "Waypoint",
    "WaypointFile",
    "check_path",
    "check_path_on",
    "check_waypoints_on",
    "play",
    "read_envelope",
    "run_waypoints",
]
