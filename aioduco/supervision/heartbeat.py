"""The heartbeat, on a thread and a connection of its own (manual 1.3.1, rpc_heartbeat).

It runs beside the event loop, so that a short stall of the loop does not stop the arm. It checks
the loop's keep-alive before each beat, so that a loop that hangs does stop the arm.

The controller stops the arm when no heartbeat came for the heartbeat time. So each beat states:
"the program that moves the arm is alive". The beats end in two cases:

- The event loop sends no keep-alive for longer than the stall limit. The program hangs, and
  would neither detect the end of a motion nor react to anything. No further beat is sent, so the
  controller stops the arm. This state is latched: a program that runs again finds a standing arm,
  and must resume the heartbeat explicitly (`rearm`).
- No beat was answered for the heartbeat time: the connection is lost, and the controller has
  stopped the arm. Further beats are tried, and the first answered one ends this state.

A process that sends beats for another process may itself be suspended, and the other process may
exit meanwhile. So after a suspension it sends beats again only after a new keep-alive.

Guarantees:
- The thread is a daemon: a program that exits without closing the robot does not send further
  beats.
- Each beat has a deadline, a third of the heartbeat time; a late beat is given up, and the next
  one uses a fresh connection.
- Other code waits for this thread only when it ends, which is immediate: `end` wakes the thread
  and interrupts its call.
"""

from __future__ import annotations

import math
import threading
import time
from enum import Enum
from typing import TYPE_CHECKING, NamedTuple

from aioduco._process.platform import boot_time
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.wakeup import Wakeup
from aioduco._wire.way_out import EMPTIES
from aioduco.errors import DucoError

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.own_connection import OwnConnection
    from aioduco.supervision.loop_watchdog import Liveness


_log = BackgroundLogger(__name__)


class HeartbeatState(Enum):
    """State of the heartbeat (心跳)."""

    OFF = "off"
    """There is none: a lost connection stops nothing."""
    STARTING = "starting"
    """No beat was answered yet."""
    BEATING = "beating"
    """Beats are answered."""
    LOST = "lost"
    """No beat was answered for the heartbeat time: the controller has stopped the arm."""
    STALLED = "stalled"
    """The event loop hung, and beats were withheld: the controller has stopped the arm."""


#: beats per heartbeat time: two may be lost before the controller stops the arm
BEATS_PER_TIME = 3
#: part of the time between beats after which an unanswered beat is repeated
_AGAIN = 0.25
#: seconds after the stall limit at which it is checked whether it has passed
_LATER = 0.001
#: heartbeat times without a beat after which the controller has stopped the arm for certain
_CERTAIN = 2


