"""What a worker's process loads, and which parts know neither clock nor file."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest
from for_each import for_each

import aioduco.streaming
from aioduco._process import spawn
from aioduco._process.platform import has_memory_files

from .conftest import HERE, Controller

FOLDER = Path(aioduco.streaming.__file__).parent
PURE = [
    "shared/config",
    "shared/options",
    "ends",
    "joint_trajectory",
    "worker/life",
    "worker/limiter",
    "sampling",
    "shared/space",
    "shared/histogram",
    "shared/words",
    "worker/interpolation",
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


@for_each("name", PURE)
def test_pure_parts_know_no_clock_and_no_file(name: str) -> None:
    assert not imported(FOLDER / f"{name}.py") & IMPURE


#: what no worker has a use for: the program's side of the package, and what that stands on
UNUSED = {
    "anyio",
    "asyncio",
    "concurrent.futures",
    "numpy",
    "logging.config",
    "multiprocessing",
    "subprocess",
}
#: of these, what the standard library's shared memory stands on, where there are no memory files
OF_SHARED_MEMORY = {"multiprocessing", "subprocess"}
#: of this package, all that a worker may load beside what is below `worker` and `shared`
USED = {
    "aioduco",
    "aioduco._process",
    "aioduco._process.platform",
    "aioduco._process.copying",
    *(
        "aioduco._process.reporting",
        "aioduco._process.wakeup",
    ),  # for what traces the connections, as the next one
    "aioduco._process.scheduling",
    "aioduco._wire",
    "aioduco.errors",
    "aioduco._process.trial",  # the end of a connection is another one in a trial
    "aioduco.models",
    *("aioduco.models.address", "aioduco.models.similar"),  # what a host may be called
    *("aioduco.models.enums", "aioduco.models.named_int"),  # numbers of the wire by name
    "aioduco.models.host_port",  # for errors
    "aioduco.models.quaternions",  # for poses
    "aioduco.models.trace",
    "aioduco.streaming",
    "aioduco.supervision",
    "aioduco.supervision.unanswered",  # the machine that brings the arm to rest, which is pure
}
OF_THE_WIRE = {"channel", "lane", "owner_loop", "pool", "messages"}

#: MB of a worker at its largest; it was 48 with numpy and thriftpy2's parser.
#: Python 3.14 takes more
MOST = 34.0 if sys.version_info < (3, 14) else 38.0

#: stands before what each process of the package runs first
RECORDER = """
import atexit, pathlib, sys
atexit.register(lambda: pathlib.Path({path!r}).write_text(" ".join(sys.modules)))
"""


@pytest.mark.slow
async def test_a_worker_loads_what_it_needs_and_stays_small(
    controller: Controller, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A real one, started as each is, with limits of jerk; at its exit it tells what it loaded."""
    record = tmp_path / "modules"
    monkeypatch.setattr(spawn, "_BEGIN", RECORDER.format(path=str(record)) + spawn._BEGIN)
    stream = controller.servo.joints(v=1.0, a=5.0, source_rate=100, upsample="ruckig")
    async with stream:
        await stream.send(HERE)
    loaded = set(record.read_text().split())
    assert {"aioduco.streaming.worker.main", "ruckig"} <= loaded
    assert loaded & UNUSED == (set() if has_memory_files() else OF_SHARED_MEMORY)
    ours = {name for name in loaded if name.partition(".")[0] == "aioduco"}
    beyond = {
        name
        for name in ours - USED
        if not name.startswith(
            ("aioduco.streaming.worker", "aioduco.streaming.shared", "aioduco._wire.")
        )
    }
    assert beyond == set()
    assert not {f"aioduco._wire.{name}" for name in OF_THE_WIRE} & ours
    megabytes = stream.statistics().memory / 1e6
    assert 0 < megabytes <= MOST
