"""The manual's example of realtime control (1.3.15), by `aioduco.sync`."""

from __future__ import annotations

from cabinet import JOINTS_VEL, run

import aioduco.sync
from aioduco import RealtimeMode, RealtimePoint


def follow_velocities(robot: aioduco.sync.Robot) -> list[float]:
    """1.3.15-1: the table, then its last row again and again: a point for each millisecond."""
    before = robot.state.get_actual_joints_position()
    points = [RealtimePoint.joint_velocity(row) for row in JOINTS_VEL]
    robot.realtime.clear_realtime_data_queue()
    robot.realtime.realtime_data_enqueue(points + [points[-1]] * 290)
    robot.realtime.start_realtime_mode(RealtimeMode.JOINT_VELOCITY, com_lost_time=0.04)
    for _ in range(3):
        while robot.realtime.get_realtime_data_queue_size() > 200:
            robot.sleep(0.01)
        robot.realtime.realtime_data_enqueue([points[-1]] * 100)
    robot.realtime.end_realtime_mode()
    after = robot.state.get_actual_joints_position()
    return [b - a for a, b in zip(before, after, strict=True)]


def main(host: str, port: int) -> dict[str, object]:
    with aioduco.sync.connect(host, port) as robot:
        robot.bring_up()
        return {"1.3.15-1": follow_velocities(robot)}


if __name__ == "__main__":
    run(main)
