"""`aioduco init`: the new project passes its own checks."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from patient import COMMAND_LINE
from test_cli import run

from aioduco import Cell
from aioduco.kinematics import arm, check, models


@pytest.mark.slow
@pytest.mark.timeout(400)
def test_the_project_is_green_as_written(tmp_path: Path) -> None:
    made = run("init", str(tmp_path / "demo"))
    assert made.exit_code == 0, made.output
    here = tmp_path / "demo"
    kept = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("PYTEST_", "AIODUCO_HOST"))
    }
    environment = {**kept, "XDG_CONFIG_HOME": str(tmp_path)}
    steps = (
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        [*COMMAND_LINE, "check", "cell.toml"],
        [*COMMAND_LINE, "preflight", "main.py", "--cell", "cell.toml"],
    )
    for step in steps:
        done = subprocess.run(
            step, cwd=here, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, (step, done.stdout, done.stderr)
        assert "Warning" not in done.stdout + done.stderr, (step, done.stdout, done.stderr)


@pytest.mark.parametrize("model", models())
def test_every_arm_reaches_its_points_and_touches_nothing(model: str, tmp_path: Path) -> None:
    assert run("init", str(tmp_path / "demo"), "--model", model).exit_code == 0
    cell = Cell.load(tmp_path / "demo" / "cell.toml")
    assert cell.arm == model
    ready = cell.joints("ready")
    report = check(cell, arm=model, near=ready)
    assert report.ok, str(report)
    scene, way = cell.scene(), [ready.array]
    for name in ("pick", "place"):
        visit = [cell.pose(name).shifted(z=height) for height in (0.06, 0.0, 0.06)]
        way += [arm(model).ikine(pose, ready) for pose in visit]
    for here, there in pairwise([*way, ready.array]):
        for part in np.linspace(0.0, 1.0, 10):
            closest = scene.clearance(here + part * (there - here))
            assert closest.distance > 0.0, closest
    assert len((tmp_path / "demo" / "README.md").read_text().splitlines()) <= 10


def test_a_host_stands_in_the_cell_as_it_was_given(tmp_path: Path) -> None:
    host = 'odd"na\\me'
    assert run("init", str(tmp_path / "demo"), "--host", host).exit_code == 0
    assert Cell.load(tmp_path / "demo" / "cell.toml").robot().host == host


@pytest.mark.linux("names of files are bytes")
def test_a_folder_whose_name_is_no_text(tmp_path: Path) -> None:
    project = tmp_path / os.fsdecode(b"\xff")
    assert run("init", str(project)).exit_code == 0
    assert (project / "README.md").read_text("utf-8").startswith("# \\udcff")


def test_a_folder_that_is_there_is_left_alone(tmp_path: Path) -> None:
    answer = run("init", str(tmp_path))
    assert (answer.exit_code, list(tmp_path.iterdir())) == (1, [])
    assert "nothing was written" in answer.output
    assert run("init", str(tmp_path / "a"), "--host", "no host").exit_code == 2
    assert not (tmp_path / "a").exists()


def test_a_project_that_cannot_be_written_is_not_left_half(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next try would say that it exists, and a user take it for a whole one."""
    write = Path.write_text

    def full(path: Path, *args: Any, **options: Any) -> int:
        if path.name == "main.py":
            raise OSError(errno.ENOSPC, "full")
        return write(path, *args, **options)

    monkeypatch.setattr(Path, "write_text", full)
    answer = run("init", str(tmp_path / "demo"))
    assert (answer.exit_code, list(tmp_path.iterdir())) == (1, [])
    assert "cannot be written: full" in answer.output


def test_the_line_to_try_it_can_be_pasted(tmp_path: Path) -> None:
    folder = tmp_path / "my cell"
    assert f"try it: cd '{folder}' && pytest" in run("init", str(folder)).stdout
