"""Motions that go on until something ends them: velocities, jogs, hand guiding."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["BRAKING", "STOOD", "Held"]

#: seconds after its time for which a motion may still slow down before it is stopped
BRAKING = 2.0
#: seconds for which the arm must have stood before a motion whose task the controller has ended
#: before its time counts as over: it may not have begun to move
STOOD = 0.25


@dataclass(frozen=True, slots=True)
class Held:
    """How a motion that goes on comes to its end.

    The controller may end the task of such a motion as soon as it has begun ("the function
    returns and the next is carried out", manual 1.3.5, speedj), or when it is over: the manual
    does not say. So the end of the task is not taken for the end of the motion: that is when the
    arm stands.

    Attributes:
        ending: the function of the wire that ends it.
        time: seconds after which it ends by itself; None if it does not.
        timed_here: whether this program sees to that, since the wire has no such time.
        until_told: whether it goes on even if the arm stands, as hand guiding does.
    """

    ending: str
    time: float | None = None
    timed_here: bool = False
    until_told: bool = False

    @property
    def mode(self) -> bool:
        """Whether it is a mode that a stop may leave on, and that its own function ends."""
        return self.until_told and self.ending != "stop"

    @property
    def limit(self) -> float | None:
        """Seconds after which the arm is stopped; None for no limit."""
        return None if self.time is None else self.time + BRAKING
