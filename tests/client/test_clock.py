"""Times of the arm go by the controller's clock, whatever the wall's says."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

import aioduco
import aioduco.sync
from aioduco import Jog, Outcome
from aioduco.models.controller_clock import Clock, ScaledClock, WallClock
from aioduco.sim import Simulator
from aioduco.testing import eventually_async
from client.bench import Bench

ASIDE = [0.4, 0.1, 1.4, 0.0, -1.5, 0.2]
TURN = [0.2, 0.0, 0.0, 0.0, 0.0, 0.0]


class Still:
    """A clock that a test sets."""

    def __init__(self) -> None:
        self.time = 100.0

    def now(self) -> float:
        return self.time

    def hold(self, at: float) -> Callable[[], None]:
        return lambda: None


@pytest.mark.slow
async def test_motions_of_a_time_on_the_fastest_clock(
    duco_robot: aioduco.Robot, duco_simulator: Simulator
) -> None:
    """The angle of a jog is that of its time, since simulated time stands while it is ended."""
    begin = duco_simulator.joints.array
    assert await duco_robot.motion.speedj(TURN, a=2.0) is Outcome.FINISHED
    assert not duco_simulator.moving
    after = duco_simulator.joints.array
    assert (after - begin)[0] == pytest.approx(0.2, abs=1e-3)
    jog = await duco_robot.motion.move_jog(Jog.joint(1, 1, vel=10)).start()
    assert await jog is Outcome.FINISHED
    assert not duco_simulator.moving
    assert (duco_simulator.joints.array - after)[0] == pytest.approx(0.05, abs=1e-3)
    assert 0.0 < jog.duration < 1.0 + 30.0  # as its begin and end were seen: by simulated time
    twist = [0.0, 0.0, -0.02, 0.0, 0.0, 0.0]
    assert await duco_robot.motion.speedl(twist, a=1.0, time=0.5) is Outcome.FINISHED


@pytest.mark.slow
async def test_a_finished_motion_is_no_interrupted_one_on_the_wall_s_clock(
    duco_simulator: Simulator,
) -> None:
    async with aioduco.connect(duco_simulator.host, duco_simulator.port) as robot:
        await robot.bring_up()
        # The deadline is by this clock, too: a busy machine takes longer than the simulated arm.
        task = await robot.motion.speedj(TURN, a=2.0, time=5.0).start(deadline=300.0)
        assert await task is Outcome.FINISHED  # not when five seconds have passed here


def test_the_clock_of_a_program_that_waits(duco_simulator: Simulator) -> None:
    begin = duco_simulator.joints.array
    with aioduco.sync.connect(
        duco_simulator.host, duco_simulator.port, clock=duco_simulator.clock
    ) as robot:
        robot.bring_up()
        robot.motion.move_jog(Jog.joint(1, 1, vel=10))
    assert (duco_simulator.joints.array - begin)[0] == pytest.approx(0.05, abs=1e-3)


async def test_deadlines_and_durations_are_the_arm_s(bench: Bench) -> None:
    clock = Still()
    bench.motion_time = 30.0
    async with aioduco.connect(bench.host, bench.port, clock=clock) as robot:
        task = await robot.motion.movej2(ASIDE, v=1.0, a=1.0).start(deadline=50.0)
        polls = robot.statistics().polls
        await eventually_async(lambda: robot.statistics().polls > polls + 5, 30.0)
        assert not task.done
        assert (task.since, task.deadline, task.duration) == (100.0, 150.0, 0.0)
        clock.time = 150.5
        with pytest.raises(aioduco.TaskOverdue):
            await task
        assert task.duration == 50.5
        clock.time = 200.0
        assert task.duration == 50.5


@pytest.mark.slow
async def test_a_finished_arm_does_not_move() -> None:
    """At the speed of the wall, with a heavy load: what swings out is no motion any more."""
    with Simulator(model="gcr5_910", speed=1.0) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
            sim.load(5.0, (0.0, 0.0, 0.1))
            await robot.frames.set_load_data(aioduco.Load(5.0, 0.0, 0.0, 0.1))
            for target in (ASIDE, [0.0, 0.0, 1.57, 0.0, -1.57, 0.0]):
                await robot.motion.movej2(target, v=3.0, a=10.0)
                assert not sim.moving
                assert not await robot.state.robotmoving()
                assert sim.joints.array == pytest.approx(target, abs=2e-3)


def test_clocks() -> None:
    wall, doubled = WallClock(), ScaledClock(2.0)
    assert isinstance(wall, Clock)
    assert isinstance(doubled, Clock)
    first, begin = wall.now(), doubled.now()
    assert wall.now() >= first
    assert doubled.now() - begin >= 0.0
    assert doubled.now() / 2.0 == pytest.approx(wall.now(), abs=30.0)
    for clock in (wall, doubled):
        clock.hold(0.0)()
    for speed in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(ValueError, match="above 0 and finite"):
            ScaledClock(speed)
    with pytest.raises(aioduco.ParameterError, match="clock"):
        aioduco.connect("192.0.2.1", clock="noon")  # type: ignore[arg-type]  # the wrong type is the point


@pytest.mark.slow
async def test_a_simulator_of_another_process_tells_its_speed() -> None:
    with Simulator.spawn(speed=10.0) as sim:
        async with aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot:
            await robot.bring_up()
            task = await robot.motion.movej2(ASIDE, v=1.0, a=2.0).start()
            await task
            assert task.started_at is not None
            assert task.ended_at is not None
            assert task.duration >= 5.0 * (task.ended_at - task.started_at)
    with Simulator.spawn(speed=math.inf) as sim, pytest.raises(ValueError, match="finite"):
        _ = sim.clock
