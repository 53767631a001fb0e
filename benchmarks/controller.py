"""Controllers without an arm, for calls, streams and stops: what is measured is their client.

    python controller.py [COUNT]

They answer at once, on a port each, and echo bytes on a further one. A motion takes as long as was
set by `set_system_value_double("duration", s)`; a realtime point is taken each millisecond.
`get_system_value_list(name)` says what came since it was last asked, or when a task ended, by
CLOCK_MONOTONIC. A heartbeat that does not come is kept as a stop when a controller would stop.

The ports are printed as a line of JSON. The program ends when its standard input does; each line
there has every connection cut, and is answered by one when that is done.
"""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import os
import selectors
import socket
import struct
import sys
import threading
import time
from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import thriftpy2
from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TProcessor
from thriftpy2.transport import TCyBufferedTransport, TTransportException

from aioduco._process.scheduling import shorten_slice
from aioduco._wire import idl, rpc
from aioduco.models.enums import ProgramState, TaskState

if TYPE_CHECKING:
    from collections.abc import Callable

CYCLE = 0.001
#: functions that answer later, or never
WAITING = (b"speed", b"set_standard_digital_out")
#: a servo stream without a point for longer counts as tripped, as a realtime queue does
TRIP = 0.02
LISTS: dict[str, Any] = {each.name: [0.1] * 7 for each in fields(rpc.RobotStatus)[:15]}
SIGNALS: dict[str, Any] = {each.name: [False] * 32 for each in fields(rpc.IOStatus)}
ANSWERS = {
    "get_robot_state": [6, ProgramState.RUNNING, 5, 1],
    "get_robot_version": "3.8.0",
    "get_last_error": [],
    "getRobotStatus": rpc.RobotStatus(**LISTS, slaveReady=[True] * 6, robotState=6),
    "getRobotIOStatus": rpc.IOStatus(**SIGNALS),
}


class Handlers:
    """Tasks that end by the clock, a realtime queue, and answers of a usual size."""

    def __init__(self) -> None:
        self._duration = 0.3
        self._ends: dict[int, float] = {}
        self._stopped: set[int] = set()
        self._moving_until = 0.0
        self._ids = itertools.count(1000)
        self._alive_until = math.inf
        self._stops: list[float] = []
        self._arrivals: list[float] = []
        self._place = [0.0] * 6
        self.clear_realtime_data_queue()

    # -- tasks

    def _start(self, *_: object) -> int:
        task_id = next(self._ids)
        self._ends[task_id] = self._moving_until = time.monotonic() + self._duration
        return task_id

    movej2 = movel = _start

    def speed(self, _val: float) -> int:
        """A motion that is awaited inside the controller: it answers at its end."""
        task_id = self._start()
        time.sleep(max(0.0, self._ends[task_id] - time.monotonic()))
        return task_id

    def get_noneblock_taskstate(self, task_id: int) -> int:
        if task_id in self._stopped:
            return TaskState.STOPPED
        running = time.monotonic() < self._ends.get(task_id, 0.0)
        return TaskState.RUNNING if running else TaskState.FINISHED

    def robotmoving(self) -> bool:
        return time.monotonic() < self._moving_until

    def stop(self, _block: bool) -> int:
        now = time.monotonic()
        self._stops.append(now)
        self._moving_until = min(self._moving_until, now)
        for task_id, end in self._ends.items():
            if end > now:
                self._ends[task_id] = now
                self._stopped.add(task_id)
        return next(self._ids)

    def rpc_heartbeat(self, milliseconds: int) -> None:
        self._lapse()
        self._alive_until = time.monotonic() + milliseconds / 1000

    def _lapse(self) -> None:
        """Keep a stop if no heartbeat came in time. No thread waits for it: 100 arms have many."""
        if self._alive_until < time.monotonic():
            self._stops.append(self._alive_until)
            self._alive_until = math.inf

    def set_standard_digital_out(self, *_: object) -> None:
        """A call that hangs."""
        threading.Event().wait()

    # -- set-points

    def servoj(self, joints: list[float], *_: object) -> int:
        self._arrivals.append(time.monotonic())
        self._place = joints
        return TaskState.FINISHED

    def get_actual_joints_position(self) -> list[float]:
        return self._place

    def clear_realtime_data_queue(self) -> int:
        self._began: float | None = None
        self._filled = self._starved = 0
        return TaskState.FINISHED

    def start_realtime_mode(self, *_: object) -> int:
        self._began = time.monotonic()
        return TaskState.FINISHED

    def end_realtime_mode(self) -> int:
        self.get_realtime_data_queue_size()
        self._began = None
        return TaskState.FINISHED

    def realtime_data_enqueue(self, points: list[Any], _block: bool) -> int:
        self.get_realtime_data_queue_size()
        self._filled += len(points)
        return TaskState.FINISHED

    def get_realtime_data_queue_size(self) -> int:
        """What is left, by the cycles until now: those without a point are counted."""
        if self._began is None:
            return self._filled
        due = int((time.monotonic() - self._began) / CYCLE) - self._starved
        self._starved += max(0, due - self._filled)
        return max(0, self._filled - due)

    # -- what came of it

    def set_system_value_double(self, _name: str, value: float) -> int:
        self._duration = value
        return 0

    def get_system_value_list(self, name: str) -> list[float]:
        """The account that is named, which begins anew; or when the task of this number ended.

        Accounts are the times of `stops`, how often an arm trips by the gaps between `arrivals` of
        set-points, and the cycles of a queue's `starvation`.
        """
        if name == "stops":
            self._lapse()
            stops, self._stops = self._stops, []
            return stops
        if name == "arrivals":
            arrivals, self._arrivals, self._place = self._arrivals, [], [0.0] * 6
            return [float(np.count_nonzero(np.diff(arrivals) > TRIP))]
        if name == "starvation":
            starved = float(self._starved)
            self.clear_realtime_data_queue()
            return [starved]
        return [self._ends[int(name)]]

    def __getattr__(self, name: str) -> Any:
        answer = ANSWERS[name]
        return lambda *_: answer


