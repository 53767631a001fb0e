"""Detects when the event loop is blocked, and by which line.

A program that computes, or sleeps, on the event loop keeps it from noticing the end of a motion,
and from sending set-points in time. Asyncio's debug mode reports that afterwards; this module
inspects the loop's thread while it is blocked.
"""

from __future__ import annotations

import sys
import threading
import time
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from aioduco._process.platform import boot_time
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.wakeup import Wakeup
from aioduco._wire.forks import fork_hooks
from aioduco.errors import GuardLost
from aioduco.supervision.concurrency import Ticker, every

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import FrameType


_log = BackgroundLogger(__name__)

#: the functions of the wire that end modes, with their arguments
Endings: TypeAlias = "Sequence[tuple[str, tuple[bool, ...]]]"

#: keep-alives of an event loop per stall limit, and the longest time between two [s]
_SIGNS: Final = 10
_SIGN_EVERY: Final = 0.1
#: keep-alives per lag limit: one that runs is never late by it
_SIGNS_PER_LAG: Final = 2.5
#: calls of the stack that are kept
_DEPTH: Final = 12
#: functions of asyncio that run a loop
_LOOPS: Final = frozenset({"run", "run_until_complete", "run_forever", "_run_once", "_run"})


def keep_alives(
    stall_limit: float, first: float | None = None, lag_limit: float | None = None
) -> Ticker:
    """Return the moments at which an event loop sends a keep-alive.

    Args:
        stall_limit: seconds without one after which its program counts as hung.
        first: when the first one was due [s of `time.monotonic`]; None for now.
        lag_limit: seconds without one after which the loop counts as blocked; None for no limit.
    """
    period = min(stall_limit / _SIGNS, _SIGN_EVERY)
    if lag_limit is not None:
        period = min(period, lag_limit / _SIGNS_PER_LAG)
    return every(period, first)


class Liveness:
    """When the event loop last ran, and whether its program moves the arm.

    Written by the loop, read by any thread. The heartbeat's thread, and the guard, stop the arm of
    a program that hangs or has exited. If a program dies that only observed the arm, they must not
    stop the motions of another program: so each program says so before it sends anything that may
    move the arm, and when the arm was seen to stand and nothing that it started still runs.

    Args:
        passed_on: passes the stamp, whether the program may be moving the arm, and its modes on to
            the guard. It returns whether that was possible. None: no guard.
    """

    __slots__ = ("_passed_on", "longest_stall", "modes", "moves", "ran", "stamp")

    def __init__(self, passed_on: Callable[[float, bool, Endings], bool] | None = None) -> None:
        self._passed_on = passed_on
        #: when the loop last ran [s of `time.monotonic`]
        self.ran: float = time.monotonic()
        #: the last keep-alive that counts [s of `boot_time`]: after a hang, none does until the
        #: program rearms the heartbeat
        self.stamp: float = boot_time()
        #: longest delay of a keep-alive [s]
        self.longest_stall: float = 0.0
        #: whether the program may be moving the arm: only then the arm is stopped for the program
        self.moves: bool = False
        #: what ends the modes that the program has entered, which a stop leaves on
        self.modes: Endings = ()

    def touch(self, due: float, *, counts: bool = True) -> None:
        """Note that the loop runs.

        Args:
            due: when this keep-alive was due [s of `time.monotonic`].
            counts: whether it is a keep-alive for the heartbeat.
        """
        now = time.monotonic()
        # the first one is due before the robot was opened: `on_grid`
        self.longest_stall = max(self.longest_stall, now - max(due, self.ran))
        self.ran = now
        if counts:
            self.stamp = boot_time()
        self._pass_on()

    def will_move(self, name: str) -> None:
        """Note that the program may move the arm, before a command is sent that may do so.

        It is passed on each time, because the guard may be a new one.

        Args:
            name: name of the command.

        Raises:
            GuardLost: no guard would stop the arm for the program; the command must not be sent.
        """
        self.moves = True
        if not self._pass_on():
            raise GuardLost(
                f"{name} was not sent: the guard is gone or does not read, and would not stop the "
                "arm if this program died. If it is gone, another guard is being started: try "
                "again, or connect without a guard"
            )

    def in_modes(self, endings: Endings) -> None:
        """Note what ends the modes that the program is about to enter, or has not left."""
        self.modes = endings
        self._pass_on()

    def at_rest(self) -> None:
        """Note that the arm stands, and that nothing that this program started still runs."""
        self.moves = False
        self._pass_on()

    def _pass_on(self) -> bool:
        return self._passed_on is None or self._passed_on(self.stamp, self.moves, self.modes)


