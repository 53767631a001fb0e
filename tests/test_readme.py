"""The README's program and commands: what a newcomer copies must work as it stands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from for_each import for_each
from interpreter import python
from moments import complaints

from aioduco import kinematics
from aioduco.models.pose import Joints, Pose
from aioduco.sim import Simulator
from aioduco.sim.simulator import READY

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
CHINESE = (ROOT / "README.zh-CN.md").read_text(encoding="utf-8")


def programs(text: str) -> list[str]:
    """The awaited one, and the plain script."""
    return re.findall(r"^```python[^\n]*\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)


def program(text: str) -> str:
    return programs(text)[0]


def command(text: str, name: str) -> str:
    pattern = rf"^<!-- command: {name} -->\n```sh\n(.*?)\n```"
    (found,) = re.findall(pattern, text, flags=re.MULTILINE | re.DOTALL)
    return str(found)


@pytest.mark.slow
def test_program_runs_as_it_stands(tmp_path: Path) -> None:
    """Only the address is another one: that of a simulated controller."""
    source = program(README)
    with Simulator(speed=10) as sim:
        there = source.replace('"127.0.0.1"', f'"{sim.host}", {sim.port}')
        assert there != source
        file = tmp_path / "program.py"
        file.write_text(there, encoding="utf-8")
        done = python("-W", "error", str(file))
        assert (done.returncode, complaints(done.stderr)) == (0, "")
        first, last = done.stdout.splitlines()
        assert re.fullmatch(r"task \d+ runs, the program goes on", first)
        assert last == "Outcome.FINISHED"
        assert not sim.moving


def test_program_is_short() -> None:
    assert len([line for line in program(README).splitlines() if line.strip()]) <= 12


@for_each("name", ["run", "test"])
def test_each_command_is_one_line_that_makes_its_own_environment(name: str) -> None:
    line = command(README, name)
    assert "\n" not in line
    first, *rest = (shlex.split(part) for part in line.split("&&"))
    assert first == ["python3", "-m", "venv", ".venv"]
    assert all(words[0].startswith(".venv/bin/") for words in rest)


def test_the_tutorial_begins_with_the_same_program() -> None:
    assert program(README) in (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")


@for_each("page", ["README.md", "README.zh-CN.md", "docs/index.md"])
def test_the_first_screen_has_the_plain_script_too(page: str) -> None:
    awaited, plain = programs((ROOT / page).read_text(encoding="utf-8"))[:2]
    assert "await robot.bring_up()" in awaited
    assert "aioduco.sync.connect" in plain
    assert plain.count("\n") < 10


def test_chinese_readme_has_the_same_programs_and_commands() -> None:
    assert programs(CHINESE) == programs(README)
    for name in ("run", "test"):
        assert command(CHINESE, name) == command(README, name)


@for_each("text", [README, CHINESE])
def test_links_lead_somewhere(text: str) -> None:
    targets = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "://" not in link]
    assert targets
    assert [link for link in targets if not (ROOT / link).exists()] == []


def test_pictures_are_small() -> None:
    begins = {".png": b"\x89PNG\r\n\x1a\n", ".gif": b"GIF89a"}
    pictures = [ROOT / picture for picture in re.findall(r"!\[[^]]*\]\(([^)]+)\)", README)]
    assert [picture.suffix for picture in pictures] == [".gif", ".png"]
    for picture in pictures:
        data = picture.read_bytes()
        assert data.startswith(begins[picture.suffix])
        assert len(data) < 400_000


#: the one home of all pages, examples and docstrings [rad]
HOME = Joints.deg(30, -15, 105, 0, -90, 0)


def test_the_first_motion_is_seen_and_leaves_the_flange_looking_down() -> None:
    arm = kinematics.arm("gcr5_910")
    there, start = arm.fkine(HOME.array), arm.fkine(np.array(READY))
    np.testing.assert_allclose(there[:3, 2], [0.0, 0.0, -1.0], atol=1e-9)
    assert np.linalg.norm(there[:3, 3] - start[:3, 3]) > 0.2
    assert min(arm.singularity(HOME.array)) > 0.2
    # Room for what the pages do from there: 100 mm along the tool, and beside it.
    for step in (Pose(0, 0, -0.1, 0, 0, 0), Pose(0, 0, 0.1, 0, 0, 0), Pose(0.1, 0, 0, 0, 0, 0)):
        assert Joints.of(arm.ikine(Pose.from_matrix(there) @ step, HOME)).distance(HOME) < 1.0


def test_pages_examples_and_docstrings_have_one_home() -> None:
    folders = [ROOT / name for name in ("docs", "examples", "aioduco")]
    paths = [
        path for folder in folders for path in folder.rglob("*") if path.suffix in {".md", ".py"}
    ]
    numbers = r"([-+\d., ]+)"
    named = re.compile(rf"\bhome = (?:aioduco\.)?Joints\.deg\({numbers}\)", re.IGNORECASE)
    moved = re.compile(rf"movej2\((?:aioduco\.)?Joints\.deg\({numbers}\)")
    listed = re.compile(rf"robot\.(?:motion\.)?movej2\(\[{numbers}\]")
    found = []
    for path in [ROOT / "README.md", ROOT / "README.zh-CN.md", *paths]:
        text = path.read_text(encoding="utf-8")
        degrees = [*named.findall(text), *moved.findall(text)]
        homes = [Joints.deg(*map(float, each.split(","))) for each in degrees]
        homes += [Joints(*map(float, each.split(","))) for each in listed.findall(text)]
        for home in homes:
            np.testing.assert_allclose(home, HOME, atol=1e-3, err_msg=str(path))
        found += [path.name] * bool(homes)
    assert {"README.md", "README.zh-CN.md", "tutorial.md", "index.md", "motion.md"} <= set(found)
    assert {"01_connect_and_move.py", "07_plain_script.py", "from-the-vendor-sdk.md"} <= set(found)
