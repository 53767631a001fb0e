"""`python -m aioduco.sim '{"model": "gcr5_910"}'`: a simulator for the program that started it.

The argument is a JSON object with the arguments of `Simulator`. The simulator writes its addresses
to the standard output as one JSON line. It ends when its standard input closes, on SIGTERM and
SIGINT, and when a client shuts the controller down. For use by hand there is `aioduco sim`.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import sys
import threading
from typing import Any

from aioduco._process.linked_process import ValueChannel
from aioduco.sim.spawned import serve


def main(argument: str = "{}") -> None:
    """Run a simulator until its input closes, a signal arrives or a client shuts it down."""

    def announce(where: dict[str, Any]) -> None:
        sys.stdout.write(f"{json.dumps(where)}\n")
        sys.stdout.flush()

    # A thread reads the pipe: not every system can wait for a pipe together with sockets.
    ours, theirs = socket.socketpair()
    with ours, theirs:
        threading.Thread(target=_end_with_input, args=(theirs,), daemon=True).start()
        serve(json.loads(argument), announce, ValueChannel(ours))


def _end_with_input(end: socket.socket) -> None:
    while os.read(sys.stdin.fileno(), 4096):
        pass
    with contextlib.suppress(OSError):  # the simulator has already ended
        end.shutdown(socket.SHUT_WR)


if __name__ == "__main__":
    main(*sys.argv[1:])
