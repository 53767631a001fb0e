"""What the benchmarks share: percentiles, the machine, the table, the JSON file, servers."""

from __future__ import annotations

import argparse
import datetime
import importlib.metadata
import importlib.util
import json
import os
import platform
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from types import TracebackType

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"

#: the percentiles that every benchmark gives
PERCENTILES = (50.0, 99.0, 99.9)


def percentile(ordered: Sequence[float], percent: float) -> float:
    """The value below which so many percent of the ordered values lie (nearest rank)."""
    if not ordered:
        raise ValueError("no values were measured")
    rank = -(-len(ordered) * percent // 100)
    return ordered[min(len(ordered) - 1, max(0, int(rank) - 1))]


def spread(seconds: Iterable[float]) -> dict[str, float]:
    """p50, p99, p99.9 and max in microseconds, of durations in seconds."""
    ordered = sorted(seconds)
    figures = {f"p{percent:g}_us": percentile(ordered, percent) * 1e6 for percent in PERCENTILES}
    return {name: round(value, 1) for name, value in figures.items()} | {
        "max_us": round(ordered[-1] * 1e6, 1)
    }


def scheduling() -> str:
    """How this process is scheduled: a busy machine needs `chrt -f 5` for figures of its own."""
    names = {os.SCHED_OTHER: "other", os.SCHED_FIFO: "fifo", os.SCHED_RR: "round robin"}
    return names.get(os.sched_getscheduler(0), "other")


#: the packages whose versions a result has: as they are imported, and as they are installed
PACKAGES = {name: name for name in ("aioduco", "thriftpy2", "thrift", "anyio", "numpy")} | {
    "mujoco": "mujoco-core",
    "gymnasium": "gymnasium",
    "panda_gym": "panda-gym",
    "pybullet": "pybullet",
    "lerobot": "lerobot",
}


def machine() -> dict[str, Any]:
    """The machine, the commit and the versions of a result; nothing that names a host."""
    versions = {
        name: importlib.metadata.version(installed)
        for name, installed in PACKAGES.items()
        if importlib.util.find_spec(name) is not None
    }
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "commit": commit(),
        "wake_up_us": wake_up(),
        "system": f"{platform.system()} {platform.release()}",
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "packages": versions,
    }


def commit() -> str:
    """The commit of this tree, with "+" if tracked files differ from it."""
    described = subprocess.run(
        ["git", "-C", str(HERE), "describe", "--always", "--exclude=*", "--dirty=+"],
        capture_output=True,
        text=True,
        check=False,
    )
    return described.stdout.strip() or "unknown"


_ECHO = """
import socket
other = socket.socket(fileno=0)
while data := other.recv(1):
    other.sendall(data)
"""


def wake_up(rounds: int = 1000) -> dict[str, float]:
    """Half of the way of a byte to another process and back [µs]: what any hand-over costs here."""
    ours, theirs = socket.socketpair()
    with (
        ours,
        subprocess.Popen([sys.executable, "-IS", "-c", _ECHO], stdin=theirs.fileno()) as process,
    ):
        theirs.close()
        if hasattr(os, "sched_setaffinity"):  # this process may be kept to one core
            os.sched_setaffinity(process.pid, range(os.cpu_count() or 1))
        took = []
        for _ in range(rounds + 10):
            begin = time.perf_counter()
            ours.sendall(b"x")
            ours.recv(1)
            took.append((time.perf_counter() - begin) / 2)
        ours.close()
        process.wait(10)
    figures = spread(took[10:])
    return {name: figures[f"{name}_us"] for name in ("p50", "p99", "max")}


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.machine()


def at_most(limit: float, found: float) -> dict[str, Any]:
    """A line of what is asked for: the limit, what was found, and whether that is enough."""
    return {"asked": f"at most {limit:g}", "found": found, "reached": found <= limit}


def at_least(limit: float, found: float) -> dict[str, Any]:
    """As `at_most`, of a figure that may be larger."""
    return {"asked": f"at least {limit:g}", "found": found, "reached": found >= limit}


def write_results(name: str, results: dict[str, Any]) -> Path:
    """Write `results/<name>.json`, with the machine that they were measured on."""
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{name}.json"
    text = json.dumps({"machine": machine()} | results, indent=2, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")
    return path


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Print a table in plain text."""
    cells = [[_cell(value) for value in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(columns, *cells, strict=True)]
    print(title)
    for row in [list(columns), *cells]:
        first, *rest = (
            text.ljust(width) if index == 0 else text.rjust(width)
            for index, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        print("  ".join([first, *rest]))
    print()


def _cell(value: object) -> str:
    if isinstance(value, float):
        if value >= 100:
            return f"{value:,.0f}"
        return f"{value:.1f}" if value >= 10 else f"{value:.2f}"
    return str(value)


def arguments(doc: str | None, name: str) -> argparse.Namespace:
    """The options that every benchmark takes."""
    return parser(doc, name).parse_args()


def parser(doc: str | None, name: str) -> argparse.ArgumentParser:
    """A parser of those options, for a benchmark that takes others as well."""
    made = argparse.ArgumentParser(description=(doc or "").splitlines()[0])
    made.add_argument("--quick", action="store_true", help="seconds instead of minutes, for CI")
    made.add_argument(
        "--save", action="store_true", help=f"write the figures to benchmarks/results/{name}.json"
    )
    return made


def apart() -> tuple[set[int], set[int]] | None:
    """Cores for the client and a core for the server, or None if there are too few.

    A controller is another machine. When the scheduler puts both on one core, a direct call
    takes a third of the time and nothing that is compared here means anything.
    """
    if not hasattr(os, "sched_getaffinity"):
        return None
    cores = sorted(os.sched_getaffinity(0))
    return (set(cores[:-1]), {cores[-1]}) if len(cores) > 1 else None


class ServerProcess:
    """A script that serves in a process of its own and says where in one line of JSON.

    The process ends when its standard input is closed, so it cannot outlive the benchmark.
    """

    def __init__(self, script: str, *options: str) -> None:
        self._command = [sys.executable, str(HERE / script), *options]
        self.endpoints: dict[str, int] = {}

    def __enter__(self) -> ServerProcess:
        self._process = subprocess.Popen(
            self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        cores = apart()
        if cores is not None:
            client, server = cores
            os.sched_setaffinity(self._process.pid, server)
            os.sched_setaffinity(0, client)
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self._command} ended before it served")
        self.endpoints = json.loads(line)
        return self

    def ask(self, line: str) -> str:
        """Write a line to the script, and return the line that it answers by."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()
        return self._process.stdout.readline()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.communicate(timeout=10)
