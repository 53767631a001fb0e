"""What to do about a motion that was sent and not answered: without socket, thread or clock.

Such a motion may reach the controller at any later time: its bytes may wait in this system, in a
switch, in a proxy, or in the controller, which may have taken them and not read them yet. The arm
would then begin to move unexpectedly. So its sender stops the arm, and goes on watching
it until one of these is certain:

- The answer came. The controller has the motion, and a stop that was sent after the answer ends it.
- Nothing of it is left in this system, and a path that delivered a stop since then delivered
  nothing else for as long as the stop took.

Why that long: what held back the stop for some time may hold back an older packet for as long
again, on another queue of the same path. It is bounded on both sides: the fast paths of a local
network are covered by `SHORTEST`, and after `LONGEST` a packet that is still on its way is beyond
what a network does. A proxy can hold bytes longer than that, and a controller can read them later;
both acknowledge them, so that their answer is waited for, up to a limit.
"""

from __future__ import annotations

import enum
from typing import Final

__all__ = ["LONGEST", "SHORTEST", "NextStep", "UnansweredMotion"]

#: seconds for which the arm is watched at least, after a stop that was accepted at once
SHORTEST: Final = 0.3
#: seconds for which it is watched at most
LONGEST: Final = 5.0
#: looks in a row that show a standing arm
_STANDING: Final = 2
#: seconds after which an arm that still moves is stopped once more
_STOP_AGAIN: Final = 0.5


class NextStep(enum.Enum):
    """What to do next."""

    STOP = "send a stop"
    LOOK = "ask whether the arm moves"
    DISSOLVE = "wait for no answer any more: dissolve the connection"
    DONE = "the motion cannot move the arm any more"
    GIVE_UP = "the time is over, and it may still move the arm"


class UnansweredMotion:
    """Decides what to do until an unanswered motion cannot move the arm any more.

    Times are seconds of one monotonic clock.

    Args:
        now: the time.
        answer_by: until when to wait for the answer.
        until: when to give up.
    """

    __slots__ = (
        "_answer_by",
        "_answered",
        "_dissolved",
        "_need",
        "_since",
        "_standing",
        "_stopped",
        "_until",
    )

    def __init__(self, now: float, answer_by: float, until: float) -> None:
        self._answer_by = answer_by
        self._until = until
        #: a stop must be sent at this time or later to count
        self._need = now
        self._answered = False
        #: since when nothing of it is in this system
        self._dissolved: float | None = None
        #: when the last stop was accepted
        self._stopped: float | None = None
        #: since when the arm has been looked at after that stop
        self._since = now
        self._standing = 0

    def __repr__(self) -> str:
        state = "answered" if self._answered else "dissolved" if self._dissolved else "open"
        return f"<UnansweredMotion {state}, seen standing {self._standing} times>"

    def answered(self, now: float) -> None:
        """Its answer has come: the controller has it, and stops that were sent before are void."""
        if not self._answered:
            self._answered = True
            self._again(now)

    def dissolved(self, now: float) -> None:
        """Its connection is gone, with whatever this system had not delivered."""
        if self._dissolved is None and not self._answered:
            self._dissolved = now
            self._again(now)

    def stopped(self, sent: float, now: float) -> None:
        """A stop was accepted.

        Args:
            sent: when it was sent.
            now: the time.
        """
        if sent >= self._need:
            self._stopped = self._since = now
            self._standing = 0

    def seen(self, now: float, *, moving: bool) -> None:
        """The controller answered whether the arm moves."""
        if not moving:
            self._standing += 1
        elif self._standing >= _STANDING or now - self._since > _STOP_AGAIN:
            self._again(now)
        else:
            self._standing = 0

    def unheard(self, now: float) -> None:
        """The controller did not answer whether the arm moves: another stop does no harm."""
        self._again(now)

    def step(self, now: float) -> NextStep:
        """What to do now."""
        if self._certain(now):
            return NextStep.DONE
        if now >= self._until:
            return NextStep.GIVE_UP
        if now >= self._answer_by and not self._answered and self._dissolved is None:
            return NextStep.DISSOLVE
        return NextStep.STOP if self._stopped is None else NextStep.LOOK

    def _certain(self, now: float) -> bool:
        if self._stopped is None or self._standing < _STANDING:
            return False
        if self._answered:
            return True
        if self._dissolved is None:
            return False
        took = self._stopped - self._dissolved
        return now - self._stopped >= min(max(took, SHORTEST), LONGEST)

    def _again(self, now: float) -> None:
        self._need = now
        self._stopped = None
        self._standing = 0
