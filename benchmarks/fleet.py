"""A fleet under one event loop: what 32 and 100 robots cost, and how soon all of them are stopped.

Each robot has its heartbeat, a feed of its state at 20 Hz with a reader, and motions one after
another. The controllers have trivial handlers and live in another process. In turn with each stop
of all, as many bare sends: what the same bytes take on open connections, while the fleet goes on.

With `--gateways` instead: how soon all arms of two gateways, each a process of its own (`aioduco
fleet serve`), are stopped from a third process, over Zenoh on loopback: from the call of
`FleetClient.stop` to the last handler called, and to the answer. Kept as `fleet_gateway.json`.
"""

from __future__ import annotations

import gc
import json
import os
import secrets
import socket
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import AsyncExitStack, ExitStack
from multiprocessing import get_context
from pathlib import Path
from subprocess import DEVNULL
from typing import TYPE_CHECKING, Any

import anyio
from _common import of_tests, parser, report, spread
from _processes import (
    CONTROLLER,
    HOST,
    Program,
    ServerProcess,
    call_bytes,
    first_stop,
    guard_of,
    open_lane,
    processor_time,
)

import aioduco
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    import argparse
    from collections.abc import Sequence

    from aioduco._wire.lane import WireLane
    from aioduco.supervision.settings import GuardKind

NAMES = ("one", "two")
GUARDS: dict[str, GuardKind | None] = {"without guard": None, "with guard": "process"}
FEED_RATE = 20.0
#: s that each motion takes
MOTION = 2.0
#: s between two stops, five samples: what asking for the last stops held up is over
PAUSE = 0.25


class Fleet:
    """Robots that are busy, until they are to stand.

    Attributes:
        samples: how many states were read.
        moving: set unless they are to stand.
    """

    def __init__(self) -> None:
        self.robots: list[aioduco.Robot] = []
        self.samples = 0
        self.moving = anyio.Event()
        self.moving.set()

    async def read(self, robot: aioduco.Robot) -> None:
        with robot.feed.subscribe() as feed:
            async for _ in feed:
                self.samples += 1

    async def move(self, robot: aioduco.Robot) -> None:
        # from rest to rest in MOTION seconds, as the client can work out itself
        speed, acceleration = 1.0, 100.0
        way = (MOTION - speed / acceleration) * speed
        while True:
            try:
                await robot.motion.movej2([way] * 6, speed, acceleration)
            except aioduco.TaskStopped:
                await self.moving.wait()


async def last_stop(lanes: Sequence[WireLane], begin: float) -> float:
    """Seconds until the last controller's handler was reached; it may be on its way."""
    return max([await first_stop(lane, begin) for lane in lanes]) - begin


async def measure(
    ports: list[int], guard: GuardKind | None, seconds: float, stops: int
) -> dict[str, Any]:
    fleet = Fleet()
    lanes: list[WireLane] = []
    late: dict[str, list[float]] = {"stop_all": [], "all_stand": [], "bare_sends": []}
    async with AsyncExitStack() as stack, anyio.create_task_group() as tasks:
        for port in ports:
            opening = aioduco.connect(HOST, port, state_rate=FEED_RATE, guard=guard)
            robot = await stack.enter_async_context(opening)
            fleet.robots.append(robot)
            lanes.append(await stack.enter_async_context(open_lane(port)))
            await lanes[-1].rpc.set_system_value_double("duration", MOTION)
            tasks.start_soon(fleet.read, robot)
            tasks.start_soon(fleet.move, robot)
        # on connections that nothing else uses
        bare = [stack.enter_context(socket.create_connection((HOST, port))) for port in ports]
        message = call_bytes("stop", True)
        # As docs/guides/production.md has it: else Python looks through all of them for garbage.
        gc.collect()
        gc.freeze()
        processes = [pid for pid in (os.getpid(), guard_of(fleet.robots[0])) if pid]
        before, begin = sum(map(processor_time, processes)), time.monotonic()
        samples = fleet.samples
        await anyio.sleep(seconds)
        wall = time.monotonic() - begin
        share = (sum(map(processor_time, processes)) - before) / wall
        rate = (fleet.samples - samples) / wall / len(ports)
        for _ in range(stops):
            await anyio.sleep(PAUSE)
            fleet.moving = anyio.Event()
            begin = time.monotonic()
            await aioduco.stop_all(fleet.robots)
            late["all_stand"].append(time.monotonic() - begin)
            late["stop_all"].append(await last_stop(lanes, begin))
            fleet.moving.set()
            await anyio.sleep(PAUSE)
            begin = time.monotonic()
            for each in bare:
                each.sendall(message)
            late["bare_sends"].append(await last_stop(lanes, begin))
            for each in bare:
                each.recv(4096)
        tasks.cancel_scope.cancel()
    figures = {"cores": round(share, 3), "samples_per_second_each": round(rate, 1)}
    return figures | {name: spread(times, "stops") for name, times in late.items()}


