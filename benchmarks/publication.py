"""Twenty watchers of `robot.publish()` at 20 samples a second: what they cost the program.

    python benchmarks/publication.py [--quick] [--save]

The program's processor time, by turns of short phases on one simulated arm in another process: with
the feed alone, published with nobody who looks, and with twenty watchers in a third process, each
of which takes every channel. The feed alone is measured twice: what the two differ by is the noise
of the machine. How many samples a watcher gets a second is counted from its own messages.
"""

from __future__ import annotations

import asyncio
import json
import struct
import subprocess
import sys
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import anyio
import anyio.to_thread
from _common import arguments, percentile, print_table, write_results

import aioduco
from aioduco.sim.process import SimulatorProcess

if TYPE_CHECKING:
    from collections.abc import Iterator

WATCHERS = 20
RATE = 20.0
HERE, THERE = [0.0, -0.3, 1.9, 0.0, -1.5, 0.0], [1.2, 0.1, 1.5, 0.4, -1.2, 0.8]
MESSAGE = struct.Struct("<BIQ")


async def watch(port: int, seen: list[int]) -> None:
    """Take every channel, and keep the times of the samples of the joints."""
    from websockets.asyncio.client import connect  # noqa: PLC0415 - of the watchers' process alone
    from websockets.typing import Subprotocol  # noqa: PLC0415

    protocol = Subprotocol("foxglove.sdk.v1")
    async with connect(f"ws://127.0.0.1:{port}", subprotocols=[protocol]) as connection:
        number = 0
        joints = -1
        async for said in connection:
            if isinstance(said, bytes):
                kind, channel, at = MESSAGE.unpack_from(said)
                if kind == 1 and channel == joints:
                    seen.append(at)
                continue
            told = json.loads(said)
            if told["op"] != "advertise":
                continue
            wanted = []
            for channel in told["channels"]:
                if channel["topic"] == "/joint_states":
                    joints = number
                wanted.append({"id": number, "channelId": channel["id"]})
                number += 1
            await connection.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))


async def watchers(port: int) -> None:
    """Watch until the standard input ends; then say how much each has seen, and for how long."""
    seen: list[list[int]] = [[] for _ in range(WATCHERS)]
    tasks = [asyncio.create_task(watch(port, each)) for each in seen]
    while not all(seen):  # noqa: ASYNC110 - each is filled by a task of its own
        await asyncio.sleep(0.05)
    print("all", flush=True)
    await asyncio.to_thread(sys.stdin.read)
    for task in tasks:
        task.cancel()
    print(json.dumps([(len(each), (each[-1] - each[0]) * 1e-9) for each in seen]))


@contextmanager
def twenty(port: int, rates: list[float]) -> Iterator[None]:
    """The watchers in a process of their own; the rate at which each has seen samples."""
    command = [sys.executable, __file__, "--watch", str(port)]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as program:
        try:
            assert program.stdout is not None
            program.stdout.readline()
            yield
            said, _ = program.communicate()
            rates += [(count - 1) / seconds for count, seconds in json.loads(said)]
        finally:
            program.kill()


class Phase:
    """Processor time of all phases of one kind."""

    def __init__(self) -> None:
        self.cpu = 0.0
        self.wall = 0.0

    async def measure(self, seconds: float) -> None:
        """Measure this process for a time."""
        cpu, wall = time.process_time(), time.monotonic()
        await anyio.sleep(seconds)
        self.cpu += time.process_time() - cpu
        self.wall += time.monotonic() - wall

    @property
    def percent(self) -> float:
        """Of one core."""
        return round(100 * self.cpu / self.wall, 2)


async def moving(robot: aioduco.Robot) -> None:
    """Move to and fro until this is cancelled."""
    while True:
        for target in (HERE, THERE):
            await robot.motion.movej2(target, v=1.0, a=2.0)


async def measured(quick: bool) -> dict[str, Any]:
    """All phases, on one simulator."""
    rounds, seconds = (2, 2.0) if quick else (10, 15.0)
    phases = {
        name: Phase()
        for name in ("feed alone", "feed alone, once more", "published", "with 20 watchers")
    }
    rates: list[float] = []
    with SimulatorProcess({}) as sim:
        async with aioduco.connect(
            sim.host, sim.port, state_rate=RATE, heartbeat=10.0, loop_stall_limit=5.0
        ) as robot:
            await robot.bring_up()
            robot.feed.forces = True
            async with anyio.create_task_group() as group:
                group.start_soon(moving, robot)
                with robot.feed.subscribe("latest"):
                    for _ in range(rounds):
                        await phases["feed alone"].measure(seconds)
                        await phases["feed alone, once more"].measure(seconds)
                        async with robot.publish(0) as publication:
                            await phases["published"].measure(seconds)
                            watching = twenty(publication.port, rates)
                            await anyio.to_thread.run_sync(watching.__enter__)
                            await phases["with 20 watchers"].measure(seconds)
                            await anyio.to_thread.run_sync(watching.__exit__, None, None, None)
                group.cancel_scope.cancel()
    rates.sort()
    figures = {name: {"core_percent": phase.percent} for name, phase in phases.items()}
    cost = phases["with 20 watchers"].percent - phases["feed alone"].percent
    return {
        "watchers": WATCHERS,
        "rate_hz": RATE,
        "cost_of_publishing_and_watchers_percent": round(cost, 2),
        "seen_by_the_slowest_watcher_hz": round(rates[0], 2),
        "seen_p50_hz": round(percentile(rates, 50.0), 2),
        "program": figures,
    }


def main() -> None:
    if sys.argv[1:2] == ["--watch"]:
        asyncio.run(watchers(int(sys.argv[2])))
        return
    options = arguments(__doc__, "publication")
    results = anyio.run(measured, options.quick)
    rows = [(name, row["core_percent"]) for name, row in results["program"].items()]
    print_table("processor time of the program", ("phase", "% of a core"), rows)
    single = [(name, value) for name, value in results.items() if name != "program"]
    print_table("publication", ("figure", "value"), single)
    if options.save:
        print(f"written to {write_results('publication', results)}")


if __name__ == "__main__":
    main()
