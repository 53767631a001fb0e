"""Random motions, streams and jogs within random zones: a few here, thousands by the script."""

from __future__ import annotations

import pytest

from .trials import KINDS, run


@pytest.mark.cases(1)
@pytest.mark.parametrize("kind", KINDS)
async def test_the_arm_stays_within_random_zones(kind: str, thorough: bool) -> None:
    """What was told to the controller and where the arm was is judged in the trials."""
    numbers = (1, 3, 5) if thorough else (0,)
    found = await run(numbers, seed=1, kind=kind)
    assert not found.failed
    assert found.counts[kind] == len(numbers)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "number"), [("stream", 2089), ("motion", 2808), ("stream", 5290)])
async def test_what_stays_clear_is_let_through(kind: str, number: int) -> None:
    """A fast stream some way off, and a line of an arm that is nearly stretched."""
    found = await run([number], seed=1, kind=kind)
    assert not found.failed
    assert {"movel sent", "streams within the zones"} & {*found.counts}
