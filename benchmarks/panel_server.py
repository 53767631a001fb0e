"""A controller with trivial handlers for the panel: its arm never rests, and it keeps its stops.

It prints its port as a line of JSON, and ends when its standard input does. The times of stops are
those of the wall, which a browser on the same machine shares.
"""

from __future__ import annotations

import json
import math
import sys
import time
from typing import Any, cast

from aioduco._wire import rpc
from aioduco.sim.server import Server


class Handlers:
    """States of an arm that swings about; stops that are taken at once."""

    def __init__(self) -> None:
        self._stops: list[float] = []

    def getRobotStatus(self) -> rpc.RobotStatus:  # noqa: N802  # the wire's name
        now = time.monotonic()
        joints = [0.5 * math.sin(now + joint) for joint in range(6)]
        speeds = [0.5 * math.cos(now + joint) for joint in range(6)]
        lists = (entry[1] for entry in list(rpc.RobotStatus.thrift_spec.values())[:15])
        told: dict[str, list[float]] = {name: [0.0] * 6 for name in lists}
        told |= {
            "jointActualPosition": joints,
            "jointExpectPosition": [angle + 0.02 for angle in joints],
            "jointActualVelocity": speeds,
            "cartActualPosition": [0.4, 0.1, 0.3, 3.1, 0.0, 0.0],
            "cartActualVelocity": [0.1, 0.0, 0.0, 0.0, 0.0, 0.0],
        }
        status = rpc.RobotStatus(slaveReady=[True] * 6, robotState=6)
        for name, values in told.items():
            setattr(status, name, values)
        return status

    def getRobotIOStatus(self) -> rpc.IOStatus:  # noqa: N802  # the wire's name
        return rpc.IOStatus(digitalInputs=[False] * 16, digitalOutputs=[True] * 16)

    def stop(self, block: bool) -> int:  # noqa: ARG002  # the wire's name
        self._stops.append(time.time())
        return 4

    def robotmoving(self) -> bool:
        return False

    def get_system_value_list(self, name: str) -> list[float]:  # noqa: ARG002  # the wire's name
        taken, self._stops = self._stops, []
        return taken

    def __getattr__(self, name: str) -> Any:
        answers: dict[str, Any] = {
            "get_robot_state": [6, 0, 5, 1],
            "get_robot_version": "3.8.0",
            "get_robot_type": ["GCR5", "910", "", "1"],
            "get_tcp_force": [1.0, 2.0, 3.0, 0.0, 0.0, 0.0],
            "get_ext_torque": [0.0] * 6,
            "get_tcp_pose_coord": [0.4, 0.1, 0.3, 3.1, 0.0, 0.0],
            "get_last_error": [],
            "get_global_speed": 100.0,
            "get_current_project": "",
            "rpc_heartbeat": None,
        }
        return lambda *_: answers[name]


def main() -> None:
    with Server(cast("Any", Handlers())) as server:
        print(json.dumps({"rpc": server.port}), flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main()
