"""Programs of the pages for those who come from another language run as they are printed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from aioduco.sim import Simulator

GUIDES = Path(__file__).parents[1] / "docs" / "guides"


@pytest.mark.parametrize("name", ["from-cpp", "from-csharp"])
def test_the_program_of_the_page_runs(name: str, tmp_path: Path) -> None:
    text = (GUIDES / f"{name}.md").read_text("utf-8")
    (source,) = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    with Simulator.spawn() as sim:
        there = source.replace('"192.168.1.10"', f'"{sim.host}", {sim.port}')
        assert there != source
        file = tmp_path / "program.py"
        file.write_text(there, "utf-8")
        done = subprocess.run(
            [sys.executable, str(file)], check=False, capture_output=True, text=True, timeout=110
        )
    assert done.returncode == 0, done.stderr
