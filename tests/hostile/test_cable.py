"""The network fails: what the program was told of its motion stays true.

The whole matrix, some five hundred runs, is run by `.ci/cables`; here is a part of it.
"""

from __future__ import annotations

import math

import pytest
from for_each import for_each

from .cable.judge import begun_after, first_told
from .cable.lines import Line
from .cable.matrix import trials
from .cable.network import why_not
from .cable.trial import Cell

#: at a time; most of a run is waiting
_JOBS = 8

#: each kind of outage, and each scene with and without a guard; the longest first
_CELLS = [
    Cell("dropped", 5.0, "sent", 1.0, guard=False),
    Cell("dropped", 5.0, "stream", 1.0, guard=True),
    Cell("held", 5.0, "sent", 1.0, guard=True),
    Cell("down", 5.0, "running", 1.0, guard=False),
    Cell("delayed", 3.2, "sent", 1.0, guard=False),
    Cell("reset", 3.2, "stream", None, guard=True),
    Cell("late", 2.0, "stream", None, guard=False),
    Cell("delayed", 2.0, "running", None, guard=True),
]

#: what a program is told of a motion that the network has let through
UNDISTURBED = ("Outcome.FINISHED", "left the stream", "nothing")


@pytest.mark.slow
@pytest.mark.timeout(600)
async def test_the_arm_never_begins_to_move_after_the_program_was_told_or_has_ended() -> None:
    if reason := why_not():
        pytest.skip(f"no network namespaces here: {reason}")
    results = await trials(_CELLS, _JOBS)
    failed = [str(result) for result in results if not result.passed]
    assert not failed, f"{len(failed)} of {len(results)}:\n" + "\n".join(failed)
    # or the network had not failed at all
    felt = {result.cell.kind for result in results if result.what not in UNDISTURBED}
    assert felt == {cell.kind for cell in _CELLS}


@for_each(
    "begins, told, ended, found",
    [
        ([0.5, 5.6], 5.0, 5.4, [5.6]),  # after it was told
        ([2.5], math.inf, 2.0, [2.5]),  # after its end
        ([2.9], 3.0, 3.1, []),  # it moves on, and does not begin
    ],
)
def test_an_arm_that_begins_too_late_is_found(
    begins: list[float], told: float, ended: float, found: list[float]
) -> None:
    program = [Line(1.0, "ready"), *([Line(told, "told")] if told < ended else [])]
    controller = [Line(at, "begin") for at in begins]
    assert [line.at for line in begun_after(controller, first_told(program, ended))] == found
