"""The page about scenes, collisions and pictures: its parts are one program."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from aioduco.sim.controller.monitoring import LEVELS

PAGE = Path(__file__).parents[2] / "docs" / "scene.md"


def test_the_page_runs_as_it_stands(tmp_path: Path) -> None:
    parts = re.findall(r"^```python\n(.*?)^```", PAGE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert len(parts) >= 7
    file = tmp_path / "scene.py"
    file.write_text("\n".join(parts), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-W", "error", str(file)],
        check=False,
        capture_output=True,
        text=True,
        timeout=50,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_its_shares_are_those_of_the_levels() -> None:
    told = re.search(r"\| share \| off \|(.*)\|", PAGE.read_text("utf-8"))
    assert told is not None
    shares = [float(share.strip(" %")) / 100 for share in told[1].split("|")]
    assert shares == list(LEVELS.values())[1:]
