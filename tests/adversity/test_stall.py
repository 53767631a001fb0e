"""A short stall of the event loop does not stop a motion. Long ones: hostile tests."""

from __future__ import annotations

import pytest

import aioduco
from aioduco.models.enums import Outcome
from aioduco.sim import Simulator
from aioduco.supervision.settings import GuardKind
from aioduco.testing import eventually_async

from .guards import BOTH
from .program import LEFT

pytestmark = pytest.mark.usefixtures("guards")

#: s for which the loop is blocked, well below the limit, which is one second if nothing is said
SHORT = 0.3


@pytest.mark.slow
@BOTH
async def test_a_short_stall_lets_the_motion_go_on(sim: Simulator, guard: GuardKind | None) -> None:
    async with aioduco.connect(sim.host, sim.port, guard=guard) as robot:
        await robot.bring_up()
        task = await robot.motion.movej2(LEFT, v=0.6, a=8.0).start()
        await eventually_async(lambda: sim.moving)
        begin = sim.time
        sim.wait_until(lambda: sim.time > begin + SHORT)  # it blocks the event loop
        assert sim.moving
        assert await task is Outcome.FINISHED
        figures = robot.heartbeat
        assert figures is not None
        assert (figures.stalls, figures.losses) == (0, 0)
