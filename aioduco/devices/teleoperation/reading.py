"""The state of an input device at one moment."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from aioduco.models.rules import Flag, Number

#: times without a sign of the device for which it counts as held
HELD = Number(0.0, 60.0, "s", open_low=True, source="this package")
#: share of a deflection within which it counts as at rest
WIDTH = Number(0.0, 0.9, source="this package")

#: what else counts as true, such as "released", moves no arm
FLAG = Flag(source="this package")

#: six shares of the full speed, -1 to 1: along x, y, z and about x, y, z; or of joints 1 to 6.
#: The axes are those of a person who stands behind the arm: x forward, y to the left, z up.
Axes = tuple[float, float, float, float, float, float]

STANDING: Axes = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Reading(NamedTuple):
    """The state of an input device at one moment.

    Attributes:
        axes: shares of the full speed; valid only while `held`.
        held: whether the dead-man switch is held.
        done: whether the person wants to end, or the device is gone.
        pressed: numbers of the pressed buttons, without a gamepad's dead-man buttons; a keyboard
            gives none.
    """

    axes: Axes = STANDING
    held: bool = False
    done: bool = False
    pressed: frozenset[int | str] = frozenset()


class ReadingSource(Protocol):
    """What may move an arm: an `InputDevice`, or any object of the program with this function."""

    def read(self, now: float) -> Reading:
        """Return the state at the moment; it must not block.

        Args:
            now: time of a clock that does not go back [s].
        """
        ...


def deadband(value: float, width: float) -> float:
    """A deflection without the noise of a stick at rest; full deflection stays 1."""
    size = min(1.0, abs(value))
    if size <= width:
        return 0.0
    return (size - width) / (1 - width) * (1 if value > 0 else -1)
