"""The network fails: what the program is told of its motion stays true, and true when it has ended.

The whole matrix, some five hundred runs, is run by `.ci/cables`; here is a part of it.
"""

from __future__ import annotations

import pytest

from .cable.judge import begun_after, first_told
from .cable.lines import Line
from .cable.matrix import trials
from .cable.network import why_not
from .cable.trial import Cell

#: at a time; most of a run is waiting
_JOBS = 12

#: the longest first
_CELLS = [
    Cell("dropped", 5.0, "sent", 1.0, guard=False),
    Cell("dropped", 5.0, "sent", None, guard=True),
    Cell("dropped", 5.0, "stream", 1.0, guard=True),
    Cell("held", 5.0, "sent", 1.0, guard=True),
    Cell("down", 5.0, "running", 1.0, guard=False),
    Cell("down", 3.5, "sent", None, guard=False),
    Cell("dropped", 3.5, "sent", 1.0, guard=True),
    Cell("held", 3.5, "stream", 1.0, guard=False),
    Cell("late", 3.2, "sent", 1.0, guard=False),
    Cell("delayed", 3.2, "sent", 1.0, guard=False),
    Cell("reset", 3.2, "stream", None, guard=True),
    Cell("reset", 2.0, "sent", 1.0, guard=False),
    Cell("late", 2.0, "stream", None, guard=False),
    Cell("down", 2.0, "stream", None, guard=True),
    Cell("delayed", 2.0, "running", None, guard=True),
    Cell("dropped", 0.5, "sent", 1.0, guard=True),
]


@pytest.mark.slow
@pytest.mark.timeout(600)
async def test_the_arm_never_begins_to_move_after_the_program_was_told_or_has_ended() -> None:
    if reason := why_not():
        pytest.skip(f"no network namespaces here: {reason}")
    results = await trials(_CELLS, _JOBS)
    failed = [str(result) for result in results if not result.passed]
    assert not failed, f"{len(failed)} of {len(results)}:\n" + "\n".join(failed)


def test_an_arm_that_begins_after_the_program_was_told_is_found() -> None:
    program = [Line(1.0, "ready"), Line(5.0, "told", "OutcomeUnknown"), Line(5.1, "left")]
    controller = [Line(0.5, "begin"), Line(0.9, "rest"), Line(5.6, "begin"), Line(6.0, "rest")]
    told = first_told(program, ended=5.4)
    assert told == 5.0
    assert begun_after(controller, told) == [controller[2]]


def test_an_arm_that_begins_after_the_program_has_ended_is_found() -> None:
    told = first_told([Line(1.0, "ready")], ended=2.0)
    assert begun_after([Line(2.5, "begin")], told)


def test_an_arm_that_moves_on_does_not_begin() -> None:
    told = first_told([Line(3.0, "told", "TaskUnknown")], ended=3.1)
    assert not begun_after([Line(2.9, "begin"), Line(5.0, "rest")], told)
