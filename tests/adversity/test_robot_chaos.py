"""A program over a faulty connection gets true outcomes, and the arm moves only as commanded."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

import aioduco
from aioduco.errors import DucoError, HeartbeatLost, StopUnconfirmed, TaskUnknown
from aioduco.models.enums import Outcome
from aioduco.sim import Simulator
from aioduco.testing import (
    ApplicationError,
    Chaos,
    Fault,
    FaultProxy,
    Plan,
    eventually_async,
    no_leaks,
)

from .arm import idle, random_target, see_it_stand, unrest
from .menu import MENU

pytestmark = pytest.mark.usefixtures("guards")

#: a controller that says that it refused what it does is not to be helped
TRUTHFUL: tuple[Fault, ...] = tuple(
    fault for fault in MENU if not (isinstance(fault, ApplicationError) and fault.forward)
)
ROUNDS = 4


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with no_leaks(), Simulator(speed=10.0) as sim:
        yield sim


def storm(seed: int) -> Plan:
    """Every second motion meets a fault, and every tenth of the calls that watch over it."""
    on_motions = Chaos(seed, TRUTHFUL, rate=0.5)
    on_others = Chaos(seed, TRUTHFUL, rate=0.1)
    return lambda n, method: (on_motions if method == "movej2" else on_others)(n, method)


class Mover:
    """Moves to one target after another, none like any other, and checks what it is told."""

    def __init__(self, sim: Simulator, rng: random.Random) -> None:
        self._sim = sim
        self._rng = rng
        self.outcomes: Counter[str] = Counter()

    async def rest(self) -> None:
        """Wait until the arm stands."""
        await eventually_async(
            lambda: idle(self._sim) and not self._sim.moving, what=lambda: unrest(self._sim)
        )

    async def move(self, robot: aioduco.Robot) -> None:
        target = random_target(self._rng)
        try:
            outcome = await robot.motion.movej2(target, v=2.0, a=8.0)
        except (StopUnconfirmed, HeartbeatLost) as exc:
            self.outcomes[type(exc).__name__] += 1
            raise
        except TaskUnknown as exc:
            self.outcomes[type(exc).__name__] += 1
            # it says that the motion may be running: it is being stopped
            await self.rest()
        except DucoError as exc:
            self.outcomes[type(exc).__name__] += 1
            # whatever it was: a motion that is given up does not go on
            await see_it_stand(self._sim, exc)
        else:
            self.outcomes["finished"] += 1
            assert outcome is Outcome.FINISHED
            assert np.abs(self._sim.joints.array - target).max() < 5e-3


@pytest.mark.slow
@pytest.mark.parametrize("part", range(ROUNDS))
async def test_the_arm_stands_whenever_the_program_has_given_up(
    sim: Simulator, part: int, faults: int, seed: int, totals: Counter[str]
) -> None:
    """Every second part with the guard, whose connections meet the same faults."""
    rng = random.Random(f"{seed}/{part}")
    mover = Mover(sim, rng)
    with FaultProxy(sim.host, sim.port, seed=seed) as proxy:
        for session in range(1000):
            proxy.clear()
            stormy = False
            try:
                async with aioduco.connect(
                    proxy.host,
                    proxy.port,
                    call_timeout=0.2,
                    unanswered_timeout=0.2,
                    heartbeat=0.3,
                    stop_timeout=1.0,
                    standstill_timeout=2.0,
                    guard="process" if part % 2 else None,
                ) as robot:
                    await robot.bring_up()
                    stormy = True
                    proxy.schedule(storm(seed * 10_000 + part * 1_000 + session))
                    for _ in range(20):
                        await mover.move(robot)
            except (StopUnconfirmed, HeartbeatLost):
                # said so: the controller stops it by itself
                await mover.rest()
            except DucoError:
                # times as short as these are over before a starved machine has opened a robot
                if stormy:
                    raise
            else:
                await see_it_stand(sim, "the program")
            if proxy.statistics().faults >= faults // 20:
                break
        requests = Counter(
            call.request.body for call in proxy.calls("movej2") if call.forwarded is not None
        )
        assert set(requests.values()) <= {1}
        totals["faults"] += proxy.statistics().faults
        totals["calls"] += proxy.statistics().calls
        totals["connections"] += proxy.statistics().connections
    totals.update({f"motions {outcome}": n for outcome, n in mover.outcomes.items()})
