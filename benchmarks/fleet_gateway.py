"""How soon all arms of two gateways are stopped from a third process, over Zenoh on loopback.

Each gateway is a process of its own, `aioduco fleet serve`, with the heartbeats and the states of
its arms. The controllers have trivial handlers and live in one other process. Measured is the time
from the call of `FleetClient.stop` until the last controller's handler is reached, and until the
answer.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import anyio
from _common import ServerProcess, arguments, print_table, scheduling, spread, write_results

from aioduco._wire.lane import WireLane
from aioduco.integrations.fleet import FleetClient, FleetSettings
from aioduco.testing import eventually_async

HOST = "127.0.0.1"
NAMES = ("one", "two")


def free_endpoint() -> str:
    with socket.create_server((HOST, 0)) as server:
        return f"tcp/{HOST}:{server.getsockname()[1]}"


def files(folder: Path, ports: list[int]) -> list[Path]:
    """The file of each gateway: the second one connects to the first."""
    half = len(ports) // 2
    endpoints = [free_endpoint() for _ in NAMES]
    made = []
    for number, name in enumerate(NAMES):
        text = (
            f'[fleet]\nname = "bench"\ngateway = "{name}"\nexpect = {json.dumps(NAMES)}\n'
            f'listen = ["{endpoints[number]}"]\nconnect = {json.dumps(endpoints[:number])}\n'
        )
        for port in ports[number * half : (number + 1) * half]:
            text += f'[[arm]]\nname = "arm-{port}"\nhost = "{HOST}"\nport = {port}\n'
        path = folder / f"{name}.toml"
        path.write_text(text, encoding="utf-8")
        made.append(path)
    return made


async def measure(ports: list[int], settings: FleetSettings, stops: int) -> dict[str, Any]:
    lanes = [WireLane("bench", HOST, port) for port in ports]
    for lane in lanes:
        await lane.open()
    reached_after: list[float] = []
    answered_after: list[float] = []
    async with FleetClient(settings) as client:
        await eventually_async(
            lambda: (
                sum(arm.link == "up" for gateway in client.view.gateways for arm in gateway.arms)
                == len(ports)
            ),
            60.0,
        )
        for _ in range(stops):
            await anyio.sleep(0.05)
            for lane in lanes:
                await lane.rpc.get_system_value_list("stops")
            begin = time.monotonic()
            done = await client.stop()
            answered_after.append(time.monotonic() - begin)
            if not done.confirmed:
                raise RuntimeError(f"a stop was not confirmed: {done}")
            last = begin
            for lane in lanes:
                reached = await lane.rpc.get_system_value_list("stops")
                last = max(last, min(at for at in reached if at >= begin))
            reached_after.append(last - begin)
    for lane in lanes:
        await lane.aclose()
    return {"reached": spread(reached_after), "answered": spread(answered_after)}


def main() -> None:
    options = arguments(__doc__, "fleet_gateway")
    each, stops = (4, 20) if options.quick else (16, 200)
    with ExitStack() as stack:
        server = stack.enter_context(ServerProcess("fleet_server.py", str(2 * each)))
        ports = list(server.endpoints.values())
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        made = files(folder, ports)
        for path in made:
            command = [sys.executable, "-m", "aioduco.cli", "fleet", "serve", str(path)]
            process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
            stack.callback(process.wait)
            stack.callback(process.terminate)
            assert process.stdout is not None
            process.stdout.readline()
        figures = anyio.run(measure, ports, FleetSettings.read(made[0]), stops)
    results = {"scheduling": scheduling(), "gateways": 2, "arms_each": each, "stops": stops}
    results |= figures
    rows = [
        [name, *(round(figures[key][p] / 1000, 2) for p in ("p50_us", "p99_us", "max_us"))]
        for name, key in (("last controller reached", "reached"), ("answered", "answered"))
    ]
    title = f"A stop of 2 x {each} arms from a third process, {stops} times [ms]"
    print_table(title, ["until", "p50", "p99", "max"], rows)
    if options.save:
        print("written:", write_results("fleet_gateway", results).name)


if __name__ == "__main__":
    main()
