"""The operating envelope: what the check of one set-point costs the worker of a stream.

    python benchmarks/envelope.py [--quick] [--save]

A stream of 500 set-points a second goes about between random zones, as `PositionGenerator` carries
it out in the worker: with 20 zones, of boxes, spheres and planes, each for tool, elbow and flange,
in two settings. "about the arm": zones of a cell, at random places. "close": all 20 within 5 cm
of the tool at some time, so that most have to be looked at again and again. Of both, "all looked
at" is the same check without what leaves zones out that cannot be reached: it sends the same
set-points, and ends at the same one.

Figures are processor time: what the check adds to a tick of the same stream without an envelope.
Each stream is carried out several times, the kinds in turn, and of each tick the quickest time
counts: a stream is the same each time, so what differs is the machine. How much that is, the last
column says: p99 of whole ticks as they came, to be compared with that of a tick without the check.
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
from aioduco.streaming.worker.checked import EnvelopeCheck
from aioduco.streaming.worker.setpoints import PositionGenerator

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


def ticks(generator: PositionGenerator, way: Array, crossed: Sequence[object]) -> list[float]:
    """Processor time of each tick [s], until a zone is in the way."""
    clock, found = time.thread_time_ns, []
    for target in way.tolist():
        generator.aim(tuple(target), PERIOD, PERIOD)
        begin = clock()
        generator.step()
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


def quickest(passes: Sequence[Sequence[float]]) -> list[float]:
    """The quickest time of each tick."""
    return [min(each) for each in zip(*passes, strict=True)]


def figures(checked: Sequence[float], came: Sequence[float]) -> dict[str, float]:
    """Percentiles of what the check adds to a tick, and how noisy the machine was [µs]."""
    ordered = sorted(each * 1e6 for each in checked)
    return {
        "mean_us": round(sum(ordered) / len(ordered), 2),
        **{f"p{p:g}_us": round(percentile(ordered, p), 2) for p in (50, 90, 99)},
        "p99 as it came_us": round(percentile(sorted(came), 99) * 1e6, 2),
    }


def main() -> None:
    options = arguments(__doc__, "envelope")
    streams, count, passes = (3, 1000, 3) if options.quick else (10, 2000, 5)
    rng = np.random.default_rng(1)
    names = ["20 zones about the arm", "20 zones close to the tool"]
    checked: dict[str, list[float]] = {}
    came: dict[str, list[float]] = {}
    bare: list[float] = []
    ended = 0
    for _ in range(streams):
        way = wander(rng, count)
        start = tuple(way[0].tolist())
        zones_of = dict(zip(names, (about(rng), close(rng, way)), strict=True))
        kinds = [(name, kind) for name in names for kind in (EnvelopeChecker, AllLookedAt)]
        plain: list[list[float]] = []
        spent: dict[str, list[list[float]]] = {}
        for _ in range(passes):
            generator = PositionGenerator("none", JOINT_SPACE, LIMITS, PERIOD, start)
            plain.append(ticks(generator, way, ()))
            for name, kind in kinds:
                crossed = list[object]()
                place = Joints(zones_of[name], kind)
                check = EnvelopeCheck(
                    *(place.checker, place.seen, JOINT_SPACE, PERIOD, start, crossed.append)
                )
                assert check.begin() is None
                generator = PositionGenerator(
                    "none", JOINT_SPACE, LIMITS, PERIOD, start, check=check
                )
                title = f"{name}, all looked at" if kind is AllLookedAt else name
                spent.setdefault(title, []).append(ticks(generator, way, crossed))
                ended += bool(crossed) and len(plain) == 1 and kind is EnvelopeChecker
        without = quickest(plain)
        bare += without
        came.setdefault("", []).extend(each for one in plain for each in one)
        for name in names:
            ends = {len(one) for title in spent if title.startswith(name) for one in spent[title]}
            assert len(ends) == 1, "both kinds end at the same set-point"
        for title, each in spent.items():
            pairs = zip(quickest(each), without, strict=False)
            checked.setdefault(title, []).extend(took - less for took, less in pairs)
            came.setdefault(title, []).extend(took for one in each for took in one)
    idle = nothing(10_000)
    alone = figures([each - idle for each in bare], came.pop(""))
    table = {name: figures(checked[name], came[name]) for name in checked}
    least = min(map(len, checked.values()))
    print_table(
        f"What the check adds to a tick, of {least} ticks or more, the quickest of {passes}",
        ["µs a set-point", "mean", "p50", "p90", "p99", "p99 of whole ticks as they came"],
        [[name, *row.values()] for name, row in ({"generator without": alone} | table).items()],
    )
    if options.save:
        results = {
            "check_of_a_set_point": {"a tick without it": alone} | table,
            "least_ticks": least,
            "ended_at_a_zone": ended,
        }
        print(f"written: {write_results('envelope', results)}")


if __name__ == "__main__":
    main()
