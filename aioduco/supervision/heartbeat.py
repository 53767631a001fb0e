"""The heartbeat: a thread and a connection of its own (manual 1.3.1, rpc_heartbeat).

It runs beside the event loop so that a short stall of the loop does not stop the arm, and asks
the loop for a sign of life before each beat so that a hung one does.

Guarantees:
- The thread is a daemon: a program that ends without closing the robot does not go on beating.
- Each beat has a deadline, a third of the heartbeat time; a late one is given up, and the next
  goes over a fresh connection.
- Nothing waits for this thread but its end, which comes at once: `end` wakes it and cuts the
  call that it is in.
"""

from __future__ import annotations

import logging
import threading
import time
from typing import TYPE_CHECKING, NamedTuple, Protocol

from aioduco.errors import DucoError
from aioduco.supervision.pulse import HeartbeatState, Pulse

if TYPE_CHECKING:
    from collections.abc import Callable

_log = logging.getLogger(__name__)

#: beats per heartbeat time: two may be lost before the controller stops the arm
BEATS_PER_TIME = 3
#: part of the time between beats after which one that was not answered is repeated
_AGAIN = 0.25
#: seconds after the stall limit at which it is looked whether it has passed
_LATER = 0.001


class Line(Protocol):
    """What the heartbeat needs of a connection."""

    def open(self, deadline: float | None = None) -> None:
        """Connect; the calling thread becomes the owner."""
        ...

    def call(self, name: str, args: tuple[object, ...], timeout: float | None) -> object:
        """Call a function and wait for its answer."""
        ...

    def abandon(self, reason: str = ...) -> None:
        """Wake a call that is under way, from any thread."""
        ...

    def close(self) -> None:
        """Close the connection."""
        ...


class SignOfLife:
    """When the event loop was last seen to run. Written by the loop, read by any thread."""

    __slots__ = ("longest_stall", "stamp")

    def __init__(self) -> None:
        self.stamp: float = time.monotonic()
        #: how late the latest sign of life came [s]
        self.longest_stall: float = 0.0

    def touch(self, due: float) -> None:
        """The loop runs; `due` is when this sign of life was to be given."""
        self.stamp = time.monotonic()
        self.longest_stall = max(self.longest_stall, self.stamp - due)


