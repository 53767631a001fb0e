"""Procedure that brings the arm to rest: without socket, thread or clock.

It ends when the arm was seen to stand twice in a row. It may stop the arm again if that takes long.

A motion that was sent and not answered makes it longer. Such a motion may reach the controller at
any later time: its bytes may wait in this system, in a switch, in a proxy, or in the controller,
which may have received them and not read them yet. The arm would then start to move unexpectedly.
So the sender stops the arm, and watches it until one of these is certain:

- The answer has arrived. The controller has the motion, and a stop that was sent after the answer
  ends it.
- None of its bytes are left in this system. A stop was delivered since then, and after it the path
  delivered nothing else for as long as the stop took: a look that began after this time saw the arm
  stand.

The reason for this time: a delay that held back the stop may hold back an older packet for as long
again, in another queue of the same path. The time has two bounds: `MIN_WATCH` covers the fast paths
of a local network, and no network delays a packet for more than `MAX_WATCH`. A proxy can hold bytes
longer than that, and a controller can read them later. Both acknowledge the bytes, so the sender
waits for the answer, up to a limit.

It never gives up by the time alone: the program may have been suspended meanwhile. What it tried
last, after the time was over, must have failed.
"""

from __future__ import annotations

import enum
from typing import Final, Self

#: time between two polls whether the arm moves [s]
LOOK_EVERY: Final = 0.01
#: minimum time for which the arm must be watched after a stop was accepted [s]
MIN_WATCH: Final = 0.3
#: maximum time for which the arm must be watched after a stop was accepted [s]
MAX_WATCH: Final = 5.0
#: number of consecutive polls that must show a standing arm
_STANDING: Final = 2
#: seconds after which an arm that still moves is stopped again
_STOP_AGAIN: Final = 0.5


class NextStep(enum.Enum):
    """The next action of the sender."""

    STOP = "send a stop"
    LOOK = "ask whether the arm moves"
    RESET = "wait for no answer any more: reset the connection"
    DONE = "the motion cannot move the arm any more"
    GIVE_UP = "the time is over, and it may still move the arm"


class UnansweredMotion:
    """Decides on the next action until the arm stands and an unanswered motion cannot move it.

    Times are seconds of one monotonic clock.

    Args:
        now: the present time.
        answer_by: time until which to wait for the answer.
        until: time after which to give up.
    """

    __slots__ = (
        "_answer_by",
        "_answered",
        "_given_up",
        "_looked",
        "_reset_at",
        "_since",
        "_standing",
        "_stop_needed_since",
        "_stopped",
        "_stops",
        "_until",
    )

    def __init__(self, now: float, answer_by: float, until: float) -> None:
        self._answer_by = answer_by
        self._until = until
        #: only a stop that was sent at this time or later counts
        self._stop_needed_since = now
        self._answered = False
        #: time since which none of its bytes are left in this system
        self._reset_at: float | None = None
        #: time at which the last stop was accepted
        self._stopped: float | None = None
        #: time since which the arm has been watched after that stop
        self._since = now
        self._standing = 0
        #: when the last look began that saw the arm stand
        self._looked = now
        #: whether the arm may be stopped
        self._stops = True
        self._given_up = False

    @classmethod
    def none(cls, now: float, until: float, *, stops: bool) -> Self:
        """Make the procedure for an arm that was stopped, or stops by itself, with none on its way.

        Args:
            now: the present time.
            until: time after which to give up.
            stops: whether an arm that still moves is stopped again.
        """
        made = cls(now, now, until)
        made.answered(now)
        made.stopped(now, now)
        made._stops = stops
        return made

    def __repr__(self) -> str:
        state = "answered" if self._answered else "reset" if self._reset_at else "open"
        return f"<UnansweredMotion {state}, seen standing {self._standing} times>"

    def answered(self, now: float) -> None:
        """Record the answer: the controller has the motion, so earlier stops no longer count."""
        if not self._answered:
            self._answered = True
            self._require_stop(now)

    def connection_reset(self, now: float) -> None:
        """Record that the connection was reset, with all bytes not delivered by this system."""
        if self._reset_at is None and not self._answered:
            self._reset_at = now
            self._require_stop(now)

    def stopped(self, sent: float, now: float) -> None:
        """Record that a stop was accepted.

        Args:
            sent: time at which it was sent.
            now: the present time.
        """
        if sent >= self._stop_needed_since:
            self._stopped = self._since = now
            self._standing = 0

    def seen(self, asked: float, now: float, *, moving: bool) -> None:
        """Record the controller's answer whether the arm moves.

        Args:
            asked: time at which it was asked.
            now: the present time.
            moving: whether it moves.
        """
        if not moving:
            self._standing += 1
            self._looked = asked
            return
        self._given_up = asked >= self._until
        if self._standing >= _STANDING or now - self._since > _STOP_AGAIN:
            self._require_stop(now)
        else:
            self._standing = 0

    def poll_failed(self, asked: float, now: float) -> None:
        """Record that the controller did not answer: send another stop, which does no harm.

        Args:
            asked: time at which it was asked, or told to stop.
            now: the present time.
        """
        self._given_up = asked >= self._until
        self._require_stop(now)

    def step(self, now: float) -> NextStep:
        """Return the next action."""
        if self._certain():
            return NextStep.DONE
        if self._given_up:
            return NextStep.GIVE_UP
        if now >= self._answer_by and not self._answered and self._reset_at is None:
            return NextStep.RESET
        return NextStep.STOP if self._stopped is None else NextStep.LOOK

    def _certain(self) -> bool:
        if self._stopped is None or self._standing < _STANDING:
            return False
        if self._answered:
            return True
        if self._reset_at is None:
            return False
        took = self._stopped - self._reset_at
        return self._looked - self._stopped >= min(max(took, MIN_WATCH), MAX_WATCH)

    def _require_stop(self, now: float) -> None:
        self._standing = 0
        if self._stops:
            self._stop_needed_since = now
            self._stopped = None
