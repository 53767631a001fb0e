"""A joint follows a sine by servoj, 250 times a second, with gains of a published driver."""

from __future__ import annotations

import math
import time
from typing import Any

PERIOD = 0.004
POINTS = 250
SWING = 0.15


def main(cobot_class: Any, ip: str, port: int) -> tuple[list[int], list[float], list[float]]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    start = robot.get_actual_joints_position()
    answers = []
    begin = time.perf_counter()
    goal = list(start)
    for number in range(1, POINTS + 1):
        goal[0] = start[0] + SWING * (1 - math.cos(math.pi * number / POINTS))
        answers.append(robot.servoj(goal, 3.5, 3.5, False, 400, 80, 5, 2))
        time.sleep(max(0.0, begin + number * PERIOD - time.perf_counter()))
    while robot.robotmoving():
        time.sleep(0.02)
    reached = robot.get_actual_joints_position()
    robot.close()
    return answers, goal, reached
