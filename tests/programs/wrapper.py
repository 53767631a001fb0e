"""A class of one's own around the vendor's, whose default speeds no arm can reach."""

from __future__ import annotations

from typing import Any


class Arm:
    """Short names, many defaults."""

    def __init__(self, cobot_class: Any, ip: str, port: int) -> None:
        self.robot = cobot_class(ip, port)
        self.robot.open()
        self.robot.power_on(True)
        self.robot.enable(True)

    def joints(self, goal: list[float], v: float = 30, a: float = 100, r: float = 0) -> int:
        return int(self.robot.movej2(goal, v, a, r, True))

    def line(self, goal: list[float], v: float = 100, a: float = 200, r: float = 0) -> int:
        return int(self.robot.movel(goal, v, a, r, None, "", "", True))

    def pose(self) -> list[float]:
        return list(self.robot.get_tcp_pose())


def main(cobot_class: Any, ip: str, port: int) -> tuple[list[int], float]:
    arm = Arm(cobot_class, ip, port)
    states = [arm.joints([0.5, 0.1, 1.4, 0.0, -1.5, 0.0])]
    goal = arm.pose()
    goal[2] += 0.05
    states.append(arm.line(goal))
    apart = max(abs(a - b) for a, b in zip(arm.pose()[:3], goal[:3], strict=True))
    arm.robot.close()
    return states, apart
