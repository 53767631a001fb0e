"""Streams: what rate they reach, how late they are, and what becomes of the arm.

    python benchmarks/streaming.py [--quick] [--save]

All alternatives stream to the same server process and take turns in slices, so that whatever
else the machine does meets them all.

    process     a lane in a process of its own, the default
    urgent      the same under SCHED_FIFO, where the system allows it
    thread      the same lane in a thread of the program
    loop        no lane: a task of the program's event loop sleeps to each tick and awaits the call
    bare        no stream at all: a loop in C (in Python without a compiler) that only sleeps to
                each tick, for the machine's own noise
    busy        the program's event loop works in bursts of 15 ms, with pauses of 15 ms

A stream whose set-points are further apart than 20 ms lets a controller trip.
"""

from __future__ import annotations

import contextlib
import functools
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
import rpc as calls
from _common import ServerProcess, arguments, print_table, write_results
from streaming_bare import BareLoop
from streaming_server import CYCLE

from aioduco._wire.connection import Connection
from aioduco._wire.lane import Lane
from aioduco.streaming.endpoint import Endpoint
from aioduco.streaming.pacing import Schedule
from aioduco.streaming.realtime import RealtimeStreams
from aioduco.streaming.servo import Servo
from aioduco.streaming.settings import LaneOptions, Upsampling
from aioduco.streaming.statistics import Histogram

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable

    from aioduco.streaming.report import StreamStatistics

HOST = "127.0.0.1"
RATE = 1000
BURST = 0.015
LANES = {
    "process": LaneOptions(lane="process"),
    "urgent": LaneOptions(lane="process", priority=50),
    "thread": LaneOptions(lane="thread", timeout=2.0),
}
SERVOJ = (1.0, 5.0, False, 200.0, 25.0, 10.0, 1.0)


def sine(count: int, rate: float) -> list[list[float]]:
    """Set-points of a slow sine on all joints, from rest."""
    turn = 2 * math.pi * 0.2 / rate
    return [[0.1 * (1 - math.cos(turn * n))] * 6 for n in range(count)]


def ask(port: int, account: str) -> list[float]:
    """What the server has kept account of, since it was last asked."""
    connection = Connection(HOST, port)
    connection.open()
    try:
        found: list[float] = connection.call("get_system_value_list", (account,), 20.0)
    finally:
        connection.close()
    return found


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


# -- the greatest rate -------------------------------------------------------------------------


