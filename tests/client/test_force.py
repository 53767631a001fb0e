"""Force control by the client, on the simulated arm above a table."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator

import pytest

import aioduco
from aioduco import Outcome, Pose
from aioduco.errors import ParameterError, RobotStateError, TaskError
from aioduco.models.force import ForceFrame, ForceLogic, GuardedForce
from aioduco.sim import Simulator
from aioduco.sim.scene import Table

Z = (False, False, True, False, False, False)
DAMPING = (1000.0,) * 3 + (57.0,) * 3
SLOW = (0.05,) * 3 + (0.2,) * 3
WIDE = (1000.0, 1000.0, 1.0, 1000.0, 1000.0, 1000.0)
NOTHING = (0.0,) * 6


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    at = Simulator().arm.fkine((0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0))[:3, 3]
    with Simulator(speed=math.inf, scene=[Table(at=(at[0], at[1], at[2] - 0.02))]) as sim:
        yield sim


@pytest.fixture
async def arm(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        yield robot


def pressing(force: float) -> tuple[float, ...]:
    return (0.0, 0.0, -force, 0.0, 0.0, 0.0)


@pytest.mark.slow
async def test_every_function_of_force_control(arm: aioduco.Robot) -> None:
    force = arm.force
    begin = Pose.of(await arm.state.get_tcp_pose())
    await force.fc_force_set_value((True,) * 6, NOTHING)
    assert await force.fc_get_ft() == pytest.approx(NOTHING, abs=0.05)
    await force.fc_config(Z, pressing(20.0), DAMPING, SLOW, frame=ForceFrame.TOOL)
    await force.fc_guard_act(Z, (40.0,) * 6, force_property=GuardedForce.EXTERNAL)
    assert not await force.fc_mode_is_active()
    await force.fc_start()
    assert await force.fc_mode_is_active()
    anywhere = (10.0,) * 6
    still = (0.001,) * 3 + (10.0,) * 3
    await force.fc_wait_pos(NOTHING, anywhere, absolute=True, duration=0.0, timeout=20.0)
    await force.fc_wait_vel(NOTHING, still, absolute=True, duration=0.1, timeout=20.0)
    await force.fc_wait_ft(pressing(20.0), WIDE, absolute=True, duration=0.1, timeout=20.0)
    await force.fc_wait_logic((ForceLogic.AND, ForceLogic.AND, ForceLogic.AND))
    assert await force.fc_move() is Outcome.FINISHED
    assert (await force.fc_get_ft())[2] == pytest.approx(-20.0, abs=1.0)
    await force.fc_guard_deact()
    await force.fc_stop()
    assert not await force.fc_mode_is_active()
    assert await arm.motion.movel(begin, v=0.1, a=0.5) is Outcome.FINISHED


@pytest.mark.slow
async def test_a_guard_is_an_error_of_the_motion_and_brought_up_again(
    arm: aioduco.Robot, sim: Simulator
) -> None:
    begin = Pose.of(await arm.state.get_tcp_pose())
    await arm.force.fc_config(Z, pressing(60.0), DAMPING, SLOW)
    await arm.force.fc_guard_act(Z, (40.0,) * 6)
    await arm.force.fc_start()
    with pytest.raises(TaskError, match="force guard"):
        await arm.force.fc_move()
    assert sim.view.force_control is False
    await arm.force.fc_guard_deact()
    await arm.bring_up()
    assert await arm.motion.movel(begin, v=0.1, a=0.5) is Outcome.FINISHED


async def test_what_makes_no_sense_is_not_sent(arm: aioduco.Robot) -> None:
    with pytest.raises(ParameterError, match="damp"):
        await arm.force.fc_config(Z, pressing(20.0), NOTHING, SLOW)
    with pytest.raises(TaskError):
        await arm.force.fc_config(Z, pressing(20.0), DAMPING, SLOW, tool="saw")
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
