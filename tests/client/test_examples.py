"""Each example runs to its end, says what it did, and nothing else."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from moments import complaints

from aioduco.sim import Simulator

EXAMPLES = Path(__file__).parents[2] / "examples"
PATIENT = str(Path(__file__).parents[1] / "patient.py")

SAYS = {
    "01_connect_and_move.py": ["ready: robot ENABLE", "finished", "back, within 0.0"],
    "02_stop_from_another_task.py": ["stopped by the other task: movej2", "moving: False"],
    "03_blended_motions.py": [
        "radius 0 mm: ",
        "(finished, finished, finished, finished)",
        "radius 20 mm: ",
        "(blended, blended, blended, finished)",
    ],
    "07_plain_script.py": ["ready: robot ENABLE", "down: finished", "round: blended, blended, fin"],
}


def run(*command: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", PATIENT, *command],
        check=False,
        capture_output=True,
        text=True,
        timeout=50,
    )
    assert complaints(done.stderr) == ""
    assert done.returncode == 0
    return done.stdout


@pytest.mark.parametrize("name", SAYS)
def test_on_a_given_address(name: str) -> None:
    with Simulator(speed=2.0) as sim:
        said = run(str(EXAMPLES / name), sim.host, str(sim.port))
    for words in SAYS[name]:
        assert words in said


def test_without_an_address_on_a_simulated_arm() -> None:
    assert "back, within 0.0" in run(str(EXAMPLES / "01_connect_and_move.py"))


def test_pressing_on_a_table() -> None:
    said = run(str(EXAMPLES / "press_on_table.py"))
    about = r"-(19|20|21) N\n"
    assert re.fullmatch(f"pressing: {about}moved by 50 mm: {about}let go: 0 N\n", said)


def test_each_is_short_and_opens_with_its_goal() -> None:
    for path in EXAMPLES.glob("0[1-37]_*.py"):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert len(lines) < 60, path
        assert lines[0].startswith('"""'), path
        assert path.name in SAYS
