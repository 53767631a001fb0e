"""What a task that follows targets is made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.sim.planner.follower import Follower

    Vector = NDArray[np.float64]

__all__ = ["Following"]


@dataclass(frozen=True, slots=True)
class Following:
    """One motion whose targets come while it runs.

    Two are equal when the later one can take over from the earlier one while that runs.

    Attributes:
        kind: what kind of motion it is: the function's name.
        make: makes the follower for the joints [rad] at which the arm stands. Shape (6,).
        aim: gives a follower of this kind its target; raises PlanError if there is none.
        alone: whether no other motion is taken while it runs.
        idle: whether it begins only where nothing else runs.
        settings: what must be equal for that.
    """

    kind: str
    make: Callable[[Vector], Follower] = field(compare=False)
    aim: Callable[[Any], None] = field(compare=False)
    alone: bool = field(default=False, compare=False)
    idle: bool = field(default=False, compare=False)
    settings: tuple[object, ...] = ()

    @classmethod
    def behind(cls, kind: str, make: Callable[[Vector], Follower]) -> Following:
        """One that waits for the motions before it, as those behind it do for it."""
        return cls(kind, make, _no_target, settings=(object(),))

    @classmethod
    def once(cls, kind: str, make: Callable[[Vector], Follower]) -> Following:
        """One that has the controller to itself: nothing else runs, waits or takes over."""
        return cls(kind, make, _no_target, alone=True, idle=True, settings=(object(),))


def _no_target(_follower: Follower) -> None:
    """It was made with all that it follows."""
