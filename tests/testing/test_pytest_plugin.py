"""The fixtures that the package brings to pytest."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from interpreter import python

from aioduco import Robot, sync
from aioduco.errors import OutcomeUnknown
from aioduco.models.enums import Outcome, RobotState
from aioduco.recording import read
from aioduco.sim import Simulator
from aioduco.supervision.settings import RobotSettings
from aioduco.sync import Robot as SyncRobot
from aioduco.testing import Cut, FaultProxy, Place

HOME = [0.2, 0.1, 1.4, 0.0, -1.5, 0.0]


@pytest.mark.slow
async def test_a_robot_that_is_ready(duco_robot: Robot, duco_simulator: Simulator) -> None:
    assert duco_simulator.view.robot is RobotState.ENABLE
    assert await duco_robot.motion.movej2(HOME, v=1.0, a=2.0) is Outcome.FINISHED
    assert duco_simulator.joints.array == pytest.approx(HOME, abs=1e-3)


@pytest.mark.slow
async def test_a_robot_behind_a_proxy(duco_robot: Robot, duco_proxy: FaultProxy) -> None:
    assert duco_robot.port == duco_proxy.port
    duco_proxy.on("movej2", Cut(Place.BEFORE_REPLY))
    with pytest.raises(OutcomeUnknown):
        await duco_robot.motion.movej2(HOME, v=1.0, a=2.0)
    assert len(duco_proxy.calls("movej2")) == 1


@pytest.mark.slow
def test_a_robot_for_programs_that_wait(
    duco_sync_robot: SyncRobot, duco_proxy: FaultProxy, duco_simulator: Simulator
) -> None:
    assert duco_sync_robot.port == duco_proxy.port
    duco_sync_robot.motion.movej2(HOME, v=1.0, a=2.0)
    assert not duco_simulator.moving
    assert duco_simulator.joints.array == pytest.approx(HOME, abs=1e-3)


class TestAnotherArm:
    @pytest.fixture
    def duco_simulator_options(self) -> dict[str, object]:
        return {"model": "gcr20_1100", "speed": 7.0}

    def test_can_be_asked_for(self, duco_simulator: Simulator) -> None:
        assert duco_simulator.arm.name == "gcr20_1100"
        assert duco_simulator.speed == 7.0


class TestTimesOfRobots:
    """A busy computer fails no test of a user; a test of such a time sets it."""

    @pytest.fixture
    def duco_robot_options(self, request: pytest.FixtureRequest) -> Any:
        if request.node.name == "test_can_be_set":
            return {"heartbeat": 1.5}
        return request.getfixturevalue("duco_robot_options")

    def test_can_be_set(self, duco_sync_robot: SyncRobot) -> None:
        assert settings_of(duco_sync_robot).heartbeat == 1.5

    @pytest.mark.slow
    def test_are_long(self, duco_sync_robot: SyncRobot) -> None:
        found = settings_of(duco_sync_robot)
        assert (found.heartbeat, found.call_timeout) == (20.0, 10.0)


def settings_of(robot: SyncRobot) -> RobotSettings:
    found: RobotSettings = robot._made._supervisor.settings
    return found


SCOPE = ["-o", "asyncio_default_fixture_loop_scope=function"]
#: plug-ins that no test here needs, and that take a quarter of a second of a processor to load
LIGHT = ["-p", "no:anyio", "-p", "no:hypothesispytest"]
OUTSIDE = """
import sys

import pytest


def test_nothing_is_loaded():
    assert not {"mujoco", "thriftpy2", "aioduco.sim", "aioduco.robot"} & set(sys.modules)


@pytest.fixture
def anyio_backend():
    return "asyncio"


