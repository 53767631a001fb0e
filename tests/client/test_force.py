"""Force control by the client, on the simulated arm."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator

import pytest

import aioduco
from aioduco.errors import ParameterError, RobotStateError, TaskError
from aioduco.sim import Simulator

Z = (False, False, True, False, False, False)
DAMPING = (1000.0,) * 3 + (57.0,) * 3
SLOW = (0.05,) * 3 + (0.2,) * 3
NOTHING = (0.0,) * 6
PRESS = (0.0, 0.0, -20.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(speed=math.inf) as sim:
        yield sim


@pytest.fixture
async def arm(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        yield robot


async def test_what_makes_no_sense_is_not_sent(arm: aioduco.Robot) -> None:
    with pytest.raises(ParameterError, match="damp"):
        await arm.force.fc_config(Z, PRESS, NOTHING, SLOW)
    with pytest.raises(TaskError):
        await arm.force.fc_config(Z, PRESS, DAMPING, SLOW, tool="saw")
    with pytest.raises(TaskError):
        await arm.force.fc_move()  # force control is off
    await arm.force.fc_config(Z, NOTHING, DAMPING, SLOW)
    await arm.force.fc_start()
    task = await arm.force.fc_move().start()
    with pytest.raises(RobotStateError):
        await arm.force.fc_stop()
    await arm.stop()
    with pytest.raises(TaskError, match="stopped"):
        await task
    await arm.force.fc_stop()
