"""The guard: a small process that holds the stop and the heartbeat of every robot of a program.

`messages` is what program and guard say to each other; `process` is the guard; `link` is the
program's end of it; `sides` puts it in the place of the local stop and heartbeat.
"""
