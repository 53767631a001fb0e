"""Long plans work in slices, by the amount of work; motions are planned beside the queue."""

from __future__ import annotations

import math
from array import array
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from aioduco.kinematics.inverse import closed_form
from aioduco.models.rotation import Array
from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.sim.planner import timing, tracing
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.path import Path
from aioduco.sim.planner.segments import Segment, joint_move, line_move, spiral_move, spline_move
from aioduco.sim.planner.slices import LONG_SLICE, SLICE, PlanDropped, in_turn, slices, yielding
from aioduco.sim.planner.timing import PathLimits, backward, fastest
from aioduco.sim.planner.weaving import Weave

from .motions import CYCLE, FIVE, HOME, moving


def shifted(q: Array, *by: float) -> Array:
    pose = FIVE.fkine(q)
    pose[:3, 3] += by
    return pose


def woven(q: Array, swings: int = 300, shape: int = 4) -> Segment:
    """A line of 0.3 m, with so many swings over it."""
    weave = Weave(WeaveShape(shape), WeavePlane.TOOL_XY, swings * 0.02 / 0.3, 0.004)
    return line_move(FIVE, q, shifted(q, 0.0, 0.3, 0.0), 0.02, 1.0, weave=weave)


def splined(q: Array) -> Segment:
    through = [shifted(q, 0.02 * math.sin(0.5 * i), 0.006 * i, 0.0) for i in range(1, 51)]
    return spline_move(FIVE, q, through, 0.1, 1.0)


def wound(q: Array) -> Segment:
    centre = shifted(q, 0.05, 0.0, 0.0)
    return spiral_move(FIVE, q, centre, 100.0, 0.1, 1.0, axial=0.05, radius=0.01)


