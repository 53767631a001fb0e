"""A controller that answers from a script, and streams that lead to it."""

from __future__ import annotations

import inspect
import itertools
import socket
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patient import STREAM_PATIENCE

from aioduco.api.streams.servo import Servo
from aioduco.sim import Simulator
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.stream import Stream
from aioduco.supervision.gate import Gate
from aioduco.testing import RecordingServer, eventually

HERE = [0.0, -0.1, 0.2, 0.3, 0.4, 0.5]
# This file may be loaded before these are the defaults.
PROCESS = WorkerOptions(
    timeout=STREAM_PATIENCE["timeout"], away_limit=STREAM_PATIENCE["away_limit"]
)
THREAD = replace(PROCESS, run_in="thread")
#: the state of the arm is not asked for meanwhile
UNWATCHED = replace(THREAD, watch=0.0)

workers = pytest.mark.parametrize("options", [THREAD, PROCESS], ids=["thread", "process"])


def near(offset: float) -> list[float]:
    """A set-point beside `HERE`, in each joint [rad]."""
    return [angle + offset for angle in HERE]


def answer_all(server: RecordingServer, answers: Mapping[str, Any]) -> None:
    """Let a server answer more functions."""
    for name, answer in answers.items():
        server.answer(name, answer)


def came_to_rest(controller: Controller, rate: float, acceleration: float, missed: int = 0) -> bool:
    """Whether the first joint's set-points end at rest, and never change their speed too fast.

    Where ticks were missed, as on a busy machine, a place is not that of the next tick.
    """
    places = np.array(controller.points())[:, 0]
    assert missed or np.abs(np.diff(places, n=2)).max() * rate**2 <= acceleration * (1 + 1e-6)
    return bool(places[-1] == places[-2])


async def fed(
    stream: Stream, points: Iterable[Any], then: Callable[[], object] | None = None
) -> None:
    """Open a stream, send it these, do what comes then, and leave it."""
    async with stream:
        for point in points:
            await stream.send(point)
        if then is not None and inspect.isawaitable(done := then()):
            await done


def at(number: int, act: Callable[[], object]) -> Iterator[list[float]]:
    """Where the arm is, again and again; before the one of this number something happens."""
    for n in itertools.count():
        if n == number:
            act()
        yield HERE


def shared_files(*pids: int) -> set[Path]:
    """The files of shared memory that processes have mapped, those without a name left out."""
    lines = (line for pid in pids for line in Path(f"/proc/{pid}/maps").read_text().splitlines())
    return {Path(line.split(maxsplit=5)[5]) for line in lines if "/dev/shm/" in line}


@dataclass
class Controller:
    """What a script answers, and what it needs to know for it."""

    server: RecordingServer
    stops: list[str] = field(default_factory=list)
    gate: Gate = field(default_factory=lambda: StreamEndpoint("", 0).gate)

    @property
    def endpoint(self) -> StreamEndpoint:
        async def stop(ending: str) -> None:
            self.stops.append(ending or "stop")

        return StreamEndpoint(
            self.server.host, self.server.port, stop, gate=self.gate, stall_limit=15.0
        )

    @staticmethod
    def nowhere() -> StreamEndpoint:
        """For streams that are made but never opened."""
        return StreamEndpoint("127.0.0.1", 1)

    @property
    def servo(self) -> Servo:
        return Servo(self.endpoint)

    def points(self, name: str = "servoj") -> list[list[float]]:
        """The set-points that came, in order."""
        return [call.args[0] for call in self.server.received(name)]

    def names(self) -> list[str]:
        """The functions that were called, each once for every run of calls of it.

        Questions at the end of a stream, whether the arm stands and why not, are left out.
        """
        found: list[str] = []
        for call in self.server.received():
            if call.method in ("robotmoving", "getRobotStatus", "get_last_error"):
                continue
            if not found or found[-1] != call.method:
                found.append(call.method)
        return found


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    """An arm on a clock as fast as the real one."""
    with Simulator() as sim:
        yield sim


@pytest.fixture
def controller() -> Iterator[Controller]:
    answers: dict[str, Any] = {
        "get_actual_joints_position": HERE,
        "get_tcp_pose_coord": [0.5, 0.1, 0.4, 3.0, 0.0, 1.0],
        "get_robot_state": [6, 2, 5, 1],
        "get_noneblock_taskstate": 1,
        "robotmoving": False,
        "stop": 4,
        "speed_stop": 1002,
        **dict.fromkeys(("servoj", "servoj_pose", "servo_tcp", "servol"), 1001),
        **dict.fromkeys(("speedj", "speedl"), 1001),
    }
    with RecordingServer(answers) as server:
        # Its accepting thread opens files of its own, which must not look like a stream's.
        with socket.create_connection((server.host, server.port)):
            eventually(lambda: server.connections == 1)
        eventually(lambda: server.connections == 0)
        yield Controller(server)


class Cycles:
    """A queue from which a controller takes a point each cycle, by its own clock.

    What it would have taken is reckoned when it is asked, so that no thread of the test has to
    keep the time.
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = cycle
        self._lock = threading.Lock()
        self._began: float | None = None
        self.taken = 0
        self.points: list[Any] = []
        self.starved = 0

    @property
    def answers(self) -> dict[str, Callable[..., int]]:
        """The functions of the realtime queue."""
        return {
            "clear_realtime_data_queue": self.clear,
            "realtime_data_enqueue": self.enqueue,
            "start_realtime_mode": self.start,
            "get_realtime_data_queue_size": self.size,
            "end_realtime_mode": self.end,
        }

    def start(self, *_: Any) -> int:
        with self._lock:
            self._began = time.monotonic()
            return 4

    def end(self) -> int:
        with self._lock:
            self._advance()
            self._began = None
            return 4

    def clear(self) -> int:
        return 4

    def enqueue(self, points: list[Any], _block: bool) -> int:
        with self._lock:
            self._advance()
            self.points += points
            return 4

    def size(self) -> int:
        with self._lock:
            self._advance()
            return len(self.points) - self.taken

    def _advance(self) -> None:
        if self._began is None:
            return
        due = int((time.monotonic() - self._began) / self._cycle) - self.starved
        missing = max(0, due - len(self.points))
        self.starved += missing
        self.taken = due - missing
