"""The fixtures that the package brings to pytest."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from aioduco.errors import OutcomeUnknown
from aioduco.models.enums import Outcome, RobotState
from aioduco.testing import Cut, FaultProxy, Place

if TYPE_CHECKING:
    from aioduco import Robot
    from aioduco.sim import Simulator
    from aioduco.sync import Robot as SyncRobot

HOME = [0.2, 0.1, 1.4, 0.0, -1.5, 0.0]


async def test_a_robot_that_is_ready(duco_robot: Robot, duco_simulator: Simulator) -> None:
    assert duco_simulator.view.robot is RobotState.ENABLE
    assert await duco_robot.motion.movej2(HOME, v=1.0, a=2.0) is Outcome.FINISHED
    assert duco_simulator.joints.array == pytest.approx(HOME, abs=1e-3)


async def test_a_robot_behind_a_proxy(duco_robot: Robot, duco_proxy: FaultProxy) -> None:
    assert duco_robot.port == duco_proxy.port
    duco_proxy.on("movej2", Cut(Place.BEFORE_REPLY))
    with pytest.raises(OutcomeUnknown):
        await duco_robot.motion.movej2(HOME, v=1.0, a=2.0)
    assert len(duco_proxy.calls("movej2")) == 1


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


SCOPE = ["-o", "asyncio_default_fixture_loop_scope=function"]
OUTSIDE = """
import sys

import pytest


def test_nothing_is_loaded():
    assert not {"mujoco", "thriftpy2", "aioduco.sim", "aioduco.testing"} & set(sys.modules)


@pytest.fixture
def anyio_backend():
    return "asyncio"


{mark}
async def test_the_fixture_is_found(duco_robot):
    assert (await duco_robot.state.get_robot_state()).robot.name == "ENABLE"
"""


@pytest.mark.parametrize(
    ("options", "mark"),
    [
        (["-o", "asyncio_mode=strict", *SCOPE], "@pytest.mark.asyncio"),
        (["-o", "asyncio_mode=auto", *SCOPE], ""),
        (["-p", "no:asyncio"], "@pytest.mark.anyio"),
    ],
    ids=["strict", "auto", "anyio"],
)
def test_outside_of_this_project(tmp_path: Path, options: list[str], mark: str) -> None:
    (tmp_path / "test_outside.py").write_text(OUTSIDE.replace("{mark}", mark))
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options, str(tmp_path)],
        check=False,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout


def test_the_quick_start_as_it_is_printed(tmp_path: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "quickstart.md").read_text(encoding="utf-8")
    (block,) = [
        one.partition("```")[0] for one in page.split("```python\n") if "duco_simulator" in one
    ]
    (tmp_path / "test_arm.py").write_text(block)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_arm.py"],
        check=False,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout
