"""Whether the arm began to move after the program was told that it would not."""

from __future__ import annotations

from collections.abc import Sequence

from .lines import Line


def first_told(program: Sequence[Line], ended: float) -> float:
    """When the program knew: it was told something of its motion, or it had ended [s]."""
    return min([line.at for line in program if line.what == "told"] + [ended])


def begun_after(controller: Sequence[Line], told: float) -> list[Line]:
    """The times at which a resting arm began to move although the program knew that it rests.

    An arm that moved already, and goes on to the end of its motion, does not begin.
    """
    return [line for line in controller if line.what == "begin" and line.at > told]
