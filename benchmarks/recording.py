"""What a recording costs: processor time and size; and what its file lacks after a kill.

Phases with and without a recording alternate in one run, on a simulated arm in another process,
with the feed running in both: so the difference is the recording's.
"""

from __future__ import annotations

import random
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
from _common import parser, percentile, report
from _processes import Program

import aioduco
from aioduco.recording import read
from aioduco.sim import Simulator
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from numpy.typing import NDArray

RATE = 125.0
HERE, THERE = [0.0, -0.3, 1.9, 0.0, -1.5, 0.0], [1.2, 0.1, 1.5, 0.4, -1.2, 0.8]

CHILD = """
import sys
import aioduco
import anyio

async def main(port, path):
    async with aioduco.connect("127.0.0.1", port, state_rate=125, record=path) as robot:
        with robot.feed.subscribe() as samples:
            async for sample in samples:
                print(sample.received_at, flush=True)

anyio.run(main, int(sys.argv[1]), sys.argv[2])
"""


async def spent(seconds: float) -> NDArray[np.float64]:
    """Processor time and time by the clock [s], while the loop has a little to do."""
    begin = np.array([time.process_time(), time.monotonic()])
    async for _ in every(0.002):
        if time.monotonic() - begin[1] > seconds:
            break
    took: NDArray[np.float64] = np.array([time.process_time(), time.monotonic()]) - begin
    return took


async def move(robot: aioduco.Robot) -> None:
    """Move to and fro until this is cancelled."""
    while True:
        for target in (HERE, THERE):
            await robot.motion.movej2(target, v=1.0, a=2.0)


async def cost_and_size(
    robot: aioduco.Robot, folder: Path, rounds: int, seconds: float, *, moves: bool
) -> dict[str, Any]:
    """Phases with and without, while the arm moves or stands."""
    off, on = np.zeros(2), np.zeros(2)
    sizes, recorded, signals = 0, 0.0, 0
    async with anyio.create_task_group() as group:
        if moves:
            group.start_soon(move, robot)
        with robot.feed.subscribe("latest"):
            for _ in range(rounds):
                off += await spent(seconds)
                async with robot.record(folder / "run.mcap") as recording:
                    on += await spent(seconds)
                sizes += recording.statistics().size
                run = read(recording.path)
                recorded += run.duration
                signals = sum(
                    array.shape[1] if array.ndim > 1 else 1
                    for topic in run.topics
                    for name, array in run.arrays(topic).items()
                    if array.dtype != object and name != "time"
                )
        group.cancel_scope.cancel()
    return {
        "core_without_percent": round(100 * float(off[0] / off[1]), 2),
        "core_with_percent": round(100 * float(on[0] / on[1]), 2),
        "megabytes_an_hour": round(sizes / recorded * 3600 / 1e6, 1),
        "numbers": signals,
    }


def kills(port: int, folder: Path, count: int) -> dict[str, float]:
    """Seconds between the last sample that a program had, and the last that is in its file."""
    chance = random.Random(7)
    lost = []
    for number in range(count):
        path = folder / f"kill-{number}.mcap"
        with Program("-c", CHILD, str(port), str(path)) as program:
            last = float(program.line())
            end = last + chance.uniform(0.5, 3.0)
            while last < end:
                last = float(program.line())
            program.kill()
            *lines, _ = program.end().split("\n")  # the last one may be cut off
            last = float(lines[-1]) if lines else last
        run = read(path)
        offset = int(run.metadata["clock_offset"])
        times = [message.time_ns for message in run.messages("/joint_states")]
        lost.append(last - (max(times) - offset) * 1e-9 if times else end - last)
    return {
        "kills": count,
        "opened": len(lost),
        "lost_p50_s": round(percentile(lost, 50), 3),
        "lost_max_s": round(max(lost), 3),
    }


async def measured(quick: bool) -> dict[str, Any]:
    """Everything, on one simulator."""
    rounds, seconds = (2, 3.0) if quick else (10, 30.0)
    with tempfile.TemporaryDirectory() as name, Simulator.spawn() as sim:
        folder = Path(name)
        async with aioduco.connect(
            sim.host, sim.port, state_rate=RATE, heartbeat=10.0, loop_stall_limit=5.0
        ) as robot:
            await robot.bring_up()
            robot.feed.forces = True
            moving = await cost_and_size(robot, folder, rounds, seconds, moves=True)
            standing = await cost_and_size(robot, folder, rounds, seconds, moves=False)
        kill = kills(sim.port, folder, 5 if quick else 100)
    return {"rate": RATE, "moving": moving, "standing": standing, "kill": kill}


def main() -> None:
    options = parser(__doc__).parse_args()
    report(options, "recording", anyio.run(measured, options.quick))


if __name__ == "__main__":
    main()
