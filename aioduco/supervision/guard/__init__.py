"""The guard: a small process that beats for every robot of a program, and stops what it leaves.

`messages` has the messages between program and guard; `process` is the guard; `client` is the
program's end of the connection; `guarded` takes the place of the program's own heartbeat.
"""
