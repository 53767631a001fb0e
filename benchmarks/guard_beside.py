"""Stops of another checkout and of this one, a few of each in turn, on one machine in one run.

    python benchmarks/guard_beside.py TREE

From the call of a stop to the controller's handler, as in `guard.py`. What a machine does beside
varies more from one minute to the next than two versions do; so both run at the same time, and
batches of stops alternate between them. The other checkout runs twice: what its two copies differ
by is the resolution of this comparison.
"""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import anyio
from _common import parser, print_table, scheduling, spread, write_results

HERE = Path(__file__).resolve().parents[1]
SCENES = ("idle", "loop in bursts of 15 ms")
BATCH = 20


def serve(tree: Path, guard_kind: str, scene: str) -> None:
    """Make stops of a checkout: for each number on the standard input a line of latencies."""
    sys.path[:0] = [str(tree), str(tree / "benchmarks")]
    for name in ("_common", "guard"):
        sys.modules.pop(name, None)
    import _common as common  # noqa: PLC0415  # of that checkout
    import guard as benchmark  # noqa: PLC0415

    import aioduco  # noqa: PLC0415

    made: Any = benchmark
    cores = os.sched_getaffinity(0)

    async def main(port: int, server: Any) -> None:
        lane = getattr(made, "WireLane", None) or made.Lane
        lane = lane("bench", made.HOST, port)
        await lane.open()
        options: Any = {"call_timeout": 600.0, "heartbeat": 60.0, "lag_limit": None}
        options["guard"] = guard_kind or None
        async with aioduco.connect(made.HOST, port, **options) as robot:
            seat = robot._supervisor.guard
            if seat is not None and seat.pid is not None:
                for thread in os.listdir(f"/proc/{seat.pid}/task"):  # noqa: PTH208
                    os.sched_setaffinity(int(thread), cores)
            desk = made.Desk(robot, lane, server)
            while line := (await anyio.to_thread.run_sync(sys.stdin.readline)).strip():
                async with anyio.create_task_group() as tasks:
                    if scene != SCENES[0]:
                        tasks.start_soon(made.work)
                    late = await desk.stops(int(line), desk.stop)
                    tasks.cancel_scope.cancel()
                sys.stdout.write(json.dumps(late) + "\n")
                sys.stdout.flush()
        await lane.aclose()

    with common.ServerProcess("supervision_server.py") as server:
        anyio.run(main, server.endpoints["rpc"], server)


class Checkout:
    """A program that makes stops of one checkout when it is asked to."""

    def __init__(self, tree: Path, guard_kind: str, scene: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, str(tree), "--serve", guard_kind, scene],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=tree,
            env={**os.environ, "PYTHONPATH": str(tree)},
        )
        self.late: list[float] = []

    def stops(self, count: int) -> list[float]:
        """Seconds from each call to the handler."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{count}\n")
        self._process.stdin.flush()
        late: list[float] = json.loads(self._process.stdout.readline())
        return late

    def end(self) -> None:
        self._process.communicate("\n")


def compare(tree: Path, guard_kind: str, scene: str, rounds: int) -> dict[str, Any]:
    names = {"before": tree, "before, again": tree, "now": HERE}
    checkouts = {name: Checkout(path, guard_kind, scene) for name, path in names.items()}
    rng = random.Random(1)
    try:
        for each in checkouts.values():
            each.stops(BATCH)  # warm
        for _ in range(rounds):
            for name in rng.sample(list(checkouts), len(checkouts)):
                checkouts[name].late += checkouts[name].stops(BATCH)
    finally:
        for each in checkouts.values():
            each.end()
    figures = {name: spread(each.late) for name, each in checkouts.items()}
    before = figures["before"]
    return {
        name: {"stops": len(checkouts[name].late)}
        | each
        | {f"{key}_to_before": round(each[f"{key}_us"] / before[f"{key}_us"], 2) for key in RATIOS}
        for name, each in figures.items()
    }


RATIOS = ("p50", "p99")


def main() -> None:
    made = parser(__doc__, "guard_beside")
    made.add_argument("tree", type=Path, help="another checkout")
    made.add_argument("--serve", nargs=2, metavar=("GUARD", "SCENE"), help="used by itself")
    options = made.parse_args()
    tree: Path = options.tree.resolve()
    if options.serve:
        serve(tree, *options.serve)
        return
    rounds = 10 if options.quick else 100
    commit = subprocess.run(
        ["git", "-C", str(tree), "rev-parse", "--short", "HEAD"],
        check=True,
        capture_output=True,
        text=True,
    )
    results: dict[str, Any] = {
        "before_is_commit": commit.stdout.strip(),
        "scheduling": scheduling(),
        "stop": {
            f"{name}, {scene}": compare(tree, kind, scene, rounds)
            for name, kind in (("without guard", ""), ("with guard", "process"))
            for scene in SCENES
        },
    }
    keys = ("p50_us", "p99_us", "p50_to_before", "p99_to_before", "stops")
    rows = [
        [case, name, *(figures[key] for key in keys)]
        for case, each in results["stop"].items()
        for name, figures in each.items()
    ]
    title = "From the call of a stop to the controller's handler [µs]"
    columns = ["stop", "", "p50", "p99", "p50 to before", "p99 to before", "stops"]
    print_table(title, columns, rows)
    if options.save:
        print("written:", write_results("guard_beside", results).name)


if __name__ == "__main__":
    main()