class HeartbeatMachine:
    """Decides when a beat is due and whether it may be sent, and keeps the heartbeat's state.

    Args:
        time: seconds without a beat after which the controller stops the arm.
        stall_limit: seconds without a keep-alive of the event loop after which no beat is sent.
        now: the time.

    Attributes:
        every: seconds between two beats.
        due: when the next beat is due.
        given: when the last beat was given to the controller at the latest.
        state: the state of the heartbeat.
        beats: beats that were answered.
        missed: beats that were not answered.
        losses: how often the heartbeat was lost.
        stalls: how often the event loop stalled.
        longest_gap: longest time between two answered beats in a row [s].
        suspended_at: when the sender of the beats was last found to have been suspended; minus
            infinity: never.
    """

    def __init__(self, time: float, stall_limit: float, now: float) -> None:
        self._time = time
        self._stall_limit = stall_limit
        self._beaten = now
        self.every: float = time / BEATS_PER_TIME
        self.due: float = now
        self.given: float = -math.inf
        self.state: HeartbeatState = HeartbeatState.STARTING
        self.beats: int = 0
        self.missed: int = 0
        self.losses: int = 0
        self.stalls: int = 0
        self.longest_gap: float = 0.0
        self.suspended_at: float = -math.inf

    def wakes_at(self, alive: float) -> float:
        """Return when to look again: the next beat is due then, or a keep-alive overdue.

        Args:
            alive: when the event loop last sent a keep-alive.
        """
        if self.state is HeartbeatState.STALLED:
            return self.due
        return min(self.due, max(alive, self.suspended_at) + self._stall_limit + _LATER)

    def woken(self, now: float, planned: float) -> None:
        """Note when the sender of the beats has woken up, and when it was to: was it suspended?"""
        if now - planned > self._time:
            self.suspended(now)

    def plan_next(self, now: float) -> None:
        """Note that a beat is sent or withheld: beats whose time has passed are skipped."""
        self.due = max(self.due + self.every, now)

    def lapsed(self, now: float) -> bool:
        """Whether no beat was given for so long that the controller has stopped the arm."""
        return self.beats > 0 and now - self.given > _CERTAIN * self._time

    def may_beat(self, now: float, alive: float) -> bool:
        """Whether a beat may be sent now.

        Args:
            now: the time.
            alive: when the event loop last sent a keep-alive.
        """
        if self.state is HeartbeatState.STALLED:
            return False
        if now - max(alive, self.suspended_at) > self._stall_limit:
            self.state = HeartbeatState.STALLED
            self.stalls += 1
            return False
        return alive > self.suspended_at

    def suspended(self, now: float) -> None:
        """Note that the sender of the beats was suspended longer than the heartbeat time."""
        self.suspended_at = now
        self._note_loss(now)

    def beaten(self, now: float) -> None:
        """Note that a beat was answered."""
        if self.beats:
            self.longest_gap = max(self.longest_gap, now - self._beaten)
        self.beats += 1
        self._beaten = now
        if self.state is not HeartbeatState.STALLED:
            self.state = HeartbeatState.BEATING

    def missed_beat(self, now: float) -> None:
        """Note that a beat was not answered: it is repeated soon."""
        self.missed += 1
        self.due = min(self.due, now + self.every * _AGAIN)
        self._note_loss(now)

    def _note_loss(self, now: float) -> None:
        if self.state is HeartbeatState.BEATING and now - self._beaten > self._time:
            self.state = HeartbeatState.LOST
            self.losses += 1

    def rearm(self) -> None:
        """Resume after a stall, on request of the program."""
        if self.state is HeartbeatState.STALLED:
            self.state = HeartbeatState.STARTING


class HeartbeatStatistics(NamedTuple):
    """Statistics of the heartbeat.

    Attributes:
        state: state of the heartbeat.
        beats: beats that were answered.
        missed: beats that were not answered in time.
        losses: how often no beat was answered for the heartbeat time.
        stalls: how often beats were withheld because the event loop hung.
        longest_gap: longest time between two answered beats in a row [s].
    """

    state: HeartbeatState
    beats: int
    missed: int
    losses: int
    stalls: int
    longest_gap: float


