"""The promise holds in all runs of the package's own coroutines that depart little from the usual.

`pytest tests/explore -s` prints the figures, and the order for each mutation.
"""

from __future__ import annotations

import pytest

from .mutations import Mutation
from .programs import ALL, Program, tried
from .shell_mutations import SHELL_MUTATIONS


@pytest.mark.slow
@pytest.mark.parametrize("program", ALL, ids=lambda kind: kind.__name__)
def test_the_promise_holds_in_all_runs(program: type[Program]) -> None:
    found = tried(program, 1)  # `.ci/explore`, which the gate runs, tries two of some programs
    print(program.__name__, found)  # noqa: T201
    assert not found.broken, str(found)


@pytest.mark.cases(2)
@pytest.mark.parametrize("mutation", SHELL_MUTATIONS, ids=str)
def test_each_mend_that_is_taken_out_is_missed(mutation: Mutation) -> None:
    with mutation.made():
        found = tried(mutation.scenario, mutation.depth)
    print(mutation, found)  # noqa: T201
    assert found.broken, f"{mutation} breaks nothing: {found}"
