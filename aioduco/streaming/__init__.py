"""Streams of set-points: servo, realtime queue, track pool, speeds; in a process of their own.

A stream has two ends. The modules here are the program's, and asynchronous. The worker (`worker`)
owns the connection to the controller and the schedule; it runs in a small process, or in a thread.
Between them lies one block of shared memory (`shared`).

Nothing is imported here, so that the worker's process stays small.
"""

from __future__ import annotations