{mark}
async def test_the_fixture_is_found(duco_robot):
    assert (await duco_robot.state.get_robot_state()).robot.name == "ENABLE"
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "mark"),
    [
        (["-o", "asyncio_mode=strict", *SCOPE], "@pytest.mark.asyncio"),
        (["-p", "no:asyncio"], "@pytest.mark.anyio"),
    ],
    ids=["asyncio", "anyio"],
)
def test_outside_of_this_project(tmp_path: Path, options: list[str], mark: str) -> None:
    (tmp_path / "test_outside.py").write_text(OUTSIDE.replace("{mark}", mark))
    done = python(
        "-m", "pytest", "-q", "-p", "no:cacheprovider", *options, str(tmp_path), cwd=tmp_path
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout


PROGRAM = """
import pytest

from aioduco.errors import OutcomeUnknown
from aioduco.testing import Cut, Place

HOME = [0.2, 0.1, 1.4, 0.0, -1.5, 0.0]


@pytest.mark.duco_model("gcr20_1100")
@pytest.mark.duco_speed(7.0)
def test_model(duco_simulator):
    assert (duco_simulator.arm.name, duco_simulator.speed) == ("gcr20_1100", 7.0)


@pytest.mark.duco_fault("movej2", Cut(Place.BEFORE_REPLY))
def test_fault(duco_sync_robot):
    with pytest.raises(OutcomeUnknown):
        duco_sync_robot.motion.movej2(HOME, v=1.0, a=2.0)


async def test_good(duco_robot):
    await duco_robot.motion.movej2(HOME, v=1.0, a=2.0)


async def test_bad(duco_robot):
    await duco_robot.motion.movej2(HOME, v=1.0, a=2.0)
    assert (await duco_robot.settings.get_global_speed()) == 55


@pytest.mark.duco_model("gcr20_1100")
def test_another_arm(duco_sync_robot):
    duco_sync_robot.motion.movej2(HOME, v=1.0, a=2.0)


class TestByOptions:
    @pytest.fixture
    def duco_simulator_options(self):
        return {"model": "gcr20_1100", "speed": float("inf")}

    def test_another_arm(self, duco_sync_robot):
        duco_sync_robot.motion.movej2(HOME, v=1.0, a=2.0)
"""


def run_tests(folder: Path, text: str, *options: str) -> tuple[int, str]:
    (folder / "test_program.py").write_text(text, encoding="utf-8")
    done = python(
        *("-m", "pytest", "-rs", "-p", "no:cacheprovider"),
        *("-o", "asyncio_mode=auto", *LIGHT, *SCOPE, *options, str(folder)),
        cwd=folder,
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.slow
def test_a_failed_test_leaves_what_is_known_of_its_arm(tmp_path: Path) -> None:
    """Beside others, and when it fails again, spread over processes: then of its last run."""
    left, before = tmp_path / "left", 0
    for options, counted in (
        ((), "1 failed, 5 passed"),
        (("-n", "1", "-k", "bad"), "1 failed"),
    ):
        status, said = run_tests(tmp_path, PROGRAM, "--duco-artefacts", str(left), *options)
        assert (status, counted in said) == (1, True), said
        (folder,) = left.iterdir()
        assert f"{folder}: run.mcap, events.txt, states.json, run.html" in said
        run = read(folder / "run.mcap")
        assert run.complete
        assert run.started_ns > before
        before = run.started_ns
        lines = (folder / "events.txt").read_text("utf-8").splitlines()
        assert any('"function": "movej2"' in line for line in lines)
        states = json.loads((folder / "states.json").read_text("utf-8"))
        assert states["/joint_states"]["position"] == pytest.approx(HOME, abs=1e-2)
        assert (folder / "arm.png").exists() or "no picture" in said


@pytest.mark.slow
def test_a_fault_that_a_test_connects_past_is_an_error(tmp_path: Path) -> None:
    """Such a test passed, without its fault."""
    _, said = run_tests(
        tmp_path,
        "import pytest\nfrom aioduco.testing import DropReply\n"
        "pytestmark = pytest.mark.duco_fault('movej2', DropReply())\n"
        "def test_past(duco_simulator): pass\n"
        "def test_through(duco_simulator, duco_proxy): pass\n",
    )
    assert "1 passed, 1 error" in said, said
    assert "connects past its duco_proxy" in said


@pytest.mark.slow
def test_tests_whose_names_differ_by_signs_leave_files_of_their_own(tmp_path: Path) -> None:
    """The folder of the first was deleted by the second; a long name was too long for a folder."""
    left = tmp_path / "left"
    _, said = run_tests(
        tmp_path,
        "import pytest\n"
        "@pytest.mark.parametrize('sign', ['+', '*'])\n"
        f"def test_{120 * '臂'}(duco_sync_robot, sign): assert not sign\n",
        "--duco-artefacts",
        str(left),
    )
    assert "2 failed" in said, said
    assert len([*left.iterdir()]) == 2


#: as pytest-rerunfailures does
RERUN = """
from _pytest.runner import runtestprotocol

def pytest_runtest_protocol(item, nextitem):
    for _ in range(2):
        item._initrequest()
        runtestprotocol(item, nextitem=nextitem, log=False)
    return True
"""


@pytest.mark.slow
def test_a_test_that_passes_when_it_is_run_again_leaves_nothing(tmp_path: Path) -> None:
    """The recording of the run that passed was left as that of a failure."""
    (tmp_path / "conftest.py").write_text(RERUN)
    left = tmp_path / "left"
    _, said = run_tests(
        tmp_path,
        "runs = []\n"
        "def test_again(duco_sync_robot):\n"
        "    runs.append(duco_sync_robot)\n"
        "    assert len(runs) == 2\n",
        "--duco-artefacts",
        str(left),
    )
    assert [*left.iterdir()] == [], said


@pytest.mark.slow
def test_on_an_arm_tests_are_slow_and_those_that_would_fault_it_are_skipped(tmp_path: Path) -> None:
    """The arm is another simulated one, behind an address."""
    with Simulator(speed=20) as sim:
        address = f"{sim.host}:{sim.port}"
        options = ("--duco-host", address, "--duco-host-speed", "55", "--duco-model", "gcr5_910")
        status, said = run_tests(tmp_path, PROGRAM, *options)
        assert (status, "2 passed, 4 skipped" in said) == (0, True), said
        assert f"the arm at {address} will move, at 55 % of its speed" in said
        for reason in ("needs the simulated arm", "faults on the wire", "needs a gcr20_1100"):
            assert reason in said
        with sync.connect(sim.host, sim.port) as robot:
            assert robot.settings.get_global_speed() == 100
    status, said = run_tests(tmp_path, PROGRAM, "--duco-host", address, "-n", "2")
    assert status == 4
    assert "without -n" in said


_LEFT_MOVING = """
async def test_bad(duco_robot):
    await duco_robot.motion.movej2([1.0] * 6, v=0.5, a=1.0).start()
    assert not "as it should be"


def test_bad_too(duco_sync_robot):
    duco_sync_robot.motion.movej2.start([0.0] * 6, v=0.5, a=1.0)
    assert not "as it should be"
"""


@pytest.mark.slow
def test_an_arm_that_a_test_leaves_moving_is_stopped_before_its_speed_is_put_back(
    tmp_path: Path,
) -> None:
    """It went on, faster, until its robot was closed."""
    with Simulator() as sim, FaultProxy(sim.host, sim.port) as proxy:
        address = f"{proxy.host}:{proxy.port}"
        _, said = run_tests(tmp_path, _LEFT_MOVING, "--duco-host", address)
        assert said.count("\nE  ") == 2, said  # no other error
        made = [call.method for call in proxy.calls() if call.method in ("movej2", "speed", "stop")]
    first = made[made.index("movej2") :]
    assert first.index("stop") < first.index("speed"), made
    second = first[first.index("movej2", 1) :]
    assert second.index("stop") < second.index("speed"), made


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--duco-model", "gcr5_91"), "model is 'gcr5_91', but must be one of"),
        (("--duco-host-speed", "0"), "--duco-host-speed is 0.0, but must be a number from 1"),
    ],
)
def test_an_arm_is_not_brought_up_for_wrong_options(
    tmp_path: Path, options: tuple[str, ...], says: str
) -> None:
    status, said = run_tests(tmp_path, PROGRAM, "--duco-host", "127.0.0.1:1", *options)
    assert status == 4
    assert says in said