class Heartbeat:
    """Sends beats from a thread of its own until it is ended.

    Args:
        own: the connection on which it sends them.
        seconds: seconds without a beat after which the controller stops the arm.
        liveness: the event loop's keep-alive.
        stall_limit: seconds without a keep-alive after which no beat is sent.
        changed: called on the thread after each beat, answered or not, and each change of state.
        remote: whether the keep-alives come from another process. If this process was suspended,
            signs from before prove nothing, so the next beat waits for a new one.
    """

    def __init__(
        self,
        own: OwnConnection,
        seconds: float,
        liveness: Liveness,
        stall_limit: float,
        changed: Callable[[Heartbeat], object],
        *,
        remote: bool = False,
    ) -> None:
        self._own = own
        self._seconds = seconds
        self._liveness = liveness
        self._changed = changed
        self._remote = remote
        #: when the last beat that was answered was sent [s of `boot_time`]; 0 before
        self.sent: float = 0.0
        self._machine = HeartbeatMachine(seconds, stall_limit, boot_time())
        self._ended = False
        self._nudge = Wakeup()
        #: why the last beat was not answered; None if it was
        self.error: DucoError | None = None
        self._thread = threading.Thread(target=self._run, name="aioduco-heartbeat", daemon=True)

    def __repr__(self) -> str:
        return f"<Heartbeat {self._seconds} s {self.state.value}, {self._machine.beats} beats>"

    @property
    def state(self) -> HeartbeatState:
        """State of the heartbeat."""
        return self._machine.state

    def statistics(self) -> HeartbeatStatistics:
        """Return statistics since the heartbeat began."""
        machine = self._machine
        return HeartbeatStatistics(
            *(getattr(machine, each) for each in HeartbeatStatistics._fields)
        )

    @property
    def lapsed(self) -> bool:
        """Whether no beat was sent for so long that the controller has stopped the arm by itself.

        Any movement of the arm after that is a new motion, not one from before.
        """
        return self._machine.lapsed(boot_time())

    def start(self) -> None:
        """Start to send beats."""
        self._liveness.touch(time.monotonic())
        self._thread.start()

    def rearm(self) -> None:
        """Resume the beats after a stall of the event loop: the next beat is sent at once."""
        self._liveness.touch(time.monotonic())
        self._machine.rearm()
        self._nudge.set()

    def end(self) -> None:
        """Stop sending beats; a beat that is in progress is interrupted."""
        self._ended = True
        self._nudge.set()
        self._own.give_up("the heartbeat ends")

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end. Returns whether it ended."""
        if self._thread.ident is not None:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        machine = self._machine
        try:
            while True:
                planned = machine.wakes_at(self._liveness.stamp)
                nudged = self._nudge.wait(max(0.0, planned - boot_time()))
                if self._ended:
                    return
                now, before = boot_time(), machine.state
                if self._remote:
                    machine.woken(now, planned)
                may = machine.may_beat(now, self._liveness.stamp)
                if machine.state is HeartbeatState.STALLED and before is not machine.state:
                    # Before the stop: a program that sees the arm stand must know why, and sends
                    # no further motion.
                    self._changed(self)
                    self._stop_stalled()
                elif not nudged and now < machine.due:
                    continue
                else:
                    machine.plan_next(now)
                    if may:
                        self._beat()
                if machine.state is not before:
                    self._report(before)
                self._changed(self)
        finally:
            self._own.close()

    def _stop_stalled(self) -> None:
        """Stop the arm at once if the event loop hangs; the missing beats would stop it later.

        The modes that a stop leaves on, such as hand guiding, are ended, and their queues emptied:
        the program cannot.
        """
        if not self._liveness.moves or self.lapsed:
            return
        modes = self._liveness.modes
        emptied = [(EMPTIES[name], ()) for name, _ in modes if name in EMPTIES]
        for name, args in (("stop", (False,)), *modes, *emptied):
            try:
                self._own.call(name, tuple(args), self._machine.every)
            except DucoError as exc:
                self._own.close()
                self.error = exc
                _log.error("the event loop hangs, and %s failed: the arm may move: %s", name, exc)

    def _beat(self) -> None:
        until = time.monotonic() + self._machine.every
        try:
            line = self._own.ready(until)
            left = max(until - time.monotonic(), 0.001)
            sent = boot_time()
            try:
                line.call("rpc_heartbeat", (round(self._seconds * 1000),), left)
            finally:
                self._machine.given = boot_time()
        except DucoError as exc:
            self._own.close()
            self.error = exc
            if not self._ended:
                self._machine.missed_beat(boot_time())
                _log.debug("heartbeat not answered: %s", exc)
        else:
            self.error = None
            self.sent = sent
            self._machine.beaten(boot_time())

    def _report(self, before: HeartbeatState) -> None:
        match self._machine.state:
            case HeartbeatState.STALLED:
                stall = boot_time() - self._liveness.stamp
                _log.error(
                    "the event loop has not run for %.2f s: %sthe heartbeat is withheld. "
                    "Call robot.rearm_heartbeat() to go on",
                    *(stall, "the arm is stopped, and " if self._liveness.moves else ""),
                )
            case HeartbeatState.LOST:
                _log.error(
                    "no heartbeat was answered for %g s: the controller stops the arm",
                    self._seconds,
                )
            case HeartbeatState.BEATING if before is HeartbeatState.LOST:
                _log.warning("the heartbeat is answered again")
