"""The guard: a small process that runs the stop and the heartbeat of every robot of a program.

`messages` has the messages between program and guard; `process` is the guard; `client` is the
program's end of the connection; `guarded` replaces the local stop and heartbeat by the guard's.
"""