class Counter:
    """Counts what planning works at between two turns."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.turns = 0
        self.most: dict[str, int] = {}
        self._since: dict[str, int] = {}
        solve, rate, sample = closed_form, timing._rate, Path._sample

        def counted_solve(geometry: Any, flange: Array, q6: float) -> Array:
            self.add("poses", len(flange))
            return solve(geometry, flange, q6)

        def counted_rate(limits: PathLimits, piece: int, x: float) -> float:
            self.add("nodes", 1)
            return rate(limits, piece, x)

        def counted_sample(path: Path, s: Array) -> Array:
            self.add("samples", len(s))
            return sample(path, s)

        monkeypatch.setattr(tracing, "closed_form", counted_solve)
        monkeypatch.setattr(timing, "_rate", counted_rate)
        monkeypatch.setattr(Path, "_sample", counted_sample)

    def add(self, what: str, count: int) -> None:
        self._since[what] = self._since.get(what, 0) + count
        self.most[what] = max(self.most.get(what, 0), self._since[what])

    def yield_hook(self) -> None:
        self.turns += 1
        self._since.clear()


@pytest.mark.slow
@pytest.mark.parametrize("plan", [woven, splined, wound])
def test_no_slice_is_longer_the_longer_the_path(
    plan: Callable[..., Segment], monkeypatch: pytest.MonkeyPatch
) -> None:
    work, mover = Counter(monkeypatch), moving()
    with yielding(work.yield_hook):
        drafted = mover.draft(1, plan).work()
    assert drafted.alone.limits is not None
    nodes = len(drafted.alone.limits.nodes)
    assert work.turns > nodes / SLICE
    assert work.most["poses"] <= 2 * SLICE  # the last one of a path and the first of its ends
    assert work.most["nodes"] <= SLICE
    assert work.most["samples"] <= LONG_SLICE + 1
    # What comes of it goes into the queue without any of this work; nor does it begin with it.
    work.yield_hook()
    work.most.clear()
    assert mover.take(drafted)
    for _ in range(3):
        mover.tick()
        assert work.most.get("nodes", 0) <= SLICE
        work.yield_hook()
    assert "poses" not in work.most
    assert mover.keys == (1,)


@pytest.mark.slow
def test_a_blend_works_in_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    end = shifted(HOME, 0.0, -0.05, 0.0)
    mover = moving(lambda q: line_move(FIVE, q, end, 0.1, 1.0, 0.01))
    mover.tick()
    work = Counter(monkeypatch)
    with yielding(work.yield_hook):
        drafted = mover.draft(2, partial(woven, swings=50)).work()
    assert drafted.joined is not None
    assert work.most["poses"] <= 2 * SLICE
    assert work.most["nodes"] <= SLICE + 1
    work.yield_hook()
    work.most.clear()
    assert mover.take(drafted)
    assert work.most.get("nodes", 0) <= SLICE
    assert "poses" not in work.most
    assert mover.keys == (1, 2)


@pytest.mark.slow
def test_turns_change_nothing_of_a_plan() -> None:
    turns: list[None] = []
    plain = woven(HOME, swings=20)
    with yielding(lambda: turns.append(None)):
        cut = woven(HOME, swings=20)
    assert len(turns) > 10
    assert plain.limits == cut.limits
    assert plain.path is not None
    assert cut.path is not None
    places = np.linspace(0.0, 0.3, 700)
    np.testing.assert_array_equal(plain.path.sample(places), cut.path.sample(places))


def test_a_plan_is_dropped_at_a_turn() -> None:
    left = iter(range(5))

    def yield_hook() -> None:
        if next(left, None) is None:
            raise PlanDropped

    with pytest.raises(PlanDropped), yielding(yield_hook):
        moving().draft(1, woven).work()


def test_slices_are_whole_and_each_has_its_turn() -> None:
    turns: list[None] = []
    with yielding(lambda: turns.append(None)):
        parts = list(slices(150, 64))
    assert parts == [slice(0, 64), slice(64, 128), slice(128, 150)]
    assert len(turns) == 3
    assert list(slices(0)) == []
    list(slices(1))
    assert len(turns) == 3


def test_each_value_has_its_turn_and_a_dropped_plan_takes_no_further_one() -> None:
    left, seen = iter(range(2)), list[int]()

    def yield_hook() -> None:
        if next(left, None) is None:
            raise PlanDropped

    def doubled(value: int) -> int:
        seen.append(value)
        return 2 * value

    with pytest.raises(PlanDropped), yielding(yield_hook):
        in_turn(doubled, range(5))
    assert seen == [0, 1, 2]
    assert in_turn(doubled, range(3)) == [0, 2, 4]


def test_the_numbers_of_a_path_are_a_few_objects_however_long_it_is() -> None:
    """A list of a hundred thousand numbers is freed, and visited by the collector, at one go."""
    entry = moving().draft(1, partial(woven, swings=20)).work().alone
    assert entry.path is not None
    assert entry.limits is not None
    blocks = (entry.path.bounds, *entry.limits[:6], entry.back)
    assert {type(each) for each in blocks} == {array}
    assert min(map(len, blocks)) > 500


# -- laws ------------------------------------------------------------------------------------------


def long_limits(count: int = 5000) -> PathLimits:
    nodes = np.linspace(0.0, 1.0, count + 1)
    ceiling = (0.01 + 0.008 * np.sin(100.0 * nodes)).tolist()
    each = [1.0] * count
    waits = ((float(nodes[count // 2]), 0.25),)
    ceiling[count // 2] = 0.0
    return PathLimits(nodes.tolist(), ceiling, each, each, [0.0] * count, each, waits)


def counted_rates(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows by one for each acceleration that a law looks up from here on."""
    rates: list[int] = []
    rate = timing._rate

    def counted(*given: Any) -> Any:
        rates.append(1)
        return rate(*given)

    monkeypatch.setattr(timing, "_rate", counted)
    return rates


