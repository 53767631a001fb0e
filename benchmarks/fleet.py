"""A fleet under one event loop: what 32 and 100 robots cost, and how soon all of them are stopped.

Each robot has its heartbeat, a feed of its state at 20 Hz with a reader, and motions one after
another. The controllers have trivial handlers and live in one other process. In turn with each stop
of all, as many bare sends: what the same bytes take on open connections, while the fleet goes on.

With `--gateways` instead: how soon all arms of two gateways are stopped from a third process, over
Zenoh on loopback. Each gateway is a process of its own, `aioduco fleet serve`. Measured is the time
from the call of `FleetClient.stop` until the last controller's handler is reached, and until the
answer. It is kept as a result of its own, `fleet_gateway.json`.
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
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
from _common import Program, ServerProcess, parser, processor_time, save, show, spread
from controller import first_stop

import aioduco
from aioduco._wire import codec, idl
from aioduco._wire.lane import WireLane
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable

HOST = "127.0.0.1"
NAMES = ("one", "two")
SPREADS = ("stop_all", "all_stand", "bare_sends")
FEED_RATE = 20.0
#: s that each motion takes
MOTION = 2.0


class Member:
    """One robot of the fleet, busy."""

    def __init__(self, robot: aioduco.Robot, lane: WireLane) -> None:
        self.robot = robot
        self.lane = lane
        self.samples = 0
        #: set unless the robot is to stand
        self.allowed = anyio.Event()
        self.allowed.set()

    async def read(self) -> None:
        with self.robot.feed.subscribe() as feed:
            async for _ in feed:
                self.samples += 1

    async def move(self) -> None:
        # from rest to rest in MOTION seconds, as the client can work out itself
        speed, acceleration = 1.0, 100.0
        way = (MOTION - speed / acceleration) * speed
        while True:
            try:
                await self.robot.motion.movej2([way] * 6, speed, acceleration)
            except aioduco.TaskStopped:
                await self.allowed.wait()


async def stop_all(fleet: list[Member]) -> tuple[float, float]:
    """Stop every robot; seconds until the last handler was reached, and until all stand."""
    for member in fleet:
        member.allowed = anyio.Event()
    begin = time.monotonic()
    await aioduco.stop_all(member.robot for member in fleet)
    stand = time.monotonic() - begin
    last = await last_stop((member.lane for member in fleet), begin)
    for member in fleet:
        member.allowed.set()
    return last - begin, stand


class Bare:
    """The bytes of a stop for each controller, on connections that nothing else uses."""

    def __init__(self, ports: Iterable[int]) -> None:
        function = idl.functions()["stop"]
        self._message = codec.message(function, 1, codec.encode(function, (True,)))
        self._sockets = [socket.create_connection((HOST, port)) for port in ports]
        for each in self._sockets:
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    async def stop_all(self, fleet: list[Member]) -> float:
        """As `stop_all`, by bare sends; the answers are taken afterwards."""
        begin = time.monotonic()
        for each in self._sockets:
            each.sendall(self._message)
        last = await last_stop((member.lane for member in fleet), begin)
        for each in self._sockets:
            each.recv(4096)
        return last - begin

    def close(self) -> None:
        for each in self._sockets:
            each.close()


async def last_stop(lanes: Iterable[WireLane], begin: float) -> float:
    """When the last controller's handler was reached; it may be on its way."""
    return max([await first_stop(lane, begin) for lane in lanes])


async def measure(server: ServerProcess, guard: bool, seconds: float, stops: int) -> dict[str, Any]:
    fleet: list[Member] = []
    async with anyio.create_task_group() as tasks:
        for port in server.endpoints.values():
            robot = aioduco.connect(
                HOST, port, state_rate=FEED_RATE, guard="process" if guard else None
            )
            await robot.open()
            lane = WireLane("bench", HOST, port)
            await lane.open()
            await lane.rpc.set_system_value_double("duration", MOTION)
            member = Member(robot, lane)
            fleet.append(member)
            tasks.start_soon(member.read)
            tasks.start_soon(member.move)
        # As docs/guides/production.md has it: else Python looks through all of them for garbage.
        gc.collect()
        gc.freeze()
        seat = fleet[0].robot._supervisor.guard
        processes = [os.getpid()]
        if seat is not None and seat.pid is not None:
            processes.append(seat.pid)
        before, begin = sum(map(processor_time, processes)), time.monotonic()
        samples = sum(member.samples for member in fleet)
        await anyio.sleep(seconds)
        wall = time.monotonic() - begin
        share = (sum(map(processor_time, processes)) - before) / wall
        rate = (sum(member.samples for member in fleet) - samples) / wall / len(fleet)
        late, standing, bare_late = [], [], []
        bare = Bare(server.endpoints.values())
        for _ in range(stops):
            await anyio.sleep(0.25)  # five samples: what asking for the last stops held up is over
            reached, stand = await stop_all(fleet)
            late.append(reached)
            standing.append(stand)
            await anyio.sleep(0.25)
            bare_late.append(await bare.stop_all(fleet))
        bare.close()
        tasks.cancel_scope.cancel()
    for member in fleet:
        await member.robot.aclose()
        await member.lane.aclose()
    return {
        "cores": round(share, 3),
        "samples_per_second_each": round(rate, 1),
        "stop_all": spread(late) | {"stops": stops},
        "all_stand": spread(standing) | {"stops": stops},
        "bare_sends": spread(bare_late) | {"stops": stops},
    }


