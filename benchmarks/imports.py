"""What a program and an operator wait for before the first call: whole processes that take turns.

    python benchmarks/imports.py [--quick] [--save]

    import numpy                the yardstick, beside the others in each round
    import aioduco              the package alone: names are loaded when they are used
    a robot is made             import aioduco, and the first connect()
    a robot is open             and `async with`, until the controller answers, and out again
    aioduco stop HOST           from the start of the process until the controller's handler has it

The controller answers from a script. Processor time is that of the whole process, its end included;
it tells more than the time on the clock where other programs run. Each ratio is the median of the
ratios to `import numpy` in the same round. Compiled modules are kept in a folder of this run.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from typing import TYPE_CHECKING

from _common import arguments, print_table, write_results

from aioduco.testing import RecordingServer

if TYPE_CHECKING:
    from collections.abc import Mapping

NUMPY = "import numpy"
STOP = "aioduco stop HOST"
OPEN = """
import anyio, aioduco
async def main():
    async with aioduco.connect({host!r}, {port}):
        pass
anyio.run(main)
"""
#: the largest processor time that is to be reached, to that of `import numpy`
LIMITS = {"a robot is made": 1.85, STOP: 2.35}
ANSWERS = {
    "stop": 5,
    "robotmoving": False,
    "get_robot_state": [6, 0, 5, 1],
    "get_robot_version": "3.8",
    "rpc_heartbeat": None,
}


class Took:
    """Seconds that a process took: on the clock, until its stop had arrived, and of a processor."""

    def __init__(self, command: list[str], env: Mapping[str, str], server: RecordingServer) -> None:
        stops = len(server.received("stop"))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        begin = time.monotonic()
        subprocess.run(command, env=env, check=True, stdout=subprocess.DEVNULL)
        self.clock: float = time.monotonic() - begin
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.processor: float = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if arrived := server.received("stop")[stops:]:
            self.clock = arrived[0].at - begin


def measured(rounds: int) -> dict[str, list[Took]]:
    """What each process took in each round."""
    with RecordingServer(ANSWERS) as server, tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, "PYTHONPYCACHEPREFIX": folder}
        env.pop("PYTHONDONTWRITEBYTECODE", None)
        python = [sys.executable, "-P"]
        commands = {
            NUMPY: [*python, "-c", "import numpy"],
            "import aioduco": [*python, "-c", "import aioduco"],
            "a robot is made": [*python, "-c", "import aioduco; aioduco.connect('192.0.2.1')"],
            "a robot is open": [*python, "-c", OPEN.format(host=server.host, port=server.port)],
            STOP: [*python, "-m", "aioduco.cli", "stop", f"{server.host}:{server.port}"],
        }
        for command in commands.values():
            Took(command, env, server)  # writes what is compiled
        took: dict[str, list[Took]] = {name: [] for name in commands}
        for _ in range(rounds):
            for name, command in commands.items():
                took[name].append(Took(command, env, server))
    return took


def main() -> int:
    options = arguments(__doc__, "imports")
    took = measured(5 if options.quick else 25)
    figures: dict[str, dict[str, float]] = {}
    for name, each in took.items():
        pairs = list(zip(each, took[NUMPY], strict=True))
        figures[name] = {
            "processor_ms": round(statistics.median(one.processor for one in each) * 1e3, 1),
            "clock_ms": round(statistics.median(one.clock for one in each) * 1e3, 1),
            "processor_to_numpy": round(
                statistics.median(one.processor / yard.processor for one, yard in pairs), 2
            ),
            "clock_to_numpy": round(
                statistics.median(one.clock / yard.clock for one, yard in pairs), 2
            ),
        }
    columns = ("", "processor ms", "clock ms", "processor / numpy", "clock / numpy", "at most")
    rows = [
        (name, *each.values(), f"{LIMITS[name]:g}" if name in LIMITS else "")
        for name, each in figures.items()
    ]
    print_table("Processes, from their start", columns, rows)
    missed = [name for name, limit in LIMITS.items() if figures[name]["processor_to_numpy"] > limit]
    print(f"not reached: {', '.join(missed) or 'nothing'}")
    if options.save:
        results = {"rounds": len(took[NUMPY]), "processes": figures, "limits": LIMITS}
        print(f"written: {write_results('imports', results)}")
    return len(missed)


if __name__ == "__main__":
    sys.exit(main())