def test_a_law_is_laid_as_far_as_it_is_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    limits = long_limits()
    back = backward(limits, 0.0)
    whole = fastest(limits, back, 0.0, 0.0)
    duration = whole.duration
    rates = counted_rates(monkeypatch)
    law = fastest(limits, back, 0.0, 0.0)
    assert rates == []
    hint = place = 0
    for cycle in range(int(duration / CYCLE)):
        before = len(rates)
        hint, s, v, a = law.at(cycle * CYCLE, hint)
        assert len(rates) - before < 50
        place, *same = whole.at(cycle * CYCLE, place)
        assert same == [s, v, a]
        assert law.end == whole.end == 1.0
        assert not law.over(cycle * CYCLE)
    assert law.over(duration)
    assert (law.duration, law.end_speed) == (duration, whole.end_speed)


@pytest.mark.slow
def test_a_law_knows_early_that_it_does_not_end_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    mover = moving(partial(woven, swings=50))
    rates = counted_rates(monkeypatch)
    mover.tick()
    assert mover.travel is not None
    assert not mover.travel.ends_within(0.1)
    assert len(rates) < 500
    assert mover.travel.ends_within(mover.time_left)
    assert not mover.travel.ends_within(mover.time_left - 1e-6)


# -- drafts ----------------------------------------------------------------------------------------


def to(q: float, r: float = 0.0) -> Callable[[Array], Segment]:
    goal = HOME + np.array([q, 0.0, 0.0, 0.0, 0.0, 0.0])
    return lambda start: joint_move(FIVE, start, goal, 1.0, 4.0, r)


def ticked(mover: Mover, cycles: int = 100_000) -> list[tuple[int, str]]:
    events: list[tuple[int, str]] = []
    for _ in range(cycles):
        if not mover.moving:
            break
        events += [(event.key, event.kind) for event in mover.tick().events]
    return events


def test_a_motion_blends_that_is_planned_while_the_one_before_it_runs() -> None:
    mover = moving(to(0.5, 0.1))
    ticked(mover, 20)
    drafted = mover.draft(2, to(-0.5)).work()
    ticked(mover, 100)
    assert mover.take(drafted)
    assert ticked(mover)[-3:] == [(1, "blended"), (2, "started"), (2, "finished")]


def test_where_the_arm_has_come_too_far_to_blend_it_stops_in_between() -> None:
    mover = moving(to(0.5, 0.1))
    ticked(mover, 20)
    drafted = mover.draft(2, to(-0.5)).work()
    while mover.progress < 0.97:
        mover.tick()
    assert mover.take(drafted)
    assert ticked(mover)[-3:] == [(1, "finished"), (2, "started"), (2, "finished")]


def test_what_has_ended_meanwhile_is_no_longer_before_it() -> None:
    mover = moving(to(0.1, 0.1), to(0.2, 0.1))
    drafted = mover.draft(3, to(0.0)).work()
    ticked(mover)
    assert mover.take(drafted)
    assert ticked(mover) == [(3, "started"), (3, "finished")]
    np.testing.assert_allclose(mover.setpoint.q, HOME, atol=1e-12)


def test_one_of_two_has_ended_meanwhile() -> None:
    mover = moving(to(0.1), to(0.6, 0.1))
    drafted = mover.draft(3, to(0.0)).work()
    while mover.active == 1:
        mover.tick()
    assert mover.take(drafted)
    assert mover.keys == (2, 3)
    assert ticked(mover)[-3:] == [(2, "blended"), (3, "started"), (3, "finished")]


def test_what_it_was_drafted_from_has_to_hold() -> None:
    mover = moving()
    first = mover.draft(1, to(0.5)).work()
    mover.append(2, to(0.2))
    assert not mover.take(first)  # the queue ends elsewhere
    assert mover.keys == (2,)
    assert not Mover(FIVE, HOME + 0.1, CYCLE).take(first)  # the arm stands elsewhere
    assert moving().take(first)


def test_what_is_left_of_a_long_motion_is_freed_where_the_next_one_is_planned() -> None:
    mover = moving(to(0.5))
    mover.tick()
    mover.stop()
    ticked(mover)
    assert mover.keys == ()
    draft = mover.draft(2, to(0.1))
    assert draft.rest  # neither the cycle that ended it has freed it, nor the stop
    draft.work()
    assert draft.rest == []
    assert mover.draft(2, to(0.1)).rest == []
