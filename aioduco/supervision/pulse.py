"""Whether the heart may beat, and whether it is heard: a state machine without a thread or clock.

The controller stops the arm when no heartbeat came for the heartbeat time. So a beat is a
statement: "the program that moves the arm is alive". Two things end it:

- The event loop shows no sign of life for longer than the stall limit. The program hangs, and
  would neither see an end of a motion nor react to anything. No further beat is sent, so the
  controller stops the arm. This state is latched: a program that wakes up again finds a standing
  arm and has to say that it goes on (`rearm`).
- No beat was answered for the heartbeat time: the connection is lost, and the controller has
  stopped the arm. Beats are tried on, and the first one answered ends this state.
"""

from __future__ import annotations

from enum import Enum

__all__ = ["HeartbeatState", "Pulse"]


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


class Pulse:
    """Decides over each beat.

    Args:
        time: seconds without a beat after which the controller stops the arm.
        stall_limit: seconds without a sign of life of the event loop after which no beat is sent.
        now: the time.

    Attributes:
        state: the state of the heartbeat.
        beats: beats that were answered.
        missed: beats that were not.
        losses: how often the heartbeat was lost.
        stalls: how often the event loop stalled.
        longest_gap: longest time between two answered beats in a row [s].
    """

    __slots__ = (
        "_beaten",
        "_stall_limit",
        "_time",
        "beats",
        "longest_gap",
        "losses",
        "missed",
        "stalls",
        "state",
    )

    def __init__(self, time: float, stall_limit: float, now: float) -> None:
        self._time = time
        self._stall_limit = stall_limit
        self._beaten = now
        self.state: HeartbeatState = HeartbeatState.STARTING
        self.beats: int = 0
        self.missed: int = 0
        self.losses: int = 0
        self.stalls: int = 0
        self.longest_gap: float = 0.0

    def may_beat(self, now: float, alive: float) -> bool:
        """Whether a beat may be sent now.

        Args:
            now: the time.
            alive: when the event loop last gave a sign of life.
        """
        if self.state is HeartbeatState.STALLED:
            return False
        if now - alive > self._stall_limit:
            self.state = HeartbeatState.STALLED
            self.stalls += 1
            return False
        return True

    def beaten(self, now: float) -> None:
        """A beat was answered."""
        if self.beats:
            self.longest_gap = max(self.longest_gap, now - self._beaten)
        self.beats += 1
        self._beaten = now
        if self.state is not HeartbeatState.STALLED:
            self.state = HeartbeatState.BEATING

    def not_heard(self, now: float) -> None:
        """A beat was not answered."""
        self.missed += 1
        if self.state is HeartbeatState.BEATING and now - self._beaten > self._time:
            self.state = HeartbeatState.LOST
            self.losses += 1

    def rearm(self) -> None:
        """The program says that it goes on after a stall."""
        if self.state is HeartbeatState.STALLED:
            self.state = HeartbeatState.STARTING
