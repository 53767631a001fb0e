"""Streams: what rate they reach, and how late they are.

    python benchmarks/streaming.py [--quick] [--save]

All alternatives stream to the same server process and take turns in slices, whatever else the
machine does.

    process     a worker in a process of its own, the default
    without priority  the same, but it never goes first, as `process` does once it wakes late
    urgent      the same under SCHED_FIFO from the start, where the system allows it
    thread      the same worker in a thread of the program
    loop        no worker: a task of the program sleeps to each tick and awaits the call
    bare        a loop on each processor that only sleeps to each tick, beside `process`
    busy        the program's event loop works in bursts of 15 ms, with pauses of 15 ms

A controller trips if set-points are further apart than 20 ms. The last cases are against the
simulated arm in a process of its own. Asked for is a p99 of lateness of at most 250 µs.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import statistics
import time
from functools import partial
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
import rpc as calls
from _common import CORES, HERE, in_turns, parser, report, spread
from _processes import CONTROLLER, HOST, Program, ServerProcess, client, open_lane

import aioduco
from aioduco._process.platform import drop_realtime_priority, set_realtime_priority
from aioduco._wire.rpc import RealTimeControlData
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.api.streams.servo import Servo
from aioduco.sim import Simulator
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.ticks import Tick, Ticks

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike

    from aioduco.streaming.report import StreamStatistics

    Run = Callable[[], Awaitable[object]]

Rows = dict[str, dict[str, Any]]

RATE = 1000
BURST, STALL = 0.015, 0.3
WORKERS = {
    "process": WorkerOptions(run_in="process"),
    "without priority": WorkerOptions(run_in="process", priority=0),
    "urgent": WorkerOptions(run_in="process", priority=50),
    "thread": WorkerOptions(run_in="thread", timeout=2.0),
}
SERVOJ = (1.0, 5.0, False, 200.0, 25.0, 10.0, 1.0)


def sine(count: int, rate: float, start: Sequence[float] = (0.0,) * 6) -> list[list[float]]:
    """Set-points of a slow sine on all joints, from rest."""
    turn = 2 * math.pi * 0.2 / rate
    ways = (0.1 * (1 - math.cos(turn * n)) for n in range(count))
    return [[angle + way for angle in start] for way in ways]


def work_for(seconds: float) -> None:
    """Python's own work, which gives its lock away no more often than it must."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        sum(range(200))


@contextlib.asynccontextmanager
async def load(busy: bool) -> AsyncIterator[None]:
    """The program's other work: bursts of plain Python in the event loop, or none."""

    async def work() -> None:
        while True:
            work_for(BURST)
            await anyio.sleep(BURST)

    async with anyio.create_task_group() as tasks:
        if busy:
            tasks.start_soon(work)
        yield
        tasks.cancel_scope.cancel()


def urgent_allowed() -> bool:
    """Whether the system allows SCHED_FIFO."""
    allowed = set_realtime_priority(1)
    drop_realtime_priority()
    return allowed


