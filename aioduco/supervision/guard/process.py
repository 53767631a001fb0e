"""The guard's process: stops every arm that its program moves when the program exits.

Guarantees:
- When the program exits, for whatever reason, its end of the socket pair closes. The guard detects
  that at once, and stops the arms over connections that have been open since the robots were.
- The guard stops only an arm that the program moves. The program reports that before it sends
  anything that may move the arm, and withdraws it when the arm stands.
- After the stop of a program that has exited or hangs, it ends the modes that a stop leaves on, as
  hand guiding: nobody else would, and the arm would go on giving way.
- If the guard was itself suspended for so long that the controllers missed its heartbeats, it sends
  no stop: the controllers have stopped the arms, and a motion now belongs to another program.
- If an event loop sends no keep-alive for its stall limit, the guard stops the arm and withholds
  the heartbeat, if there is one.
- When the guard exits, the heartbeats end, and the controllers stop their arms. A signal that asks
  it to exit (SIGTERM, SIGHUP) makes it stop the arms instead, and it continues.
"""

from __future__ import annotations

import logging
import os
import signal
import socket
import syslog
import time
from functools import partial
from typing import TYPE_CHECKING

import anyio
from anyio.lowlevel import checkpoint

from aioduco._process.platform import boot_time, handed_socket, set_realtime_priority
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.scheduling import shorten_slice
from aioduco._wire.endpoint import Endpoint, Route
from aioduco._wire.lane import WireLane
from aioduco._wire.own_connection import OwnConnection
from aioduco._wire.way_out import WAY_OUT, prepare
from aioduco.errors import DucoError
from aioduco.models.host_port import host_port
from aioduco.supervision.concurrency import every
from aioduco.supervision.guard.messages import (
    MAX_PACKET,
    Alive,
    Beat,
    Done,
    LogMessage,
    Rearm,
    Release,
    Watch,
    pack,
    shortened,
    unpack,
)
from aioduco.supervision.heartbeat import Heartbeat
from aioduco.supervision.loop_watchdog import Liveness
from aioduco.supervision.motion_sources import Modes
from aioduco.supervision.rest import bring_to_rest
from aioduco.supervision.stop_channel import StopChannel
from aioduco.supervision.unanswered import UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Sequence

    from anyio.abc import TaskGroup

    from aioduco.supervision.guard.messages import Message

_log = BackgroundLogger(__name__)

#: seconds for which the guard tries to stop the arms of a program that has exited
ABANDONED_LIMIT = 30.0
#: real-time priority: the lowest, which is above all processes without one
_PRIORITY = 1
#: length of a time slice [ns]: the shortest possible one
_SLICE = 100_000
#: answer to a request that had no effect, because the robot was released
_RELEASED = "the robot was released meanwhile"
#: seconds for a heartbeat's thread to end
_GRACE = 1.0