def served(count: int, guard: bool, seconds: float, stops: int) -> dict[str, Any]:
    """One fleet and its controllers."""
    with ServerProcess("controller.py", str(count)) as server:
        return anyio.run(measure, server, guard, seconds, stops)


# -- two gateways -----------------------------------------------------------------------------


def free_endpoint() -> str:
    with socket.create_server((HOST, 0)) as server:
        return f"tcp/{HOST}:{server.getsockname()[1]}"


def files(folder: Path, ports: list[int]) -> list[Path]:
    """The file of each gateway: the second one connects to the first. A stop is proven by keys."""
    keys = folder / "keys.toml"
    keys.touch(0o600)
    keys.write_text("".join(f'{name} = "{secrets.token_hex(32)}"\n' for name in NAMES), "utf-8")
    half = len(ports) // 2
    endpoints = [free_endpoint() for _ in NAMES]
    made = []
    for number, name in enumerate(NAMES):
        text = (
            f'[fleet]\nname = "bench"\ngateway = "{name}"\nexpect = {json.dumps(NAMES)}\n'
            f'keys = "{keys}"\n'
            f'listen = ["{endpoints[number]}"]\nconnect = {json.dumps(endpoints[:number])}\n'
        )
        for port in ports[number * half : (number + 1) * half]:
            text += f'[[arm]]\nname = "arm-{port}"\nhost = "{HOST}"\nport = {port}\n'
        path = folder / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        made.append(path)
    return made


async def reach(ports: list[int], path: Path, stops: int) -> dict[str, Any]:
    from aioduco.integrations.fleet import FleetClient, FleetSettings  # noqa: PLC0415  # an extra of its own

    lanes = [WireLane("bench", HOST, port) for port in ports]
    for lane in lanes:
        await lane.open()
    reached_after: list[float] = []
    answered_after: list[float] = []
    async with FleetClient(FleetSettings.read(path)) as client:
        await eventually_async(
            lambda: (
                sum(arm.link == "up" for gateway in client.view.gateways for arm in gateway.arms)
                == len(ports)
            ),
            60.0,
        )
        for _ in range(stops):
            await anyio.sleep(0.05)
            begin = time.monotonic()
            done = await client.stop()
            answered_after.append(time.monotonic() - begin)
            if not done.confirmed:
                raise RuntimeError(f"a stop was not confirmed: {done}")
            reached_after.append(await last_stop(lanes, begin) - begin)
    for lane in lanes:
        await lane.aclose()
    return {"reached": spread(reached_after), "answered": spread(answered_after)}


def gateways(options: argparse.Namespace) -> None:
    """The stop of two gateways, and its table."""
    each, stops = (4, 20) if options.quick else (16, 200)
    with ExitStack() as stack:
        server = stack.enter_context(ServerProcess("controller.py", str(2 * each)))
        ports = list(server.endpoints.values())
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        made = files(folder, ports)
        for path in made:
            serve = ("-m", "aioduco.cli", "fleet", "serve", str(path))
            gateway = stack.enter_context(Program(*serve, quiet=True))
            stack.callback(gateway.process.terminate)
            gateway.line()
        figures = anyio.run(reach, ports, made[0], stops)
    show(f"A stop of 2 x {each} arms from a third process, {stops} times", figures)
    save(options, "fleet_gateway", {"gateways": 2, "arms_each": each, "stops": stops, **figures})


def main() -> None:
    made = parser(__doc__)
    made.add_argument("--gateways", action="store_true", help="of two gateways, over Zenoh")
    options = made.parse_args()
    if options.gateways:
        gateways(options)
        return
    counts, seconds = (((8, 20),), 3.0) if options.quick else (((32, 50), (100, 10)), 12.0)
    fleets: dict[str, dict[str, Any]] = {}
    for count, stops in counts:
        for name, guard in (("without guard", False), ("with guard", True)):
            # Each in a program of its own, as one would be: nothing of another one is left in it.
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as program:
                found = program.submit(served, count, guard, seconds, stops).result()
            fleets[f"{count} robots, {name}"] = found
    for name, found in fleets.items():
        show(f"{name}: {found['cores']} cores", {each: found[each] for each in SPREADS})
    save(options, "fleet", {"fleets": fleets})


if __name__ == "__main__":
    main()
