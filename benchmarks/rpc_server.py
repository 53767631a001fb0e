"""A controller without an arm, for calls and streams: what is measured beside it is the client.

It answers at once, takes a realtime point each millisecond by its own clock, and says in
`get_system_value_list(name)` what came of the set-points since it was last asked. It speaks the
wire on one port and echoes bytes on another, prints both as a line of JSON, and ends when its
standard input does.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np
import thriftpy2
from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TProcessor
from thriftpy2.transport import TCyBufferedTransport, TSocket

from aioduco._process.scheduling import shorten_slice
from aioduco._wire import idl

if TYPE_CHECKING:
    from collections.abc import Callable

_socket: Any = TSocket
CYCLE = 0.001
#: a servo stream without a point for longer counts as tripped, as a realtime queue does
TRIP = 0.02


class Handlers:
    """Answers of the right type and a usual size.

    What was taken from the realtime queue is reckoned when somebody looks.
    """

    def __init__(self, structs: Any) -> None:
        self._status = structs.RobotStatus(
            **{
                entry[1]: [0.1] * 7 for entry in list(structs.RobotStatus.thrift_spec.values())[:15]
            },
            slaveReady=[True] * 6,
            collision=False,
            collisionAxis=0,
            emcStopSignal=False,
            robotState=6,
            robotError=0,
        )
        self.place: list[float] = [0.0] * 6
        self.times: list[float] = []
        self.clear_realtime_data_queue()

    def get_noneblock_taskstate(self, *_: object) -> int:
        return 1

    def getRobotStatus(self) -> Any:  # noqa: N802  # the name on the wire
        return self._status

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


def answer_calls(sock: socket.socket, service: Any, handlers: Handlers) -> None:
    # A controller is another machine: it does not wait behind the program's own work.
    shorten_slice(100_000)
    transport = TCyBufferedTransport(_socket(sock=sock))
    protocol: Any = TCyBinaryProtocol
    stream = protocol(transport)
    processor = TProcessor(service, handlers)
    while True:
        processor.process(stream, stream)


def answer_echoes(sock: socket.socket) -> None:
    """Read the sizes of request and reply once; then send a reply for each request."""
    request, reply = struct.unpack("!II", receive(sock, 8))
    data = bytes(reply)
    while True:
        receive(sock, request)
        sock.sendall(data)


def receive(sock: socket.socket, size: int) -> bytes:
    data = sock.recv(size)
    while len(data) < size:
        chunk = sock.recv(size - len(data))
        if not chunk:
            raise EOFError
        data += chunk
    return data


def listen(answer: Callable[[socket.socket], None]) -> int:
    """Serve each connection on a thread of its own; the port."""
    listener = socket.create_server(("127.0.0.1", 0), backlog=64)

    def serve(sock: socket.socket) -> None:
        # a client that goes away ends its connection, however it shows
        with contextlib.suppress(Exception), sock:
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            answer(sock)

    def accept() -> None:
        while True:
            sock, _ = listener.accept()
            threading.Thread(target=serve, args=(sock,), daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    return int(listener.getsockname()[1])


def main() -> None:
    # Threads take turns at once: a controller's queue does not wait for Python's lock.
    sys.setswitchinterval(0.0005)
    module = thriftpy2.load(str(idl.path()), module_name="rpc_server_thrift")
    handlers = Handlers(module)
    ports = {
        "thrift": listen(lambda sock: answer_calls(sock, module.RPCRobot, handlers)),
        "echo": listen(answer_echoes),
    }
    print(json.dumps(ports), flush=True)
    sys.stdin.read()
    # threads that wait for bytes need no farewell
    os._exit(0)


if __name__ == "__main__":
    main()
