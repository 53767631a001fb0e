"""A thread beats once a second on a connection of its own, while the arm goes to and fro."""

from __future__ import annotations

import threading
import time
from typing import Any

HERE = [0.0, 0.0, 1.57, 0.0, -1.57, 0.0]
THERE = [0.6, 0.0, 1.57, 0.0, -1.57, 0.0]


def main(cobot_class: Any, ip: str, port: int) -> list[int]:
    running = True

    def beat() -> None:
        watch = cobot_class(ip, port)
        watch.open()
        while running:
            watch.rpc_heartbeat()
            time.sleep(1)  # as such programs beat
        watch.close()

    robot = cobot_class(ip, port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    states = [robot.movej2(goal, 0.6, 2.0, 0.0, True) for goal in (THERE, HERE)]
    running = False
    robot.close()
    thread.join()
    return states