class Ports:
    """Every port of this process, served by one loop: 100 robots have some 800 connections."""

    def __init__(self) -> None:
        self._selector = selectors.DefaultSelector()
        self._selector.register(sys.stdin, selectors.EVENT_READ, self._drop)
        self._open: set[socket.socket] = set()

    def listen(self, connection: Callable[[socket.socket], Callable[[bytes], object]]) -> int:
        """Listen on a free port; each connection makes what is called with the bytes that come."""
        listener = socket.create_server(("127.0.0.1", 0), backlog=512)
        accept = partial(self._accept, listener, connection)
        self._selector.register(listener, selectors.EVENT_READ, accept)
        return int(listener.getsockname()[1])

    def _accept(self, listener: socket.socket, connection: Callable[[socket.socket], Any]) -> None:
        sock, _ = listener.accept()
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._open.add(sock)
        read = partial(self._read, sock, connection(sock))
        self._selector.register(sock, selectors.EVENT_READ, read)

    def _read(self, sock: socket.socket, answer: Callable[[bytes], object]) -> None:
        came = b""
        with contextlib.suppress(OSError):  # a client that goes away, however it shows
            if came := sock.recv(1 << 16):
                answer(came)
                return
        self._open.discard(sock)
        self._selector.unregister(sock)
        sock.close()

    def _drop(self) -> None:
        """Cut every connection, or end with standard input."""
        if not os.read(sys.stdin.fileno(), 1 << 10):
            os._exit(0)  # threads that hang in a call need no farewell
        for each in self._open:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
        print(flush=True)

    def serve(self) -> None:
        """Answer until standard input ends."""
        while True:
            for key, _ in self._selector.select():
                key.data()


class Calls:
    """Answers the calls of a connection: one, which may come in pieces, or several in one."""

    def __init__(self, processor: TProcessor, sock: socket.socket) -> None:
        protocol: Any = TCyBinaryProtocol
        self._processor = processor
        self._wire = protocol(TCyBufferedTransport(self))
        self._more = sock.recv
        self._came = b""
        self.write, self.flush = sock.sendall, int

    def read(self, size: int) -> bytes:
        came, self._came = self._came[:size], self._came[size:]
        return came or (self._more(size) if self._first else b"")

    def __call__(self, came: bytes) -> None:
        self._came = came
        if any(each in came for each in WAITING):
            threading.Thread(target=self._answer, daemon=True).start()
        else:
            self._answer()

    def _answer(self) -> None:
        self._first = True
        with contextlib.suppress(TTransportException):  # the end of what came
            while True:
                self._processor.process(self._wire, self._wire)
                self._first = False


def echo(sock: socket.socket) -> Callable[[bytes], None]:
    """Takes the size of a reply, in four bytes, once; then sends one for whatever comes."""
    reply = bytes(struct.unpack("!I", sock.recv(4))[0])
    return lambda _: sock.sendall(reply)


def main() -> None:
    # Controllers are another machine: they do not wait behind the program's own work.
    shorten_slice(100_000)
    idl.functions()  # the structs of `rpc` know their fields then
    service = thriftpy2.load(str(idl.path()), module_name="controller_thrift").RPCRobot
    served = Ports()
    processors = [TProcessor(service, Handlers()) for _ in range(int((sys.argv[1:] or ["1"])[0]))]
    ports = [served.listen(partial(Calls, each)) for each in processors]
    print(json.dumps({"ports": ports, "echo": served.listen(echo)}), flush=True)
    served.serve()


if __name__ == "__main__":
    main()
