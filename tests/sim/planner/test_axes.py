"""External axes that go along with motions: together from start to end, within their limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from aioduco.models.rotation import Array
from aioduco.sim.planner.segments import (
    ExternalAxesMove,
    Segment,
    arc_move,
    joint_move,
    line_move,
    stay,
)

from .motions import CYCLE, FIVE, HOME, moving, trapezoid

START = FIVE.fkine(HOME)
RAIL, TABLE = 0, 1


def ride(
    *ends: float, v: float = 0.5, a: float = 1.0, numbers: tuple[int, ...] = ()
) -> ExternalAxesMove:
    """A move of axes, from zero if nothing has moved them."""
    count = len(ends)
    limits = np.full(count, v), np.full(count, a), np.full(count, 2.0 * a)
    return ExternalAxesMove(
        numbers or tuple(range(count)), np.zeros(count), np.array(ends), *limits
    )


def line(
    axes: ExternalAxesMove | None,
    x: float = 0.0,
    y: float = 0.2,
    *,
    v: float = 0.25,
    r: float = 0.0,
) -> Callable[[Array], Segment]:
    target = START.copy()
    target[:3, 3] += (x, y, 0.0)
    return lambda q: replace(line_move(FIVE, q, target, v, 1.0, r), axes=axes)


class Run:
    """Motions to their end, with something done on the way."""

    def __init__(self, *plans: Callable[[Array], Segment], **what: int) -> None:
        self.mover = moving(*plans)
        self.q: list[Array] = []
        self.axes: list[dict[int, float]] = []
        self.events: list[tuple[int, str]] = []
        calls = {cycle: name for name, cycle in what.items()}
        last = max(calls, default=0)
        while self.mover.moving or len(self.q) <= last:
            if len(self.q) in calls:
                name = calls[len(self.q)]
                if name == "slow":
                    self.mover.set_speed(0.3)
                else:
                    getattr(self.mover, name)()
            tick = self.mover.tick()
            self.q.append(tick.setpoint.q)
            self.axes.append(dict(self.mover.axes))
            self.events += [(event.key, event.kind) for event in tick.events]

    @property
    def time(self) -> float:
        return len(self.q) * CYCLE

    def of(self, number: int) -> Array:
        return np.array([at.get(number, 0.0) for at in self.axes])

    def way(self) -> Array:
        """How far along y the flange has come [m]."""
        found: Array = FIVE.fkine(np.array(self.q))[:, 1, 3] - START[1, 3]
        return found


def test_axes_alone_take_the_time_of_a_trapezoid_and_the_arm_stays() -> None:
    run = Run(lambda q: replace(stay(FIVE, q), axes=ride(1.5)))
    assert run.time == pytest.approx(trapezoid(1.5, 0.5, 1.0), abs=2 * CYCLE)
    assert run.of(RAIL)[-1] == 1.5
    assert (np.array(run.q) == HOME).all()
    assert run.events == [(1, "started"), (1, "finished")]
    speeds = np.diff(run.of(RAIL)) / CYCLE
    assert speeds.max() == pytest.approx(0.5, rel=1e-6)
    assert np.abs(np.diff(speeds)).max() / CYCLE < 1.0 + 1e-3


@pytest.mark.parametrize("end", [0.05, 1.5])
def test_arm_and_axes_start_and_end_together(end: float) -> None:
    # 0.2 m at 0.25 m/s and 1 m/s² are slower than 0.05 and faster than 1.5 of the axis.
    run = Run(line(ride(end)))
    longest = max(trapezoid(0.2, 0.25, 1.0), trapezoid(end, 0.5, 1.0))
    assert run.time == pytest.approx(longest, rel=2e-3)
    np.testing.assert_allclose(run.of(RAIL) / end, run.way() / 0.2, atol=1e-5)
    assert run.of(RAIL)[-1] == end
    assert np.diff(run.of(RAIL)).max() / CYCLE < 0.5 * (1 + 1e-6)


def test_on_an_arc_and_with_joints_too() -> None:
    via, end = START.copy(), START.copy()
    via[:3, 3] += (0.05, 0.05, 0.0)
    end[:3, 3] += (0.0, 0.1, 0.0)
    moves = [
        lambda q: replace(arc_move(FIVE, q, via, end, 0.2, 1.0, mode=1), axes=ride(0.3)),
        lambda q: replace(joint_move(FIVE, q, HOME, 0.8, 2.0), axes=ride(0.0)),
    ]
    run = Run(*moves)
    finished = [kind for _, kind in run.events].count("finished")
    assert finished == 2
    assert run.of(RAIL).max() == pytest.approx(0.3)
    assert run.of(RAIL)[-1] == 0.0
    turned = np.abs(np.array(run.q) - HOME).max(axis=1)
    back = slice(int(np.argmax(run.of(RAIL))), None)
    share = turned[back] / turned[back][0]
    np.testing.assert_allclose(run.of(RAIL)[back] / 0.3, share, atol=1e-6)


def test_the_slowest_of_several_axes_counts() -> None:
    run = Run(lambda q: replace(stay(FIVE, q), axes=ride(0.2, -1.0)))
    assert run.time == pytest.approx(trapezoid(1.0, 0.5, 1.0), abs=2 * CYCLE)
    np.testing.assert_allclose(run.of(RAIL), -0.2 * run.of(TABLE), atol=1e-12)


@pytest.mark.parametrize("end", [0.05, 1.5])
def test_pauses_and_speeds_keep_them_together(end: float) -> None:
    run = Run(line(ride(end)), slow=150, pause=400, resume=700)
    np.testing.assert_allclose(run.of(RAIL) / end, run.way() / 0.2, atol=1e-5)
    assert np.ptp(run.of(RAIL)[640:700]) == 0.0
    assert run.of(RAIL)[-1] == end


def test_a_stop_stops_both() -> None:
    run = Run(line(ride(1.5)), stop=500)
    assert run.events[-1] == (1, "stopped")
    share = run.of(RAIL)[-1] / 1.5
    assert 0.0 < share < 0.5
    assert run.way()[-1] / 0.2 == pytest.approx(share, abs=1e-5)
    speeds = np.diff(run.of(RAIL)) / CYCLE
    assert np.abs(np.diff(speeds)).max() / CYCLE < 2.0 + 1e-3  # what the axis's drive can do


def test_an_axis_goes_on_from_where_the_queue_leaves_it() -> None:
    run = Run(line(ride(0.2)), line(ride(0.1), 0.0, 0.0), line(None, 0.1, 0.0), line(ride(0.3)))
    steps = np.abs(np.diff(run.of(RAIL)))
    assert steps.max() < 0.5 * CYCLE * (1 + 1e-6)
    assert run.of(RAIL)[-1] == 0.3
    assert [kind for _, kind in run.events].count("finished") == 4


def test_motions_with_the_same_axes_blend() -> None:
    run = Run(line(ride(0.3), 0.0, 0.15, r=0.03), line(ride(0.1), 0.15, 0.15))
    assert (1, "blended") in run.events
    speeds = np.diff(run.of(RAIL)) / CYCLE
    assert np.abs(speeds).max() < 0.5 * 1.02
    assert np.abs(np.diff(speeds)).max() / CYCLE < 1.02
    assert 0.25 < run.of(RAIL).max() < 0.3  # the corner is cut
    assert run.of(RAIL)[-1] == 0.1


@pytest.mark.parametrize("other", [None, ride(0.2, numbers=(TABLE,))])
def test_motions_with_other_axes_do_not(other: ExternalAxesMove | None) -> None:
    run = Run(line(ride(0.3), 0.0, 0.15, r=0.03), line(other, 0.15, 0.15))
    assert (1, "finished") in run.events
    assert run.of(RAIL)[-1] == 0.3


def test_axes_that_are_there_already_change_nothing() -> None:
    assert Run(line(ride(0.0))).time == Run(line(None)).time
    there = Run(lambda q: replace(stay(FIVE, q), axes=ride(0.0)))
    assert there.events == [(1, "started"), (1, "finished")]
    assert there.axes[-1] == {RAIL: 0.0}
