"""What the benchmarks of the drivers for ROS 1 and ROS 2 share."""

from __future__ import annotations

import importlib
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from _common import spread

if TYPE_CHECKING:
    import subprocess

    from aioduco.sim import Simulator

RATE = 125.0
HEARTBEAT = 1.0
#: s from a kill until the arm stands: by the heartbeat, and by the guard
LIMITS = {"": HEARTBEAT + 0.1, "process": 0.05}
#: s within which whatever is waited for has come
PATIENT = 120.0


def test_module(name: str) -> Any:
    """What the tests of the drivers start programs with."""
    tests = str(Path(__file__).resolve().parents[1] / "tests")
    if tests not in sys.path:
        sys.path.insert(0, tests)
    return importlib.import_module(f"integrations.ros.{name}")


def family(pid: int) -> list[int]:
    """A process and its children."""
    children = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [pid, *(int(child) for child in children.split())]


def processor(pid: int) -> float:
    """Seconds of processor time of a process and of its children."""
    programs = test_module("programs")
    return float(sum(programs.processor_time(each) for each in family(pid)))


def stood_after(sim: Simulator, process: subprocess.Popen[str]) -> float:
    """Kill a process, and give the seconds until the arm stands."""
    begin = time.monotonic()
    process.kill()
    while sim.moving and time.monotonic() < begin + PATIENT:
        time.sleep(0.0005)
    return time.monotonic() - begin


def kill_row(late: list[float], limit: float) -> dict[str, Any]:
    """Figures of the times until the arm stood [s], and of those beyond a limit [s]."""
    return {
        **{
            name.replace("_us", "_ms"): round(value / 1e3, 1)
            for name, value in spread(late).items()
            if name in ("p50_us", "max_us")
        },
        "limit_ms": limit * 1e3,
        "beyond": sum(each > limit for each in late),
        "times": len(late),
    }
