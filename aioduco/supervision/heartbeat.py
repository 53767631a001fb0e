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
        self.stamp = time.monotonic()
        #: how late the latest sign of life came [s]
        self.longest_stall = 0.0

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


class Heartbeat:
    """Beats from a thread of its own until it is ended.

    Args:
        connect: makes a connection that is not open yet.
        seconds: without a beat for this long, the controller stops the arm.
        life: the event loop's sign of life.
        stall_limit: seconds without a sign of life after which no beat is sent.
    """

    def __init__(
        self, connect: Callable[[], Line], seconds: float, life: SignOfLife, stall_limit: float
    ) -> None:
        self._connect = connect
        self._seconds = seconds
        self._life = life
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
                self._nudge.wait(max(0.0, due - time.monotonic()))
                self._nudge.clear()
                if self._ended:
                    return
                now = time.monotonic()
                # An absolute schedule; beats whose time has passed are left out.
                due = max(due + every, now)
                before = self._pulse.state
                if self._pulse.may_beat(now, self._life.stamp) and not self._beat(every):
                    due = min(due, time.monotonic() + every * _AGAIN)
                if self._pulse.state is not before:
                    self._report(before)
        finally:
            self._drop()

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
                    "the event loop has not run for %.2f s: the heartbeat is withheld, and the "
                    "controller stops the arm. Call robot.rearm_heartbeat() to go on",
                    stall,
                )
            case HeartbeatState.LOST:
                _log.error(
                    "no heartbeat was answered for %g s: the controller stops the arm",
                    self._seconds,
                )
            case HeartbeatState.BEATING if before is HeartbeatState.LOST:
                _log.warning("the heartbeat is answered again")