class Lateness:
    """How late one alternative was in all of its slices."""

    def __init__(self) -> None:
        self.seconds = np.zeros(0)
        self.ticks = self.missed = 0

    def add(self, seconds: ArrayLike, ticks: int, missed: int) -> None:
        """Add a slice."""
        self.seconds = np.append(self.seconds, seconds)
        self.ticks += ticks
        self.missed += missed

    def add_stream(self, found: StreamStatistics) -> None:
        """Add a slice of a stream, by its histogram."""
        low, high, count = np.reshape(np.array(found.buckets["lateness"], int), (-1, 3)).T
        self.add(np.repeat((low + high) // 2 * 1e-9, count), found.ticks, found.missed)

    def figures(self) -> dict[str, Any]:
        late = {f"late_{name}": value for name, value in spread(self.seconds).items()}
        beyond = int(np.count_nonzero(self.seconds > 0.002))
        return {"ticks": self.ticks, "missed": self.missed, **late, "beyond_2ms": beyond}


@contextlib.contextmanager
def bare_loop(found: Lateness, rate: float, core: int | None) -> Iterator[None]:
    """A loop that only sleeps to its ticks: what the machine does to anybody's schedule.

    In a process of its own on one processor, or any for None, while the block runs.
    """
    with Program(str(HERE / "ticks.py"), str(rate)) as program:
        if core is not None:
            os.sched_setaffinity(program.pid, {core})
        program.line()  # what its start takes is over
        yield
        late, ticks, missed = json.loads(program.end())
        found.add(np.array(late) * 1e-9, ticks, missed)


@contextlib.contextmanager
def bare_loops(found: Lateness) -> Iterator[None]:
    """One on each processor: the machine's own noise, beside what is measured.

    The worker may run on any of them, so the worst of them is what it is held against.
    """
    with contextlib.ExitStack() as stack:
        for core in CORES:
            stack.enter_context(bare_loop(found, RATE, core))
        yield


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
    rows = {name: {"calls_per_second": round(rate, 1)} for name, rate in medians.items()}
    for name, rate in medians.items():
        rows["process"][f"to_{name.lower()}"] = round(medians["process"] / rate, 3)
    return rows


async def send(found: Lateness, stream: Any, points: list[list[float]]) -> None:
    """Send one set-point after the other, as a program does."""
    with contextlib.suppress(TimeoutError):
        async with stream:
            # one that falls behind is cut off, not waited for
            with anyio.fail_after(len(points) / RATE + 1):
                for point in points:
                    await stream.send(point)
    found.add_stream(stream.statistics())


async def play(found: Lateness, stream: Any, points: list[list[float]]) -> None:
    """Play a path through a queue, and stall the event loop in the middle."""
    seconds = len(points) / RATE
    with contextlib.suppress(TimeoutError):
        async with stream:
            with anyio.fail_after(seconds + 1):
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(stream.play, points)
                    await anyio.sleep(seconds / 2)
                    work_for(STALL)
    found.add_stream(stream.statistics())


async def by_worker(found: Lateness, kind: str, port: int, seconds: float) -> None:
    stream = Servo(StreamEndpoint(HOST, port)).joints(
        v=3.0, a=50.0, rate=RATE, hold=20.0, options=WORKERS[kind]
    )
    await send(found, stream, sine(round(seconds * RATE), RATE))


async def by_loop(found: Lateness, port: int, seconds: float) -> None:
    points = sine(round(seconds * RATE) + 1, RATE)
    ticks: list[Tick] = []
    async with open_lane(port) as lane:
        async for tick in Ticks(1 / RATE, lambda: None):
            if tick.time > seconds:
                break
            ticks.append(tick)
            await lane.rpc.servoj(points[tick.number], *SERVOJ)
    late = [tick.late + np.arange(tick.skipped + 1) / RATE for tick in ticks]
    found.add(np.concatenate(late), len(ticks), sum(tick.skipped for tick in ticks))


async def accounts(
    port: int, account: str, runs: Mapping[str, Run], slices: int, *, busy: bool
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
    stream = RealtimeStreams(StreamEndpoint(HOST, port)).stream(
        "joint_position", v=3.0, a=50.0, depth=50, hold=20.0, options=WORKERS["process"]
    )
    await play(Lateness(), stream, sine(round(seconds * RATE), RATE))


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
                work_for(STALL)
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


async def simulated(quick: bool) -> Rows:
    """Against a simulated arm in a process of its own."""
    seconds = 2.0 if quick else 20.0
    found = {name: Lateness() for name in ("servoj", "bare, beside servoj", "realtime")}
    # The stall is meant, so nobody needs to be warned of it.
    async with Simulator.spawn() as sim, aioduco.connect(HOST, sim.port, lag_limit=None) as robot:
        await robot.bring_up()
        points = sine(round(seconds * RATE), RATE, await robot.state.get_actual_joints_position())
        async with load(True):
            with bare_loops(found["bare, beside servoj"]):
                stream: Any = robot.servo.joints(v=1.0, a=20.0, rate=RATE, hold=5.0)
                await send(found["servoj"], stream, points)
            points = sine(len(points), RATE, await robot.state.get_actual_joints_position())
            stream = robot.realtime.stream("joint_position", v=1.0, a=20.0, depth=50, hold=5.0)
            await play(found["realtime"], stream, points)
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
    with ServerProcess(CONTROLLER) as server:
        results = anyio.run(measure, server.ports[0], options.quick)
    report(options, "streaming", results)


if __name__ == "__main__":
    main()
