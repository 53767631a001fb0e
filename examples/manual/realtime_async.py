"""The manual's example of realtime control (1.3.15), by `aioduco`."""

from __future__ import annotations

import anyio
from cabinet import JOINTS_VEL, run

import aioduco
from aioduco import RealtimeMode, RealtimePoint


async def follow_velocities(robot: aioduco.Robot) -> list[float]:
    """1.3.15-1: the table, then its last row again and again: a point for each millisecond."""
    before = await robot.state.get_actual_joints_position()
    points = [RealtimePoint.joint_velocity(row) for row in JOINTS_VEL]
    await robot.realtime.clear_realtime_data_queue()
    await robot.realtime.realtime_data_enqueue(points + [points[-1]] * 290)
    await robot.realtime.start_realtime_mode(RealtimeMode.JOINT_VELOCITY, com_lost_time=0.04)
    for _ in range(3):
        while await robot.realtime.get_realtime_data_queue_size() > 200:  # noqa: ASYNC110 - ask
            await anyio.sleep(0.01)
        await robot.realtime.realtime_data_enqueue([points[-1]] * 100)
    await robot.realtime.end_realtime_mode()
    after = await robot.state.get_actual_joints_position()
    return [b - a for a, b in zip(before, after, strict=True)]


async def main(host: str, port: int) -> dict[str, object]:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        return {"1.3.15-1": await follow_velocities(robot)}


if __name__ == "__main__":
    run(lambda host, port: anyio.run(main, host, port))
