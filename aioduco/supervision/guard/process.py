"""The guard's process: stops every arm that it watches when the program is gone.

Guarantees:
- The program's end, however it comes, closes its end of the socket pair. The guard sees that at
  once, and stops the arms over connections that have been open since the robots were.
- A stop that the program asks for goes out without the program's interpreter: its GIL, its event
  loop and its garbage collector cannot delay it.
- An event loop that gives no sign of life for its stall limit has its arm stopped here, and its
  heartbeat withheld.
- The guard's own end ends the heartbeats, and the controllers stop their arms.
"""

from __future__ import annotations

import logging
import os
import signal
import socket
from typing import TYPE_CHECKING

import anyio
from anyio.lowlevel import checkpoint

from aioduco._wire.connection import Connection
from aioduco._wire.lane import Lane
from aioduco.errors import DucoError
from aioduco.scheduling import shorten_slice
from aioduco.supervision.control import Control
from aioduco.supervision.guard.messages import (
    LARGEST,
    Alive,
    Beat,
    Done,
    Rearm,
    Release,
    Stop,
    Watch,
    pack,
    shortened,
    unpack,
)
from aioduco.supervision.heartbeat import Heartbeat, SignOfLife

if TYPE_CHECKING:
    from anyio.abc import TaskGroup

    from aioduco.supervision.guard.messages import Message

_log = logging.getLogger(__name__)

#: seconds for which the guard goes on trying to stop the arms of a program that is gone
ORPHAN_LIMIT = 30.0
#: real-time priority: the lowest, which goes before all that have none
_PRIORITY = 1
#: length of a slice of a processor [ns]: the shortest that there is
_SLICE = 100_000
#: what a request is answered by that came to nothing since the robot is gone
_RELEASED = "the robot was released meanwhile"
#: seconds for a heartbeat's thread to end
_GRACE = 1.0


class Ward:
    """One robot that the guard looks after.

    Args:
        watch: the request that it came with.
        guard: who is told about its heartbeat.
    """

    def __init__(self, watch: Watch, guard: Guard) -> None:
        self.robot: int = watch.robot
        self._watch = watch
        self._guard = guard
        lanes = [
            Lane(
                name,
                watch.host,
                watch.port,
                connect_timeout=watch.connect_timeout,
                call_timeout=watch.call_timeout,
            )
            for name in ("guard-stop", "guard-spare")
        ]
        self._lanes = lanes
        self.control: Control = Control(lanes[0], lanes[1], lanes[1])
        self.life: SignOfLife = SignOfLife()
        self.heartbeat: Heartbeat | None = None
        #: stops on their way: pointless as soon as the robot is released
        self.stopping: set[anyio.CancelScope] = set()

    async def open(self) -> None:
        """Open the connections and beat.

        Raises:
            DucoError: the controller does not answer.
        """
        try:
            for lane in self._lanes:
                await lane.open()
        except BaseException:
            await self.aclose()
            raise
        if self._watch.heartbeat is not None:
            self.heartbeat = Heartbeat(
                self._line,
                self._watch.heartbeat,
                self.life,
                self._watch.stall_limit,
                changed=self._beaten,
            )
            self.heartbeat.start()

    def _line(self) -> Connection:
        watch = self._watch
        return Connection(watch.host, watch.port, connect_timeout=watch.connect_timeout)

    def _beaten(self, heartbeat: Heartbeat) -> None:
        """Tell the program how its heart beats; on the heartbeat's thread."""
        figures = heartbeat.statistics()
        error = shortened(str(heartbeat.error)) if heartbeat.error is not None else ""
        self._guard.tell(Beat(self.robot, figures.state.value, *figures[1:], error))

    async def aclose(self) -> None:
        """End the heartbeat and close the connections."""
        for scope in self.stopping:
            scope.cancel()
        if self.heartbeat is not None:
            self.heartbeat.end()
        for lane in self._lanes:
            await lane.aclose()
        if self.heartbeat is not None:
            self.heartbeat.join(_GRACE)


class _Arrival:
    """A robot whose connections are being opened: it may be released before they are."""

    def __init__(self) -> None:
        self.scope = anyio.CancelScope()
        self.over = anyio.Event()


