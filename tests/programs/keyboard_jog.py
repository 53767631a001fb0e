"""Keys move the tool by small steps of servo_tcp, as an older client sends it: no smoothing."""

from __future__ import annotations

import time
from typing import Any

STEP = 0.002
KEYS = {"w": (0, STEP), "s": (0, -STEP), "a": (1, STEP), "d": (1, -STEP), "r": (2, -STEP)}


def main(cobot_class: Any, ip: str, port: int, keys: str) -> tuple[list[int], list[float]]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    before = robot.get_tcp_pose()
    answers = []
    for key in keys:
        axis, step = KEYS[key]
        offset = [0.0] * 6
        offset[axis] = step
        answers.append(robot.servo_tcp(offset, 0.5, 0.5, "", False, 200, 25))
        time.sleep(0.02)
    while robot.robotmoving():
        time.sleep(0.02)
    after = robot.get_tcp_pose()
    robot.close()
    return answers, [after[axis] - before[axis] for axis in range(3)]
