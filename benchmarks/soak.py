"""Ten minutes of feed, motions and reconnects: does memory, do threads or descriptors grow?

Against a simulated arm in a process of its own, through a proxy that cuts every connection from
time to time. The figures after a warm-up are compared with those at the end.
"""

from __future__ import annotations

import gc
import os
import threading
import time
from pathlib import Path
from typing import Any

import anyio
from _common import arguments, print_table, write_results

import aioduco
from aioduco.sim import Simulator
from aioduco.testing import FaultProxy

LEFT = [0.4, 0.0, 1.57, 0.0, -1.57, 0.0]
RIGHT = [-0.4, 0.1, 1.4, 0.0, -1.57, 0.2]
#: s between two cuts of every connection
CUT_EVERY = 10.0


def resources() -> dict[str, float]:
    """What this process holds now."""
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return {
        "memory_mib": round(pages * os.sysconf("SC_PAGE_SIZE") / 2**20, 2),
        "threads": threading.active_count(),
        "descriptors": len(os.listdir("/proc/self/fd")),  # noqa: PTH208
        "objects": len(gc.get_objects()),
    }


async def move(robot: aioduco.Robot, counts: dict[str, int]) -> None:
    while True:
        for target in (LEFT, RIGHT):
            try:
                await robot.motion.movej2(target, v=2.0, a=10.0)
                counts["motions"] += 1
            except aioduco.HeartbeatLost:
                # while the connection is away; tried again soon
                await anyio.sleep(0.05)
            except aioduco.DucoError:
                counts["interrupted"] += 1
                await recovered(robot)


async def recovered(robot: aioduco.Robot) -> None:
    while True:
        try:
            await robot.recover()
        except aioduco.DucoError:
            await anyio.sleep(0.1)
        else:
            return


async def read(robot: aioduco.Robot, counts: dict[str, int]) -> None:
    with robot.feed.subscribe() as feed:
        async for _ in feed:
            counts["samples"] += 1


async def measure(seconds: float) -> dict[str, Any]:
    counts = {"motions": 0, "interrupted": 0, "samples": 0, "cuts": 0}
    history: list[dict[str, float]] = []
    with (
        Simulator.spawn() as sim,
        FaultProxy(sim.host, sim.port) as proxy,
    ):
        async with aioduco.connect(proxy.host, proxy.port, heartbeat=2.0) as robot:
            await robot.bring_up()
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(move, robot, counts)
                tasks.start_soon(read, robot, counts)
                begin = due = time.monotonic()
                while due < begin + seconds:
                    due += min(CUT_EVERY, seconds / 8)
                    await anyio.sleep(max(0.0, due - time.monotonic()))
                    proxy.forget()
                    history.append(resources())
                    proxy.cut()
                    counts["cuts"] += 1
                tasks.cancel_scope.cancel()
    # The first quarter warms up: caches, the proxy's and the client's, fill.
    quarter = len(history) // 4
    settled = history[quarter : 2 * quarter]
    late = history[-quarter:]
    return {
        "seconds": seconds,
        **counts,
        "held": {
            name: {
                "settled": max(h[name] for h in settled),
                "at_the_end": max(h[name] for h in late),
                "growth": round(max(h[name] for h in late) - max(h[name] for h in settled), 2),
            }
            for name in history[0]
        },
    }


def main() -> None:
    options = arguments(__doc__, "soak")
    results = anyio.run(measure, 20.0 if options.quick else 600.0)
    held = results["held"]
    columns = ["held", "settled", "at the end", "growth"]
    print_table(
        f"{results['motions']} motions, {results['samples']} samples, {results['cuts']} cuts "
        f"in {results['seconds']:g} s",
        columns,
        [[name, f["settled"], f["at_the_end"], f["growth"]] for name, f in held.items()],
    )
    if options.save:
        print("written:", write_results("soak", results).name)


if __name__ == "__main__":
    main()
