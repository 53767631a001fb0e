"""A wafer cell: at each station the status port, the calls and the arm's own kinematics agree."""

from __future__ import annotations

import math
import socket
import struct
from typing import Any, NamedTuple

FRAME = 1468
CUP = 1
#: joints of the stations [rad]; the aligner turns the wafer far to one side
STATIONS = {
    "cassette": [0.6, 0.1, 1.5, 0.0, -1.57, 0.4],
    "aligner": [0.0, 0.0, 1.57, 0.0, -1.57, -4.3],
    "chuck": [-0.5, -0.1, 1.6, 0.1, -1.57, 0.0],
}


class Seen(NamedTuple):
    """A station: how far the three sources are from each other [rad, m]."""

    joints: float
    tip_by_frame: float
    tip_by_kinematics: float
    cup: bool


def frame_of(ip: str, port: int) -> tuple[list[float], list[float]]:
    """Joints and tip by one whole frame of a new connection."""
    data = b""
    with socket.create_connection((ip, port), timeout=60) as sock:
        while len(data) < FRAME:
            data += sock.recv(FRAME - len(data))
    return list(struct.unpack_from("<6f", data, 0)), list(struct.unpack_from("<3f", data, 368))


def tip_of(rows: list[list[float]], joints: list[float]) -> list[float]:
    """The flange by Denavit and Hartenberg, in plain lists as such programs have it."""
    total = [[float(row == column) for column in range(4)] for row in range(4)]
    for (a, alpha, d, theta), q in zip(rows, joints, strict=True):
        c, s, ca, sa = (
            *(math.cos(q + theta), math.sin(q + theta)),
            *(math.cos(alpha), math.sin(alpha)),
        )
        link = [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0.0, sa, ca, d],
            [0.0, 0.0, 0.0, 1.0],
        ]
        columns = list(zip(*link, strict=True))
        total = [
            [sum(x * y for x, y in zip(row, column, strict=True)) for column in columns]
            for row in total
        ]
    return [row[3] for row in total[:3]]


def apart(a: list[float], b: list[float]) -> float:
    return max(abs(x - y) for x, y in zip(a, b, strict=False))


def main(cobot_class: Any, ip: str, port: int, status_port: int) -> dict[str, Seen]:
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    rows = robot.get_origin_DH()
    seen = {}
    for number, (name, joints) in enumerate(STATIONS.items()):
        if robot.movej2(joints, 2.0, 4.0, 0.0, True) != 4:
            raise RuntimeError(f"{name}: {robot.get_last_error()}")
        robot.set_tool_digital_out(CUP, number < 2, True)
        now, tip = robot.get_actual_joints_position(), robot.get_tcp_pose()
        by_frame, tip_by_frame = frame_of(ip, status_port)
        seen[name] = Seen(
            apart(now, by_frame),
            apart(tip[:3], tip_by_frame),
            apart(tip[:3], tip_of(rows, now)),
            robot.get_tool_digital_out(CUP),
        )
    robot.close()
    return seen
