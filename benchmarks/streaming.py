"""Streams: what rate they reach, and how late they are.

    python benchmarks/streaming.py [--quick] [--save]

All alternatives stream to the same server process and take turns in slices, so that whatever
else the machine does meets them all.

    process     a worker in a process of its own, the default
    without priority  the same, but that it never goes first, as `process` does once it wakes late
    urgent      the same under SCHED_FIFO from the start, where the system allows it
    thread      the same worker in a thread of the program
    loop        no worker: a task of the program sleeps to each tick and awaits the call
    bare        no stream at all: a loop on each processor that only sleeps to each tick, beside
                `process`, for the machine's own noise
    busy        the program's event loop works in bursts of 15 ms, with pauses of 15 ms

A stream whose set-points are further apart than 20 ms lets a controller trip. The last cases are
against the simulated arm, in a process of its own, with the program's loop busy. Asked for is a p99
of lateness of at most 250 µs.
"""

from __future__ import annotations

import contextlib
import os
import statistics
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import anyio
import rpc as calls
from _common import CORES, ServerProcess, parser, save, show
from _streaming import (
    HOST,
    RATE,
    SERVOJ,
    WORKERS,
    Lateness,
    ask,
    bare_loops,
    load,
    sine,
    urgent_allowed,
    work_for,
)
from rpc_server import CYCLE
from ticks import Ticks

import aioduco
from aioduco._wire.lane import WireLane
from aioduco._wire.rpc import RealTimeControlData
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.sim import Simulator
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from aioduco.streaming.report import StreamStatistics


async def lane_rate(port: int, count: int) -> float:
    """Set-points per second of a worker that never has to wait for its schedule."""
    opened = Servo(StreamEndpoint(HOST, port)).joints(
        v=3.0, a=1000.0, rate=50_000, ahead=count, options=WorkerOptions(watch=0)
    )
    async with opened as stream:
        await stream.play(sine(count, 50_000))
    return 1 / stream.statistics().interval.mean


def sync_rate(call: Callable[..., object], seconds: float) -> float:
    """Calls per second, one after another."""
    begin = now = time.perf_counter()
    number = 0
    while now - begin < seconds:
        call([1e-5 * number] * 6, *SERVOJ)
        number += 1
        now = time.perf_counter()
    return number / (now - begin)


async def greatest_rate(port: int, quick: bool) -> dict[str, dict[str, Any]]:
    """Closed loop: each set-point is sent when the one before has been answered."""
    rounds, seconds, count = (3, 0.3, 3000) if quick else (10, 1.0, 10_000)
    rates: dict[str, list[float]] = {"process": [], "thriftpy2": []}
    with contextlib.ExitStack() as stack:
        direct = calls.thriftpy2_client(port, stack).servoj
        apache = stack.enter_context(calls.apache_module())
        slow = None if apache is None else calls.apache_client(apache, port, stack).servoj
        for _ in range(rounds):
            rates["process"].append(await lane_rate(port, count))
            rates["thriftpy2"].append(sync_rate(direct, seconds))
            if slow is not None:
                rates.setdefault("Apache", []).append(sync_rate(slow, seconds))
    medians = {name: statistics.median(found) for name, found in rates.items()}
    slowest = medians.get("Apache")
    return {
        name: {
            "calls_per_second": round(rate, 1),
            "to_thriftpy2": round(rate / medians["thriftpy2"], 3),
            "to_apache": round(rate / slowest, 1) if slowest else "",
        }
        for name, rate in medians.items()
    }


async def by_worker(found: Lateness, kind: str, port: int, seconds: float) -> None:
    """Send one set-point after the other, as a program does."""
    stream = Servo(StreamEndpoint(HOST, port)).joints(
        v=3.0, a=50.0, rate=RATE, hold=20.0, options=WORKERS[kind]
    )
    with contextlib.suppress(TimeoutError):
        async with stream:
            # one that falls behind is cut off, not waited for
            with anyio.fail_after(seconds + 1):
                for point in sine(round(seconds * RATE), RATE):
                    await stream.send(point)
    figures = stream.statistics()
    found.add(figures.buckets["lateness"], figures.ticks, figures.missed)


