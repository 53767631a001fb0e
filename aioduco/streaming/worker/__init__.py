"""What runs in a stream's own process: it sends set-points on a schedule of its own.

Imports neither anyio nor asyncio nor numpy, nothing of streaming but `shared`, and of the rest of
the package only the wire, the errors, and what is asked of the scheduler.
"""
