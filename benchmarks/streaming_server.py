"""A controller without an arm for the benchmark of streams: it takes points, and keeps account.

It answers at once, takes a realtime point each millisecond by its own clock, and says in
`get_system_value_list(name)` what came of it since it was last asked. It prints its port as a
line of JSON, and ends when its standard input does.
"""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import rpc_server
import thriftpy2

from aioduco._process.scheduling import shorten_slice
from aioduco._wire import idl

if TYPE_CHECKING:
    import socket

CYCLE = 0.001
#: a servo stream without a point for longer counts as tripped, as a realtime queue does
TRIP = 0.02


class Handlers(rpc_server.Handlers):
    """What streams call; what was taken from the queue is reckoned when somebody looks."""

    def __init__(self, structs: Any) -> None:
        super().__init__(structs)
        self.place: list[float] = [0.0] * 6
        self.times: list[float] = []
        self.clear_realtime_data_queue()

    def servoj(self, *args: Any) -> int:
        self.times.append(time.monotonic())
        self.place = args[0]
        return 1000

    def get_actual_joints_position(self) -> list[float]:
        return self.place

    def get_robot_state(self) -> list[int]:
        return [6, 2, 5, 1]

    def robotmoving(self) -> bool:
        return False

    def stop(self, _block: bool) -> int:
        return 4

    def clear_realtime_data_queue(self) -> int:
        self.began: float | None = None
        self.filled = self.taken = self.starved = 0
        self.longest = self.dry = 0
        return 4

    def start_realtime_mode(self, *_: object) -> int:
        self.began = time.monotonic()
        return 4

    def end_realtime_mode(self) -> int:
        self._advance()
        self.began = None
        return 4

    def realtime_data_enqueue(self, realtime_data: list[Any], _block: bool) -> int:
        self._advance()
        self.filled += len(realtime_data)
        return 4

    def get_realtime_data_queue_size(self) -> int:
        self._advance()
        return self.filled - self.taken

    def _advance(self) -> None:
        if self.began is None:
            return
        due = int((time.monotonic() - self.began) / CYCLE) - self.starved
        missing = max(0, due - self.filled)
        self.taken = due - missing
        self.starved += missing
        self.dry = self.dry + missing if missing else 0
        self.longest = max(self.longest, self.dry)

    def get_system_value_list(self, name: str) -> list[float]:
        """The account that is named, which begins anew."""
        found = getattr(self, f"_{name}")()
        self.times, self.place = [], [0.0] * 6
        return [float(value) for value in found]

    def _arrivals(self) -> list[float]:
        """How often an arm trips by the gaps between set-points."""
        return [float(np.count_nonzero(np.diff(self.times) > TRIP))]

    def _starvation(self) -> list[float]:
        """Points taken, cycles without one, and the most of them in a row."""
        found: list[float] = [self.taken, self.starved, self.longest]
        self.clear_realtime_data_queue()
        return found


def main() -> None:
    # Threads take turns at once: a controller's queue does not wait for Python's lock.
    sys.setswitchinterval(0.0005)
    module = thriftpy2.load(str(idl.path()), module_name="streaming_server_thrift")
    handlers = Handlers(module)

    def answer(sock: socket.socket) -> None:
        # A controller is another machine: it does not wait behind the program's own work.
        shorten_slice(100_000)
        rpc_server.answer_calls(sock, module.RPCRobot, handlers)

    rpc_server.serve({"thrift": rpc_server.listen(answer)})


if __name__ == "__main__":
    main()
