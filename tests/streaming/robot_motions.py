"""One short stream of each kind on a robot, and where it leads to."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import aioduco
from aioduco.models.pose import Joints
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.stream import Stream

#: where every test begins; far from every singularity [rad]
START = Joints(0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)
WAY = 0.03  # rad, m


def bump(start: Any, way: float, count: int) -> list[list[float]]:
    """Set-points along the first axis: from rest at the start to rest at the way's end."""
    first, *others = start
    return [
        [first + way * (1 - math.cos(math.pi * n / count)) / 2, *others] for n in range(count + 1)
    ]


async def ramp(robot: aioduco.Robot, stream: Stream, space: str) -> None:
    """Positions, a way of `WAY` along the first axis."""
    joints = space == "joints"
    start = await (
        robot.state.get_actual_joints_position() if joints else robot.state.get_tcp_pose()
    )
    await stream.play(bump(start, WAY, 200))


async def offsets(_robot: aioduco.Robot, stream: Stream, _space: str) -> None:
    for _ in range(30):
        await stream.send([WAY / 30, 0, 0, 0, 0, 0])


async def speeds(_robot: aioduco.Robot, stream: Stream, _space: str) -> None:
    async for tick in stream.ticks(100):
        await stream.send([0.1, 0, 0, 0, 0, 0])
        if tick.number == 30:
            return


class Kind(NamedTuple):
    """A kind of stream.

    Attributes:
        open: makes the stream.
        feed: feeds it to its end.
        space: the space in which the way is measured.
        calls: the function of the wire that carries its set-points.
    """

    open: Callable[[aioduco.Robot, WorkerOptions], Stream]
    feed: Callable[[aioduco.Robot, Stream, str], Any]
    space: str
    calls: str


#: a busy machine's clock is late; the simulated controller must not trip over that
PATIENT: dict[str, Any] = {"com_lost_time": 0.5, "depth": 100}

KINDS = {
    "servoj": Kind(lambda r, o: r.servo.joints(v=1.0, a=8.0, options=o), ramp, "joints", "servoj"),
    "servoj_pose": Kind(
        lambda r, o: r.servo.pose(v=1.0, a=8.0, options=o), ramp, "pose", "servoj_pose"
    ),
    "servol": Kind(lambda r, o: r.servo.linear(v=1.0, a=8.0, options=o), ramp, "pose", "servol"),
    "servo_tcp": Kind(
        lambda r, o: r.servo.tcp_offset(v=1.0, a=8.0, options=o), offsets, "pose", "servo_tcp"
    ),
    "speedj": Kind(lambda r, o: r.speed.joints(a=2.0, options=o), speeds, "joints", "speedj"),
    "speedl": Kind(lambda r, o: r.speed.linear(a=2.0, options=o), speeds, "pose", "speedl"),
    "joint_position": Kind(
        lambda r, o: r.realtime.stream("joint_position", v=1.0, a=8.0, **PATIENT, options=o),
        ramp,
        "joints",
        "realtime_data_enqueue",
    ),
    "joint_velocity": Kind(
        lambda r, o: r.realtime.stream(
            "joint_velocity", v=1.0, a=8.0, latest=True, **PATIENT, options=o
        ),
        speeds,
        "joints",
        "realtime_data_enqueue",
    ),
    "pose": Kind(
        lambda r, o: r.realtime.stream("pose", v=(0.3, 1.0), a=(3, 10), **PATIENT, options=o),
        ramp,
        "pose",
        "realtime_data_enqueue",
    ),
    "twist": Kind(
        lambda r, o: r.realtime.stream(
            "twist", v=(0.3, 1.0), a=(3, 10), latest=True, **PATIENT, options=o
        ),
        speeds,
        "pose",
        "realtime_data_enqueue",
    ),
    "track joints": Kind(
        lambda r, o: r.track.stream("joints", speed=0.5, acc=2.0, options=o),
        ramp,
        "joints",
        "trackEnqueue",
    ),
    "track pose": Kind(
        lambda r, o: r.track.stream("pose", speed=0.2, acc=1.0, options=o),
        ramp,
        "pose",
        "trackEnqueue",
    ),
}
