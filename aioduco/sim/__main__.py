"""`python -m aioduco.sim '{"model": "gcr5_910"}'`: a simulator for the program that started it.

The argument is a JSON object with the arguments of `Simulator`. Where it listens is written to the
standard output as one JSON line. It ends when its standard input closes, on SIGTERM and SIGINT,
and when a client shuts the controller down. People use `aioduco sim`.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from aioduco.sim.spawned import serve


def main(argument: str = "{}") -> None:
    """Run a simulator until it is to end."""

    def tell(where: dict[str, Any]) -> None:
        sys.stdout.write(f"{json.dumps(where)}\n")
        sys.stdout.flush()

    serve(json.loads(argument), tell, sys.stdin.fileno())


if __name__ == "__main__":
    main(*sys.argv[1:])
