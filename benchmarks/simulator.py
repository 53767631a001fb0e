"""A simulator in a process of its own, which says how well it keeps time; and a client of it.

    python simulator.py SPEED

It prints its port as a line of JSON, answers each line by its time and its processor time, and ends
when its standard input does.
"""

from __future__ import annotations

import contextlib
import json
import sys
import time
from typing import TYPE_CHECKING

from aioduco._wire.connection import Connection
from aioduco._wire.rpc import RpcClient
from aioduco.sim import Simulator

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextlib.contextmanager
def client(port: int) -> Iterator[RpcClient]:
    """A connection below the SDK: each function, blocking."""
    connection = Connection("127.0.0.1", port)
    connection.open()
    try:
        yield RpcClient(lambda name, args: connection.call(name, args, 60.0))
    finally:
        connection.close()


def main() -> None:
    with Simulator(speed=float(sys.argv[1])) as sim:
        print(json.dumps({"port": sim.port}), flush=True)
        for _ in sys.stdin:
            print(json.dumps({"time": sim.time, "cpu": time.process_time()}), flush=True)


if __name__ == "__main__":
    main()
