"""Weaves over paths against the closed forms of their shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from aioduco.models.rotation import Array, matrix_from_rotvec
from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import Segment, arc_move, joint_move, line_move
from aioduco.sim.planner.weaving import Weave

from .motions import CYCLE, FIVE, HOME, moving, ticks_of

START = FIVE.fkine(HOME)
WAY = np.array([0.08, 0.12, 0.06])  # across every plane
LENGTH = float(np.linalg.norm(WAY))
BENCH = matrix_from_rotvec(np.array([[0.2, -0.3, 0.4]]))[0]
PLAIN = Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 2.0, 0.003)
HALF_MILLIMETRE = 0.5e-3


def zigzag(x: Array) -> Array:
    found: Array = 2.0 / np.pi * np.arcsin(np.sin(2 * np.pi * x))
    return found


def sine(x: Array) -> Array:
    found: Array = np.sin(2 * np.pi * x)
    return found


#: to the left, and forward, in amplitudes, over the swing
FORMULAS: dict[WeaveShape, tuple[Callable[[Array], Array], Callable[[Array], Array]]] = {
    WeaveShape.TRIANGLE: (zigzag, np.zeros_like),
    WeaveShape.SINE: (sine, np.zeros_like),
    WeaveShape.CIRCLE: (sine, lambda x: 1 - np.cos(2 * np.pi * x)),
    WeaveShape.TRAPEZOID: (lambda x: np.clip(2 * zigzag(x), -1, 1), np.zeros_like),
    WeaveShape.FIGURE_EIGHT: (sine, lambda x: np.sin(4 * np.pi * x) / 2),
}


def woven(weave: Weave | None, v: float = 0.05, a: float = 1.0) -> Segment:
    target = START.copy()
    target[:3, 3] += WAY
    return line_move(FIVE, HOME, target, v, a, weave=weave)


def axes_of(weave: Weave, forward: Array) -> tuple[Array, Array, Array]:
    """Left, ahead in the plane, and normal of a weave; the orientation of the tool is kept."""
    frame = BENCH if weave.plane >= 3 else START[:3, :3]
    normal = frame[:, (2, 1, 0)[weave.plane % 3]]
    left = np.cross(normal, forward)
    left /= np.linalg.norm(left)
    return left, np.cross(left, normal), normal


def off_the_line(points: Array, s: Array, weave: Weave) -> tuple[Array, Array, Array]:
    away = points - (START[:3, 3] + s[:, None] * WAY / LENGTH)
    left, ahead, normal = axes_of(weave, WAY / LENGTH)
    return away @ left, away @ ahead, away @ normal


@pytest.mark.parametrize(
    ("plane", "amplitude"),
    [*((plane, 0.003) for plane in WeavePlane), (WeavePlane.WORK_OBJECT_XZ, 0.02)],
)
@pytest.mark.parametrize("shape", WeaveShape)
def test_each_shape_in_each_plane_is_its_formula(
    shape: WeaveShape, plane: WeavePlane, amplitude: float
) -> None:
    weave = Weave(shape, plane, 2.0, amplitude, work_object=BENCH)
    segment = woven(weave)
    s = np.linspace(0.0, segment.length, 3001)
    points = segment.tcp(s)[:, :3, 3]
    left, ahead, out = off_the_line(points, s, weave)
    swings = round(LENGTH / 0.05 * 2.0)
    to_left, forward = (of(s / LENGTH * swings) for of in FORMULAS[shape])
    assert np.abs(left - amplitude * to_left).max() < HALF_MILLIMETRE
    assert np.abs(ahead - amplitude * forward).max() < HALF_MILLIMETRE
    assert np.abs(out).max() < 1e-5
    assert np.abs(left).max() == pytest.approx(amplitude, abs=HALF_MILLIMETRE)
    np.testing.assert_allclose(points[0], START[:3, 3], atol=1e-6)
    np.testing.assert_allclose(points[-1], START[:3, 3] + WAY, atol=1e-6)


def test_on_an_arc_it_swings_to_the_side_of_the_arc() -> None:
    centre, radius = START[:3, 3] - [0.06, 0.0, 0.0], 0.06
    via, end = START.copy(), START.copy()
    via[:3, 3] = centre + np.array([0.0, radius, 0.0])
    end[:3, 3] = centre - [radius, 0.0, 0.0]
    weave = Weave(WeaveShape.SINE, WeavePlane.WORK_OBJECT_XY, 3.0, 0.005)
    segment = arc_move(FIVE, HOME, via, end, 0.05, 1.0, mode=1, weave=weave)
    s = np.linspace(0.0, segment.length, 2001)
    spoke = segment.tcp(s)[:, :3, 3] - centre
    swings = round(np.pi * radius / 0.05 * 3.0)
    # Left of a way round to the left is inwards.
    wide = radius - 0.005 * np.sin(2 * np.pi * swings * s / segment.length)
    assert np.abs(np.linalg.norm(spoke, axis=1) - wide).max() < 1e-5
    assert np.abs(spoke[:, 2]).max() < 1e-5


@pytest.mark.slow
def test_the_frequency_is_that_asked_for_but_for_whole_swings() -> None:
    plain = woven(None).duration
    for frequency in (0.9, 2.0, 3.3):
        segment = woven(Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, frequency, 0.003))
        assert segment.duration == pytest.approx(plain, rel=1e-3)
        s = np.linspace(0.0, segment.length, 20001)
        left, _, _ = off_the_line(segment.tcp(s)[:, :3, 3], s, PLAIN)
        sides = np.sign(left[np.abs(left) > 1e-4])
        crossings = np.count_nonzero(np.diff(sides))
        assert (crossings + 1) / 2 == round(LENGTH / 0.05 * frequency)


@pytest.mark.slow
def test_dwells_beside_the_path_while_it_goes_on() -> None:
    weave = Weave(WeaveShape.TRIANGLE, WeavePlane.TOOL_XY, 2.0, 0.003, 0.2, 0.3)
    segment = woven(weave, v=0.02)
    s = np.linspace(0.0, segment.length, 40001)
    left, _, _ = off_the_line(segment.tcp(s)[:, :3, 3], s, weave)
    share = LENGTH / round(LENGTH / 0.02) / 0.02  # of a swing, as it is, in one as asked for: 1 s
    assert np.mean(left > 0.0029) * share == pytest.approx(0.2, abs=0.05)
    assert np.mean(left < -0.0029) * share == pytest.approx(0.3, abs=0.05)


def test_where_the_path_waits_the_arm_stands_at_the_sides() -> None:
    weave = Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 1.0, 0.003, 0.1, 0.2, stands=True)
    segment = woven(weave)
    swings = round(LENGTH / 0.05)
    stood: dict[int, list[Array]] = {}
    for tick in ticks_of(moving(lambda _q: segment))[:-1]:
        point = tick.setpoint
        if not point.qd.any():
            way = float((FIVE.fkine(point.q)[:3, 3] - START[:3, 3]) @ WAY) / LENGTH
            stood.setdefault(round(way / LENGTH * swings * 4), []).append(point.q)
    sides = {4 * number + side for number in range(swings) for side in (1, 3)}
    assert set(stood) - {0} == sides
    for place in sides:
        assert np.ptp(stood[place], axis=0).max() < 1e-12
        wait = 0.1 if place % 4 == 1 else 0.2
        assert len(stood[place]) * CYCLE == pytest.approx(wait, abs=0.003)


def test_a_pause_does_not_shorten_a_dwell() -> None:
    weave = Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 1.0, 0.003, 0.2, 0.0, stands=True)

    def stood(pause: bool) -> int:
        mover = moving(lambda _q: woven(weave))
        still = 0
        while mover.moving or mover.paused:
            still += not mover.tick().setpoint.qd.any()
            if still == 50 and pause:
                mover.pause()
            elif still == 90 and pause:
                mover.resume()
        return still

    assert stood(pause=True) == stood(pause=False) + 40


@pytest.mark.parametrize("before", [1, 10, 30])
def test_a_change_of_speed_just_before_a_dwell_does_not_skip_it(before: int) -> None:
    weave = Weave(WeaveShape.TRAPEZOID, WeavePlane.TOOL_XY, 1.0, 0.003, 0.2, 0.0, stands=True)
    segment = woven(weave)
    turning = [tick.setpoint.qd.any() for tick in ticks_of(moving(lambda _q: segment))]
    dwell = turning.index(np.False_, 1)
    mover = moving(lambda _q: segment)
    for _ in range(dwell - before):
        mover.tick()
    mover.set_speed(0.5)
    still = [not mover.tick().setpoint.qd.any() for _ in range(500)]
    assert sum(still) * CYCLE == pytest.approx(0.4, abs=0.005)


def test_a_slower_speed_near_the_end_comes_to_rest_within_the_drives_acceleration() -> None:
    weave = Weave(WeaveShape.FIGURE_EIGHT, WeavePlane.TOOL_XY, 5.0, 0.01, 0.0, 0.2)
    aside = START.copy()
    aside[1, 3] += 0.01
    segment = line_move(FIVE, HOME, aside, 0.02, 1.0, weave=weave)
    mover = moving(lambda _q: segment)
    for _ in range(len(ticks_of(moving(lambda _q: segment))) - 20):
        mover.tick()
    mover.set_speed(0.1)
    speeds = np.array([tick.setpoint.qd for tick in ticks_of(mover)])
    assert np.abs(np.diff(speeds, axis=0)).max() / CYCLE < max(FIVE.acceleration)


@pytest.mark.slow
def test_pauses_and_speeds_leave_the_way_as_it_is() -> None:
    weave = Weave(WeaveShape.FIGURE_EIGHT, WeavePlane.TOOL_XY, 2.0, 0.004, 0.1, 0.1, stands=True)
    segment = woven(weave)
    s = np.linspace(0.0, segment.length, 6001)
    way = segment.tcp(s)[:, :3, 3]
    mover = moving(lambda _q: segment)
    what = {300: lambda: mover.set_speed(0.3), 700: mover.pause, 1100: mover.resume}
    what |= {1800: lambda: mover.set_speed(1.0), 2301: mover.pause, 2302: mover.resume}
    seen, events = [], []
    for cycle in range(60_000):
        if not mover.moving and cycle > 1200:
            break
        what.get(cycle, lambda: None)()
        tick = mover.tick()
        events += [event.kind for event in tick.events]
        seen.append(tick.setpoint)
    points = FIVE.fkine(np.array([point.q for point in seen[::11]]))[:, :3, 3]
    distance = np.linalg.norm(points[:, None] - way[None], axis=2).min(axis=1)
    assert distance.max() < 5e-5
    assert events == ["started", "finished"]
    speeds = np.array([point.qd for point in seen])
    assert not speeds[1000].any()  # it stood in the pause
    assert np.abs(np.diff(speeds, axis=0)).max() / CYCLE < max(FIVE.acceleration)


def test_a_stop_stands_on_the_way() -> None:
    mover = moving(lambda _q: woven(PLAIN))
    for _ in range(700):
        mover.tick()
    mover.stop()
    events = [[event.kind for event in tick.events] for tick in ticks_of(mover)]
    assert len(events) < 50
    assert events[-1] == ["stopped"]


@pytest.mark.slow
def test_joints_keep_to_what_they_can_and_the_path_slows_down() -> None:
    wild = Weave(WeaveShape.TRIANGLE, WeavePlane.TOOL_XY, 12.0, 0.03)
    segment = woven(wild)
    assert segment.duration > 1.5 * woven(None).duration
    points = [tick.setpoint for tick in ticks_of(moving(lambda _q: segment))]
    q, qd, qdd = zip(*((point.q, point.qd, point.qdd) for point in points), strict=True)
    assert (np.abs(qd) < 1.02 * np.array(FIVE.velocity)).all()
    assert (np.abs(qdd) < 1.02 * np.array(FIVE.acceleration)).all()
    np.testing.assert_allclose(FIVE.fkine(q[-1])[:3, 3], START[:3, 3] + WAY, atol=1e-6)


@pytest.mark.slow
def test_speed_along_the_path_is_that_asked_for() -> None:
    q = np.array([tick.setpoint.q for tick in ticks_of(moving(lambda _q: woven(PLAIN)))])
    way = (FIVE.fkine(q)[:, :3, 3] - START[:3, 3]) @ WAY / LENGTH
    speeds = np.diff(way[200:-200]) / CYCLE
    assert np.mean(speeds) == pytest.approx(0.05, rel=0.02)


def test_motions_with_a_weave_blend() -> None:
    def leg(x: float, y: float, r: float) -> Callable[[Array], Segment]:
        target = START.copy()
        target[:3, 3] += (x, y, 0.0)
        return lambda q: line_move(FIVE, q, target, 0.05, 1.0, r, weave=PLAIN)

    ticks = ticks_of(moving(leg(0.08, 0.0, 0.02), leg(0.08, 0.08, 0.0)))
    events = [(event.key, event.kind) for tick in ticks for event in tick.events]
    speeds = [tick.setpoint.qd for tick in ticks]
    assert events == [(1, "started"), (1, "blended"), (2, "started"), (2, "finished")]
    assert np.abs(np.diff(speeds, axis=0)).max() / CYCLE < max(FIVE.acceleration)
    assert (np.abs(speeds).max(axis=1)[5:-5] > 0.0).all()


@pytest.mark.slow
def test_what_waits_is_bounded() -> None:
    mover = moving()
    long = woven(Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 200.0, 0.0005))
    back = replace(long, q_start=long.q_end, q_end=long.q_start)

    def append() -> None:
        for key in range(60):
            mover.append(key, lambda _q: back if key % 2 else long)  # noqa: B023 - called at once

    with pytest.raises(PlanError, match="too long") as caught:
        append()
    assert caught.value.code == "limits"
    assert 10 < len(mover.keys) < 60


def test_nothing_is_laid_over_what_is_too_short_or_leads_nowhere() -> None:
    slow = Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 0.1, 0.003)
    turned = START.copy()
    turned[:3, :3] = turned[:3, :3] @ matrix_from_rotvec(np.array([[0.0, 0.0, 0.5]]))[0]
    still = Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 2.0, 0.0)
    for segment in (
        woven(slow),
        woven(still),
        line_move(FIVE, HOME, turned, 0.1, 1.0, weave=PLAIN),
        joint_move(FIVE, HOME, HOME + 0.1, 1.0, 1.0),
    ):
        plain = woven(None) if segment.length == pytest.approx(LENGTH) else segment
        s = np.linspace(0.0, segment.length, 50)
        np.testing.assert_allclose(segment.tcp(s), plain.tcp(s), atol=1e-9)


@pytest.mark.slow
def test_what_cannot_be_laid_over_a_path_is_refused() -> None:
    down = START.copy()
    down[2, 3] -= 0.1
    with pytest.raises(PlanError, match="square to the plane") as caught:
        line_move(FIVE, HOME, down, 0.05, 1.0, weave=PLAIN)
    assert caught.value.code == "parameter"
    for frequency in (1e5, 1e300):
        endless = Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, frequency, 0.003)
        with pytest.raises(PlanError, match="too many"):
            woven(endless)
    with pytest.raises(PlanError, match="cannot follow the weave"):
        woven(Weave(WeaveShape.SINE, WeavePlane.TOOL_XY, 350.0, 0.03))