class HeartbeatStatistics(NamedTuple):
    """Figures of the heartbeat.

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


class Heart(Protocol):
    """A heartbeat as the supervision sees it: of this program, or of its guard."""

    @property
    def state(self) -> HeartbeatState:
        """State of the heartbeat."""
        ...

    @property
    def heard(self) -> bool:
        """Whether a beat was answered, and no later one was lost."""
        ...

    @property
    def error(self) -> DucoError | None:
        """Why the last beat was not answered; None if it was."""
        ...

    def start(self) -> None:
        """Begin to beat."""
        ...

    def statistics(self) -> HeartbeatStatistics:
        """Figures since the heartbeat began."""
        ...

    def rearm(self) -> None:
        """Go on beating after a stall of the event loop."""
        ...

    def end(self) -> None:
        """Beat no more."""
        ...

    def join(self, timeout: float) -> bool:
        """Wait until nothing of it runs any more. Returns whether that is so."""
        ...


class Heartbeat:
    """Beats from a thread of its own until it is ended.

    Args:
        connect: makes a connection that is not open yet.
        seconds: without a beat for this long, the controller stops the arm.
        life: the event loop's sign of life.
        stall_limit: seconds without a sign of life after which no beat is sent.
        changed: called on the thread after each beat, answered or not, and each change of state.
    """

    def __init__(
        self,
        connect: Callable[[], Line],
        seconds: float,
        life: SignOfLife,
        stall_limit: float,
        changed: Callable[[Heartbeat], None] | None = None,
    ) -> None:
        self._connect = connect
        self._seconds = seconds
        self._life = life
        self._stall_limit = stall_limit
        self._changed = changed
        self._pulse = Pulse(seconds, stall_limit, time.monotonic())
        self._line: Line | None = None
        self._ended = False
        self._nudge = threading.Event()
        self._error: DucoError | None = None
        self._thread = threading.Thread(target=self._run, name="aioduco-heartbeat", daemon=True)

    def __repr__(self) -> str:
        return f"<Heartbeat {self._seconds} s {self.state.value}, {self._pulse.beats} beats>"

    @property
    def state(self) -> HeartbeatState:
        """State of the heartbeat."""
        return self._pulse.state

    def statistics(self) -> HeartbeatStatistics:
        """Figures since the heartbeat began."""
        pulse = self._pulse
        return HeartbeatStatistics(
            pulse.state, pulse.beats, pulse.missed, pulse.losses, pulse.stalls, pulse.longest_gap
        )

    def start(self) -> None:
        """Begin to beat."""
        self._life.touch(time.monotonic())
        self._thread.start()

    @property
    def heard(self) -> bool:
        """Whether a beat was answered since `start` or `rearm`, and no later one was lost."""
        return self._pulse.state is HeartbeatState.BEATING

    @property
    def error(self) -> DucoError | None:
        """Why the last beat was not answered; None if it was."""
        return self._error

    def rearm(self) -> None:
        """Go on beating after a stall of the event loop: the next beat goes at once."""
        self._life.touch(time.monotonic())
        self._pulse.rearm()
        self._nudge.set()

    def end(self) -> None:
        """Beat no more; a beat that is under way is cut."""
        self._ended = True
        self._nudge.set()
        line = self._line
        if line is not None:
            line.abandon("the heartbeat ends")

    def join(self, timeout: float) -> bool:
        """Wait for the thread's end. Returns whether it ended."""
        if self._thread.ident is not None:
            self._thread.join(timeout)
        return not self._thread.is_alive()

    def _run(self) -> None:
        every = self._seconds / BEATS_PER_TIME
        due = time.monotonic()
        try:
            while True:
                nudged = self._nudge.wait(max(0.0, self._wake(due) - time.monotonic()))
                self._nudge.clear()
                if self._ended:
                    return
                now = time.monotonic()
                before = self._pulse.state
                may = self._pulse.may_beat(now, self._life.stamp)
                if self._pulse.state is HeartbeatState.STALLED and before is not self._pulse.state:
                    self._stop_stalled(every)
                elif not nudged and now < due:
                    continue
                else:
                    # An absolute schedule; beats whose time has passed are left out.
                    due = max(due + every, now)
                    if may and not self._beat(every):
                        due = min(due, time.monotonic() + every * _AGAIN)
                if self._pulse.state is not before:
                    self._report(before)
                if self._changed is not None:
                    self._changed(self)
        finally:
            self._drop()

    def _wake(self, due: float) -> float:
        """When to look again: for the next beat, or for a sign of life that does not come."""
        if self._pulse.state is HeartbeatState.STALLED:
            return due
        return min(due, self._life.stamp + self._stall_limit + _LATER)

    def _stop_stalled(self, deadline: float) -> None:
        """The event loop hangs: stop the arm at once; the heartbeat's end would do it later."""
        try:
            if self._line is None:
                self._line = self._connect()
                self._line.open(time.monotonic() + deadline)
            self._line.call("stop", (False,), deadline)
        except DucoError as exc:
            self._drop()
            self._error = exc
            _log.error("the event loop hangs, and the arm could not be stopped at once: %s", exc)

    def _beat(self, deadline: float) -> bool:
        until = time.monotonic() + deadline
        try:
            if self._line is None:
                self._line = self._connect()
                if self._ended:  # `end` came before it could see the line
                    return False
                self._line.open(until)
            left = max(until - time.monotonic(), 0.001)
            self._line.call("rpc_heartbeat", (round(self._seconds * 1000),), left)
        except DucoError as exc:
            self._drop()
            self._error = exc
            if not self._ended:
                self._pulse.not_heard(time.monotonic())
                _log.debug("heartbeat not answered: %s", exc)
        else:
            self._error = None
            self._pulse.beaten(time.monotonic())
        return self._error is None

    def _drop(self) -> None:
        line, self._line = self._line, None
        if line is not None:
            line.close()

    def _report(self, before: HeartbeatState) -> None:
        match self._pulse.state:
            case HeartbeatState.STALLED:
                stall = time.monotonic() - self._life.stamp
                _log.error(
                    "the event loop has not run for %.2f s: the arm is stopped, and the "
                    "heartbeat withheld. Call robot.rearm_heartbeat() to go on",
                    stall,
                )
            case HeartbeatState.LOST:
                _log.error(
                    "no heartbeat was answered for %g s: the controller stops the arm",
                    self._seconds,
                )
            case HeartbeatState.BEATING if before is HeartbeatState.LOST:
                _log.warning("the heartbeat is answered again")
