"""How long a motion of the joints takes, and its progress."""

from __future__ import annotations

import math

import hypothesis.strategies as st
import pytest
from client.bench import HOME, POSE, Bench
from hypothesis import given

import aioduco
from aioduco.models.enums import Outcome
from aioduco.sim import Simulator
from aioduco.supervision.task_state import JointEta
from aioduco.testing import eventually_async

START = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5)
ETA = JointEta((1.0, 0.1, -0.8, 0.3, 0.4, 0.5), v=0.5, a=2.0)


def test_the_time_is_that_of_the_joint_with_the_longest_way() -> None:
    for way in (1.0, 0.2):  # gets to 0.5 rad/s
        far = (1.0 - way, 0.1, -0.8, 0.3, 0.4, 0.5)
        assert ETA.seconds(far) == pytest.approx(way / 0.5 + 0.5 / 2.0)
    near = (0.9, *ETA.target[1:])
    assert ETA.seconds(near) == pytest.approx(2 * (0.1 / 2.0) ** 0.5)  # it never gets to 0.5
    assert ETA.seconds(ETA.target) == 0.0
    assert JointEta(ETA.target, v=0.5, a=None).seconds(START) is None


@given(st.floats(0.0, 1.0))
def test_the_part_of_the_way(part: float) -> None:
    now = [a + part * (b - a) for a, b in zip(START, ETA.target, strict=True)]
    assert ETA.part(START, now) == pytest.approx(part)


def test_the_part_is_never_more_than_all_or_less_than_nothing() -> None:
    assert ETA.part(START, (-0.1, *START[1:])) == 0.0
    assert ETA.part(START, (2.0, *START[1:])) == 1.0
    assert ETA.part(ETA.target, START) == 1.0  # there was no way to go


@pytest.mark.slow
async def test_a_task_tells_how_far_it_is_and_when_it_ends() -> None:
    target = [0.5, 0.0, 1.57, 0.0, -1.57, 0.0]
    with Simulator(speed=1.0) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
            task = await robot.motion.movej2(target, v=0.8, a=8.0).start()
            await eventually_async(lambda: task.remaining is not None)
            parts: list[float] = []
            while not task.done:
                here = await task.progress()
                assert here is not None
                parts.append(here)
            assert parts == pytest.approx(sorted(parts), abs=1e-3)
            assert parts[0] < 0.3
            assert parts[-1] > 0.9
            assert await task is Outcome.FINISHED
            assert await task.progress() == 1.0
            assert task.remaining == 0.0


async def test_what_is_not_known_is_not_told(bench: Bench, robot: aioduco.Robot) -> None:
    line = await robot.motion.movel(POSE, v=0.1, a=0.1).start()
    behind = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    assert await line.progress() is None
    assert await behind.progress() is None  # it begins where the line ends, whenever that is
    assert (line.remaining, behind.remaining) == (None, None)
    await robot.stop()
    await line.wait()
    assert await line.progress() is None


async def test_external_axes_and_what_is_no_place(bench: Bench, robot: aioduco.Robot) -> None:
    bench.motion_time = 60.0
    bench.answer("get_actual_joints_position", [*HOME, 0.7])
    task = await robot.motion.movej2([*HOME[:5], 3.0], v=0.1, a=1.0).start()
    await eventually_async(lambda: task.remaining is not None)
    assert await task.progress() == 0.0
    for wrong in ([0.0] * 5, [*HOME[:5], math.nan]):
        bench.answer("get_actual_joints_position", wrong)
        with pytest.raises(aioduco.StaleState, match="still starting"):
            await task.progress()
    await robot.stop()
    before = robot.statistics().polls
    unknown = await robot.motion.movej2([*HOME[:5], 3.0], v=0.1, a=1.0).start()
    await eventually_async(lambda: robot.statistics().polls > before + 3)
    assert unknown.remaining is None
    await robot.stop()
