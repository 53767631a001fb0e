"""What the twin sees: runs with one hidden change, runs without, and hours in good order.

    python benchmarks/twin.py                       20 runs of each kind, and 20 without a change
    python benchmarks/twin.py --runs 200 --hours 10 --jobs 2 --save

The arm is a simulator whose time is locked and advanced as fast as possible, with dry and viscous
friction that its controller does not know, readings in single precision, noise on joints, speeds
and external torques, samples at uneven times of which some are lost, and no force sensor. Its
program picks and places at random places. The twin gets the samples and the program's commands, and
limits that it learned from another run of such a program on the same arm.
"""

from __future__ import annotations

import dataclasses
import math
import multiprocessing
import pickle
import random
import statistics
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import chain, count, cycle, islice, repeat
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from _common import parser, report

from aioduco.compat import DucoCobot, Op
from aioduco.errors import DucoError
from aioduco.kinematics import arm as arm_of
from aioduco.models.pose import Pose
from aioduco.sim import Simulator
from aioduco.sim.twin.data import Cause, Divergence, TwinCommand, TwinSample
from aioduco.sim.twin.limits import TwinLimits, deviations, learn
from aioduco.sim.twin.monitor import TwinMonitor
from aioduco.sim.twin.predictor import Timeline

if TYPE_CHECKING:
    from collections.abc import Iterator

    from aioduco.kinematics import Arm
    from aioduco.sim.twin.predictor import Item

MODEL = "gcr5_910"
CYCLE = 0.004
EVERY = 2  # cycles between samples: 125 Hz
READY = (0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)
#: standard deviations of the readings: joints [rad], speeds [rad/s], torques as a share of the
#: joint's largest; share of samples that are lost
JOINTS, SPEEDS, TORQUES, LOST = 1e-5, 2e-3, 0.003, 0.01
#: largest time between the arm's state and the receipt of its sample [s], and of a command's way
LATE = 0.004
HELD_MASS = 0.5
#: how often the same work in good order is judged, each time with other errors of the readings
DRAWS = 10
#: of different friction
ARMS = 4
TOOL = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

#: the kinds of hidden changes, with the cause that the twin should name
CHANGES = {
    "payload": Cause.PAYLOAD,
    "friction": Cause.FRICTION,
    "contact": Cause.CONTACT,
    "geometry": Cause.GEOMETRY,
    "second client": Cause.OTHER_PROGRAM,
    "lost part": Cause.LOST_PART,
    "delay": Cause.DELAYED_CONTROLLER,
}


def friction(arm: Arm, number: int, factor: float = 1.0) -> list[list[float]]:
    """Dry and viscous: 2.4 to 3.6 % of each joint's largest torque, and as much at 3 rad/s."""
    draw = random.Random(f"arm {number}")
    return [
        [factor * share * draw.uniform(0.8, 1.2) * each for each in arm.effort]
        for share in (0.03, 0.01)
    ]


class Noise:
    """The errors of readings and of their times."""

    def __init__(self, seed: int) -> None:
        self._draw = np.random.default_rng(seed)
        self._effort = np.array(arm_of(MODEL).effort)

    def __call__(self, item: Any) -> Any:
        """The item as the twin gets it; None for a sample that is lost."""
        if isinstance(item, TwinCommand):
            return item._replace(time=item.time - self._draw.uniform(0.0, LATE))
        if self._draw.random() < LOST:
            return None
        noise = self._draw.standard_normal((3, 6))
        assert item.external is not None
        read = {
            "joints": item.joints + JOINTS * noise[0],
            "speeds": item.speeds + SPEEDS * noise[1],
            "expected": item.expected,
            "expected_speeds": item.expected_speeds,
            "pose": item.pose,
            "external": item.external + TORQUES * self._effort * noise[2],
        }
        single = {name: tuple(np.array(each, "f4").tolist()) for name, each in read.items()}
        return item._replace(time=item.time + self._draw.uniform(0.001, LATE), **single)


