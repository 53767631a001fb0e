"""Kinds of output signals: a level, or pulses (manual 1.3.7, set_digital_output_mode)."""

from __future__ import annotations

from dataclasses import dataclass

from aioduco.sim.bank import Bank

__all__ = ["LEVEL", "Outputs", "Pulses"]

_SHORTEST = 1e-3  # shorter pulses switch the output off [s]


@dataclass(frozen=True, slots=True)
class Pulses:
    """A train of pulses while the output is set.

    Attributes:
        frequency: pulses a second, 1 to 100 [Hz]; 0 for a level.
        duty: part of the period in which the output is high, 1 to 100 [%].
    """

    frequency: int
    duty: int

    def level(self, time: float) -> bool:
        """Whether the output is high at a time [s], while it is set."""
        if not self.frequency:
            return True
        if self.duty < _SHORTEST * 100.0 * self.frequency:
            return False
        # A nanosecond for the rounding of a sum of cycles.
        return (time + 1e-9) * self.frequency % 1.0 < self.duty / 100.0


LEVEL = Pulses(0, 100)


class Outputs(Bank[bool]):
    """Outputs that are levels or pulses.

    Another kind takes effect when the output is set next, as the manual has it.
    """

    __slots__ = ("_chosen", "_used")

    def __init__(self, size: int) -> None:
        super().__init__(size, False)
        self._chosen = [LEVEL] * size
        self._used = [LEVEL] * size

    def __setitem__(self, num: int, value: bool) -> None:
        super().__setitem__(num, value)
        self._used[num - 1] = self._chosen[num - 1]

    def choose(self, num: int, pulses: Pulses) -> None:
        """Choose the kind of one output, and the pulses of all: there is one generator."""
        self._chosen[num - 1] = pulses
        if pulses is not LEVEL:
            for kinds in (self._chosen, self._used):
                kinds[:] = [pulses if kind is not LEVEL else LEVEL for kind in kinds]

    def level(self, num: int, time: float) -> bool:
        """Whether an output is high at a time [s]; False for one that does not exist."""
        return self[num] and self._used[num - 1].level(time)

    def levels(self, time: float) -> list[bool]:
        """Every output at a time [s]."""
        return [on and kind.level(time) for on, kind in zip(self.all(), self._used, strict=True)]
