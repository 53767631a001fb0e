"""What the benchmarks share: options, turns, figures, the machine, JSON files."""

from __future__ import annotations

import argparse
import datetime
import importlib
import importlib.metadata
import json
import os
import platform
import re
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

T = TypeVar("T")

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
#: those that this program may use, before it is kept to some of them
CORES = sorted(os.sched_getaffinity(0))


def percentile(values: Sequence[float] | NDArray[np.float64], percent: float) -> float:
    """The value below which so many percent of the values lie (nearest rank)."""
    return float(np.percentile(values, percent, method="inverted_cdf"))


def spread(seconds: Iterable[float], count: str = "") -> dict[str, float]:
    """p50, p99 of a hundred or more, p99.9 of a thousand or more, and max, in microseconds.

    Args:
        seconds: the durations.
        count: the name under which their number is given; empty for none.
    """
    values = [float(each) * 1e6 for each in seconds]
    told = (each for each, least in ((50, 1), (99, 100), (99.9, 1000)) if len(values) >= least)
    figures = {f"p{each:g}_us": round(percentile(values, each), 1) for each in told}
    figures["max_us"] = round(max(values), 1)
    return figures | ({count: len(values)} if count else {})


def in_turns(rounds: int, alternatives: Mapping[str, T]) -> Iterator[tuple[str, T]]:
    """Each alternative in each round, so that what else the machine does meets them all alike.

    Each round begins with the next one, so that none is always behind the same other one.
    """
    order = list(alternatives.items())
    for _ in range(rounds):
        yield from order
        order.append(order.pop(0))


#: the packages whose versions a result has
PACKAGES = (
    *("aioduco", "anyio", "gymnasium", "lerobot", "mujoco-core", "numpy", "panda-gym", "pybullet"),
    *("thrift", "thriftpy2"),
)


def machine() -> dict[str, Any]:
    """The machine, the commit and the versions of a result; nothing that names a host."""
    policies = {os.SCHED_OTHER: "other", os.SCHED_FIFO: "fifo", os.SCHED_RR: "round robin"}
    processor = re.search(r"^model name\s*: (.+)", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    versions = {each.name: each.version for each in importlib.metadata.distributions()}
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "commit": commit(),
        "wake_up_us": wake_up(),
        # a busy machine needs `chrt -f 5` for figures of its own
        "scheduling": policies.get(os.sched_getscheduler(0), "other"),
        "system": f"{platform.system()} {platform.release()}",
        "processor": processor[1] if processor else platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "packages": {name: versions[name] for name in PACKAGES if name in versions},
    }


def commit() -> str:
    """The commit of this tree, with "+" if tracked files differ from it."""
    command = ["git", "-C", str(HERE), "describe", "--always", "--exclude=*", "--dirty=+"]
    described = subprocess.run(command, capture_output=True, text=True, check=False)
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


def at_most(limit: float, found: float) -> dict[str, Any]:
    """A line of what is asked for: the limit, what was found, and whether that is enough."""
    return {"asked": f"at most {limit:g}", "found": found, "reached": found <= limit}


def at_least(limit: float, found: float) -> dict[str, Any]:
    """As `at_most`, of a figure that may be larger."""
    return {"asked": f"at least {limit:g}", "found": found, "reached": found >= limit}


def text_of(results: dict[str, Any]) -> str:
    return json.dumps(results, indent=2, ensure_ascii=False)


def write_results(name: str, results: dict[str, Any]) -> Path:
    """Write `results/<name>.json`, with the machine that they were measured on."""
    RESULTS.mkdir(exist_ok=True)
    path = RESULTS / f"{name}.json"
    path.write_text(text_of({"machine": machine()} | results) + "\n", encoding="utf-8")
    return path


def parser(doc: str | None) -> argparse.ArgumentParser:
    """The options that every benchmark takes."""
    made = argparse.ArgumentParser(description=(doc or "").splitlines()[0])
    made.add_argument("--quick", action="store_true", help="seconds instead of minutes, for CI")
    made.add_argument("--save", action="store_true", help="write the figures to benchmarks/results")
    return made


def report(options: argparse.Namespace, name: str, results: dict[str, Any]) -> None:
    """Print the results, and write them if the options ask for it."""
    print(text_of(results))
    if options.save:
        print("written:", write_results(name, results))


def of_tests(name: str) -> Any:
    """A module of the tests, which makes what is measured."""
    sys.path.append(str(HERE.parent / "tests"))
    return importlib.import_module(name)
