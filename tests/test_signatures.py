"""The script that compares public interfaces: what it looks at, and what it finds."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from interpreter import python

ROOT = Path(__file__).parents[1]


def signatures(*args: str) -> subprocess.CompletedProcess[str]:
    return python(".ci/signatures", *args, cwd=ROOT)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("signatures") / "interface.json"
    done = signatures("--record", str(path))
    assert done.returncode == 0, done.stderr
    return path


@pytest.mark.slow
def test_what_programs_call_is_recorded(recorded: Path) -> None:
    records = json.loads(recorded.read_text(encoding="utf-8"))
    for name, said in (
        ("aioduco.connect", "host: 'str'"),
        ("aioduco.Robot.bring_up", "timeout: 'float' = 30.0"),
        ("aioduco.Robot.motion.movej2", "joints: 'JointsLike'"),
        ("aioduco.Robot.servo.joints", "max_step: 'float' = 0.2"),
        ("aioduco.Task.wait", "Outcome"),
        ("aioduco.sync.Robot.motion.movej2", "joints: 'JointsLike'"),
        ("aioduco.compat.DucoCobot.movej2", "joints_list: 'Sequence[float]'"),
        ("aioduco.sim.Simulator", "speed: 'float'"),
        ("aioduco.testing.eventually", "condition: "),
    ):
        assert said in records[name]["signature"], name
        assert records[name]["doc"], name
    # what is taken by keyword alone
    assert "rate" in records["aioduco.Robot.servo.joints > ServoOptions"]["keys"]


@pytest.mark.slow
def test_the_same_interface_has_no_differences(recorded: Path) -> None:
    done = signatures(str(recorded), str(recorded))
    assert done.returncode == 0
    assert done.stdout.endswith(": 0 differences\n")


@pytest.mark.slow
def test_each_difference_is_told(recorded: Path, tmp_path: Path) -> None:
    record: dict[str, Any] = json.loads(recorded.read_text(encoding="utf-8"))
    record["aioduco.Robot.stop"]["doc"] = "Another text."
    record["aioduco.connect"]["signature"] = "(host)"
    record["aioduco.movej"] = record.pop("aioduco.deg")
    other = tmp_path / "other.json"
    other.write_text(json.dumps(record), encoding="utf-8")
    done = signatures(str(recorded), str(other))
    assert done.returncode == 1
    assert "gone     aioduco.deg\n" in done.stdout
    assert "new      aioduco.movej\n" in done.stdout
    assert "changed  aioduco.Robot.stop: doc\n" in done.stdout
    assert "changed  aioduco.connect: signature\n" in done.stdout
    assert ": 4 differences\n" in done.stdout
