"""The robot for scripts and notebooks: the same functions, each of which blocks until it is done.

    import aioduco.sync
    from aioduco import Joints

    with aioduco.sync.connect("192.168.1.10") as robot:
        robot.bring_up()
        robot.motion.movej2(Joints.deg(30, -15, 105, 0, -90, 0), v=1.0, a=1.0)

The supervision is the same as in `aioduco`; it runs in an event loop on a thread of its own.
"""

from __future__ import annotations

from aioduco.sync._cell import connect_cell
from aioduco.sync._feeds import Subscription
from aioduco.sync._generated import (
    Robot,
    check_path_on,
    check_waypoints_on,
    connect,
    play,
    run_waypoints,
    teleoperate,
)
from aioduco.sync._generated_objects import Events, Feed
from aioduco.sync._gripper import Gripper
from aioduco.sync._stop_all import stop_all
from aioduco.sync._streams import OffsetStream, Stream, TrackStream
from aioduco.sync._tasks import MotionCommand, MotionFunction, MotionPath, Task

__all__ = [
    "Events",
    "Feed",
    "Gripper",
    "MotionCommand",
    "MotionFunction",
    "MotionPath",
    "OffsetStream",
    "Robot",
    "Stream",
    "Subscription",
    "Task",
    "TrackStream",
    "check_path_on",
    "check_waypoints_on",
    "connect",
    "connect_cell",
    "play",
    "run_waypoints",
    "stop_all",
    "teleoperate",
]
