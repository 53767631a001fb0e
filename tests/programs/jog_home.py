"""A held key moves the tool by speedl; let go, it stops without waiting, and the next is home."""

from __future__ import annotations

import time
from typing import Any

FAR = 0.03


def main(cobot_class: Any, ip: str, port: int) -> tuple[int, float]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    home = robot.get_tcp_pose()
    robot.speedl([0.0, 0.0, -0.1, 0.0, 0.0, 0.0], 0.5, -1, False)
    while abs(robot.get_tcp_pose()[2] - home[2]) < FAR:
        time.sleep(0.02)  # the key is held
    robot.speed_stop(False)
    state = robot.movel(home, 0.2, 0.5, 0.0, None, "", "", True)
    back = robot.get_tcp_pose()
    robot.close()
    return state, max(abs(a - b) for a, b in zip(back[:3], home[:3], strict=True))
