"""Work in slices: a long plan lets others have their turn in between.

Planning runs beside the controller's cycles and commands. What plans calls its `turn` between two
slices of the work; who runs it lets others go on there, and drops a plan that nobody waits for any
more by raising `PlanDropped`. How long a path is cut depends on the path alone, never on the time
that a slice takes, so a plan comes out the same on every machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from aioduco.models.rotation import Array

__all__ = ["LONG_SLICE", "SLICE", "PlanDropped", "Turn", "listed", "no_turn", "slices"]

Turn: TypeAlias = Callable[[], None]

#: samples or nodes of a path that are worked at between two turns
SLICE = 64
#: the same for what is but a few operations on each
LONG_SLICE = 512


class PlanDropped(Exception):
    """Nobody waits for a plan any more; not an error of what plans, which must let it through."""


def no_turn() -> None:
    """Go on at once: nobody else has to have a turn."""


def slices(count: int, turn: Turn, size: int = SLICE) -> Iterator[slice]:
    """Cut so many samples into slices, with a turn after each.

    Args:
        count: of the samples.
        turn: called after each slice.
        size: of a slice.
    """
    for begin in range(0, count, size):
        yield slice(begin, min(begin + size, count))
        turn()


def listed(values: Array, turn: Turn) -> list[float]:
    """Give an array as a list, with a turn after each of its slices. Shape (n,)."""
    numbers: list[float] = []
    for part in slices(len(values), turn, 8 * LONG_SLICE):
        numbers += values[part].tolist()
    return numbers
