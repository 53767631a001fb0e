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
from _common import CORES, in_turns, parser, report
from _processes import HOST, ServerProcess, client, open_lane
from _streaming import (
    RATE,
    SERVOJ,
    WORKERS,
    Lateness,
    bare_loops,
    load,
    sine,
    urgent_allowed,
    work_for,
)
from controller import CYCLE
from ticks import Ticks

import aioduco
from aioduco._wire.rpc import RealTimeControlData
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.sim import Simulator
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    Run = Callable[[], Awaitable[object]]

Rows = dict[str, dict[str, Any]]


async def lane_rate(port: int, count: int) -> float:
    """Set-points per second of a worker that never has to wait for its schedule."""
    opened = Servo(StreamEndpoint(HOST, port)).joints(
        v=3.0, a=1000.0, rate=50_000, ahead=count, options=WorkerOptions(watch=0)
    )
    async with opened as stream:
        await stream.play(sine(count, 50_000))
    return 1 / stream.statistics().interval.mean


async def rate_of(client: Any, seconds: float) -> float:
    """Set-points per second of a client, one call after another."""
    point = [0.0] * 6
    return 1 / statistics.mean(await calls.called(lambda: client.servoj(point, *SERVOJ), seconds))


async def greatest_rate(port: int, quick: bool) -> Rows:
    """Closed loop: each set-point is sent when the one before has been answered."""
    rounds, seconds, count = (3, 0.3, 3000) if quick else (10, 1.0, 10_000)
    with contextlib.ExitStack() as stack:
        ways: dict[str, Callable[[], Awaitable[float]]] = {
            "process": partial(lane_rate, port, count),
            "thriftpy2": partial(rate_of, calls.thriftpy2_client(port, stack), seconds),
        }
        apache = stack.enter_context(calls.apache_module())
        if apache is not None:
            ways["Apache"] = partial(rate_of, calls.apache_client(apache, port, stack), seconds)
        rates: dict[str, list[float]] = {name: [] for name in ways}
        for name, way in in_turns(rounds, ways):
            rates[name].append(await way())
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
    found.add_stream(stream.statistics())


async def by_loop(found: Lateness, port: int, seconds: float) -> None:
    points = sine(round(seconds * RATE) + 1, RATE)
    async with open_lane(port) as lane:
        ticks = Ticks(RATE)
        end = ticks.due + round(seconds * 1e9)
        while ticks.due < end:
            await anyio.sleep(max(0, ticks.due - time.monotonic_ns()) * 1e-9)
            ticks.begin()
            await lane.rpc.servoj(points[min(ticks.ticks, len(points) - 1)], *SERVOJ)
            ticks.end()
    found.add(ticks.buckets(), ticks.ticks, ticks.missed)


async def accounts(
    port: int,
    account: str,
    runs: Mapping[str, Run],
    slices: int,
    *,
    busy: bool,
) -> dict[str, int]:
    """What the controller counted in all slices of each run."""

    def ask() -> int:
        with client(port) as robot:
            return round(robot.get_system_value_list(account)[0])

    counted = dict.fromkeys(runs, 0)
    for name, run in in_turns(slices, runs):
        ask()
        async with load(busy):
            await run()
        counted[name] += ask()
    return counted


async def pacing(port: int, busy: bool, quick: bool) -> Rows:
    """One set-point each millisecond; the alternatives take turns."""
    slices, seconds = (1, 1.5) if quick else (6, 3.0)
    kinds = [kind for kind in WORKERS if kind != "urgent" or urgent_allowed()]
    found = {name: Lateness() for name in (*kinds, "loop", "bare")}

    async def beside_bare_loops() -> None:
        with bare_loops(found["bare"]):
            await by_worker(found["process"], "process", port, seconds)

    runs: dict[str, Run] = {
        kind: partial(by_worker, found[kind], kind, port, seconds) for kind in kinds
    }
    runs |= {"process": beside_bare_loops, "loop": partial(by_loop, found["loop"], port, seconds)}
    trips = await accounts(port, "arrivals", runs, slices, busy=busy)
    return {name: late.figures() | {"trips": trips.get(name, 0)} for name, late in found.items()}


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
    depth, period = 50, 0.004
    points = [RealTimeControlData(joint_pos_cmd=q, status=True) for q in sine(100, 1000)]
    async with open_lane(port) as lane:
        rpc = lane.rpc
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


async def starvation(port: int, quick: bool) -> Rows:
    """A point each millisecond through the queue, under load; the controller's side of it."""
    slices, seconds = (1, 2.0) if quick else (6, 2.0)
    runs = {
        "process": partial(queue_by_worker, port, seconds),
        "loop": partial(queue_by_loop, port, seconds),
    }
    starved = await accounts(port, "starvation", runs, slices, busy=True)
    return {name: {"starved_cycles": cycles} for name, cycles in starved.items()}


# -- the simulated arm ---


async def servo(robot: aioduco.Robot, late: Lateness, seconds: float) -> None:
    start = await robot.state.get_actual_joints_position()
    async with robot.servo.joints(v=1.0, a=20.0, rate=RATE, hold=5.0) as stream:
        for point in sine(round(seconds * RATE), RATE, start):
            await stream.send(point)
    late.add_stream(stream.statistics())


async def realtime(robot: aioduco.Robot, late: Lateness, seconds: float) -> None:
    start = await robot.state.get_actual_joints_position()
    opened = robot.realtime.stream("joint_position", v=1.0, a=20.0, depth=50, hold=5.0)
    async with opened as stream, anyio.create_task_group() as tasks:
        tasks.start_soon(stream.play, sine(round(seconds * RATE), RATE, start))
        await anyio.sleep(seconds / 2)
        work_for(0.3)
    late.add_stream(stream.statistics())


async def simulated(quick: bool) -> Rows:
    """Against a simulated arm in a process of its own."""
    seconds = 2.0 if quick else 20.0
    found = {name: Lateness() for name in ("servoj", "bare, beside servoj", "realtime")}
    # The stall is meant, so nobody needs to be warned of it.
    async with Simulator.spawn() as sim, aioduco.connect(HOST, sim.port, lag_limit=None) as robot:
        await robot.bring_up()
        async with load(True):
            with bare_loops(found["bare, beside servoj"]):
                await servo(robot, found["servoj"], seconds)
            await realtime(robot, found["realtime"], seconds)
    return {name: late.figures() for name, late in found.items()}


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
    with ServerProcess("controller.py") as server:
        results = anyio.run(measure, server.ports[0], options.quick)
    report(options, "streaming", results)


if __name__ == "__main__":
    main()
