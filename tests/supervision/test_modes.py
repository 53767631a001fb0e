"""Modes that a stop leaves on, on the simulated arm: all are off after the program."""

from __future__ import annotations

import math
import threading
from collections.abc import Awaitable, Callable, Iterator

import anyio
import pytest
from moments import on_another_thread

import aioduco
from aioduco import Outcome
from aioduco.sim import Simulator
from aioduco.supervision.gate import PermitEnding
from aioduco.testing import eventually_async

Z = (False, False, True, False, False, False)
DAMPING = (1000.0,) * 3 + (57.0,) * 3
SLOW = (0.05,) * 3 + (0.2,) * 3
TARGET = [1.5, 0.0, 1.57, 0.0, -1.57, 0.0]


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(speed=20.0) as sim:
        yield sim


async def press(robot: aioduco.Robot) -> None:
    """Force control with nothing to press on: the arm goes down until it is told otherwise."""
    await robot.force.fc_config(Z, (0.0, 0.0, -10.0, 0.0, 0.0, 0.0), DAMPING, SLOW)
    await robot.force.fc_start()
    await robot.motion.movej2(TARGET, v=0.1, a=4.0).start()


async def guide(robot: aioduco.Robot) -> None:
    """Hand guiding, which goes on though nobody touches the arm."""
    await robot.motion.teach_mode().start()


async def fail(robot: aioduco.Robot) -> None:
    """A defect while force control is on."""
    await press(robot)
    raise KeyError("no such part")


@pytest.mark.cases(1)
@pytest.mark.parametrize("mode", [press, guide, fail])
async def test_no_mode_is_on_when_the_robot_was_left(
    sim: Simulator, mode: Callable[[aioduco.Robot], Awaitable[None]]
) -> None:
    async def program() -> None:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
            await mode(robot)

    if mode is fail:
        with pytest.raises(KeyError):
            await program()
    else:
        await program()
    assert not sim.moving
    assert not sim.tasks
    async with aioduco.connect(sim.host, sim.port) as robot:
        assert not await robot.force.fc_mode_is_active()
        report = await robot.bring_up()
        assert report.states.robot is aioduco.RobotState.ENABLE


async def test_force_control_goes_on_through_a_stop(sim: Simulator) -> None:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        await press(robot)
        with anyio.fail_after(10):
            await robot.stop()
        assert await robot.force.fc_mode_is_active()
        await robot.force.fc_stop()
        await eventually_async(lambda: not sim.moving)
        assert (
            await robot.motion.movej2([0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0], v=2.0, a=8.0)
            is Outcome.FINISHED
        )


@pytest.mark.slow
async def test_a_dry_run_is_supervised_as_a_run(sim: Simulator) -> None:
    # A busy machine holds up the loop: that is no matter of this test.
    async with aioduco.connect(sim.host, sim.port, heartbeat=60.0, loop_stall_limit=60.0) as robot:
        await robot.bring_up()
        before = sim.joints.array
        begin = (await robot.state.get_actual_joints_position()).array
        await robot.settings.simulation(True)
        assert await robot.motion.movej2(TARGET, v=3.0, a=8.0) is Outcome.FINISHED
        running = await robot.motion.movej2(list(begin), v=0.2, a=4.0).start()
        with pytest.raises(aioduco.RobotStateError, match="the arm moves"):
            await robot.settings.simulation(False)
        await robot.stop()  # returns when the simulated arm stands
        assert (await running.wait()) is Outcome.STOPPED
        assert not await robot.state.robotmoving()
        await robot.settings.simulation(False)
        at = (await robot.state.get_actual_joints_position()).array
        assert at == pytest.approx(before, abs=1e-3)
        assert sim.joints.array == pytest.approx(before, abs=1e-3)


class _Watched(dict[str, object]):
    """Modes of which one is left on the event loop as soon as another thread has looked at it."""

    def __init__(self, leave: Callable[[], None]) -> None:
        super().__init__()
        self._leave = leave

    def __contains__(self, key: object) -> bool:
        found = super().__contains__(key)
        if found and threading.current_thread() is not threading.main_thread():
            self._leave()
        return found


async def test_a_mode_may_be_left_while_another_thread_ends_the_permits(
    sim: Simulator,
) -> None:
    """A heartbeat that is lost at this moment ends the permits, and with them the modes."""
    async with aioduco.connect(sim.host, sim.port) as robot:
        modes = robot._supervisor.stop_coordinator.modes
        modes._on = _Watched(lambda: modes.over("end_teach_mode"))  # type: ignore[assignment]
        modes.enter("end_teach_mode")
        on_another_thread(lambda: robot._supervisor.gate.end(PermitEnding.LAPSED))
        await robot.bring_up()
        await robot.motion.movej2(TARGET, v=1.0, a=4.0)