class Guard:
    """Looks after the robots of one program.

    Args:
        program: the guard's end of the socket pair.
    """

    def __init__(self, program: socket.socket) -> None:
        self._program = program
        self._wards: dict[int, Ward] = {}
        self._arrivals: dict[int, _Arrival] = {}

    def tell(self, message: Message) -> None:
        """Send a message to the program; one that does not read loses it, one that is gone too."""
        try:
            self._program.send(pack(message), socket.MSG_DONTWAIT)
        except OSError:
            # Whether the program is gone is for the reading side to find; figures may be lost.
            return

    async def run(self) -> None:
        """Serve the program until it is gone, then stop what it left behind."""
        async with anyio.create_task_group() as tasks:
            while (message := await self._next()) is not None:
                self._take(message, tasks)
            # Stops that were asked for are still being sent: nothing is cancelled here.
            for ward in self._wards.values():
                tasks.start_soon(self._orphan, ward)

    async def _next(self) -> Message | None:
        while True:
            try:
                packet = self._program.recv(LARGEST, socket.MSG_DONTWAIT)
            except BlockingIOError:
                await anyio.wait_readable(self._program)
                continue
            except OSError:
                return None
            await checkpoint()
            return unpack(packet) if packet else None

    def _take(self, message: Message, tasks: TaskGroup) -> None:
        match message:
            case Alive(robot, stamp):
                if robot in self._wards:
                    self._wards[robot].life.stamp = stamp
            case Stop():
                tasks.start_soon(self._stop, message)
            case Watch(robot):
                # Here and not in the task: a release that follows at once must find it.
                self._arrivals[robot] = arrival = _Arrival()
                tasks.start_soon(self._watch, message, arrival)
            case Rearm(robot):
                ward = self._wards.get(robot)
                if ward is not None and ward.heartbeat is not None:
                    ward.heartbeat.rearm()
            case Release():
                tasks.start_soon(self._release, message)
            case Done() | Beat():
                raise ValueError(f"a program sent {message!r} to its guard")

    async def _watch(self, request: Watch, arrival: _Arrival) -> None:
        ward = Ward(request, self)
        error = _RELEASED
        with arrival.scope:
            try:
                await ward.open()
            except DucoError as exc:
                error = shortened(str(exc))
            else:
                error = ""
                self._wards[request.robot] = ward
        self._arrivals.pop(request.robot, None)
        arrival.over.set()
        self.tell(Done(request.token, error))

    async def _stop(self, request: Stop) -> None:
        ward = self._wards.get(request.robot)
        if ward is None:
            self.tell(Done(request.token, "the guard does not know this robot"))
            return
        error = _RELEASED
        with anyio.CancelScope() as scope:
            ward.stopping.add(scope)
            try:
                await ward.control.stop(request.timeout)
            except DucoError as exc:
                error = shortened(str(exc))
            else:
                error = ""
            finally:
                ward.stopping.discard(scope)
        self.tell(Done(request.token, error))

    async def _release(self, request: Release) -> None:
        if (arrival := self._arrivals.get(request.robot)) is not None:
            arrival.scope.cancel()
            await arrival.over.wait()
        ward = self._wards.pop(request.robot, None)
        if ward is not None:
            await ward.aclose()
        self.tell(Done(request.token, ""))

    async def _orphan(self, ward: Ward) -> None:
        """The program is gone without having released this robot: stop its arm."""
        try:
            await ward.control.stop(ORPHAN_LIMIT)
            await ward.control.rest(ORPHAN_LIMIT, ORPHAN_LIMIT)
        except DucoError as exc:
            _log.critical("the program is gone, and its arm was not seen to stop: %s", exc)
        finally:
            await ward.aclose()


def _go_first() -> None:
    """Have the guard run as soon as it has something to do; its threads inherit it.

    It works for moments, and must not wait behind a program that works for long. Where the system
    allows it, it goes before everything that has no real-time priority; else it asks for short
    slices.
    """
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return  # the program was given a policy, and the guard has it too
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    except PermissionError:
        shorten_slice(_SLICE)


def main(descriptor: int) -> None:
    """Run a guard.

    Args:
        descriptor: file descriptor of the guard's end of the socket pair.
    """
    # Ctrl-C in a terminal reaches all its processes: it is for the program to act on.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _go_first()
    with socket.socket(fileno=descriptor) as program:
        program.setblocking(False)
        guard = Guard(program)
        anyio.run(guard.run)
