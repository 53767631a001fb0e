"""The promise holds in every order of events, and fails when a safeguard is removed.

`pytest tests/explore -s` prints the figures, and the shortest order for each mutation.
"""

from __future__ import annotations

import pytest

from .mutations import MUTATIONS, Mutation
from .scenarios import ALL, Living, Scenario
from .world import explore

#: steps by which the thorough and the quick run go less deep than the gate by `.ci/explore`
_THOROUGH, _QUICK = 4, 8


@pytest.mark.parametrize("scenario", ALL, ids=lambda kind: kind.__name__)
@pytest.mark.cases(len(ALL))
def test_the_promise_holds_in_every_order(
    scenario: type[Scenario | Living], request: pytest.FixtureRequest
) -> None:
    fewer = _THOROUGH if request.config.getoption("thorough") else _QUICK
    found = explore(scenario, scenario.gate - fewer)
    print(scenario.__name__, found)  # noqa: T201
    assert not found.broken, str(found)


@pytest.mark.cases(1)
@pytest.mark.parametrize("mutation", MUTATIONS, ids=str)
def test_each_mend_that_is_taken_out_is_missed(mutation: Mutation) -> None:
    with mutation.made():
        found = explore(mutation.scenario, mutation.depth)
    print(mutation, found)  # noqa: T201
    assert found.broken, f"{mutation} breaks nothing within {mutation.depth} steps: {found}"
