"""The operating envelope: what the check of one set-point costs the worker of a stream.

    python benchmarks/envelope.py [--quick] [--save]

A stream of 500 set-points a second goes about between random zones, as `CheckedFollower` carries
it out in the worker: with 20 zones, of boxes, spheres and planes, each for tool, elbow and flange,
in three settings. "about the arm": zones of a cell, at random places. "close": all 20 within 5 cm
of the tool at some time, so that most have to be looked at again and again. "no envelope": the
same stream without one. Of both, "all looked at" is the same check without what leaves zones out
that cannot be reached: it sends the same set-points, and ends at the same one.

Figures are processor time of single ticks, less that of the clock. Each stream is carried out
several times, the kinds in turn, and of each tick the quickest time counts: a stream is the same
each time, so what differs is the machine. How much that is, the last column says: the same p99 of
all ticks as they came.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from _common import arguments, percentile, print_table, write_results

from aioduco.envelope import Envelope, Zone
from aioduco.envelope.checker import EnvelopeChecker
from aioduco.kinematics import arm
from aioduco.streaming.shared.space import JOINT_SPACE, Limits
from aioduco.streaming.worker.follower import CheckedFollower, Follower

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array

ARM = arm("gcr5_910")
START = np.array([0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0])
TOOL = (0.02, -0.01, 0.12, 0.0, 0.3, 0.0)
PERIOD = 0.002
LIMITS = Limits((2.0,) * 6, (10.0,) * 6, (100.0,) * 6)
ZONES = 20


class AllLookedAt(EnvelopeChecker):
    """The same check, of all zones each time."""

    def clear(self, start: Sequence[float], more: float) -> bool:
        """Nothing is clear without a look."""
        del start, more
        return False

    def _near(self, start: Sequence[float], elbow: float, wrist: float) -> bool:
        del start, elbow, wrist
        for zone in self._zones:
            zone.near = True
        return True


class Joints:
    """Set-points that are joints."""

    def __init__(
        self, zones: Sequence[Zone], kind: type[EnvelopeChecker] = EnvelopeChecker
    ) -> None:
        self.checker = kind(Envelope(ARM, *zones).packed(TOOL))

    def seen(self, config: Any) -> Any:
        return config


def about(rng: np.random.Generator) -> list[Zone]:
    """Zones at random places about an arm, of which it is clear where it begins."""
    found: list[Zone] = []
    while len(found) < ZONES:
        at = rng.uniform([-0.8, -0.8, 0.0], [0.8, 0.8, 1.0])
        kind = len(found) % 4
        if kind == 0:
            zone = Zone.sphere(at, 0.1)
        elif kind == 1:
            zone = Zone.box([*at, *rng.uniform(-1, 1, 3)], (0.2, 0.2, 0.2))
        elif kind == 2:
            zone = Zone.box((0, 0, 0.5), rng.uniform(1.4, 2.4, 3), keep="in")
        else:
            zone = Zone.plane(at, at - np.array([0.3, 0.0, 0.5]))
        if Joints([zone]).checker.begin(tuple(START.tolist())) is None:
            found.append(zone)
    return found


def close(rng: np.random.Generator, way: Array) -> list[Zone]:
    """Zones that the tool comes near to on its way, and does not cross."""
    look = Joints([]).checker
    tool = np.array([look.places(tuple(q.tolist()))[0] for q in way])
    found: list[Zone] = []
    for number in range(ZONES):
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        furthest = float((tool @ -normal).max())
        if number % 2:
            point = -normal * (furthest + rng.uniform(0.02, 0.05))
            found.append(Zone.plane(point, normal, bodies=("tool",)))
        else:
            radius = float(np.linalg.norm(tool - tool.mean(axis=0), axis=1).max())
            size = 2 * (radius + rng.uniform(0.02, 0.05))
            pose = [*tool.mean(axis=0), *rng.uniform(-1, 1, 3)]
            found.append(Zone.box(pose, (size, size, size), keep="in", bodies=("tool",)))
    return found


def wander(rng: np.random.Generator, count: int) -> Array:
    """A smooth way about the start."""
    t = np.arange(count) * PERIOD
    rates, phases = rng.uniform(0.5, 2.0, 6), rng.uniform(0, 2 * math.pi, 6)
    swing = 0.25 * np.sin(t[:, None] * rates + phases) * np.minimum(t, 1.0)[:, None] ** 2
    return np.asarray(START + swing)


def ticks(follower: Follower, way: Array, crossed: Sequence[object]) -> list[float]:
    """Processor time of each tick [s], until a zone is in the way."""
    clock, found = time.thread_time_ns, []
    for target in way.tolist():
        follower.aim(tuple(target), PERIOD, PERIOD)
        begin = clock()
        follower.step()
        found.append((clock() - begin) * 1e-9)
        if crossed:
            break
    return found


def nothing(count: int) -> float:
    """What the clock itself takes [s]."""
    clock, found = time.thread_time_ns, []
    for _ in range(count):
        begin = clock()
        found.append(clock() - begin)
    return percentile(sorted(found), 50) * 1e-9


def figures(passes: list[list[float]], idle: float) -> dict[str, float]:
    """Percentiles of the quickest time of each tick, and how noisy the machine was."""
    ordered = sorted(max(0.0, min(each) - idle) * 1e6 for each in zip(*passes, strict=True))
    raw = sorted(max(0.0, each - idle) * 1e6 for one in passes for each in one)
    return {
        "mean_us": round(sum(ordered) / len(ordered), 2),
        **{f"p{p:g}_us": round(percentile(ordered, p), 2) for p in (50, 90, 99)},
        "p99 as it came_us": round(percentile(raw, 99), 2),
    }


def main() -> None:
    options = arguments(__doc__, "envelope")
    streams, count, passes = (3, 1000, 3) if options.quick else (10, 2000, 7)
    rng = np.random.default_rng(1)
    near, bare = "20 zones close to the tool", "no envelope"
    names = [bare, "20 zones about the arm", near]
    kinds = [(name, kind) for name in names for kind in (EnvelopeChecker, AllLookedAt)][1:]
    spent: dict[str, list[list[float]]] = {}
    ended = 0
    for _ in range(streams):
        way = wander(rng, count)
        start = tuple(way[0].tolist())
        zones_of = dict(zip(names, ([], about(rng), close(rng, way)), strict=True))
        ends: dict[str, set[int]] = {}
        for turn in range(passes):
            for name, kind in kinds:
                zones, crossed = zones_of[name], list[object]()
                follower: Follower = Follower("none", JOINT_SPACE, LIMITS, PERIOD, start)
                if zones:
                    place = Joints(zones, kind)
                    follower = CheckedFollower(
                        "none", JOINT_SPACE, LIMITS, PERIOD, start, place, crossed.append
                    )
                    assert follower.begin() is None
                title = f"{name}, all looked at" if zones and kind is AllLookedAt else name
                took = ticks(follower, way, crossed)
                spent.setdefault(title, [[] for _ in range(passes)])[turn] += took
                ends.setdefault(name, set()).add(len(took))
                ended += bool(crossed) and turn == 0 and kind is EnvelopeChecker
        assert all(len(each) == 1 for each in ends.values()), "they end at the same set-point"
    idle = nothing(10_000)
    table = {name: figures(seconds, idle) for name, seconds in spent.items()}
    for row in table.values():
        row["check_mean_us"] = round(row["mean_us"] - table[bare]["mean_us"], 2)
    least = min(len(each[0]) for each in spent.values())
    columns = ["µs a set-point", "mean", "p50", "p90", "p99", "p99 as it came", "mean of the check"]
    print_table(
        f"One tick of the worker's follower, of {least} ticks or more, the quickest of {passes}",
        columns,
        [[name, *row.values()] for name, row in table.items()],
    )
    if options.save:
        results = {"set_point": table, "least_ticks": least, "ended_at_a_zone": ended}
        print(f"written: {write_results('envelope', results)}")


if __name__ == "__main__":
    main()
