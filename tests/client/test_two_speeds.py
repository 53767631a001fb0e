"""The fastest clock gives the same outcomes and angles as real time."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import AsyncIterator, Callable
from typing import Any

import anyio
import numpy as np
import pytest
from api.cases import Case, cases

import aioduco
from aioduco import Jog, Outcome
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

HOME = [0.0, 0.0, 1.5708, 0.0, -1.5708, 0.0]
#: simulated time after which a call counts as one that goes on, and is cancelled [s]
GOES_ON = 2.0
#: what ends the controller, or its power, or is left to a person: each has an arm of its own
ALONE = {"shutdown", "restart"}
NAMES = sorted({case.name for case in cases()})
#: functions in a test: an arm is made once for them
PARTS = [NAMES[first : first + 36] for first in range(0, len(NAMES), 36)]

TIMED: dict[str, Callable[[aioduco.Robot], Any]] = {
    "movej2": lambda robot: robot.motion.movej2([0.3, 0.1, 1.4, 0.1, -1.5, 0.2], v=2.0, a=8.0),
    "speedj": lambda robot: robot.motion.speedj([0.2, 0, 0, 0, 0, 0.5], a=4.0, time=0.5),
    "speedl": lambda robot: robot.motion.speedl([0, 0, -0.05, 0, 0, 0], a=1.0, time=0.5),
    "move_jog": lambda robot: robot.motion.move_jog(Jog.joint(1, 1, vel=10), time=0.5),
    "move_jog a step": lambda robot: robot.motion.move_jog(Jog.joint(1, 1, vel=10, step=0.02)),
}


@contextlib.asynccontextmanager
async def brought_up(speed: float) -> AsyncIterator[tuple[Simulator, aioduco.Robot]]:
    """As the fixtures of the package make them, but for the speed."""
    async with (
        Simulator(speed=math.inf) as sim,
        aioduco.connect(
            *(sim.host, sim.port),
            clock=sim.clock,
            heartbeat=30.0,  # a busy machine is not what is compared
            loop_stall_limit=30.0,
            lag_limit=None,
        ) as robot,
    ):
        await robot.bring_up()
        sim.speed = speed
        yield sim, robot


def standing(sim: Simulator) -> bool:
    return sim.view.standing


async def home(sim: Simulator, robot: aioduco.Robot) -> None:
    """To where each call begins, on the fast clock."""
    speed, sim.speed = sim.speed, math.inf
    await robot.stop()  # ends a mode that the call before has left on
    await robot.recover()
    if np.abs(sim.joints.array - HOME).max() > 1e-5:
        await robot.motion.movej2(HOME, v=3.0, a=20.0)
    await sim.wait_until_async(lambda: sim.view.standing)
    sim.speed = speed


async def outcome(
    sim: Simulator, robot: aioduco.Robot, case: Case, longest: float = GOES_ON
) -> str:
    """How a call ends: what it returns by its type, or its error by its class."""
    ends: list[str] = []

    async def run() -> None:
        try:
            result = await case.method(robot)(**case.args)
        except aioduco.DucoError as exc:
            ends.append(type(exc).__name__)
        else:
            ends.append(result.name if isinstance(result, Outcome) else type(result).__name__)

    until = sim.time + longest
    async with anyio.create_task_group() as group:
        group.start_soon(run)
        go_on = sim.clock.hold(until, lasting=True)
        try:
            await eventually_async(lambda: ends or sim.time >= until, 60.0, what=case.name)
            for _ in range(20):  # an answer of before then may be on its way
                if not ends:
                    await robot.state.robotmoving()
        finally:
            go_on()
        if not ends:
            group.cancel_scope.cancel()
    return ends[0] if ends else "goes on"


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize("names", PARTS, ids=lambda names: f"{names[0]} to {names[-1]}")
async def test_each_function_ends_alike(names: list[str]) -> None:
    ends: list[dict[str, str]] = []
    for speed in (math.inf, 1.0):
        ends.append({})
        async with brought_up(speed) as (sim, robot):
            for case in (one for one in cases() if one.name in names and one.name not in ALONE):
                await home(sim, robot)
                ends[-1][case.name] = await outcome(sim, robot, case)
    assert ends[0] == ends[1]
    assert ends[0].keys() == set(names) - ALONE


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(ALONE))
async def test_what_ends_the_controller_ends_alike(name: str) -> None:
    (case,) = (one for one in cases() if one.name == name)
    ends = []
    for speed in (math.inf, 1.0):
        with contextlib.suppress(aioduco.DucoError):  # it cannot be left any more
            async with brought_up(speed) as (sim, robot):
                # Restart waits for the computer's time until it is connected again.
                ends.append(await outcome(sim, robot, case, math.inf))
    assert len(ends) == 2
    assert ends[0] == ends[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", TIMED)
async def test_a_motion_of_a_time_turns_as_far(name: str) -> None:
    turned = []
    for speed in (math.inf, 1.0):
        async with brought_up(speed) as (sim, robot):
            await home(sim, robot)
            assert await TIMED[name](robot) is Outcome.FINISHED
            await sim.wait_until_async(functools.partial(standing, sim))
            turned.append(sim.joints.array)
    assert turned[0] == pytest.approx(turned[1], abs=1e-3)
    assert np.abs(turned[0] - HOME).max() > 5e-3
