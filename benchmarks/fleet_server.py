"""Many controllers with trivial handlers in one process, each on a port of its own.

    python fleet_server.py COUNT

It prints its ports as a line of JSON, and ends when its standard input does.
"""

from __future__ import annotations

import contextlib
import json
import sys
from typing import Any, cast

from supervision_server import Handlers

from aioduco._wire import rpc
from aioduco.sim.server import Server

SIX = [0.0] * 6
STATUS = rpc.RobotStatus(
    jointExpectPosition=SIX,
    jointExpectVelocity=SIX,
    jointExpectAccelera=SIX,
    jointActualPosition=SIX,
    jointActualVelocity=SIX,
    jointActualAccelera=SIX,
    jointActualCurrent=SIX,
    jointTemperature=SIX,
    driverTemperature=SIX,
    cartExpectPosition=SIX,
    cartExpectVelocity=SIX,
    cartExpectAccelera=SIX,
    cartActualPosition=SIX,
    cartActualVelocity=SIX,
    cartActualAccelera=SIX,
    slaveReady=[True] * 6,
    robotState=6,
)
IO = rpc.IOStatus(
    digitalInputs=[False] * 16,
    digitalOutputs=[False] * 16,
    boolRegisterInputs=[False] * 64,
    boolRegisterOutputs=[False] * 64,
    wordRegisterInputs=[0] * 32,
    wordRegisterOutputs=[0] * 32,
    floatRegisterInputs=[0.0] * 32,
    floatRegisterOutputs=[0.0] * 32,
)


class Robot(Handlers):
    """A controller that also has a state."""

    def getRobotStatus(self) -> rpc.RobotStatus:  # noqa: N802  # the wire's name
        return STATUS

    def getRobotIOStatus(self) -> rpc.IOStatus:  # noqa: N802  # the wire's name
        return IO


def main() -> None:
    with contextlib.ExitStack() as stack:
        servers = [
            stack.enter_context(Server(cast("Any", Robot()))) for _ in range(int(sys.argv[1]))
        ]
        print(json.dumps({str(k): server.port for k, server in enumerate(servers)}), flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main()
