"""Many simulators at once, as where tests are spread over processes."""

from __future__ import annotations

import math
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from aioduco.sim import Simulator
from aioduco.sim.process import SimulatorProcess

from .raw import RawClient

HERE, ELSEWHERE = 8, 2
FINISHED = 4


@pytest.mark.slow
def test_ten_simulators_at_once_share_no_port_and_no_arm() -> None:
    """Most are in this process, as in one test run; some in their own, as where runs meet."""
    together = threading.Barrier(HERE + ELSEWHERE)

    def life(number: int) -> tuple[int, float]:
        sim: Simulator | SimulatorProcess = (
            Simulator(speed=math.inf) if number < HERE else Simulator.spawn(speed=math.inf)
        )
        with sim as running, RawClient(running.port, timeout=60.0) as client:
            for name in ("power_on", "enable"):
                assert client.call(name, block=True) == FINISHED
            together.wait(60.0)  # all listen, and have their arms enabled
            goal = [0.02 * number, 0.0, 1.57, 0.0, -1.57, 0.0]
            assert client.call("movej2", goal, 2.0, 10.0, 0.0, True) == FINISHED
            joints = client.call("get_actual_joints_position")
            assert joints == pytest.approx(goal, abs=1e-3)
            together.wait(60.0)  # none has ended before the last one has moved
            return running.port, joints[0]

    with ThreadPoolExecutor(HERE + ELSEWHERE) as pool:
        lives = list(pool.map(life, range(HERE + ELSEWHERE)))
    assert len({port for port, _ in lives}) == HERE + ELSEWHERE
    assert [round(joint / 0.02) for _, joint in lives] == list(range(HERE + ELSEWHERE))
