"""Controllers with tasks and trivial handlers, which keep when they were reached.

    python controller.py [COUNT]

Motions take as long as the time set by `set_system_value_double("duration", s)`. All times are of
CLOCK_MONOTONIC, which a client on the same machine shares. It prints the ports as a line of JSON,
and ends when its standard input does; each line there has all cut every connection, and is
answered by one when that is done. A heartbeat that does not come stops nothing here, but is kept
as a stop at the time at which a controller would have acted. `first_stop` is for its clients.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import sys
import threading
import time
from dataclasses import fields
from typing import TYPE_CHECKING, Any, cast

import anyio

from aioduco._wire import rpc
from aioduco.models.enums import TaskState
from aioduco.sim.server import Server

if TYPE_CHECKING:
    from aioduco._wire.lane import WireLane

#: each list of a status
LISTS: dict[str, Any] = {
    each.name: [0.0] * 6 for each in fields(rpc.RobotStatus) if each.default_factory is list
}
STATUS = rpc.RobotStatus(**LISTS | {"slaveReady": [True] * 6}, robotState=6)
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


class Handlers:
    """Tasks that end by the clock; calls that hang until they are let go."""

    def __init__(self) -> None:
        self._duration = 0.3
        self._ends: dict[int, float] = {}
        self._stops: list[float] = []
        self._stopped: set[int] = set()
        self._moving_until = 0.0
        self._ids = itertools.count(1000)
        self._beat: threading.Timer | None = None
        self.held = threading.Event()

    def _start(self, *_: object) -> int:
        task_id = next(self._ids)
        self._ends[task_id] = self._moving_until = time.monotonic() + self._duration
        return task_id

    movej2 = movel = _start

    def speed(self, val: float) -> int:  # noqa: ARG002  # the wire's name
        """A motion that is awaited inside the controller: it answers at its end."""
        task_id = self._start()
        time.sleep(max(0.0, self._ends[task_id] - time.monotonic()))
        return task_id

    def get_noneblock_taskstate(self, id: int) -> int:  # noqa: A002  # the wire's name
        if id in self._stopped:
            return TaskState.STOPPED
        return (
            TaskState.RUNNING if time.monotonic() < self._ends.get(id, 0.0) else TaskState.FINISHED
        )

    def stop(self, block: bool) -> int:  # noqa: ARG002  # the wire's name
        now = time.monotonic()
        self._stops.append(now)
        self._moving_until = min(self._moving_until, now)
        for task_id, end in self._ends.items():
            if end > now:
                self._ends[task_id] = now
                self._stopped.add(task_id)
        return next(self._ids)

    def robotmoving(self) -> bool:
        return time.monotonic() < self._moving_until

    def rpc_heartbeat(self, time: int) -> None:  # the wire's name
        if self._beat is not None:
            self._beat.cancel()
        self._beat = threading.Timer(time / 1000, self._lost)
        self._beat.daemon = True
        self._beat.start()

    def _lost(self) -> None:
        self._stops.append(time.monotonic())

    def set_standard_digital_out(self, *_: object) -> int:
        self.held.wait()
        return TaskState.FINISHED

    def set_system_value_double(self, name: str, value: float) -> int:  # noqa: ARG002  # the wire's
        self._duration = value
        return 0

    def get_system_value_list(self, name: str) -> list[float]:
        if name == "stops":
            taken, self._stops = self._stops, []
            return taken
        return [self._ends[int(name)]]

    def __getattr__(self, name: str) -> Any:
        answers = {
            "get_robot_state": [6, 0, 5, 1],
            "get_robot_version": "3.8.0",
            "get_actual_joints_position": [0.0] * 6,
            "get_last_error": [],
            "getRobotStatus": STATUS,
            "getRobotIOStatus": IO,
        }
        return lambda *_: answers[name]


async def first_stop(lane: WireLane, begin: float) -> float:
    """When the controller was first told to stop after `begin`, or stopped by itself."""
    with anyio.fail_after(30.0):
        while True:
            after = [at for at in await lane.rpc.get_system_value_list("stops") if at >= begin]
            if after:
                return min(after)
            await anyio.sleep(0.005)


def main() -> None:
    handlers = [Handlers() for _ in range(int(sys.argv[1]) if sys.argv[1:] else 1)]
    with contextlib.ExitStack() as stack:
        servers = [stack.enter_context(Server(cast("Any", each))) for each in handlers]
        print(json.dumps({str(k): server.port for k, server in enumerate(servers)}), flush=True)
        for _ in sys.stdin:
            for server in servers:
                server.drop()
            print(flush=True)
        for each in handlers:
            each.held.set()


if __name__ == "__main__":
    main()
