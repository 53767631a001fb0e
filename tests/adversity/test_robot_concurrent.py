"""Several tasks of one program move, stop, pause, resume and cancel the same arm at once."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import anyio
import numpy as np
import pytest

import aioduco
from aioduco.errors import TaskError
from aioduco.models.enums import Outcome
from aioduco.sim import Simulator
from aioduco.supervision.settings import GuardKind
from aioduco.testing import no_leaks

from .arm import random_target, see_it_stand

pytestmark = pytest.mark.usefixtures("guards")

MOTIONS = 25


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with no_leaks(), Simulator(speed=10.0) as sim:
        yield sim


class Players:
    """What the tasks of the program do, again and again, until there were enough motions."""

    def __init__(self, sim: Simulator, robot: aioduco.Robot, rng: random.Random) -> None:
        self._sim = sim
        self._robot = robot
        self._rng = rng
        self._over = anyio.Event()
        self.outcomes: Counter[str] = Counter()

    async def move(self) -> None:
        """Moves; some of the motions are cancelled, or tied to a block that ends early."""
        for _ in range(MOTIONS):
            target = random_target(self._rng)
            motion = self._robot.motion.movej2(target, v=2.0, a=8.0)
            limit = self._rng.uniform(0.0, 0.1) if self._rng.random() < 0.3 else 60.0
            with anyio.move_on_after(limit) as scope:
                try:
                    outcome = await motion
                except TaskError as exc:
                    self.outcomes[type(exc).__name__] += 1
                else:
                    self.outcomes["finished"] += 1
                    assert outcome is Outcome.FINISHED
                    assert np.abs(self._sim.joints.array - target).max() < 5e-3
            if scope.cancelled_caught:
                assert limit < 60.0, "a motion did not end"
                self.outcomes["cancelled"] += 1
        self._over.set()

    async def play(self, what: Callable[[], Awaitable[object]]) -> None:
        while not self._over.is_set():
            with anyio.move_on_after(self._rng.uniform(0.0, 0.15)):
                await self._over.wait()
            try:
                await what()
            except TaskError as exc:
                self.outcomes[f"{what.__name__}: {type(exc).__name__}"] += 1


@pytest.mark.parametrize("part", range(4))
async def test_every_motion_ends_truly_and_the_arm_stands(
    sim: Simulator, part: int, seed: int, totals: Counter[str]
) -> None:
    rng = random.Random(f"{seed}/{part}")
    with anyio.fail_after(120):
        guard: GuardKind | None = "process" if part % 2 else None
        # a starved machine is not what is tested
        patience: dict[str, Any] = {
            "connect_timeout": 20.0,
            "stop_timeout": 20.0,
            "standstill_timeout": 20.0,
        }
        async with aioduco.connect(sim.host, sim.port, guard=guard, **patience) as robot:
            await robot.bring_up()
            players = Players(sim, robot, rng)
            async with anyio.create_task_group() as group:
                group.start_soon(players.move)
                for what in (robot.stop, robot.pause, robot.resume, robot.resume):
                    group.start_soon(players.play, what)
                group.start_soon(players.play, robot.state.getRobotStatus)
            # with nobody to interfere: on a busy machine perhaps no other one could finish
            assert await robot.motion.movej2([0.0, 0.0, 1.5, 0.0, -1.5, 0.0], v=2.0, a=8.0) is (
                Outcome.FINISHED
            )
    await see_it_stand(sim, "the program")
    totals.update({f"motions {outcome}": n for outcome, n in players.outcomes.items()})
