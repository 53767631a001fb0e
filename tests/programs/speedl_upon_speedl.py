"""A stick moves the tool: a speedl without an end each 50 ms, each upon the one before."""

from __future__ import annotations

import time
from typing import Any

PERIOD = 0.05


def main(
    cobot_class: Any, ip: str, port: int, stick: list[float]
) -> tuple[list[int], list[int], float]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    before = robot.get_tcp_pose()
    tasks = []
    begin = time.perf_counter()
    for number, share in enumerate(stick, 1):
        twist = [0.0, 0.0, -0.1 * share, 0.0, 0.0, 0.0]
        tasks.append(robot.speedl(twist, 0.5, -1, False))
        time.sleep(max(0.0, begin + number * PERIOD - time.perf_counter()))
    stopped = robot.speed_stop(True)
    states = [robot.get_noneblock_taskstate(task) for task in tasks]
    after = robot.get_tcp_pose()
    robot.close()
    return [stopped, *states], tasks, after[2] - before[2]
