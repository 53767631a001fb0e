"""The memory that a program shares with the worker of its stream.

Imports neither anyio, asyncio nor numpy, and of the rest of the package `_process.platform` alone.
"""
