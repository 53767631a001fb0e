"""What a program and the worker of its stream have in common: the memory between them.

Imports neither anyio nor asyncio nor numpy, and nothing of the package but what is here.
"""
