"""A hardware interface at 250 Hz: each cycle two reads, positions and speeds, and one set-point."""

from __future__ import annotations

import math
import time
from typing import Any

PERIOD = 0.004
CYCLES = 125
SWING = 0.1


class Hardware:
    """Read and write, as a controller manager calls them."""

    def __init__(self, cobot_class: Any, ip: str, port: int) -> None:
        self.robot = cobot_class(ip, port)
        self.robot.open()
        self.robot.power_on(True)
        self.robot.enable(True)
        self.commands: list[float] = []
        self.read()
        self.commands = list(self.positions)

    def read(self) -> None:
        self.positions = self.robot.get_actual_joints_position()
        self.velocities = self.robot.get_actual_joints_speed()

    def write(self) -> int:
        return int(self.robot.servoj(self.commands, 3.5, 3.5, False, 400, 80, 5, 2))


def main(cobot_class: Any, ip: str, port: int) -> tuple[list[int], float, float, float]:
    hardware = Hardware(cobot_class, ip, port)
    start = list(hardware.positions)
    answers, fastest = [], 0.0
    begin = time.perf_counter()
    for cycle in range(1, CYCLES + 1):
        hardware.read()
        fastest = max(fastest, abs(hardware.velocities[0]))
        hardware.commands[0] = start[0] + SWING * (1 - math.cos(math.pi * cycle / CYCLES))
        answers.append(hardware.write())
        time.sleep(max(0.0, begin + cycle * PERIOD - time.perf_counter()))
    while hardware.robot.robotmoving():
        time.sleep(0.02)
    hardware.read()
    hardware.robot.close()
    return answers, hardware.commands[0], hardware.positions[0], fastest
