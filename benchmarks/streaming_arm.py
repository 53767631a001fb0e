"""What becomes of the arm: smooth from targets at a low rate, standing after a death."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from streaming_load import HOST, ask, sine

from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.servo import Servo

if TYPE_CHECKING:
    from aioduco.streaming.shared.options import Upsampling


async def upsampling(port: int) -> dict[str, dict[str, Any]]:
    """30 Hz targets at 500 Hz, as they arrive at the controller."""
    slow, fast, jerk = 30.0, 500.0, 300.0
    found: dict[str, dict[str, Any]] = {}
    ways: tuple[Upsampling, ...] = ("none", "linear", "cubic", "ruckig")
    for way in ways:
        ask(port, "arrivals")
        opened = Servo(StreamEndpoint(HOST, port)).joints(
            v=3.0,
            # without up-sampling the limiter stands aside: what is shown are the bare steps
            a=1e6 if way == "none" else 15.0,
            jerk=jerk,
            rate=fast,
            latest=True,
            upsample=way,
        )
        async with opened as stream:
            async for tick in stream.ticks(slow):
                moment = tick.number / slow
                await stream.send([0.15 * (1 - math.cos(3 * moment))] * 6)
                if moment > 4:
                    break
        _, first, second, third = ask(port, "motion")
        found[way] = {
            "velocity": first * fast,
            "acceleration": second * fast**2,
            "jerk": third * fast**3,
            "jerk_limit": jerk if way == "ruckig" else "",
        }
    bare = found["none"]["acceleration"]
    for row in found.values():
        row["to_bare_steps"] = round(row["acceleration"] / bare, 4)
    return found


PROGRAM = """
import sys
import anyio
from aioduco.streaming.servo import Servo
from aioduco.streaming.endpoint import StreamEndpoint

async def main(port):
    servo = Servo(StreamEndpoint("127.0.0.1", int(port)))
    async with servo.joints(v=1.0, a=5.0, rate=500) as stream:
        number = 0
        while True:
            way = 5e-6 * number**2 if number < 80 else 0.032 + 8e-4 * (number - 80)
            await stream.send([way] * 6)
            number += 1
            if number == 200:
                print(stream.pid, flush=True)

anyio.run(main, sys.argv[1])
"""


def runs(process: int) -> bool:
    """Whether a process runs; one that has ended and was not waited for does not."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def leftovers() -> set[str]:
    """Workers' processes, and what stands in shared memory under a name."""
    workers = {
        path.parent.name
        for path in Path("/proc").glob("[0-9]*/cmdline")
        if b"aioduco.streaming.worker.main" in _read(path)
    }
    return workers | {path.name for path in Path("/dev/shm").iterdir()}


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def killed(port: int) -> dict[str, Any]:
    """The program is killed while the arm moves at 0.4 rad/s, with a limit of 5 rad/s²."""
    before = leftovers()
    ask(port, "arrivals")
    program = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(port)], stdout=subprocess.PIPE, text=True
    )
    assert program.stdout is not None
    worker = int(program.stdout.readline())
    program.send_signal(signal.SIGKILL)
    program.communicate()
    start = time.monotonic()
    while runs(worker) and time.monotonic() < start + 10:
        time.sleep(0.002)
    gone = time.monotonic() - start
    slowing, last, stops = ask(port, "ending")
    return {
        "ms_to_worker_gone": round(gone * 1e3, 1),
        "ticks_to_rest": slowing,
        "step_at_the_end_rad": last,
        "stops": stops,
        "left": len(leftovers() - before),
    }


async def memory(port: int) -> dict[str, float]:
    """The size of a worker's process, in MB."""
    found: dict[str, float] = {}
    ways: tuple[Upsampling, ...] = ("none", "ruckig")
    for way in ways:
        opened = Servo(StreamEndpoint(HOST, port)).joints(
            v=1.0,
            a=5.0,
            source_rate=None if way == "none" else 50,
            upsample=way,
        )
        async with opened as stream:
            for point in sine(100, 500):
                await stream.send(point)
        found[way] = round(stream.statistics().memory / 1e6, 1)
    return found
