"""A program that is cancelled at any of its awaits leaves a standing arm and no resources."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from contextlib import suppress

import pytest

import aioduco
from aioduco.errors import TaskStopped
from aioduco.sim import Simulator
from aioduco.supervision.settings import GuardKind
from aioduco.supervision.task import OnCancel
from aioduco.testing import Cancelled, Resources, cancel_at_every_await, eventually_async
from aioduco.testing.cancel import How

from .arm import see_it_stand, unrest
from .program import LEFT, RIGHT

pytestmark = pytest.mark.usefixtures("guards")

Script = Callable[[aioduco.Robot], Awaitable[None]]


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(speed=20.0) as sim:
        yield sim


async def move(robot: aioduco.Robot) -> None:
    """Motions one by one, one beside another call, one tied to a block."""
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


async def hold(robot: aioduco.Robot) -> None:
    """Motions that go on until they are told to end, and a mode in which the arm gives way."""
    motion = robot.motion
    async with motion.speedj([0.2, 0.0, 0.0, 0.0, 0.0, 0.0], a=4.0, time=30.0):
        await robot.feed.latest()
    async with motion.teach_mode():
        await robot.io.set_standard_digital_out(1, value=True)
    await motion.movej2(RIGHT, v=2.0, a=8.0)


async def look_and_recover(robot: aioduco.Robot) -> None:
    """Readers of the state and of events, a program left paused, power gone and back."""
    with robot.events.subscribe():
        await robot.feed.latest()
        await robot.motion.movej2(LEFT, v=0.5, a=4.0).start()
        await robot.wait_for(lambda sample: sample.status.joint_speeds[0] != 0.0)
        await robot.pause()
        await robot.recover()
        await robot.system.power_off()
        await robot.recover()


class Program:
    """Opens a robot, makes it ready, and does what a script says."""

    def __init__(
        self,
        sim: Simulator,
        script: Script,
        *,
        guard: GuardKind | None = None,
        on_cancel: OnCancel = "stop",
    ) -> None:
        self._sim = sim
        self._script = script
        self._guard = guard
        self._on_cancel: OnCancel = on_cancel
        self.through = False

    async def __call__(self) -> None:
        self.through = False
        async with aioduco.connect(
            self._sim.host, self._sim.port, guard=self._guard, on_cancel=self._on_cancel
        ) as robot:
            await robot.bring_up()
            await self._script(robot)
            self.through = True


#: awaits from one cancellation to the next: the five seeds of `.ci/adversity` come to all of them
STEP = 5


async def cancelled_everywhere(
    sim: Simulator, program: Program, how: How, again: int, first: int, step: int = STEP
) -> None:
    """Cancel a program at each so many awaits, and look what it leaves."""
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

    runs = await cancel_at_every_await(
        program, check, how=how, again=again, first=1 + first % step, step=step
    )
    assert runs * step > 20


@pytest.mark.slow
@pytest.mark.parametrize("how", ["scope", "task"])
@pytest.mark.parametrize("again", [0, 3])
async def test_the_arm_stands_after_a_cancellation_at_any_await(
    sim: Simulator, seed: int, how: How, again: int
) -> None:
    """Once: at every second await in the one way, and at the others in the other way."""
    first = seed + (how == "task")
    await cancelled_everywhere(sim, Program(sim, move), how, again, first, STEP if again else 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "how", "again", "guard", "on_cancel"),
    [
        (move, "task", 3, "process", "stop"),
        (move, "scope", 0, "process", "stop"),
        (move, "scope", 0, None, "pause"),
        (move, "task", 1, None, "detach"),
        (hold, "task", 0, None, "stop"),
        (hold, "scope", 1, "process", "stop"),
        (look_and_recover, "task", 1, None, "stop"),
        (look_and_recover, "scope", 0, "process", "stop"),
    ],
)
async def test_whatever_the_program_does_and_however_it_is_watched(
    sim: Simulator,
    seed: int,
    script: Script,
    how: How,
    again: int,
    guard: GuardKind | None,
    on_cancel: OnCancel,
) -> None:
    program = Program(sim, script, guard=guard, on_cancel=on_cancel)
    await cancelled_everywhere(sim, program, how, again, seed)
