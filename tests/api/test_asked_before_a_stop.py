"""What was asked for before a stop is not sent after it, whatever had to be read first."""

from __future__ import annotations

from typing import TYPE_CHECKING

import anyio
import pytest
from client.bench import HOME

import aioduco
from aioduco import Joints, RealtimeMode, RealtimePoint
from aioduco.envelope import Envelope, Zone
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from api.desk import Desk


async def into_realtime(robot: aioduco.Robot) -> None:
    await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_POSITION)


async def into_track(robot: aioduco.Robot) -> None:
    await robot.track.trackEnqueue([Joints(*HOME)])
    await robot.track.trackJointMotion(1.0, 2.0).start()


FED: dict[
    str,
    tuple[Callable[[aioduco.Robot], Awaitable[None]], Callable[[aioduco.Robot], Awaitable[object]]],
] = {
    "realtime_data_enqueue": (
        into_realtime,
        lambda robot: robot.realtime.realtime_data_enqueue([RealtimePoint.joint_position(HOME)]),
    ),
    "trackEnqueue": (into_track, lambda robot: robot.track.trackEnqueue([Joints(*HOME)])),
}


@pytest.mark.parametrize("name", FED)
async def test_points_whose_check_reads_while_the_arm_is_stopped_are_not_sent(
    desk: Desk, name: str
) -> None:
    begin, feed = FED[name]
    desk.motion_time = 30.0
    desk.moves("trackJointMotion")
    for each in ("trackEnqueue", "trackClearQueue", "start_realtime_mode", "end_realtime_mode"):
        desk.answer(each, 4)
    desk.answer("realtime_data_enqueue", 4)
    desk.answer("get_wobj", [0.0] * 6)
    desk.answer("get_flange_pose", [0.5, 0.1, 0.6, 3.1, 0.0, -1.5])
    async with aioduco.connect(desk.host, desk.port) as robot:
        await begin(robot)
        before = len(desk.received(name))
        read = desk.hold("get_tcp_offset", [0.0] * 6)
        robot.envelope = Envelope("gcr5_910", Zone.plane((0, 0, -5.0), (0, 0, 1)))
        raised: list[BaseException] = []

        async def fed() -> None:
            try:
                await feed(robot)
            except aioduco.DucoError as exc:
                raised.append(exc)

        async with anyio.create_task_group() as group:
            group.start_soon(fed)
            await eventually_async(lambda: desk.received("get_tcp_offset"))
            await robot.stop()
            read.set()
        assert isinstance(raised[0], aioduco.TaskStopped)
        assert len(desk.received(name)) == before
