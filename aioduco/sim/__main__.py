"""`python -m aioduco.sim '{"model": "gcr5_910"}'`: a simulator for the program that started it.

The argument is a JSON object with the arguments of `Simulator`. Where it listens is written to the
standard output as one JSON line. It ends when its standard input closes, on SIGTERM and SIGINT,
and when a client shuts the controller down. People use `aioduco sim`.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import sys
import threading
from typing import Any

from aioduco._linked_process import ValueChannel
from aioduco.sim.spawned import serve


def main(argument: str = "{}") -> None:
    """Run a simulator until it is to end."""

    def tell(where: dict[str, Any]) -> None:
        sys.stdout.write(f"{json.dumps(where)}\n")
        sys.stdout.flush()

    # By a thread: a pipe cannot be waited for together with sockets on every system.
    ours, theirs = socket.socketpair()
    with ours, theirs:
        threading.Thread(target=_end_with_input, args=(theirs,), daemon=True).start()
        serve(json.loads(argument), tell, ValueChannel(ours))


def _end_with_input(end: socket.socket) -> None:
    while os.read(sys.stdin.fileno(), 4096):
        pass
    with contextlib.suppress(OSError):  # it has ended by itself
        end.shutdown(socket.SHUT_WR)


if __name__ == "__main__":
    main(*sys.argv[1:])