async def by_loop(found: Lateness, port: int, seconds: float) -> None:
    lane = WireLane("benchmark", HOST, port)
    await lane.open()
    points = sine(round(seconds * RATE) + 1, RATE)
    ticks = Ticks(RATE)
    end = ticks.due + round(seconds * 1e9)
    while ticks.due < end:
        await anyio.sleep(max(0, ticks.due - time.monotonic_ns()) * 1e-9)
        ticks.begin()
        await lane.rpc.servoj(points[min(ticks.ticks, len(points) - 1)], *SERVOJ)
        ticks.end()
    await lane.aclose()
    found.add(ticks.buckets(), ticks.ticks, ticks.missed)


async def in_turn(
    port: int,
    account: str,
    runs: Mapping[str, Callable[[], Awaitable[object]]],
    slices: int,
    *,
    busy: bool,
) -> tuple[dict[str, list[list[float]]], Lateness]:
    """The server's account of each slice, and how late bare loops beside `process` were."""
    accounts: dict[str, list[list[float]]] = {name: [] for name in runs}
    noise = Lateness()
    for _ in range(slices):
        for name, run in runs.items():
            ask(port, account)
            beside = bare_loops(noise) if name == "process" else contextlib.nullcontext()
            async with load(busy):
                with beside:
                    await run()
            accounts[name].append(ask(port, account))
    return accounts, noise


async def pacing(port: int, busy: bool, quick: bool) -> dict[str, dict[str, Any]]:
    """One set-point each millisecond; the alternatives take turns."""
    slices, seconds = (1, 1.5) if quick else (6, 3.0)
    kinds = [kind for kind in WORKERS if kind != "urgent" or urgent_allowed()]
    found = {name: Lateness() for name in (*kinds, "loop")}
    runs = {kind: partial(by_worker, found[kind], kind, port, seconds) for kind in kinds}
    runs["loop"] = partial(by_loop, found["loop"], port, seconds)
    accounts, noise = await in_turn(port, "arrivals", runs, slices, busy=busy)
    rows = {
        name: each.figures() | {"trips": round(sum(trips for (trips,) in accounts[name]))}
        for name, each in found.items()
    }
    return rows | {"bare": noise.figures() | {"trips": 0}}


async def queue_by_worker(port: int, seconds: float) -> None:
    opened = RealtimeStreams(StreamEndpoint(HOST, port)).stream(
        "joint_position", v=3.0, a=50.0, depth=50, hold=20.0, options=WORKERS["process"]
    )
    with contextlib.suppress(TimeoutError):
        async with opened as stream:
            with anyio.fail_after(seconds + 1):
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(stream.play, sine(round(seconds / CYCLE), 1 / CYCLE))
                    await anyio.sleep(seconds / 2)
                    work_for(0.3)


async def queue_by_loop(port: int, seconds: float) -> None:
    """What a program writes without streams: look at the queue, fill it up, sleep."""
    lane = WireLane("benchmark", HOST, port)
    await lane.open()
    rpc, depth, period = lane.rpc, 50, 0.004
    points = [RealTimeControlData(joint_pos_cmd=q, status=True) for q in sine(100, 1000)]
    await rpc.clear_realtime_data_queue()
    await rpc.realtime_data_enqueue(points[:depth], True)
    await rpc.start_realtime_mode(0, 100.0, 0.02)
    start = anyio.current_time()
    for number in range(1, round(seconds / period)):
        await anyio.sleep_until(start + number * period)
        if number == round(seconds / period) // 2:
            work_for(0.3)
        missing = depth - await rpc.get_realtime_data_queue_size()
        if missing > 0:
            await rpc.realtime_data_enqueue(points[:missing], True)
    await rpc.end_realtime_mode()
    await lane.aclose()


