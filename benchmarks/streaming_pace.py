"""How many set-points a second, and how late they are."""

from __future__ import annotations

import contextlib
import functools
import time
from typing import TYPE_CHECKING, Any

import anyio
import rpc as calls
from streaming_load import (
    HOST,
    RATE,
    SERVOJ,
    WORKERS,
    Lateness,
    Noise,
    ask,
    load,
    sine,
    urgent_allowed,
)

from aioduco._wire.lane import WireLane
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.options import WorkerOptions
from aioduco.streaming.servo import Servo
from aioduco.streaming.shared.histogram import Histogram
from aioduco.streaming.worker.clock import Schedule

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable


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
    found.starved += figures.starved


async def by_loop(found: Lateness, port: int, seconds: float) -> None:
    lane = WireLane("benchmark", HOST, port)
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
    found.add(histogram.buckets(), number, schedule.missed)


async def pacing(port: int, busy: bool, quick: bool) -> dict[str, dict[str, Any]]:
    """One set-point each millisecond; the alternatives take turns."""
    slices, seconds = (1, 1.5) if quick else (6, 3.0)
    runs: dict[str, Callable[[Lateness], Awaitable[None]]] = {
        kind: functools.partial(by_worker, kind=kind, port=port, seconds=seconds)
        for kind in WORKERS
    }
    runs["loop"] = functools.partial(by_loop, port=port, seconds=seconds)
    if not urgent_allowed():
        del runs["urgent"]
    found = {name: Lateness() for name in runs}
    noise = Noise()
    for _ in range(slices):
        for name, run in runs.items():
            ask(port, "arrivals")
            beside = noise.beside() if name == "process" else contextlib.nullcontext()
            async with load(busy):
                with beside:
                    await run(found[name])
            _, _, _, gap, trips = ask(port, "arrivals")
            found[name].gap = max(found[name].gap, gap)
            found[name].trips += int(trips)
    found["bare"] = noise.lateness
    return {name: lateness.figures() for name, lateness in found.items()}