def served(count: int, guard: GuardKind | None, seconds: float, stops: int) -> dict[str, Any]:
    """One fleet and its controllers."""
    with ServerProcess(CONTROLLER, str(count)) as server:
        return anyio.run(measure, server.ports, guard, seconds, stops)


def files(folder: Path, ports: list[int]) -> list[Path]:
    """The file of each gateway: the second one connects to the first. A stop is proven by keys."""
    keys = folder / "keys.toml"
    keys.touch(0o600)
    keys.write_text("".join(f'{name} = "{secrets.token_hex(32)}"\n' for name in NAMES), "utf-8")
    half = len(ports) // 2
    endpoints = [f"tcp/{HOST}:{of_tests('ports').free_port()}" for _ in NAMES]
    made = []
    for number, name in enumerate(NAMES):
        text = (
            f'[fleet]\nname = "bench"\ngateway = "{name}"\nexpect = {json.dumps(NAMES)}\n'
            f'keys = "{keys}"\n'
            f'listen = ["{endpoints[number]}"]\nconnect = {json.dumps(endpoints[:number])}\n'
        )
        for port in ports[number * half : (number + 1) * half]:
            text += f'[[arm]]\nname = "arm-{port}"\nhost = "{HOST}"\nport = {port}\n'
        made.append(folder / f"{name}.toml")
        made[-1].write_text(text, encoding="utf-8")
    return made


async def reach(ports: list[int], path: Path, stops: int) -> dict[str, Any]:
    from aioduco.integrations.fleet import FleetClient, FleetSettings  # noqa: PLC0415  # an extra of its own

    late: dict[str, list[float]] = {"reached": [], "answered": []}
    async with AsyncExitStack() as stack:
        lanes = [await stack.enter_async_context(open_lane(port)) for port in ports]
        client = await stack.enter_async_context(FleetClient(FleetSettings.read(path)))

        def up() -> int:
            arms = (arm for gateway in client.view.gateways for arm in gateway.arms)
            return sum(arm.link == "up" for arm in arms)

        await eventually_async(lambda: up() == len(ports), 60.0)
        for _ in range(stops):
            await anyio.sleep(0.05)
            begin = time.monotonic()
            done = await client.stop()
            late["answered"].append(time.monotonic() - begin)
            if not done.confirmed:
                raise RuntimeError(f"a stop was not confirmed: {done}")
            late["reached"].append(await last_stop(lanes, begin))
    return {name: spread(times) for name, times in late.items()}


def gateways(options: argparse.Namespace) -> None:
    """The stop of two gateways, and its table."""
    each, stops = (4, 20) if options.quick else (16, 200)
    with ExitStack() as stack:
        server = stack.enter_context(ServerProcess(CONTROLLER, str(2 * each)))
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        made = files(folder, server.ports)
        for path in made:
            serve = ("-m", "aioduco.cli", "fleet", "serve", str(path))
            gateway = stack.enter_context(Program(*serve, stderr=DEVNULL))
            stack.callback(gateway.terminate)
            gateway.line()
        figures = anyio.run(reach, server.ports, made[0], stops)
    report(options, "fleet_gateway", {"gateways": 2, "arms_each": each, "stops": stops, **figures})


def main() -> None:
    made = parser(__doc__)
    made.add_argument("--gateways", action="store_true", help="of two gateways, over Zenoh")
    options = made.parse_args()
    if options.gateways:
        gateways(options)
        return
    counts, stops, seconds = ((8,), 20, 3.0) if options.quick else ((32, 100), 100, 12.0)
    fleets: dict[str, dict[str, Any]] = {}
    for count in counts:
        for name, guard in GUARDS.items():
            # Each in a program of its own, as one would be: nothing of another one is left in it.
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as program:
                found = program.submit(served, count, guard, seconds, stops).result()
            fleets[f"{count} robots, {name}"] = found
    report(options, "fleet", {"fleets": fleets})


if __name__ == "__main__":
    main()
