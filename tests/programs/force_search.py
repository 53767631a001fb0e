"""Search along one axis with force control: go on until the tool has come 5 cm far."""

from __future__ import annotations

import time
from typing import Any

ONLY_Z = [False, False, True, False, False, False]
LIFT = [0.0, 0.0, 10.0, 0.0, 0.0, 0.0]
DAMPING = [1000.0, 1000.0, 250.0, 57.0, 57.0, 57.0]
FASTEST = [0.05, 0.05, 0.05, 0.1, 0.1, 0.1]
NONE = [0.0] * 6


def main(cobot_class: Any, ip: str, port: int) -> tuple[int, float]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    before = robot.get_tcp_pose()
    robot.fc_config(ONLY_Z, LIFT, DAMPING, FASTEST, NONE, "", "", 0)
    robot.fc_start()
    robot.fc_wait_pos([0, 0, 0.05, 0, 0, 0], [0, 0, 0.005, 0, 0, 0], False, 0, 20000)
    robot.fc_wait_logic([1, 0, 2])
    search = robot.fc_move(False)
    state = 0
    while state < 3:
        time.sleep(0.05)  # as such programs wait
        state = robot.get_noneblock_taskstate(search)
    robot.fc_stop()
    after = robot.get_tcp_pose()
    robot.close()
    return state, after[2] - before[2]
