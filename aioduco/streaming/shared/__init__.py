"""The memory that a program shares with the worker of its stream.

Imports neither anyio nor asyncio nor numpy, and from the rest of the package only `_platform`.
"""