class Cell:
    """One arm with its program, in made-up time.

    Attributes:
        arm: the arm, as it should be.
        shown: when the change begins to show in the motion [s]; None before.
    """

    def __init__(self, number: int, seed: int, change: str = "", at: float = 8.0) -> None:
        self.arm = true = arm_of(MODEL)
        if change == "geometry":
            which = random.Random(f"link {seed}").choice(("a2", "a3"))
            longer = true.geometry._replace(**{which: getattr(true.geometry, which) + 1e-3})
            true = dataclasses.replace(true, geometry=longer)
        self._number = number
        self._change, self._at = change, at
        self._draw = random.Random(seed)
        self._sim = Simulator(true, cycle=CYCLE, seed=seed, joints=READY, speed=math.inf)
        #: what the program has sent, with the time at which the arm gets it
        self._underway: list[tuple[float, str, tuple[Any, ...]]] = []
        self._late = 0.0
        self._held = self._changed = False
        self.shown: float | None = 0.0 if change == "geometry" else None

    def run(self, seconds: float) -> Iterator[tuple[float, list[Any]]]:
        """Give times, and the samples and commands that have come until then."""
        sim = self._sim
        with sim, DucoCobot(sim.host, sim.port) as client, DucoCobot(sim.host, sim.port) as other:
            client.power_on(True)
            client.enable(True)
            sim.lock_time()
            sim.drag(*friction(self.arm, self._number))
            start, now, next_at, queue = sim.time, 0.0, 0.5, self._program()
            while now < seconds:
                items: list[Any] = []
                if self._change and not self._changed and now >= self._at:
                    self._changed = self._begin_change(other)
                # the second client waits for a rest of the program
                waits = self._change == "second client" and self._at - 0.3 < now < self._at + 2.0
                if now >= next_at and self._stands and not waits:
                    function, arguments = next(queue)
                    self._underway.append((now + self._late, function, arguments))
                    items.append(TwinCommand(now, function, arguments, True))
                    next_at = now + self._draw.uniform(0.03, 0.2)
                    if self._late and self.shown is None:
                        self.shown = now
                while self._underway and self._underway[0][0] <= now:
                    _, function, arguments = self._underway.pop(0)
                    getattr(client, function)(*arguments)
                sim.advance(EVERY)
                now = sim.time - start
                if self._changed and not self._late and self.shown is None and sim.moving:
                    self.shown = now
                yield now, [*items, self._sample(now)]

    def _sample(self, now: float) -> TwinSample:
        """A sample without errors."""
        snapshot = self._sim._running().runtime.snapshot
        view, setpoint = snapshot.view, snapshot.setpoint
        pose = Pose.from_matrix(self._sim.arm.fkine(snapshot.q) @ view.tool.matrix)
        q, qd, expected, expected_speeds, external = (
            tuple(each.tolist())
            for each in (snapshot.q, snapshot.qd, setpoint.q, setpoint.qd, snapshot.external_torque)
        )
        axis, states = view.collision_axis, (int(view.robot), int(view.program), int(view.safety))
        moved = (q, qd, expected, expected_speeds, tuple(pose))
        return TwinSample(now, *moved, external, None, *states, axis)

    @property
    def _stands(self) -> bool:
        return not self._sim.moving and not self._underway

    def _begin_change(self, other: DucoCobot) -> bool:
        """Make the change, if this is a moment for it."""
        draw, sim = self._draw, self._sim
        match self._change:
            case "geometry":
                pass  # from the beginning
            # the plant carries what the program set, until it is told otherwise
            case "payload" if not self._held:
                sim.load(0.5, (0.0, 0.0, 0.05))
            case "lost part" if self._held:
                sim.load(0.0)
            case "friction":
                sim.drag(*friction(self.arm, self._number, 1.3))
            case "contact":
                way = np.array([draw.gauss(0.0, 1.0) for _ in range(3)])
                sim.push([*(10.0 * way / np.linalg.norm(way)).tolist(), 0.0, 0.0, 0.0])
            case "second client" if self._stands:
                goal = [angle + draw.uniform(-0.4, 0.4) for angle in sim.joints]
                other.movej2(goal, draw.uniform(0.3, 1.0), 1.0, 0.0, False, Op(), False)
            case "delay":
                self._late = draw.uniform(0.1, 0.3)
            case _:
                return False
        return True

    def _program(self) -> Any:
        """Pick and place at random places, in joints and along lines."""
        draw, arm = self._draw, self.arm
        while True:
            near = [angle + draw.uniform(-0.5, 0.5) for angle in READY]
            near[0] = draw.uniform(-1.2, 1.2)
            above = arm.fkine(near)
            if above[2, 3] < 0.25 or above[0, 3] ** 2 + above[1, 3] ** 2 < 0.09:
                continue
            down = above.copy()
            down[2, 3] -= draw.uniform(0.05, 0.12)
            try:
                arm.ikine(down, near)
            except DucoError:
                continue
            speed, fast = draw.uniform(0.1, 0.3), draw.uniform(0.5, 1.5)
            there, back = (list(Pose.from_matrix(each)) for each in (down, above))
            yield "movej2", (near, fast, draw.uniform(1.0, 3.0), 0.0, False, Op(), False)
            yield "movel", (there, speed, 1.0, 0.0, near, "", "", False, Op(), False)
            if self._change != "payload" and not self._changed:
                self._held = not self._held
                yield "set_load_data", ([HELD_MASS if self._held else 0.0, 0.0, 0.0, 0.05],)
            yield "movel", (back, speed, 1.0, 0.0, near, "", "", False, Op(), False)


def received(cell: Cell, seconds: float, noise: Noise) -> Iterator[tuple[float, Item]]:
    """Samples and commands of a run as a twin gets them, each with the time of the run."""
    line = Timeline()
    for now, items in cell.run(seconds):
        for item in filter(None, map(noise, items)):
            line.put(item)
        for due in line.due():
            yield now, due


def heard(monitor: TwinMonitor, item: Item) -> list[Divergence]:
    """What a twin says of an item."""
    if isinstance(item, TwinCommand):
        monitor.command(item)
        return []
    return list(monitor.sample(item))


