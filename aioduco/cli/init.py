"""`aioduco init`: a project with a cell, a supervised program, tests and a workflow."""

from __future__ import annotations

import math
import shlex
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import Annotated, Final

import typer

from aioduco.cli import extras
from aioduco.cli.exit_codes import fail
from aioduco.cli.output import say

__all__ = ["init"]

_CELL: Final = """\
# The cell: robots, points and limits. Programs, tests and `aioduco … --cell cell.toml` read it.
arm = "{model}"

[robots.arm]
host = "{host}" # 127.0.0.1: a simulator of this computer; then the address of your controller

# Teach them at your arm: aioduco teach --cell cell.toml
[points.ready]
joints_deg = [20, -10, 100, 0, -90, 0]

[points.pick]
pose_mm_deg = [{x}, {y}, {z}, 180, 0, {turn}]

[points.place]
pose_mm_deg = [{x}, -{y}, {z}, 180, 0, {turn}]

[[scene.thing]]
kind = "box"
name = "table"
at = [{table_x}, 0, {table_z}]
size = [{table_length}, 0.6, 0.02]

# Motions beyond these limits are refused, and the arm is stopped if it leaves them.
[[limit]]
kind = "plane"
point = [0, 0, {plane_z}]
normal = [0, 0, 1]
name = "above the table"

[[limit]]
kind = "tool_speed"
most = 0.25
action = "slow"
"""

_PROGRAM: Final = '''\
"""Goes from point to point of cell.toml, within its limits; the arm stops when this ends."""

import asyncio
from pathlib import Path
from typing import Any

from aioduco import Cell, Robot, mm

CELL = Cell.load(Path(__file__).with_name("cell.toml"))


async def visit(robot: Robot, name: str) -> None:
    place = CELL.pose(name)
    above = place.shifted(z=mm(60))
    async with robot.motion.path() as path:  # the first motion blends into the second
        await path.add(
            robot.motion.movej_pose2(above, v=0.5, a=1.0, r=mm(20), q_near=CELL.joints("ready"))
        )
        await path.add(robot.motion.movel(place, v=0.1, a=0.5))
    await robot.motion.movel(above, v=0.1, a=0.5)


async def run(robot: Robot) -> None:
    await robot.motion.movej2(CELL.joints("ready"), v=0.5, a=1.0)
    for name in ("pick", "place"):
        await visit(robot, name)
        print(f"{name} was visited")
    await robot.motion.movej2(CELL.joints("ready"), v=0.5, a=1.0)


async def main(**options: Any) -> None:
    # A separate process stops the arm if this program dies; Ctrl-C and errors stop it from here.
    async with CELL.connect(**{"guard": "process", **options}) as robot:
        await robot.bring_up()
        await run(robot)


if __name__ == "__main__":
    asyncio.run(main())
'''

_TESTS: Final = '''\
"""The program on a simulated arm, faster than the real one."""

import asyncio

import main
import pytest

from aioduco import EnvelopeViolated


def test_the_program_reaches_its_end():
    with main.CELL.simulator(speed=10.0) as sim:
        asyncio.run(main.main(host=sim.host, port=sim.port, clock=sim.clock))
        assert sim.joints.almost_equal(main.CELL.joints("ready"), 0.01)


def test_a_motion_into_the_table_is_refused():
    async def press(sim):
        async with main.CELL.connect(host=sim.host, port=sim.port, clock=sim.clock) as robot:
            await robot.bring_up()
            await robot.motion.movej2(main.CELL.joints("ready"), v=1.0, a=2.0)
            table = main.CELL.pose("pick").shifted(z=-0.2)
            with pytest.raises(EnvelopeViolated, match="above the table"):
                await robot.motion.movel(table, v=0.1, a=0.5)

    with main.CELL.simulator(speed=10.0) as sim:
        asyncio.run(press(sim))
'''

_WORKFLOW: Final = """\
name: checks
on: [push, pull_request]
jobs:
  checks:
    runs-on: ubuntu-latest
    steps:
      - uses: actions/checkout@v4
      - uses: actions/setup-python@v5
        with:
          python-version: "3.11"
      - run: pip install -r requirements.txt
      - run: pytest -q
      - run: aioduco check cell.toml
      - run: aioduco preflight main.py --cell cell.toml
"""

_README: Final = """\
# {name}

- `cell.toml`: address of the arm, its points and limits. `main.py`: the program.
- `pytest`: the tests, on a simulated arm.
- `aioduco preflight main.py --cell cell.toml`: the program, tried before the arm moves.
- `aioduco sim --cell cell.toml`, then elsewhere `python main.py`: the program on a simulator.

On the arm: set `host` in `cell.toml`, `aioduco status --cell cell.toml`, teach the points
(`aioduco teach --cell cell.toml`), global speed to a tenth, then `python main.py`.
"""


def init(
    folder: Annotated[Path, typer.Argument(help="Folder of the project; it must not exist yet.")],
    model: Annotated[str, typer.Option(help="The arm.")] = "gcr5_910",
    host: Annotated[
        str, typer.Option(help="Address of its controller; that of a simulator if left out.")
    ] = "127.0.0.1",
) -> None:
    """Write a project: a cell, a supervised program, tests on the simulator, a workflow.

    It runs as it is: pytest, then aioduco preflight main.py --cell cell.toml. Nothing is sent to an
    arm.

    aioduco init demo

    Exit codes: 0 written; 1 it cannot be written; 2 wrong options.
    """
    arm = extras.arm(model)
    from aioduco.errors import ParameterError  # noqa: PLC0415
    from aioduco.models.address import parse_address  # noqa: PLC0415 - for this command alone
    from aioduco.models.pose import Joints, Pose  # noqa: PLC0415

    try:
        parse_address(host, name="--host")
    except ParameterError as error:
        raise typer.BadParameter(str(error)) from None
    # Points that every arm reaches: below where its flange is in the first configuration, and
    # farther out, as the table is, so that the arm is not folded over it.
    ready = Pose.from_matrix(arm.fkine(Joints.deg(20, -10, 100, 0, -90, 0).array))
    height = round(ready.z - 0.08, 2)
    numbers = {
        "x": round(1.2 * ready.x * 1e3),
        "y": round(130 * arm.reach),
        "z": round(height * 1e3),
        "turn": round(math.degrees(ready.rz)),
        "plane_z": round(height - 0.05, 3),
        "table_x": round(1.4 * ready.x, 3),
        "table_length": round(ready.x, 3),
        "table_z": round(height - 0.11, 3),
    }
    files = {
        "cell.toml": _CELL.format(model=model, host=host, **numbers),
        "main.py": _PROGRAM,
        "test_main.py": _TESTS,
        "requirements.txt": "aioduco[cli,sim]\npytest\n",
        ".github/workflows/checks.yml": _WORKFLOW,
        "README.md": _README.format(name=folder.name),
    }
    try:
        folder.mkdir(parents=True)
        for name, text in files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    except FileExistsError:
        fail(f"{folder} exists already; nothing was written")
    except OSError as error:
        fail(f"{folder} cannot be written: {error}")
    say(f"written to {folder}: {', '.join(files)}")
    inside = f"cd {shlex.quote(str(folder))}"
    say(f"try it: {inside} && pytest && aioduco preflight main.py --cell cell.toml")
