"""The code of a stream's separate process, which sends set-points on its own schedule.

Imports neither anyio nor asyncio, and numpy only if an envelope needs inverse kinematics. It
imports from streaming only `shared`, and from the rest of the package only the wire, the errors,
the envelope's checker, and the requests to the system.
"""