async def lane_rate(port: int, count: int) -> float:
    """Set-points per second of a lane that never has to wait for its schedule."""
    opened = Servo(Endpoint(HOST, port)).joints(
        v=3.0, a=1000.0, rate=50_000, ahead=count, options=LaneOptions(watch=0)
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
        slow = None if apache is None else calls.apache_client(apache, port, False, stack).servoj
        for _ in range(rounds):
            rates["process"].append(await lane_rate(port, count))
            rates["thriftpy2"].append(sync_rate(direct, seconds))
            if slow is not None:
                rates.setdefault("Apache", []).append(sync_rate(slow, seconds))
    medians = {name: sorted(found)[len(found) // 2] for name, found in rates.items()}
    slowest = medians.get("Apache")
    return {
        name: {
            "calls_per_second": round(rate, 1),
            "to_thriftpy2": round(rate / medians["thriftpy2"], 3),
            "to_apache": round(rate / slowest, 1) if slowest else "",
        }
        for name, rate in medians.items()
    }


# -- pacing ------------------------------------------------------------------------------------


class Pacing:
    """What one alternative did in all of its slices."""

    def __init__(self) -> None:
        self.lateness = Histogram()
        self.buckets: dict[int, int] = {}
        self.ticks = self.missed = self.trips = 0
        self.gap = 0.0

    def add(self, lateness: list[tuple[int, int, int]], ticks: int, missed: int) -> None:
        for low, high, count in lateness:
            self.buckets[(low + high) // 2] = self.buckets.get((low + high) // 2, 0) + count
        self.ticks += ticks
        self.missed += missed

    def percentile(self, fraction: float) -> float:
        """In seconds."""
        left = fraction * sum(self.buckets.values())
        for value in sorted(self.buckets):
            left -= self.buckets[value]
            if left <= 0:
                return value * 1e-9
        return 0.0

    def beyond(self, limit: float) -> int:
        return sum(count for value, count in self.buckets.items() if value > limit * 1e9)

    def figures(self) -> dict[str, Any]:
        return {
            "ticks": self.ticks,
            "missed": self.missed,
            "late_p50_us": round(self.percentile(0.5) * 1e6, 1),
            "late_p99_us": round(self.percentile(0.99) * 1e6, 1),
            "late_p99.9_us": round(self.percentile(0.999) * 1e6, 1),
            "late_max_us": round(max(self.buckets, default=0) * 1e-3, 1),
            "beyond_2ms": self.beyond(0.002),
            "longest_gap_ms": round(self.gap * 1e3, 2),
            "trips": self.trips,
        }


def urgent_allowed() -> bool:
    """Whether the system allows SCHED_FIFO."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        return False
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return True


async def by_lane(kind: str, port: int, seconds: float) -> tuple[Any, int, int]:
    count = round(seconds * RATE)
    stream = Servo(Endpoint(HOST, port)).joints(
        v=3.0, a=50.0, rate=RATE, hold=20.0, options=LANES[kind]
    )
    with contextlib.suppress(TimeoutError):
        async with stream:
            # one that falls behind is cut off, not waited for
            with anyio.fail_after(seconds + 1):
                await stream.play(sine(count, RATE))
    found = stream.statistics()
    return found.buckets["lateness"], found.ticks, found.missed


async def by_loop(port: int, seconds: float) -> tuple[Any, int, int]:
    lane = Lane("benchmark", HOST, port)
    await lane.open()
    histogram = Histogram()
    period = round(1e9 / RATE)
    schedule = Schedule(period, time.monotonic_ns() + period)
    end = schedule.due + round(seconds * 1e9)
    points = sine(round(seconds * RATE) + 1, RATE)
    number = 0
    while schedule.due < end:
        await anyio.sleep(max(0, schedule.due - time.monotonic_ns()) * 1e-9)
        due = schedule.due
        histogram.record(time.monotonic_ns() - due)
        await lane.rpc.servoj(points[min(number, len(points) - 1)], *SERVOJ)
        number += 1
        now = time.monotonic_ns()
        for missed in range(schedule.advance(now)):
            histogram.record(now - due - (missed + 1) * period)
    await lane.aclose()
    return histogram.buckets(), number, schedule.missed


async def by_bare(seconds: float) -> tuple[Any, int, int]:
    with BareLoop(RATE) as bare:
        await anyio.sleep(seconds)
    return bare.buckets(), bare.ticks, bare.missed


async def pacing(port: int, busy: bool, quick: bool) -> dict[str, dict[str, Any]]:
    """One set-point each millisecond; the alternatives take turns."""
    slices, seconds = (1, 1.5) if quick else (6, 10.0)
    runs: dict[str, Callable[[float], Awaitable[tuple[Any, int, int]]]] = {
        "process": lambda s: by_lane("process", port, s),
        "urgent": lambda s: by_lane("urgent", port, s),
        "thread": lambda s: by_lane("thread", port, s),
        "loop": lambda s: by_loop(port, s),
        "bare": by_bare,
    }
    if not urgent_allowed():
        del runs["urgent"]
    found = {name: Pacing() for name in runs}
    for _ in range(slices):
        for name, run in runs.items():
            ask(port, "arrivals")
            async with load(busy):
                found[name].add(*await run(seconds))
            _, _, _, gap, trips = ask(port, "arrivals")
            if name != "bare":
                found[name].gap = max(found[name].gap, gap)
                found[name].trips += int(trips)
    return {name: pacing.figures() for name, pacing in found.items()}


# -- the realtime queue ------------------------------------------------------------------------


async def queue_by_lane(kind: str, port: int, seconds: float, stall: bool) -> StreamStatistics:
    opened = RealtimeStreams(Endpoint(HOST, port)).stream(
        "joint_position", v=3.0, a=50.0, depth=50, hold=20.0, options=LANES[kind]
    )
    with contextlib.suppress(TimeoutError):
        async with opened as stream:
            with anyio.fail_after(seconds + 1):
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(stream.play, sine(round(seconds / CYCLE), 1 / CYCLE))
                    await anyio.sleep(seconds / 2)
                    if stall:
                        work_for(0.3)
    return opened.statistics()


async def queue_by_loop(port: int, seconds: float, stall: bool) -> None:
    """What a program writes without streams: look at the queue, fill it up, sleep."""
    from aioduco._wire.rpc import RealTimeControlData  # noqa: PLC0415  # only for this

    lane = Lane("benchmark", HOST, port)
    await lane.open()
    rpc, depth, period = lane.rpc, 50, 0.004
    points = [RealTimeControlData(joint_pos_cmd=q, status=True) for q in sine(100, 1000)]
    await rpc.clear_realtime_data_queue()
    await rpc.realtime_data_enqueue(points[:depth], True)
    await rpc.start_realtime_mode(0, 100.0, 0.02)
    start = anyio.current_time()
    for number in range(1, round(seconds / period)):
        await anyio.sleep_until(start + number * period)
        if stall and number == round(seconds / period) // 2:
            work_for(0.3)
        missing = depth - await rpc.get_realtime_data_queue_size()
        if missing > 0:
            await rpc.realtime_data_enqueue(points[:missing], True)
    await rpc.end_realtime_mode()
    await lane.aclose()


async def starvation(port: int, busy: bool, stall: bool, quick: bool) -> dict[str, dict[str, Any]]:
    """A point each millisecond through the queue, under load; the controller's side of it."""
    slices, seconds = (1, 2.0) if quick else (6, 10.0)
    runs: dict[str, Callable[[], Awaitable[object]]] = {
        "process": functools.partial(queue_by_lane, "process", port, seconds, stall),
        "urgent": functools.partial(queue_by_lane, "urgent", port, seconds, stall),
        "thread": functools.partial(queue_by_lane, "thread", port, seconds, stall),
        "loop": functools.partial(queue_by_loop, port, seconds, stall),
    }
    if not urgent_allowed():
        del runs["urgent"]
    found = {name: [0.0, 0.0, 0.0] for name in runs}
    noise = Pacing()
    for _ in range(slices):
        for name, run in runs.items():
            ask(port, "starvation")
            async with load(busy):
                await run()
            taken, starved, longest = ask(port, "starvation")
            before = found[name]
            found[name] = [before[0] + taken, before[1] + starved, max(before[2], longest)]
        async with load(busy):
            noise.add(*await by_bare(seconds))
    rows: dict[str, dict[str, Any]] = {
        name: {"points": round(taken), "starved_cycles": round(starved), "longest_ms": longest}
        for name, (taken, starved, longest) in found.items()
    }
    # What no queue of this depth bridges: how long the machine let a bare loop wait.
    rows["bare"] = {"longest_ms": round(max(noise.buckets) * 1e-6, 1)}
    return rows


# -- what becomes of the arm -------------------------------------------------------------------


async def upsampling(port: int) -> dict[str, dict[str, Any]]:
    """30 Hz targets at 500 Hz, as they arrive at the controller."""
    slow, fast, jerk = 30.0, 500.0, 300.0
    found: dict[str, dict[str, Any]] = {}
    ways: tuple[Upsampling, ...] = ("none", "linear", "cubic", "ruckig")
    for way in ways:
        ask(port, "arrivals")
        opened = Servo(Endpoint(HOST, port)).joints(
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
from aioduco.streaming.endpoint import Endpoint

async def main(port):
    async with Servo(Endpoint("127.0.0.1", int(port))).joints(v=1.0, a=5.0, rate=500) as stream:
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


def killed(port: int) -> dict[str, Any]:
    """The program is killed while the arm moves at 0.4 rad/s, with a limit of 5 rad/s²."""
    ask(port, "arrivals")
    program = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, str(port)], stdout=subprocess.PIPE, text=True
    )
    assert program.stdout is not None
    lane = int(program.stdout.readline())
    program.send_signal(signal.SIGKILL)
    program.communicate()
    start = time.monotonic()
    while runs(lane) and time.monotonic() < start + 10:
        time.sleep(0.002)
    gone = time.monotonic() - start
    slowing, last, stops = ask(port, "ending")
    return {
        "ms_to_lane_gone": round(gone * 1e3, 1),
        "ticks_to_rest": slowing,
        "step_at_the_end_rad": last,
        "stops": stops,
        "lane_left": runs(lane),
    }


async def memory(port: int) -> dict[str, float]:
    """The size of a lane's process, in MB."""
    found: dict[str, float] = {}
    ways: tuple[Upsampling, ...] = ("none", "ruckig")
    for way in ways:
        opened = Servo(Endpoint(HOST, port)).joints(
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


# -- the tables --------------------------------------------------------------------------------


def show(results: dict[str, Any]) -> None:
    print_table(
        "greatest servoj rate, closed loop",
        ("", "calls/s", "/ thriftpy2", "/ Apache"),
        [(name, *row.values()) for name, row in results["greatest_rate"].items()],
    )
    for title in ("idle", "busy"):
        figures = results["pacing"][title]
        columns = ("", "p50", "p99", "p99.9", "max", "> 2 ms", "missed", "gap ms", "trips")
        keys = ("late_p50_us", "late_p99_us", "late_p99.9_us", "late_max_us", "beyond_2ms")
        rows = [
            (name, *(row[key] for key in (*keys, "missed", "longest_gap_ms", "trips")))
            for name, row in figures.items()
        ]
        print_table(f"servoj at 1 kHz, the program's loop {title}: lateness in µs", columns, rows)
    for title, figures in results["realtime_queue"].items():
        accounts = ("points", "starved_cycles", "longest_ms")
        rows = [(name, *(row.get(key, "") for key in accounts)) for name, row in figures.items()]
        heads = ("", "points", "starved cycles", "longest ms")
        print_table(f"realtime queue at 1 kHz, {title}", heads, rows)
    print_table(
        "30 Hz targets at 500 Hz",
        ("", "velocity", "acceleration", "jerk", "limit", "acceleration / bare steps"),
        [(way, *row.values()) for way, row in results["upsampling"].items()],
    )
    print_table("the program killed at 0.4 rad/s", ("", ""), list(results["killed"].items()))
    print_table("memory of a lane's process", ("", "MB"), list(results["memory"].items()))


async def measure(port: int, quick: bool) -> dict[str, Any]:
    results: dict[str, Any] = {"greatest_rate": await greatest_rate(port, quick)}
    # The rest needs no server on a core of its own: a paced lane leaves the machine idle.
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    results["pacing"] = {
        "idle": await pacing(port, False, quick),
        "busy": await pacing(port, True, quick),
    }
    results["realtime_queue"] = {
        "busy loop": await starvation(port, True, False, quick),
        "busy loop, one stall of 300 ms": await starvation(port, True, True, quick),
    }
    results["upsampling"] = await upsampling(port)
    results["killed"] = killed(port)
    results["memory"] = await memory(port)
    return results


def main() -> None:
    options = arguments(__doc__, "streaming")
    with ServerProcess("streaming_server.py") as server:
        results = anyio.run(measure, server.endpoints["thrift"], options.quick)
    show(results)
    if options.save:
        path = write_results("streaming", results)
        print(f"written to {path.relative_to(path.parents[2])}")


if __name__ == "__main__":
    main()
