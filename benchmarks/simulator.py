"""A simulator that says how far its time has come.

    python simulator.py SPEED

It prints its port as a line of JSON, answers each line by its time, and ends when its standard
input does.
"""

from __future__ import annotations

import json
import sys

from aioduco.sim import Simulator


def main() -> None:
    with Simulator(speed=float(sys.argv[1])) as sim:
        print(json.dumps({"ports": [sim.port]}), flush=True)
        for _ in sys.stdin:
            print(sim.time, flush=True)


if __name__ == "__main__":
    main()
