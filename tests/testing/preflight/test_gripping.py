"""A gripper may touch what it grips; anything else that its fingers touch is found."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from cli_runner import CliRunner

from aioduco.cli.app import app
from aioduco.errors import ParameterError
from aioduco.sim.scene import Rod
from aioduco.testing.preflight import PreflightSettings

from .trying import tried

PROGRAM = """
import anyio
import aioduco
from aioduco import Joints, Pose
from aioduco.devices.grippers import gripper_model
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, Table

GRIPPER = gripper_model("parallel")
READY = Joints.deg(20, -10, 100, 0, -90, 0)
DOWN = Pose(0.5, 0.1, 0.35, 3.14159265, 0.0, 0.0)

async def close(robot, on):
    await robot.io.set_standard_digital_out(1, on)
    await robot.wait_for(lambda sample: sample.io.digital_inputs[0 if on else 1], timeout=30.0)

async def main(host, port):
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        await robot.motion.movej_pose2(DOWN.shifted(z=0.1), v=1.0, a=2.0, q_near=READY)
        STEPS

part = Box(at=(0.5, 0.1, 0.35 - GRIPPER.length), size=(0.03, 0.04, 0.06), mass=0.2, name="part")
post = Box(at=(0.5, -0.1, 0.35), size=(0.05, 0.02, 0.6), name="post")
table = Table(at=(0.5, 0.1, 0.32 - GRIPPER.length), size=(0.2, 0.2), name="table")
with Simulator(gripper="parallel", scene=[table, part, post]) as sim:
    anyio.run(main, sim.host, sim.port)
"""
GO = "await robot.motion.movel({}, v=0.25, a=1.0)"
GRIP = [GO.format("DOWN"), "await close(robot, True)", GO.format("DOWN.shifted(z=0.1)")]
LET_GO = [GO.format("DOWN.shifted(z=0.002)"), "await close(robot, False)"]
UP = GO.format("DOWN.shifted(z=0.1)")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("steps", "found"),
    [
        ([*GRIP, *LET_GO, UP], None),
        # the open fingers are set down on it
        ([GO.format("DOWN.shifted(y=0.05, z=0.09)"), GO.format("DOWN.shifted(y=0.05)")], "part"),
        # they are around it, stand, and are led against it
        ([GO.format("DOWN"), GO.format("DOWN.shifted(y=0.04)")], "part"),
        # what holds the part is led against something else
        ([*GRIP, GO.format("DOWN.shifted(y=-0.15, z=0.1)")], "post"),
    ],
    ids=["gripped", "set down on it", "led against it", "led against another"],
)
def test_a_grip_is_meant_and_a_collision_is_found(
    tmp_path: Path, steps: list[str], found: str | None
) -> None:
    report = tried(tmp_path, PROGRAM.replace("STEPS", "\n        ".join(steps)))
    texts = [str(each) for each in report.findings]
    if found is None:
        assert report.ok, texts
        assert report.contacts == ()
    else:
        assert any(
            each.kind == "collision of the tool" and f"touches {found}" in each.text
            for each in report.findings
        ), texts


WITH_CELL = """
import asyncio
from aioduco import Cell
from aioduco.sim import Simulator

CELL = Cell.load("cell.toml")

async def main(**address):
    async with CELL.connect(**address) as robot:
        await robot.bring_up()
        await robot.motion.movej2([0.3, 0, 1.6, 0, -1.5, 0], v=1.0, a=2.0)
        async with CELL.gripper.driver(robot) as gripper:
            await asyncio.wait_for(gripper.close(), 20.0)
            await asyncio.wait_for(gripper.open(), 20.0)

SIMULATED
"""
CELL = """
arm = "gcr5_910"

[robots.arm]
host = "192.168.1.10"

[gripper]
kind = "parallel"
close = 1
shut = 1
opened = 2
"""


OWN = """with Simulator(gripper="parallel") as sim:
    asyncio.run(main(host=sim.host, port=sim.port))"""


@pytest.mark.slow
@pytest.mark.parametrize("own", [True, False])
def test_the_gripper_of_a_cell_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own: bool
) -> None:
    """In the program's simulator, and in that of `--cell`, which had no gripper.

    Reading a cell starts no simulator, and no limit of the program is over meanwhile.
    """
    (tmp_path / "cell.toml").write_text(CELL, encoding="utf-8")
    text = WITH_CELL.replace("SIMULATED", OWN if own else "asyncio.run(main())")
    (tmp_path / "program.py").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    cell = () if own else ("--cell", "cell.toml")
    files = ("--json", "report.json", "--html", "report.html")
    done = CliRunner().invoke(app, ["preflight", "program.py", *cell, *files])
    report = json.loads(Path("report.json").read_text("utf-8"))
    assert (done.exit_code, report["findings"]) == (0, []), done.output
    assert [each["of"] for each in report["margins"]][-1] == "obstacle"  # the fingers, too
    assert "<figure>" in Path("report.html").read_text("utf-8")


def test_a_gripper_is_the_tool() -> None:
    with pytest.raises(ParameterError, match="gripper is 'parallel'"):
        PreflightSettings(gripper="parallel", tool=[Rod(length=0.1, radius=0.01)])
