"""A program that forks while its stream runs.

    python fork_in_stream.py HOST PORT RUN_IN

The child leaves by sys.exit. The parent goes on streaming, and says how many set-points it sent
before and after, and how its stream ended.
"""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Literal, cast

import aioduco
from aioduco import WorkerOptions
from aioduco.errors import DucoError
from aioduco.streaming.stream import Stream

COUNT = 100
START = [0.0, 0.1, 1.5, 0.0, -1.5, 0.0]


async def in_child(stream: Stream) -> None:
    """Every way of sending is refused."""
    stream.statistics()

    async def source() -> AsyncIterator[list[float]]:
        yield START

    ways: tuple[Callable[[], Awaitable[None]], ...] = (
        lambda: stream.send(START),
        lambda: stream.send_chunk([START]),
        lambda: stream.follow(source()),
        lambda: stream.play([START, START], [0.0, 1.0]),
    )
    for way in ways:
        try:
            await way()
        except DucoError:
            continue
        sys.exit(8)
    sys.exit(7)


async def main(host: str, port: int, run_in: Literal["process", "thread"]) -> None:
    told: dict[str, object] = {}
    # a busy machine is not to end the stream
    options = WorkerOptions(run_in=run_in, timeout=20.0, away_limit=20.0)
    async with aioduco.connect(host, port, heartbeat=30.0, loop_stall_limit=20.0) as robot:
        await robot.bring_up()
        async with robot.servo.joints(v=1.0, a=4.0, rate=125.0, options=options) as stream:
            for n in range(COUNT):
                await stream.send([2e-4 * n, *START[1:]])
            child = os.fork()
            if child == 0:
                await in_child(stream)
            for n in range(COUNT, 2 * COUNT):
                await stream.send([2e-4 * n, *START[1:]])
        told["child"] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])  # noqa: ASYNC222  # it has ended
        told["sent"] = stream.statistics().ticks > 0
        told["commanded"] = stream.commanded is not None and stream.commanded[0]
    print(json.dumps(told))  # noqa: T201


if __name__ == "__main__":
    kind = cast("Literal['process', 'thread']", sys.argv[3])
    asyncio.run(main(sys.argv[1], int(sys.argv[2]), kind))
