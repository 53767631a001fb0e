"""A hand at the tool's RS-485 port: Modbus frames by hand, signed bytes, old bytes drained."""

from __future__ import annotations

import struct
import time
from typing import Any

UNIT = 1
SETTLE = 0.15


def crc(data: bytes) -> bytes:
    value = 0xFFFF
    for octet in data:
        value ^= octet
        for _ in range(8):
            value = (value >> 1) ^ (0xA001 if value & 1 else 0)
    return struct.pack("<H", value)


class Hand:
    """Registers of the hand: 0x0100 initialise, 0x0101 force, 0x0103 position, 0x0104 speed."""

    def __init__(self, robot: Any) -> None:
        self.robot = robot

    def ask(self, body: bytes, length: int) -> bytes:
        """Drain, write, and read until the answer is whole."""
        self.robot.tool_read_raw_data_485(64)
        frame = body + crc(body)
        self.robot.tool_write_raw_data_485([one - 256 if one > 127 else one for one in frame])
        answer = b""
        for _ in range(20):
            answer += bytes(one & 0xFF for one in self.robot.tool_read_raw_data_485(length))
            if len(answer) >= length:
                break
            time.sleep(SETTLE)
        if crc(answer[:-2]) != answer[-2:]:
            raise RuntimeError(f"checksum: {answer.hex()}")
        return answer

    def write(self, register: int, value: int) -> None:
        self.ask(struct.pack(">BBHH", UNIT, 6, register, value), 8)

    def read(self, register: int) -> int:
        answer = self.ask(struct.pack(">BBHH", UNIT, 3, register, 1), 7)
        return int.from_bytes(answer[3:5], "big")


def main(cobot_class: Any, ip: str, port: int) -> tuple[list[int], list[int]]:
    robot = cobot_class(ip, port)
    robot.open()
    hand = Hand(robot)
    hand.write(0x0100, 0xA5)  # to both ends
    while hand.read(0x0200) != 1:
        time.sleep(0.05)
    hand.write(0x0101, 40)
    hand.write(0x0104, 50)
    reached = []
    for position in (0, 700):
        hand.write(0x0103, position)
        while hand.read(0x0201) == 0:
            time.sleep(0.05)
        reached.append(hand.read(0x0202))
    state = [hand.read(register) for register in (0x0200, 0x0201, 0x0205)]
    robot.close()
    return reached, state