class LoopWatchdog:
    """Watches the loop of one thread for all robots on it: a block affects all of them.

    Args:
        loop_thread: identifier of the loop's thread.
    """

    def __init__(self, loop_thread: int) -> None:
        self._loop_thread = loop_thread
        #: keep-alives of the robots, each with its limit and its callback; replaced as a whole
        self._watched: dict[Liveness, tuple[float, Callable[[float, str], None]]] = {}
        self._changed = Wakeup()
        self._thread = threading.Thread(target=self._run, name="aioduco-loop-watchdog", daemon=True)

    def add(self, life: Liveness, limit: float, blocked: Callable[[float, str], None]) -> None:
        """Add a robot; `_Watchdogs.watch` describes it."""
        first = not self._watched
        self._watched = {**self._watched, life: (limit, blocked)}
        if first:
            try:
                self._thread.start()
            except BaseException:
                self._watched = {}
                raise

    def remove(self, life: Liveness) -> bool:
        """Remove a robot. Returns whether none is left, so that the thread ends."""
        self._watched = {one: how for one, how in self._watched.items() if one is not life}
        if self._watched:
            return False
        self._changed.set()
        return True

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end. Returns whether it ended."""
        self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while watched := self._watched:
            stamp = max(life.ran for life in watched)
            limit = min(limit for limit, _ in watched.values())
            if self._changed.wait(max(0.0, stamp + limit - time.monotonic())):
                return
            if self._latest() != stamp:
                continue
            # Now, while it is blocked: afterwards the blocking line cannot be found.
            line, stack = blocking_calls(sys._current_frames().get(self._loop_thread))
            while self._latest() <= stamp:  # below it: the robot that it was of has been left
                if self._changed.wait(limit / 4):
                    return
            self._report(self._latest() - stamp, line, stack)

    def _latest(self) -> float:
        return max((life.ran for life in self._watched), default=0.0)

    def _report(self, seconds: float, line: str, stack: str) -> None:
        for limit, blocked in self._watched.values():
            if seconds > limit:
                blocked(seconds, line)
        if line:
            _log.warning("the event loop was blocked for %.2f s by %s", seconds, line)
        else:
            _log.warning(
                "the event loop did not get to run for %.2f s: the computer was busy, or another "
                "thread of this program",
                seconds,
            )
        if stack:
            _log.debug("while the event loop did not run, its thread was in:\n%s", stack)


class _Watchdogs:
    """The watchdogs of this process, one per thread with an event loop."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._by_thread: dict[int, LoopWatchdog] = {}
        fork_hooks.add(self)

    def forked(self) -> None:
        """Start anew in a forked child: no watchdog runs there, and no thread frees the lock."""
        self._lock = threading.Lock()
        self._by_thread = {}

    def watch(
        self, life: Liveness, limit: float, blocked: Callable[[float, str], None]
    ) -> Callable[[float], None]:
        """Watch the loop of the calling thread for a robot.

        Args:
            life: the loop's keep-alive.
            limit: seconds without a keep-alive after which the loop counts as blocked.
            blocked: called on the watchdog's thread when the loop runs again, with the duration of
                the block [s] and the line of the program that blocked, or "".

        Returns:
            Ends that; waits so many seconds for the thread's end if no robot is left.
        """
        thread = threading.get_ident()
        with self._lock:
            watchdog = self._by_thread.get(thread) or LoopWatchdog(thread)
            watchdog.add(life, limit, blocked)
            self._by_thread[thread] = watchdog

        def leave(timeout: float) -> None:
            with self._lock:
                if not watchdog.remove(life):
                    return
                if self._by_thread.get(thread) is watchdog:
                    del self._by_thread[thread]
            watchdog.join(timeout)

        return leave


#: one per process: a loop's thread is inspected once for all robots on it
watchdogs: Final = _Watchdogs()


def blocking_calls(frame: FrameType | None) -> tuple[str, str]:
    """Return what a loop's thread runs.

    Returns:
        The innermost line of the program: file, number, function and text; empty if only asyncio, a
        library or this package ran, as on a busy computer. And the innermost calls, as Python
        prints them; empty if the thread is idle.
    """
    if frame is None:
        return "", ""
    try:
        stack = traceback.extract_stack(frame)
        # A loop that waits in its selector is not blocked, but starved: by the GIL or the machine.
        if stack and stack[-1].name in {"select", "poll"}:
            return "", ""
        return _line(stack), "".join(traceback.format_list(stack[-_DEPTH:]))
    except Exception as exc:  # the program's own module loaders give the lines, and may fail
        return "", f"(its call stack cannot be read: {type(exc).__name__})\n"


def _line(stack: traceback.StackSummary) -> str:
    """Return the innermost line of the program among the calls that the loop made; or ""."""
    from aioduco._process.program_lines import of_program  # noqa: PLC0415 - of a block alone

    calls: list[traceback.FrameSummary] = []
    for call in stack:
        calls.append(call)
        if call.name in _LOOPS and Path(call.filename).parent.name == "asyncio":
            calls.clear()  # these only run the loop
    for call in reversed(calls):
        if of_program(call.filename):
            return f"{call.filename}:{call.lineno}, in {call.name}: {call.line}".removesuffix(": ")
    return ""