@cache
def limits(number: int) -> TwinLimits:
    """Limits from a good run of 100 s on one arm."""
    cell = Cell(number, 90_000 + number)
    items = (item for _, item in received(cell, 100.0, Noise(90_000 + number)))
    return learn(cell.arm, deviations(cell.arm, items, TOOL))


class Watched(NamedTuple):
    """One run: what was hidden, when it showed, and what the twin said first, when."""

    change: str
    shown: float | None
    first: Divergence | None
    at: float
    early: int

    @property
    def cause(self) -> str:
        return "not seen" if self.first is None else self.first.cause.value


def watched(number: int, seed: int, change: str, seconds: float, after: float = 3.0) -> Watched:
    """One run with a twin, up to some time after the change shows."""
    cell = Cell(number, seed, change, at=random.Random(f"when {seed}").uniform(4.0, 8.0))
    monitor = TwinMonitor(cell.arm, limits(number), tool=TOOL)
    first, at, early = None, math.nan, 0
    for now, item in received(cell, seconds, Noise(seed)):
        for divergence in heard(monitor, item):
            early += cell.shown is None
            if first is None:
                first, at = divergence, now
        if (first is not None and change) or (cell.shown is not None and now > cell.shown + after):
            break
    return Watched(change, cell.shown, first, at, early)


#: what a twin says about work in good order, and its processor time for a sample [s]
Order = tuple[list[Divergence], float]


def good_order(number: int, items: list[Any], seed: int) -> Order:
    """Judge work in good order, with one draw of the readings' errors."""
    monitor = TwinMonitor(arm_of(MODEL), limits(number), tool=TOOL)
    line, noise = Timeline(), Noise(seed)
    found: list[Divergence] = []
    # as the twin's process gets them
    given = [pickle.dumps([item]) for item in filter(None, map(noise, items))]
    begun = time.process_time()
    for data in given:
        line.put(pickle.loads(data)[0])
        for due in line.due():
            found += heard(monitor, due)
    return found, (time.process_time() - begun) / max(1, len(given))


def hour_in_good_order(number: int, seed: int, block: float) -> list[Order]:
    """A part of an hour of work, judged as often as makes the whole hour of it."""
    items = [item for _, some in Cell(number, 50_000 + seed).run(3600 * block) for item in some]
    return [good_order(number, items, 1000 * draw + seed) for draw in range(DRAWS)]


def main() -> None:
    options = parser(__doc__)
    options.add_argument("--runs", type=int, default=20, help="with a change, and without")
    options.add_argument("--hours", type=float, default=0.2, help="of work in good order")
    options.add_argument("--jobs", type=int, default=1, help="processes beside each other")
    given = options.parse_args()
    if given.quick:
        given.runs, given.hours = 2, 0.02
    changes = list(islice(cycle(CHANGES), given.runs))
    arms = [number % ARMS for number in range(given.runs)]
    seeds = range(1000, 1000 + given.runs)
    block = min(0.1, given.hours / DRAWS)
    blocks = range(round(given.hours / DRAWS / block) if block else 0)
    # Processes that start anew: the simulators' threads would not be in a fork.
    with ProcessPoolExecutor(given.jobs, multiprocessing.get_context("spawn")) as pool:
        with_change = pool.map(watched, arms, seeds, changes, repeat(40.0))
        without = pool.map(watched, arms, count(1500), repeat(""), repeat(12.0))
        ordered = pool.map(hour_in_good_order, [n % ARMS for n in blocks], blocks, repeat(block))
        runs, good, orders = [*with_change], [*without], [*chain.from_iterable(ordered)]
    false_runs = [run for run in good if run.early]
    false = [divergence for found, _ in orders for divergence in found]
    costs = [cost for _, cost in orders]
    right = [run for run in runs if run.cause == CHANGES[run.change].value]
    odd = [run for run in runs if run not in right or run.early]
    print("what a twin should not have said:", *odd, *false_runs, *false, sep="\n")
    confusion: dict[str, Counter[str]] = defaultdict(Counter)
    times: dict[str, list[float]] = defaultdict(list)
    for run in runs:
        confusion[run.change][run.cause] += 1
        if run.first is not None and run.shown is not None:
            times[run.change].append(run.at - run.shown)
    result = {
        "runs with a change": given.runs,
        "seen": sum(run.first is not None for run in runs),
        "seen within 0.5 s of showing": sum(each <= 0.5 for row in times.values() for each in row),
        "cause named right": len(right),
        "runs without a change": given.runs,
        "of these with an alarm": len(false_runs),
        "hours in good order": round(block * DRAWS * len(blocks), 2),
        "of different work": round(block * len(blocks), 2),
        "false alarms in these": len(false),
        "share of a processor at 125 Hz": round(125.0 * statistics.median(costs), 3),
        "confusion: hidden change, named cause": confusion,
        "time until it was said [s]": {
            change: {"p50": round(statistics.median(row), 3), "max": round(max(row), 3)}
            for change, row in times.items()
        },
    }
    report(given, "twin", result)


if __name__ == "__main__":
    main()
