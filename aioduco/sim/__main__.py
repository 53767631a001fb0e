"""`python -m aioduco.sim '{"model": "gcr5_910"}'`: a simulator for the program that started it.

The argument is a JSON object with the arguments of `Simulator`. Where it listens is written to the
standard output as one JSON line. It ends when its standard input closes, on SIGTERM and SIGINT,
and when a client shuts the controller down. People use `aioduco sim`.
"""

from __future__ import annotations

import json
import os
import selectors
import signal
import socket
import sys

from aioduco.sim.simulator import Simulator


def main(argument: str = "{}") -> int:
    """Run a simulator until it is to end; the process's exit status."""
    options = json.loads(argument)
    ours, others = socket.socketpair()
    ours.setblocking(False)
    others.setblocking(False)
    # The handlers do nothing: their signal arrives as a byte on the socket, at any moment.
    signal.set_wakeup_fd(others.fileno(), warn_on_full_buffer=False)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: None)
    with Simulator(**options, on_shutdown=lambda: others.send(b"x")) as sim:
        ports = {"port": sim.port, "status_port": sim.status_port}
        ready = json.dumps({"host": sim.host, **ports, "pid": os.getpid()})
        sys.stdout.write(f"{ready}\n")
        sys.stdout.flush()
        with selectors.DefaultSelector() as selector:
            stdin = sys.stdin.fileno()
            selector.register(stdin, selectors.EVENT_READ)
            selector.register(ours, selectors.EVENT_READ)
            while True:
                ready_ones = {key.fileobj for key, _ in selector.select()}
                if ours in ready_ones or not os.read(stdin, 4096):
                    break
    ours.close()
    others.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
