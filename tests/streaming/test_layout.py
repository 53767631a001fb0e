"""What a lane's process may load, and which parts know neither clock nor file."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import aioduco.streaming

FOLDER = Path(aioduco.streaming.__file__).parent
PURE = [
    "config",
    "ends",
    "filling",
    "gains",
    "jerk",
    "joint_trajectory",
    "limits",
    "rates",
    "sampling",
    "source",
    "space",
    "statistics",
    "upsample",
]
IMPURE = {"time", "os", "socket", "threading", "select", "mmap", "signal", "anyio", "pathlib"}


def imported(path: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.partition(".")[0])
    return found


@pytest.mark.parametrize("name", PURE)
def test_pure_parts_know_no_clock_and_no_file(name: str) -> None:
    assert not imported(FOLDER / f"{name}.py") & IMPURE


def test_a_lane_loads_nothing_of_the_face() -> None:
    """The package's own `__init__` aside, which every import of a part of it runs."""
    script = (
        "import sys, types, importlib.util\n"
        "spec = importlib.util.find_spec('aioduco')\n"
        "package = types.ModuleType('aioduco')\n"
        "package.__path__ = list(spec.submodule_search_locations)\n"
        "sys.modules['aioduco'] = package\n"
        "import aioduco.streaming.lane\n"
        "print(*sorted({'anyio', 'asyncio', 'ruckig', 'aioduco.streaming.stream',"
        " 'aioduco.api'} & set(sys.modules)))\n"
    )
    shown = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True
    )
    assert shown.stdout.split() == []
