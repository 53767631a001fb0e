"""The script that compares public interfaces: what it looks at, and what it finds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from interpreter import python

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_each_difference_is_told(tmp_path: Path) -> None:
    here, other = tmp_path / "here.json", tmp_path / "other.json"
    done = python(".ci/signatures", "--record", str(here), cwd=ROOT)
    assert done.returncode == 0, done.stderr
    record: dict[str, Any] = json.loads(here.read_text(encoding="utf-8"))
    changed = {
        "aioduco.Robot.motion.movej2": "doc",
        "aioduco.compat.DucoCobot.movej2": "doc",
        "aioduco.connect": "signature",
        "aioduco.sync.Robot.motion.movej2": "signature",
    }
    for name, part in changed.items():
        record[name][part] = "Another text."
    # what is taken by keyword alone
    record["aioduco.Robot.servo.joints > ServoOptions"]["keys"].pop("rate")
    record["aioduco.movej"] = record.pop("aioduco.deg")
    other.write_text(json.dumps(record), encoding="utf-8")
    done = python(".ci/signatures", str(here), str(other), cwd=ROOT)
    assert done.returncode == 1
    for line in (
        "gone     aioduco.deg",
        "new      aioduco.movej",
        "changed  aioduco.Robot.servo.joints > ServoOptions: keys",
        *(f"changed  {name}: {part}" for name, part in changed.items()),
    ):
        assert f"{line}\n" in done.stdout, done.stdout
    assert done.stdout.endswith(": 7 differences\n")
