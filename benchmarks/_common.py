"""What the benchmarks share: options, percentiles, the machine, tables, JSON files, processes."""

from __future__ import annotations

import argparse
import contextlib
import datetime
import importlib
import importlib.metadata
import json
import os
import platform
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from typing import Self

    from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
#: those that this program may use, before it is kept to some of them
CORES = sorted(os.sched_getaffinity(0))

#: the percentiles that every benchmark gives
PERCENTILES = (50.0, 99.0, 99.9)


def percentile(values: Sequence[float] | NDArray[np.float64], percent: float) -> float:
    """The value below which so many percent of the values lie (nearest rank)."""
    return float(np.percentile(values, percent, method="inverted_cdf"))


def spread(seconds: Iterable[float]) -> dict[str, float]:
    """p50, p99, p99.9 and max in microseconds, of durations in seconds."""
    values = [float(each) * 1e6 for each in seconds]
    figures = {f"p{percent:g}_us": percentile(values, percent) for percent in PERCENTILES}
    return {name: round(value, 1) for name, value in (figures | {"max_us": max(values)}).items()}


def scheduling() -> str:
    """How this process is scheduled: a busy machine needs `chrt -f 5` for figures of its own."""
    names = {os.SCHED_OTHER: "other", os.SCHED_FIFO: "fifo", os.SCHED_RR: "round robin"}
    return names.get(os.sched_getscheduler(0), "other")


def processor_time(pid: int) -> float:
    """Seconds of processor time that a process has used: the clock of clock_getcpuclockid(3)."""
    return time.clock_gettime(~pid << 3 | 2)


#: the packages whose versions a result has
PACKAGES = {
    "aioduco", "thriftpy2", "thrift", "anyio", "numpy", "mujoco-core",
    "gymnasium", "panda-gym", "pybullet", "lerobot",
}  # fmt: skip


def machine() -> dict[str, Any]:
    """The machine, the commit and the versions of a result; nothing that names a host."""
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "commit": commit(),
        "wake_up_us": wake_up(),
        "scheduling": scheduling(),
        "system": f"{platform.system()} {platform.release()}",
        "processor": _processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "packages": dict(
            sorted(
                (each.name, each.version)
                for each in importlib.metadata.distributions()
                if each.name in PACKAGES
            )
        ),
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
        os.sched_setaffinity(process.pid, CORES)
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


def show(title: str, rows: Mapping[str, Mapping[str, object]]) -> None:
    """Print a table: a row for each name, a column for each key."""
    columns = list(dict.fromkeys(key for row in rows.values() for key in row))
    cells = [[name, *(_cell(row.get(key, "")) for key in columns)] for name, row in rows.items()]
    cells.insert(0, ["", *columns])
    first, *others = (max(map(len, column)) for column in zip(*cells, strict=True))
    print(title)
    for name, *values in cells:
        print("  ".join([name.ljust(first), *map(str.rjust, values, others)]))
    print()


def _cell(value: object) -> str:
    """A value as docs/figures.py shows it."""
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
    return str(value)


def parser(doc: str | None) -> argparse.ArgumentParser:
    """The options that every benchmark takes."""
    made = argparse.ArgumentParser(description=(doc or "").splitlines()[0])
    made.add_argument("--quick", action="store_true", help="seconds instead of minutes, for CI")
    made.add_argument("--save", action="store_true", help="write the figures to benchmarks/results")
    return made


def save(options: argparse.Namespace, name: str, results: dict[str, Any]) -> None:
    """Write the results, if the options ask for it."""
    if options.save:
        print("written:", write_results(name, results))


def of_tests(name: str) -> Any:
    """A module of the tests, which makes what is measured."""
    sys.path.append(str(HERE.parent / "tests"))
    return importlib.import_module(name)


@contextlib.contextmanager
def core_of_its_own() -> Iterator[None]:
    """What starts in the block gets a core that this thread does not use, if there are two.

    A controller is another machine. When the scheduler puts both on one core, a direct call
    takes a third of the time and nothing that is compared here means anything.
    """
    *ours, theirs = CORES
    os.sched_setaffinity(0, {theirs})
    try:
        yield
    finally:
        os.sched_setaffinity(0, ours or CORES)


class Program:
    """A program of Python in a process of its own, which reads and writes lines.

    It ends when its standard input is closed, so it cannot outlive the benchmark.
    """

    def __init__(self, *arguments: str, quiet: bool = False) -> None:
        self.process = subprocess.Popen(
            [sys.executable, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL if quiet else None,
            text=True,
        )

    def __enter__(self) -> Self:
        return self

    def line(self) -> str:
        """The next line that it writes."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.process.args!r} ended before it answered")
        return line

    def ask(self, line: str) -> str:
        """Write a line, and return the one that it answers by."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{line}\n")
        self.process.stdin.flush()
        return self.line()

    def end(self) -> str:
        """Close its standard input; the rest of what it writes until it has ended."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        with self.process:
            self.process.stdin.close()
            return self.process.stdout.read()

    def __exit__(self, *_: object) -> None:
        if self.process.returncode is None:
            self.end()


class ServerProcess(Program):
    """A script that serves on a core of its own, and says where by one line of JSON."""

    def __init__(self, script: str, *options: str) -> None:
        with core_of_its_own():
            super().__init__(str(HERE / script), *options)
        self.endpoints: dict[str, int] = json.loads(self.line())