class GuardedRobot:
    """One robot whose heartbeat the guard has taken over, and its stop if the program ends.

    Args:
        watch: the request to supervise it.
        guard: sends the reports of its heartbeat to the program.
    """

    def __init__(self, watch: Watch, guard: Guard) -> None:
        self.robot: int = watch.robot
        self._watch = watch
        self._guard = guard
        route = self._route = Route()
        lanes = [
            WireLane(
                name,
                watch.host,
                watch.port,
                connect_timeout=watch.connect_timeout,
                call_timeout=watch.call_timeout,
                route=route,
            )
            for name in ("guard-stop", "guard-spare")
        ]
        self._lanes = lanes
        self.stop_channel: StopChannel = StopChannel(lanes[0], lanes[1], lanes[1])
        self.liveness: Liveness = Liveness()
        self.heartbeat: Heartbeat | None = None
        #: stops on their way: cancelled when the robot is released
        self.stopping: set[anyio.CancelScope] = set()
        #: watches the event loop of a robot without a heartbeat
        self.watching: anyio.CancelScope = anyio.CancelScope()
        #: opens the connections: cancelled if the robot is released before they are open
        self.opening: anyio.CancelScope = anyio.CancelScope()
        self.opened: anyio.Event = anyio.Event()

    async def open(self) -> None:
        """Open the connections, and start the heartbeat.

        Raises:
            DucoError: the controller does not answer.
        """
        prepare(WAY_OUT)
        try:
            for lane in self._lanes:
                await lane.open()
        except BaseException:
            await self.aclose()
            raise
        if self._watch.heartbeat is not None:
            watch = self._watch
            end = Endpoint(watch.host, watch.port, watch.connect_timeout, route=self._route)
            self.heartbeat = Heartbeat(
                OwnConnection(end),
                self._watch.heartbeat,
                self.liveness,
                self._watch.stall_limit,
                changed=self._beaten,
                remote=True,
            )
            self.heartbeat.start()

    def _beaten(self, heartbeat: Heartbeat) -> None:
        """Report the heartbeat to the program; on the heartbeat's thread."""
        figures = heartbeat.statistics()
        error = shortened(str(heartbeat.error)) if heartbeat.error is not None else ""
        told = Beat(
            self.robot, figures.state.value, *figures[1:], error, heartbeat.lapsed, heartbeat.sent
        )
        self._guard.tell(told)

    async def halt(self, *, gone: bool = False) -> None:
        """Stop the arm and wait until it stands, if the program moves it; failures are logged.

        The modes of a program that has exited are ended.

        Args:
            gone: whether the program has exited: its last motion may still be on its way.
        """
        begin = time.monotonic()
        if not self.liveness.moves or (self.heartbeat is not None and self.heartbeat.lapsed):
            return
        with anyio.CancelScope() as scope:
            self.stopping.add(scope)
            try:
                await self.stop_channel.stop(ABANDONED_LIMIT)
                if gone:
                    await self._leave_modes()  # until then a hand may move the arm
                await self.stop_channel.rest(ABANDONED_LIMIT, ABANDONED_LIMIT)
                if gone:
                    await self._stop_until_certain(begin)
                    await self._leave_modes()  # the program's last command may have entered one
            except DucoError as exc:
                where = host_port(self._watch.host, self._watch.port)
                _log.critical("the arm of %s was not seen to stop: %s", where, exc)
            finally:
                self.stopping.discard(scope)

    async def _leave_modes(self) -> None:
        modes = Modes(self.stop_channel)
        for name, args in self.liveness.modes:
            modes.enter(name, tuple(args))
        await modes.leave()

    async def _stop_until_certain(self, begin: float) -> None:
        """Watch the arm until the motion that the program sent last cannot move it any more.

        Its connection closed when the program exited, and undelivered bytes were discarded.
        """
        now = time.monotonic()
        motion = UnansweredMotion(now, now, now + ABANDONED_LIMIT)
        motion.connection_reset(begin)
        motion.stopped(now, now)
        if not await bring_to_rest(
            motion, partial(self.stop_channel.stop, ABANDONED_LIMIT), self.stop_channel.moving
        ):
            _log.critical("the arm was told to stop, and begins to move again and again")

    async def watch_loop(self) -> None:
        """Stop the arm if the event loop hangs, for a robot whose heartbeat's thread does not."""
        limit = self._watch.stall_limit
        woken = looked = boot_time()
        told = 0.0
        with self.watching:
            async for _ in every(limit / 10):
                before, looked = looked, boot_time()
                if looked - before > limit:
                    woken = looked  # it was itself suspended: keep-alives from before prove nothing
                stamp = self.liveness.stamp
                if not self.liveness.moves or told == stamp or looked < max(stamp, woken) + limit:
                    continue
                told = stamp
                _log.error("the event loop has not run for %.2f s: the arm is stopped", limit)
                try:
                    await self.stop_channel.stop(ABANDONED_LIMIT)
                except DucoError as exc:
                    _log.critical("the event loop hangs, and %s", exc)
                await self._leave_modes()
                looked = boot_time()

    async def aclose(self) -> None:
        """End the heartbeat and close the connections."""
        self.watching.cancel()
        for scope in self.stopping:
            scope.cancel()
        if self.heartbeat is not None:
            self.heartbeat.end()
        for lane in self._lanes:
            await lane.aclose()
        if self.heartbeat is not None:
            self.heartbeat.join(_GRACE)


