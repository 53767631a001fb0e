"""Pages that watch a panel as browsers do, without a browser: both of a page's connections.

    python benchmarks/panel_watchers.py PAGE_PORT SCENE_PORT NUMBER

It says when all of them are there, and after each line of its standard input how many states each
of them has been told since the line before. It ends with its standard input.
"""

from __future__ import annotations

import asyncio
import importlib.metadata
import json
import sys

from websockets.asyncio.client import connect
from websockets.typing import Subprotocol


async def watch(url: str, number: int, counts: list[int], there: asyncio.Semaphore) -> None:
    async with connect(url, compression=None, max_size=None) as page:
        there.release()
        async for message in page:
            counts[number] += isinstance(message, str) and '"tell":"state"' in message[:20]


async def look(url: str, there: asyncio.Semaphore) -> None:
    spoken = [Subprotocol(f"viser-v{importlib.metadata.version('viser')}")]
    async with connect(url, compression=None, max_size=None, subprotocols=spoken) as scene:
        there.release()
        async for _ in scene:
            pass


async def main() -> None:
    page_port, scene_port, number = map(int, sys.argv[1:])
    counts = [0] * number
    there = asyncio.Semaphore(0)
    tasks = []
    for each in range(number):
        url = f"ws://127.0.0.1:{page_port}/socket"
        tasks.append(asyncio.create_task(watch(url, each, counts, there)))
        tasks.append(asyncio.create_task(look(f"ws://127.0.0.1:{scene_port}", there)))
    for _ in range(2 * number):
        await there.acquire()
    print("there", flush=True)
    while await asyncio.to_thread(sys.stdin.readline):
        print(json.dumps(counts), flush=True)
        counts[:] = [0] * number


if __name__ == "__main__":
    asyncio.run(main())
