"""What an input device says at one moment."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["STANDING", "Axes", "Reading", "deadband"]

#: six shares of the full speed, -1 to 1: along x, y, z and about x, y, z; or of joints 1 to 6.
#: As somebody sees them who stands behind the arm: x leads forward, y to the left, z up.
Axes = tuple[float, float, float, float, float, float]

STANDING: Axes = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Reading(NamedTuple):
    """What an input device says at one moment.

    Attributes:
        axes: shares of the full speed; they count only while `held`.
        held: whether the dead-man is held.
        done: whether the person wants to end.
        pressed: buttons that are down beside the dead-man, by their numbers, or letters of keys.
    """

    axes: Axes = STANDING
    held: bool = False
    done: bool = False
    pressed: frozenset[int | str] = frozenset()


def deadband(value: float, width: float) -> float:
    """A deflection without what a stick at rest says; its full deflection stays what it is."""
    size = min(1.0, abs(value))
    if size <= width:
        return 0.0
    return (size - width) / (1 - width) * (1 if value > 0 else -1)