class Guard:
    """Supervises the robots of one program.

    Args:
        program: the guard's end of the socket pair.
    """

    def __init__(self, program: socket.socket) -> None:
        self._program = program
        self._guarded: dict[int, GuardedRobot] = {}
        #: robots whose connections are being opened
        self._pending: dict[int, GuardedRobot] = {}

    def tell(self, message: Message) -> bool:
        """Send a message to the program; it is lost if the program does not read or has exited.

        Returns:
            Whether it was sent.
        """
        try:
            self._program.send(pack(message), socket.MSG_DONTWAIT)
        except OSError:
            # The reading side detects the program's exit; statistics may be lost.
            return False
        return True

    async def run(self) -> None:
        """Serve the program until it exits, then stop the arms that it has not released."""
        with anyio.open_signal_receiver(signal.SIGTERM, signal.SIGHUP) as signals:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._on_end_signals, signals, tasks)
                async with anyio.create_task_group() as stops:
                    while (message := await self._next()) is not None:
                        self._take(message, stops)
                    # it has exited: its arms are stopped for that
                    for guarded in self._guarded.values():
                        guarded.watching.cancel()
                    for guarded in self._guarded.values():
                        stops.start_soon(self._stop_abandoned, guarded)
                tasks.cancel_scope.cancel()

    async def _on_end_signals(self, signals: AsyncIterator[int], tasks: TaskGroup) -> None:
        """Stop the arms at each signal that asks the guard to exit, and continue.

        A service manager signals the program and its guard at the same time. The program may be
        closing its robots, and needs its heartbeat for that, however long it takes; after the
        program, the guard exits by itself. If that takes too long, the manager kills both.
        """
        async for _ in signals:
            for guarded in self._guarded.values():
                tasks.start_soon(guarded.halt)

    async def _next(self) -> Message | None:
        while True:
            try:
                packet = self._program.recv(MAX_PACKET, socket.MSG_DONTWAIT)
            except BlockingIOError:
                await anyio.wait_readable(self._program)
                continue
            except OSError:
                return None
            await checkpoint()
            return unpack(packet) if packet else None

    def _take(self, message: Message, tasks: TaskGroup) -> None:
        match message:
            case Alive(robot, stamp, moves, modes):
                if robot in self._guarded:
                    self._guarded[robot].liveness.stamp = stamp
                    self._guarded[robot].liveness.moves = moves
                    self._guarded[robot].liveness.modes = modes
            case Watch(robot, token):
                # Added here and not in the task: a release that follows at once must find it.
                self._pending[robot] = guarded = GuardedRobot(message, self)
                tasks.start_soon(self._watch, guarded, token, tasks)
            case Rearm(robot):
                if robot in self._guarded and (beats := self._guarded[robot].heartbeat) is not None:
                    beats.rearm()
            case Release():
                tasks.start_soon(self._release, message)
            case Done() | Beat() | LogMessage():
                raise ValueError(f"a program sent {message!r} to its guard")

    async def _watch(self, guarded: GuardedRobot, token: int, tasks: TaskGroup) -> None:
        error = _RELEASED
        with guarded.opening:
            try:
                await guarded.open()
            except DucoError as exc:
                error = shortened(str(exc))
            else:
                error = ""
                self._guarded[guarded.robot] = guarded
                if guarded.heartbeat is None:
                    tasks.start_soon(guarded.watch_loop)
        self._pending.pop(guarded.robot, None)
        guarded.opened.set()
        self.tell(Done(token, error))

    async def _release(self, request: Release) -> None:
        if (pending := self._pending.get(request.robot)) is not None:
            pending.opening.cancel()
            await pending.opened.wait()
        guarded = self._guarded.pop(request.robot, None)
        if guarded is not None:
            await guarded.aclose()
        self.tell(Done(request.token, ""))

    async def _stop_abandoned(self, guarded: GuardedRobot) -> None:
        """Stop the arm of a robot that the program did not release before it exited."""
        try:
            await guarded.halt(gone=True)
        finally:
            await guarded.aclose()


def _raise_priority() -> None:
    """Let the guard run as soon as it has work to do; its threads inherit the priority.

    Its work is short, and must not wait behind a program that works for long. Where the system
    allows it, the guard runs before everything without a real-time priority; else it asks for short
    time slices.
    """
    if os.sched_getscheduler(0) != os.SCHED_OTHER:
        return  # the program has a policy of its own, and the guard has inherited it
    if not set_realtime_priority(_PRIORITY):
        shorten_slice(_SLICE)


class _Relay(logging.Handler):
    """Log handler that sends the guard's messages to the program, or to syslog after its exit."""

    def __init__(self, guard: Guard) -> None:
        super().__init__(logging.WARNING)
        self._guard = guard

    def emit(self, record: logging.LogRecord) -> None:
        """Send the record to the program, or to syslog."""
        text = shortened(self.format(record))
        if not self._guard.tell(LogMessage(record.levelno, text)):
            syslog.syslog(syslog.LOG_CRIT, f"aioduco's guard: {text}")


def main(arguments: Sequence[str]) -> int:
    """Run a guard.

    Args:
        arguments: file descriptor of the guard's end of the socket pair.

    Returns:
        The exit code.
    """
    # Ctrl-C in a terminal reaches all its processes: only the program must act on it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # Until the guard runs, it supervises no arm that it could stop.
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    _raise_priority()
    with handed_socket(arguments[0]) as program:
        program.setblocking(False)
        guard = Guard(program)
        logging.getLogger().addHandler(_Relay(guard))
        anyio.run(guard.run)
    return 0
