"""What a program and an operator wait for before the first call: whole processes that take turns.

    python benchmarks/imports.py [--quick] [--save]

    import numpy                the yardstick, beside the others in each round
    import aioduco              the package alone: names are loaded when they are used
    a robot is made             import aioduco, and the first connect()
    a robot is open             and `async with`, until the controller answers, and out again
    aioduco stop HOST           from the start of the process until the controller's handler has it

The controller answers from a script. Processor time is that of the whole process, its end included;
it tells more than the time on the clock where other programs run. Each ratio is the median of the
ratios to `import numpy` in the same round. Asked for, to numpy's processor time: at most 1.85 until
a robot is made, 2.35 for `aioduco stop`. Compiled modules are kept in a folder of this run.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np
from _common import in_turns, parser, report

from aioduco.testing import RecordingServer

NUMPY = "import numpy"
STOP = "aioduco stop HOST"
OPEN = """
import anyio, aioduco
async def main():
    async with aioduco.connect({host!r}, {port}):
        pass
anyio.run(main)
"""
Took = tuple[float, float]
ANSWERS = {
    "stop": 5,
    "robotmoving": False,
    "get_robot_state": [6, 0, 5, 1],
    "get_robot_version": "3.8",
    "rpc_heartbeat": None,
}


def took(command: list[str], env: dict[str, str], server: RecordingServer) -> Took:
    """Seconds of a processor, and on the clock: until its stop has arrived, or else its end."""
    stops = len(server.received("stop"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    subprocess.run(command, env=env, check=True, stdout=subprocess.DEVNULL)
    end = time.monotonic()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if arrived := server.received("stop")[stops:]:
        end = arrived[0].at
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return processor, end - begin


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
            took(command, env, server)  # writes what is compiled
        found: dict[str, list[Took]] = {name: [] for name in commands}
        for name, command in in_turns(rounds, commands):
            found[name].append(took(command, env, server))
    return found


def main() -> None:
    options = parser(__doc__).parse_args()
    found = measured(5 if options.quick else 25)
    figures: dict[str, dict[str, float]] = {}
    for name, rounds in found.items():
        processor, clock = np.median(rounds, axis=0).tolist()
        ratios = np.median(np.array(rounds) / found[NUMPY], axis=0).tolist()
        figures[name] = {
            "processor_ms": round(processor * 1e3, 1),
            "clock_ms": round(clock * 1e3, 1),
            "processor_to_numpy": round(ratios[0], 2),
            "clock_to_numpy": round(ratios[1], 2),
        }
    report(options, "imports", {"processes": figures})


if __name__ == "__main__":
    main()