async def starvation(port: int, quick: bool) -> dict[str, dict[str, Any]]:
    """A point each millisecond through the queue, under load; the controller's side of it."""
    slices, seconds = (1, 2.0) if quick else (6, 2.0)
    runs = {
        "process": partial(queue_by_worker, port, seconds),
        "loop": partial(queue_by_loop, port, seconds),
    }
    accounts, noise = await in_turn(port, "starvation", runs, slices, busy=True)
    rows: dict[str, dict[str, Any]] = {}
    for name, account in accounts.items():
        taken, starved, longest = zip(*account, strict=True)
        rows[name] = {
            "points": round(sum(taken)),
            "starved_cycles": round(sum(starved)),
            "longest_ms": max(longest),
        }
    # What no queue of this depth bridges: how long the machine let a bare loop wait.
    rows["bare"] = {"longest_ms": round(float(noise.seconds.max()) * 1e3, 1)}
    return rows


# -- the simulated arm ---


async def servo(robot: aioduco.Robot, seconds: float, noise: Lateness) -> dict[str, Any]:
    start = await robot.state.get_actual_joints_position()
    async with load(True):
        with bare_loops(noise):
            async with robot.servo.joints(v=1.0, a=20.0, rate=RATE, hold=5.0) as stream:
                for point in sine(round(seconds * RATE), RATE, start):
                    await stream.send(point)
    return figures(stream.statistics())


async def realtime(robot: aioduco.Robot, seconds: float) -> dict[str, Any]:
    start = await robot.state.get_actual_joints_position()
    async with load(True):
        opened = robot.realtime.stream("joint_position", v=1.0, a=20.0, depth=50, hold=5.0)
        async with opened as stream, anyio.create_task_group() as tasks:
            tasks.start_soon(stream.play, sine(round(seconds * RATE), RATE, start))
            await anyio.sleep(seconds / 2)
            work_for(0.3)
    return figures(stream.statistics())


def figures(found: StreamStatistics) -> dict[str, Any]:
    lateness = Lateness()
    lateness.add(found.buckets["lateness"], found.ticks, found.missed)
    return lateness.figures()


async def simulated(quick: bool) -> dict[str, dict[str, Any]]:
    """Against a simulated arm in a process of its own."""
    seconds = 2.0 if quick else 20.0
    # The stall is meant, so nobody needs to be warned of it.
    async with Simulator.spawn() as sim, aioduco.connect(HOST, sim.port, lag_limit=None) as robot:
        await robot.bring_up()
        noise = Lateness()
        return {
            "servoj": await servo(robot, seconds, noise),
            "bare, beside servoj": noise.figures(),
            "realtime": await realtime(robot, seconds),
        }


async def measure(port: int, quick: bool) -> dict[str, Any]:
    results: dict[str, Any] = {"greatest_rate": await greatest_rate(port, quick)}
    # The rest needs no server on a core of its own: a paced worker leaves the machine idle.
    os.sched_setaffinity(0, CORES)
    results["pacing"] = {
        "idle": await pacing(port, False, quick),
        "busy": await pacing(port, True, quick),
    }
    results["realtime_queue"] = {"busy loop, one stall of 300 ms": await starvation(port, quick)}
    results["simulator"] = await simulated(quick)
    return results


def main() -> None:
    options = parser(__doc__).parse_args()
    with ServerProcess("rpc_server.py") as server:
        results = anyio.run(measure, server.endpoints["thrift"], options.quick)
    show("greatest servoj rate, closed loop", results["greatest_rate"])
    for kind in ("pacing", "realtime_queue"):
        for title, rows in results[kind].items():
            show(f"{kind.replace('_', ' ')}, {title}", rows)
    show("simulated arm, busy", results["simulator"])
    save(options, "streaming", results)


if __name__ == "__main__":
    main()
