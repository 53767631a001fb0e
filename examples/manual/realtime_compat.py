"""The manual's example of realtime control (1.3.15), by the vendor's class."""

from __future__ import annotations

import time

from cabinet import JOINTS_VEL, run

from aioduco.compat import DucoCobot, RealTimeData


def follow_velocities(robot: DucoCobot) -> list[float]:
    """1.3.15-1: the table, then its last row again and again: a point for each millisecond."""
    before = robot.get_actual_joints_position()
    points = [RealTimeData(joint_vel_cmd=row, status=True) for row in JOINTS_VEL]
    robot.clear_realtime_data_queue()
    robot.realtime_data_enqueue(points + [points[-1]] * 290, True)
    robot.start_realtime_mode(1, 100, 0.04)
    for _ in range(3):
        while robot.get_realtime_data_queue_size() > 200:
            time.sleep(0.01)
        robot.realtime_data_enqueue([points[-1]] * 100, True)
    robot.end_realtime_mode()
    after = robot.get_actual_joints_position()
    return [b - a for a, b in zip(before, after, strict=True)]


def main(host: str, port: int) -> dict[str, object]:
    with DucoCobot(host, port) as robot:
        robot.power_on(True)
        robot.enable(True)
        return {"1.3.15-1": follow_velocities(robot)}


if __name__ == "__main__":
    run(main)
