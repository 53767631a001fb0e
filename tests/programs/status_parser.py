"""Read the status port: frames of 1468 bytes that come by themselves, taken apart by offsets."""

from __future__ import annotations

import socket
import struct
from typing import Any

FRAME = 1468
OFFSETS = {"joints": (0, "<7f"), "tcp": (368, "<6f"), "state": (1449, "<B"), "error": (1456, "<I")}


def parse(frame: bytes) -> dict[str, Any]:
    return {name: struct.unpack_from(form, frame, at) for name, (at, form) in OFFSETS.items()}


def frames(ip: str, port: int) -> Any:
    """Each frame, whole: what comes may be a part of one, or more than one."""
    waiting = b""
    with socket.create_connection((ip, port), timeout=60) as sock:
        while True:
            received = sock.recv(4096)
            if not received:
                return
            waiting += received
            while len(waiting) >= FRAME:
                yield parse(waiting[:FRAME])
                waiting = waiting[FRAME:]


def main(cobot_class: Any, ip: str, port: int, status_port: int) -> dict[str, Any]:
    """Move a joint without waiting, and follow it by the frames until it has arrived."""
    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    robot.movej2([0.3, 0.0, 1.57, 0.0, -1.57, 0.0], 0.5, 1.0, 0.0, False)
    seen: list[dict[str, Any]] = []
    for frame in frames(ip, status_port):
        seen.append(frame)
        if abs(frame["joints"][0] - 0.3) < 1e-3:
            break
    last = seen[-1] | {"pose": robot.get_tcp_pose(), "frames": len(seen)}
    robot.close()
    return last
