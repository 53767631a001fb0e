"""Streams of set-points: servo, realtime queue, track pool, speeds; in a process of their own.

A stream has two ends. The *face* lives in the program (`servo`, `realtime`, `track`, `speed`,
`trajectory`) and is asynchronous. The *lane* owns the connection to the controller and the
schedule; it runs in a small process, or in a thread, and imports neither asyncio nor anyio.
Between them lies one block of shared memory.

Nothing is imported here, so that the lane's process stays small.
"""

from __future__ import annotations
