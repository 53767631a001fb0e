"""Lines with blend radii, each call blocking: the next is sent on Interrupt, and so they blend."""

from __future__ import annotations

import time
from typing import Any

FINISHED, INTERRUPT = 4, 5


def main(cobot_class: Any, ip: str, port: int) -> tuple[list[int], float]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    robot.set_blend_ahead(50, 1)
    x, y, z, *turn = robot.get_tcp_pose()
    corners = [(x, y + 0.1, z), (x, y + 0.1, z - 0.1), (x, y, z - 0.1)]
    states = []
    for corner in corners:
        states.append(robot.movel([*corner, *turn], 0.1, 0.5, 0.02, None, "", "", True))
        if states[-1] not in (FINISHED, INTERRUPT):
            break
    while robot.robotmoving():
        time.sleep(0.02)  # as such programs wait
    reached = robot.get_tcp_pose()
    robot.close()
    return states, max(abs(a - b) for a, b in zip(reached, corners[-1], strict=False))
