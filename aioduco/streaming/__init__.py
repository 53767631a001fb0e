"""Streams of set-points (servo, realtime queue, track pool, speeds), sent by a separate process.

A stream has two ends. The modules here are the program's end, and asynchronous. The worker
(`worker`) owns the connection to the controller and the schedule; it runs in a small process or in
a thread. The two ends share one block of memory (`shared`).

This module imports nothing, so that the worker's process stays small.
"""

from __future__ import annotations
