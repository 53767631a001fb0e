"""The simulated controller in a process of its own, for `simulation.py`.

    python benchmarks/simulation_server.py <speed>

Says where it serves in one line of JSON, and answers each line that it is sent by another: how far
simulated time is, and how well the cycle is kept.
"""

from __future__ import annotations

import json
import sys
import time

from aioduco.sim import Simulator


def main() -> None:
    with Simulator(speed=float(sys.argv[1])) as sim:
        print(json.dumps({"port": sim.port}), flush=True)
        for _ in sys.stdin:
            kept = sim.statistics()
            said = {
                "time": sim.time,
                "cpu": time.process_time(),
                "slipped": kept.slipped,
                "late_p99": kept.late_p99,
                "work_p50": kept.work_p50,
                "work_p99": kept.work_p99,
            }
            print(json.dumps(said), flush=True)


if __name__ == "__main__":
    main()
