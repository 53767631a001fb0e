"""A program that is cancelled at any of its awaits leaves a standing arm and nothing else."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

import pytest

import aioduco
from aioduco.errors import TaskStopped
from aioduco.sim import Simulator
from aioduco.testing import Resources, cancel_at_every_await, eventually_async

from .arm import see_it_stand, unrest
from .program import LEFT, RIGHT

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.testing import Cancelled
    from aioduco.testing.cancel import How


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(speed=20.0) as sim:
        yield sim


class Program:
    """Does one of everything that moves an arm.

    Attributes:
        through: whether it came to the end of its block, so that only leaving it was left.
    """

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self.through = False

    async def __call__(self) -> None:
        self.through = False
        async with aioduco.connect(self._sim.host, self._sim.port) as robot:
            await robot.bring_up()
            motion = robot.motion
            await motion.movej2(LEFT, v=2.0, a=8.0)
            task = await motion.movej2(RIGHT, v=2.0, a=8.0).start()
            await robot.io.set_standard_digital_out(1, value=True)
            await task.wait()
            with suppress(TaskStopped):
                async with motion.movej2(LEFT, v=0.5, a=4.0):
                    await robot.pause()
                    await robot.resume()
                    await robot.stop()
            self.through = True


@pytest.mark.parametrize("how", ["scope", "task"])
@pytest.mark.parametrize("again", [0, 3])
async def test_the_arm_stands_after_a_cancellation_at_any_await(
    sim: Simulator, how: How, again: int
) -> None:
    program = Program(sim)
    await program()
    await eventually_async(lambda: not sim.connections)
    before = Resources.now()

    async def check(run: Cancelled) -> None:
        # at once: the program has seen it stand before it ended
        await see_it_stand(sim, run)
        assert run.error is None
        # a scope cannot cancel what is shielded: the way out of a block that was gone through
        assert program.through or run.ended == "cancelled"
        await eventually_async(
            lambda: not Resources.now().beyond(before) and not sim.tasks,
            what=lambda: f"{run} left {Resources.now().beyond(before)} and {unrest(sim)}",
        )

    assert await cancel_at_every_await(program, check, how=how, again=again) > 20
