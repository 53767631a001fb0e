"""Paint rows: arcs that keep the tool at the tangent (mode 2), with the gun opened on the way."""

from __future__ import annotations

from typing import Any

GUN = 3
ROWS = 3


def main(cobot_class: Any, op_class: Any, ip: str, port: int) -> tuple[list[int], list[bool]]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    x, y, z, *turn = robot.get_tcp_pose()
    nothing = op_class()
    # As the vendor's demo fills it: kinds of triggers that no manual names, and no output.
    nothing.time_or_dist_1 = nothing.time_or_dist_2 = 3
    states, levels = [], []
    for row in range(ROWS):
        height = z - 0.02 * row
        left = [x, y, height, *turn]
        middle = [x + 0.03, y + 0.05, height, *turn]
        right = [x, y + 0.1, height, *turn]
        states.append(robot.movel(left, 0.3, 1.0, 0, None, "", "", True, nothing))
        robot.set_standard_digital_out(GUN, True, True)
        levels.append(robot.get_standard_digital_out(GUN))
        states.append(robot.movec(middle, right, 0.2, 0.5, 0, 2, None, "", "", True, nothing))
        robot.set_standard_digital_out(GUN, False, True)
        levels.append(robot.get_standard_digital_out(GUN))
    robot.close()
    return states, levels
