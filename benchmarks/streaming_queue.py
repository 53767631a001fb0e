"""The realtime queue under load, from the controller's side."""

from __future__ import annotations

import contextlib
import functools
from typing import TYPE_CHECKING, Any

import anyio
from streaming_load import HOST, WORKERS, Noise, ask, load, sine, urgent_allowed, work_for
from streaming_server import CYCLE

from aioduco._wire.lane import WireLane
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.realtime import RealtimeStreams

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.streaming.report import StreamStatistics


async def queue_by_worker(kind: str, port: int, seconds: float, stall: bool) -> StreamStatistics:
    opened = RealtimeStreams(StreamEndpoint(HOST, port)).stream(
        "joint_position", v=3.0, a=50.0, depth=50, hold=20.0, options=WORKERS[kind]
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
        if stall and number == round(seconds / period) // 2:
            work_for(0.3)
        missing = depth - await rpc.get_realtime_data_queue_size()
        if missing > 0:
            await rpc.realtime_data_enqueue(points[:missing], True)
    await rpc.end_realtime_mode()
    await lane.aclose()


async def starvation(port: int, busy: bool, stall: bool, quick: bool) -> dict[str, dict[str, Any]]:
    """A point each millisecond through the queue, under load; the controller's side of it."""
    slices, seconds = (1, 2.0) if quick else (6, 2.0)
    runs: dict[str, Callable[[], Awaitable[object]]] = {
        "process": functools.partial(queue_by_worker, "process", port, seconds, stall),
        "urgent": functools.partial(queue_by_worker, "urgent", port, seconds, stall),
        "thread": functools.partial(queue_by_worker, "thread", port, seconds, stall),
        "loop": functools.partial(queue_by_loop, port, seconds, stall),
    }
    if not urgent_allowed():
        del runs["urgent"]
    found = {name: [0.0, 0.0, 0.0] for name in runs}
    noise = Noise()
    for _ in range(slices):
        for name, run in runs.items():
            ask(port, "starvation")
            beside = noise.beside() if name == "process" else contextlib.nullcontext()
            async with load(busy):
                with beside:
                    await run()
            taken, starved, longest = ask(port, "starvation")
            before = found[name]
            found[name] = [before[0] + taken, before[1] + starved, max(before[2], longest)]
    rows: dict[str, dict[str, Any]] = {
        name: {"points": round(taken), "starved_cycles": round(starved), "longest_ms": longest}
        for name, (taken, starved, longest) in found.items()
    }
    # What no queue of this depth bridges: how long the machine let a bare loop wait.
    rows["bare"] = {"longest_ms": round(max(noise.lateness.buckets) * 1e-6, 1)}
    return rows
