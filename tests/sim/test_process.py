"""A simulator in a process of its own, and how it ends."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import threading
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType
from typing import Any

import psutil
import pytest
from for_each import for_each

from aioduco.errors import ParameterError, SceneError
from aioduco.sim.cabinet.script import Call
from aioduco.sim.process import SimulatorProcess
from aioduco.sim.simulator import Simulator

from .conftest import Connect
from .raw import RawClient


def test_a_spawned_simulator_is_served_and_ends_with_its_block(connect: Connect) -> None:
    with Simulator.spawn(model="gcr10_1300", seed=7) as sim:
        assert psutil.pid_exists(sim.pid)
        assert sim.host == "127.0.0.1"
        assert repr(sim) == f"<SimulatorProcess on 127.0.0.1:{sim.port}>"
        assert connect(sim).get_robot_type() == ["GCR10", "1300", "", "SIM00000007"]
    assert sim.process.returncode == 0
    assert repr(sim) == "<SimulatorProcess not running>"


@pytest.mark.slow
def test_a_spawned_simulator_tells_where_everything_is() -> None:
    process = Simulator.spawn(gripper="parallel", joints=[0.1, 0.0, 1.5, 0.0, -1.5, 0.0])
    with pytest.raises(RuntimeError, match="not running"):
        _ = process.positions
    with process:
        assert process.positions.shape == (8,)
        assert process.positions[0] == pytest.approx(0.1, abs=1e-3)


@pytest.mark.slow
async def test_the_same_in_async_code(connect: Connect) -> None:
    async with Simulator.spawn() as sim:
        assert connect(sim).get_robot_state() == [4, 0, 4, 1]
    assert sim.process.returncode == 0


@pytest.mark.slow
def test_a_process_that_cannot_start_says_why() -> None:
    with pytest.raises(ParameterError, match="ur5"), Simulator.spawn(model="ur5"):
        pass
    scene = "<mujoco><worldbody><geom/></worldbody></mujoco>"
    with pytest.raises(SceneError, match="scene"), Simulator.spawn(scene=scene):
        pass


def _program() -> Generator[Call, Any, None]:
    yield "movej2", ()


@for_each(
    "options, told",
    [
        ({"programs": {"a": lambda: [*_program()]}}, "programs is .*lists of calls or in a folder"),
        ({"values": {"a": threading.Lock()}}, "values is .*must be what another process"),
        ({"on_shutdown": print}, "on_shutdown is .*process.wait"),
    ],
)
def test_what_no_other_process_can_have_is_refused(options: dict[str, Any], told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        Simulator.spawn(**options)


def test_an_unknown_option_is_refused() -> None:
    with pytest.raises(TypeError, match="spede"):
        Simulator.spawn(spede=1.0)


@pytest.mark.slow
def test_what_only_the_program_can_import_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module = ModuleType("of_this_program")
    module.__dict__["_program"] = _program
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(_program, "__module__", module.__name__)
    process = Simulator.spawn(programs={"a": _program}, speed=math.inf)
    with pytest.raises(ParameterError, match="programs is something that only your program has"):
        process.start()
    assert process.process.returncode == 0


@pytest.mark.slow
def test_an_address_of_another_computer_is_refused_as_in_this_process() -> None:
    with pytest.raises(OSError, match="assign requested address") as here:
        Simulator(host="192.0.2.9").start()
    with pytest.raises(OSError, match="assign requested address") as there:
        Simulator.spawn(host="192.0.2.9").start()
    assert here.value.errno == there.value.errno


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_end_it_cleanly(number: signal.Signals) -> None:
    with Simulator.spawn() as sim:
        sim.process.send_signal(number)
        assert sim.process.wait(30) == 0


@pytest.mark.slow
def test_it_ends_with_the_process_that_started_it_even_if_that_is_killed() -> None:
    program = (
        "import sys, time; from aioduco.sim.simulator import Simulator\n"
        "sim = Simulator.spawn().start(); print(sim.pid, flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as parent:
        assert parent.stdout is not None
        child = psutil.Process(int(parent.stdout.readline()))
        parent.kill()
        parent.wait(30)
    gone, alive = psutil.wait_procs([child], timeout=30)
    assert (len(gone), alive) == (1, [])


@pytest.mark.slow
def test_a_shutdown_ends_the_process(connect: Connect) -> None:
    with Simulator.spawn(speed=50.0) as sim:
        connect(sim).shutdown(False)
        assert sim.process.wait(30) == 0


HERE, ELSEWHERE = 4, 2
FINISHED = 4


@pytest.mark.slow
def test_six_simulators_at_once_share_no_port_and_no_arm() -> None:
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
