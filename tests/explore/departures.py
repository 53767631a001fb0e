"""Tries all runs of a program that depart from its usual order up to a number of times."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .world import Violation


class Choices:
    """The choices of one run.

    Args:
        given: numbers of the possibilities that are chosen, by the numbers of the choices; in all
            others, what comes without a choice.

    Attributes:
        open: numbers of the possibilities that there were.
    """

    def __init__(self, given: Mapping[int, int]) -> None:
        self._given = given
        self.open: list[int] = []

    def choose(self, possibilities: int) -> int:
        """Choose one of several possibilities, the first without a choice."""
        choice = self._given.get(len(self.open), 0)
        self.open.append(possibilities)
        return choice


class Broken(Exception):
    """The promise is broken, in an order."""

    def __init__(self, violation: Violation, order: Sequence[str]) -> None:
        super().__init__(str(violation))
        self.order = tuple(order)


@dataclass(frozen=True)
class Tried:
    """What was tried."""

    runs: int
    departures: int
    choices: int
    seconds: float
    broken: str = ""
    order: tuple[str, ...] = ()

    def __str__(self) -> str:
        figures = (
            f"{self.runs} runs, all with up to {self.departures} departures, "
            f"up to {self.choices} choices each, {self.seconds:.1f} s"
        )
        if not self.broken:
            return f"{figures}: the promise holds"
        return "\n".join([f"{figures}: {self.broken}", *[f"  {words}" for words in self.order]])


def depart(program: Callable[[Choices], None], most: int) -> Tried:
    """Try all runs of a program with up to `most` departures, those with the fewest first."""
    begin = time.process_time()
    runs = longest = 0
    given: list[dict[int, int]] = [{}]
    for departures in range(most + 1):
        further: list[dict[int, int]] = []
        for chosen in given:
            choices = Choices(chosen)
            runs += 1
            try:
                program(choices)
            except Broken as exc:
                seconds = time.process_time() - begin
                return Tried(runs, departures, longest, seconds, str(exc), exc.order)
            longest = max(longest, len(choices.open))
            if departures < most:
                for number in range(max(chosen, default=-1) + 1, len(choices.open)):
                    further += [
                        chosen | {number: other} for other in range(1, choices.open[number])
                    ]
        given = further
    return Tried(runs, most, longest, time.process_time() - begin)
