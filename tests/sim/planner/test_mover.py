"""The mover: set-points of each cycle, through pauses, stops, speeds and blends."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from kinematics.bias import bias_acceleration
from quick import examples

from aioduco.kinematics import Arm, arm, models
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array
from aioduco.sim.planner.motion_limits import STOPPING
from aioduco.sim.planner.mover import Mover, Travel
from aioduco.sim.planner.path import JointSetPoint, PlanError
from aioduco.sim.planner.segments import Segment, arc_move, joint_move, line_move

from .motions import CYCLE, FIVE, HOME, moving, shifted

SQUARE = ((0.1, 0.0, 0.0), (0.1, 0.2, 0.0), (-0.1, 0.2, 0.0), (-0.1, 0.2, -0.2))


#: the flange at home, moved in the base frame
at = partial(shifted, HOME)


def turned(*way: float) -> Array:
    """The joints at home, the first of them turned."""
    goal: Array = HOME + np.array([*way, *[0.0] * (6 - len(way))])
    return goal


def joints(
    *way: float, v: float = 1.0, a: float = 2.0, r: float = 0.0
) -> Callable[[Array], Segment]:
    """A plan for a joint move to home plus some angles."""
    return lambda q: joint_move(FIVE, q, turned(*way), v, a, r)


def line(
    x: float, y: float, z: float = 0.0, *, v: float = 0.25, a: float = 1.0, r: float = 0.0
) -> Callable[[Array], Segment]:
    """A plan for a line to home, moved in the base frame."""
    return lambda q: line_move(FIVE, q, at(x, y, z), v, a, r)


@dataclass
class Recorder:
    """Ticks a mover and keeps what it did."""

    mover: Mover = field(default_factory=moving)
    arm: Arm = FIVE
    setpoints: list[JointSetPoint] = field(default_factory=list)
    events: list[tuple[int, int, str]] = field(default_factory=list)

    def tick(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            tick = self.mover.tick()
            self.setpoints.append(tick.setpoint)
            self.events += [(len(self.setpoints), key, kind) for key, kind in tick.events]

    def until_rest(self, cycles: int = 100_000) -> Recorder:
        while self.mover.moving:
            assert len(self.setpoints) < cycles, "the mover does not come to rest"
            self.tick()
        return self

    def until(self, key: int, kind: str, cycles: int = 100_000) -> None:
        while (key, kind) not in [event[1:] for event in self.events[-4:]]:
            assert len(self.setpoints) < cycles, f"no {kind} of {key}"
            self.tick()

    @property
    def kinds(self) -> list[tuple[int, str]]:
        return [event[1:] for event in self.events]

    @property
    def q(self) -> Array:
        return np.array([setpoint.q for setpoint in self.setpoints])

    @property
    def qd(self) -> Array:
        return np.array([setpoint.qd for setpoint in self.setpoints])

    @property
    def qdd(self) -> Array:
        return np.array([setpoint.qdd for setpoint in self.setpoints])

    def tool_speed(self) -> Array:
        """Speed of the flange [m/s]. Shape (n,)."""
        velocity = (self.arm.jacobian(self.q) @ self.qd[..., None])[:, :3, 0]
        return np.linalg.norm(velocity, axis=1)  # type: ignore[no-any-return]  # numpy's stubs

    def tool_acceleration(self) -> Array:
        """Acceleration of the flange [m/s²]. Shape (n,)."""
        turned = (self.arm.jacobian(self.q) @ self.qdd[..., None])[:, :3, 0]
        bias = bias_acceleration(self.arm.geometry, self.q, self.qd)[:, :3]
        return np.linalg.norm(turned + bias, axis=1)  # type: ignore[no-any-return]  # as above

    def hangs_together(self, least: float = 0.1) -> None:
        """Speeds are those of the positions, and no acceleration is hidden between cycles.

        Args:
            least: acceleration that may be hidden, since a stop can end within a cycle [rad/s²].
        """
        q = np.vstack([HOME, self.q])
        qd = np.vstack([np.zeros(6), self.qd])
        most = max(np.abs(self.qdd).max(), least)
        mean = 0.5 * (qd[1:] + qd[:-1])
        np.testing.assert_allclose(np.diff(q, axis=0) / CYCLE, mean, atol=1.1 * most * CYCLE)
        assert np.abs(np.diff(qd, axis=0)).max() <= 1.02 * most * CYCLE + 1e-9


def followed(*plans: Callable[[Array], Segment]) -> Recorder:
    """Motions of the numbers 1, 2 and so on to their end; what was sent hangs together."""
    run = Recorder(moving(*plans)).until_rest()
    run.hangs_together()
    return run


def off_line(points: Array, start: Array, end: Array) -> float:
    """Largest distance of points from the line between two points [m]."""
    direction = (end - start) / np.linalg.norm(end - start)
    away = points - start
    return float(np.linalg.norm(away - np.outer(away @ direction, direction), axis=1).max())


def test_a_joint_move_from_rest_to_rest() -> None:
    run = Recorder(moving(joints(1.0, 0.5, -0.3)))
    assert run.mover.moving
    assert (run.mover.active, run.mover.progress) == (1, 0.0)
    run.until_rest()
    run.hangs_together()
    # 1 rad at 1 rad/s and 2 rad/s² takes 1.5 s.
    assert run.events == [(1, 1, "started"), (1501, 1, "finished")]
    np.testing.assert_array_equal(run.q[-1], turned(1.0, 0.5, -0.3))
    np.testing.assert_array_equal(run.qd[-1], np.zeros(6))
    assert np.abs(run.qd).max() == pytest.approx(1.0)
    assert np.abs(run.qdd).max() == pytest.approx(2.0)
    assert (run.mover.active, run.mover.progress) == (None, 1.0)
    ratios = (run.q[1:-1] - HOME)[:, 1] / (run.q[1:-1] - HOME)[:, 0]
    np.testing.assert_allclose(ratios, 0.5, atol=1e-6)


def test_motions_follow_each_other_from_rest_to_rest() -> None:
    plans = joints(0.3), line(0.0, 0.1), joints(0.0)
    assert moving(*plans).keys == (1, 2, 3)
    run = followed(*plans)
    assert run.kinds == [(key, kind) for key in (1, 2, 3) for kind in ("started", "finished")]
    ends = [cycle for cycle, _, kind in run.events if kind == "finished"]
    for end in ends:
        np.testing.assert_array_equal(run.qd[end - 1], np.zeros(6))
    np.testing.assert_array_equal(run.q[-1], HOME)


def test_a_motion_to_where_the_arm_is_ends_at_once() -> None:
    run = followed(joints(0.0), joints(0.1))
    assert run.events[:3] == [(1, 1, "started"), (1, 1, "finished"), (2, 2, "started")]


def test_a_motion_that_cannot_be_planned_leaves_the_queue_as_it_was() -> None:
    run = Recorder(moving(joints(0.3)))
    with pytest.raises(PlanError):
        run.mover.append(2, line(2.0, 0.0))
    with pytest.raises(PlanError, match="does not begin where"):
        run.mover.append(3, lambda _q: joint_move(FIVE, HOME, HOME + 0.1, 1.0, 1.0))
    assert run.mover.keys == (1,)
    run.until_rest()
    assert run.kinds == [(1, "started"), (1, "finished")]


@pytest.mark.slow
@pytest.mark.parametrize("when", [1, 100, 400, 750, 1200, 1450, 1499])
@pytest.mark.parametrize("plan", [joints(1.0, 0.5), line(0.02, 0.29, v=0.2, a=2.0)])
def test_pause_and_resume_keep_to_the_path_and_the_limits(
    when: int, plan: Callable[[Array], Segment]
) -> None:
    alone = followed(plan)
    if when >= len(alone.setpoints):
        return
    run = Recorder(moving(plan))
    run.tick(when)
    run.mover.pause()
    assert run.mover.paused
    run.until_rest()
    stood = run.setpoints[-1]
    run.tick(50)
    for setpoint in run.setpoints[-50:]:
        np.testing.assert_array_equal(setpoint.q, stood.q)
        np.testing.assert_array_equal(setpoint.qd, np.zeros(6))
        np.testing.assert_array_equal(setpoint.qdd, np.zeros(6))
    run.mover.resume()
    run.until_rest()
    run.hangs_together()
    assert run.kinds == [(1, "started"), (1, "finished")]
    np.testing.assert_array_equal(run.q[-1], alone.q[-1])
    assert np.abs(run.qd).max() <= 1.01 * np.abs(alone.qd).max()
    if plan(HOME).curve is None:
        assert np.abs(run.qdd).max() <= 2.0 * 1.001
    else:
        assert run.tool_acceleration().max() <= 2.0 * 1.02
    # Each place of the pause is on the path.
    nearest = np.abs(run.q[::7, None, 1] - alone.q[None, :, 1]).min(axis=1)
    assert nearest.max() < 2e-3


def test_a_pause_before_the_first_cycle_holds_the_motion_back() -> None:
    run = Recorder(moving(joints(0.3)))
    run.mover.pause()
    assert not run.mover.moving
    run.tick(20)
    assert run.events == []
    run.mover.resume()
    run.until_rest()
    assert run.events[0] == (21, 1, "started")


@pytest.mark.parametrize("when", [1, 300, 750, 1200, 1390])
@pytest.mark.parametrize("plan", [joints(1.0, 0.5), line(0.02, 0.29, v=0.25, a=1.0)])
def test_a_stop_stands_soon_and_drops_the_queue(
    when: int, plan: Callable[[Array], Segment]
) -> None:
    run = Recorder(moving(plan, joints(0.0)))
    run.tick(when)
    speed = np.abs(run.qd[-1]).max()
    run.mover.stop()
    before = len(run.setpoints)
    with pytest.raises(PlanError, match="stopping"):
        run.mover.append(3, joints(0.5))
    run.until_rest()
    run.tick()
    run.hangs_together(STOPPING * max(FIVE.acceleration))
    assert run.kinds == [(1, "started"), (1, "stopped"), (2, "stopped")]
    assert run.mover.keys == ()
    # No slower than the motion's own way to slow down, and faster where the drives can.
    least = speed / max(FIVE.acceleration)
    assert least <= (len(run.setpoints) - before) * CYCLE <= 0.5 * (1.0 / 2.0) + 0.01
    assert np.abs(run.qdd).max() <= STOPPING * max(FIVE.acceleration) * 1.01
    stood = run.mover.setpoint.q
    run.mover.append(4, joints(0.1))
    np.testing.assert_array_equal(run.mover.setpoint.q, stood)
    run.until_rest()
    assert run.kinds[-2:] == [(4, "started"), (4, "finished")]


def test_a_stop_at_rest_is_told_with_the_next_cycle() -> None:
    run = Recorder(moving(joints(1.0)))
    run.tick(300)
    run.mover.pause()
    run.until_rest()
    run.mover.stop()
    assert not run.mover.moving
    run.tick()
    assert run.kinds == [(1, "started"), (1, "stopped")]
    assert not run.mover.paused
    run.mover.stop()
    run.tick()
    assert len(run.events) == 2


def test_half_the_speed_takes_twice_the_time() -> None:
    full, half = Recorder(), Recorder()
    half.mover.set_speed(0.5)
    for run in (full, half):
        run.mover.append(1, line(0.0, 0.25))
        run.until_rest()
        run.hangs_together()
    assert len(half.setpoints) == pytest.approx(2 * len(full.setpoints), abs=2)
    np.testing.assert_allclose(half.q[1::2][:500], full.q[:500], atol=1e-9)
    assert half.tool_speed().max() == pytest.approx(0.125, rel=1e-3)


@pytest.mark.parametrize("speed", [1.0, 0.4])
def test_motions_to_a_stand_may_settle_there(speed: float) -> None:
    plans = line(0.1, 0.0, r=0.05), line(0.1, 0.2), joints(0.0)
    plain, slow = Recorder(moving(*plans)), Recorder(moving(*plans, settling=lambda: 0.3))
    for run in (plain, slow):
        run.mover.set_speed(speed)
        run.until_rest()
        run.hangs_together()
    assert slow.kinds == plain.kinds
    assert plain.kinds[:2] == [(1, "started"), (1, "blended")]
    # Twice 0.3 s: the motion that blends has no end of its own.
    assert len(slow.setpoints) - len(plain.setpoints) == pytest.approx(600, abs=4)


def test_a_pause_and_a_stop_while_it_settles() -> None:
    run = Recorder(moving(joints(0.1), settling=lambda: 0.3))
    run.until(1, "started")
    run.tick(2000)
    assert run.kinds == [(1, "started"), (1, "finished")]
    run.mover.append(2, joints(0.2))
    while run.mover.progress < 1.0:
        run.tick()
    run.mover.pause()
    run.tick(500)
    assert not run.mover.moving
    run.mover.resume()
    run.tick(10)
    assert run.mover.keys == (2,)
    run.mover.stop()
    run.tick()
    assert run.kinds[2:] == [(2, "started"), (2, "stopped")]
    np.testing.assert_allclose(run.mover.setpoint.q, turned(0.2), atol=1e-9)


def test_speeds_that_change_on_the_way_keep_to_the_limits() -> None:
    run = Recorder(moving(line(0.0, 0.3, v=0.2, a=0.5)))
    for fraction in (0.3, 1.0, 0.01, 0.6, 1.0):
        run.tick(250)
        run.mover.set_speed(fraction)
    run.until_rest()
    run.hangs_together()
    assert run.tool_speed().max() <= 0.2 * 1.001
    assert run.tool_acceleration().max() <= 0.5 * 1.001
    assert run.kinds == [(1, "started"), (1, "finished")]
    for fraction in (0.0, 0.009, 1.1):
        with pytest.raises(ValueError, match=r"not 0\.01 to 1"):
            run.mover.set_speed(fraction)


def corner_run(radius: float, **limits: float) -> Recorder:
    run = Recorder()
    for key, (x, y, z) in enumerate(SQUARE):
        run.mover.append(key, line(x, y, z, r=radius if key < 3 else 0.0, **limits))
    return run.until_rest()


def test_lines_blend_within_the_radius_of_their_corners() -> None:
    run, stopping = corner_run(0.04, v=0.5, a=2.0), corner_run(0.0, v=0.5, a=2.0)
    run.hangs_together()
    assert run.kinds == [
        *[(0, "started")],
        *[pair for key in range(3) for pair in ((key, "blended"), (key + 1, "started"))],
        *[(3, "finished")],
    ]
    assert len(run.setpoints) < 0.9 * len(stopping.setpoints)
    points = FIVE.fkine(run.q)[:, :3, 3]
    for x, y, z in SQUARE[:3]:
        away = np.linalg.norm(points - at(x, y, z)[:3, 3], axis=1)
        # A parabola between points 0.04 m from a right angle passes it at 0.04/√8 m.
        assert away.min() == pytest.approx(0.04 / math.sqrt(8), rel=0.01)
        assert run.tool_speed()[away < 0.04].min() > 0.1
    # Outside of the blends the lines are kept.
    corners = [at()[:3, 3], *[at(*corner)[:3, 3] for corner in SQUARE]]
    away = np.array([np.linalg.norm(points - corner, axis=1) for corner in corners[1:4]])
    outside = points[(away > 0.0401).all(axis=0)]
    distances = np.array(
        [
            [off_line(point[None], start, end) for start, end in pairwise(corners)]
            for point in outside[::20]
        ]
    )
    assert distances.min(axis=1).max() < 2e-5
    assert run.tool_speed().max() <= 0.5 * 1.001
    assert run.tool_acceleration().max() <= 2.0 * 1.02
    np.testing.assert_allclose(FIVE.fkine(run.q[-1]), at(*SQUARE[-1]), atol=1e-9)


def test_joint_moves_blend_by_the_distance_of_the_tool() -> None:
    run = followed(joints(0.8, r=0.05), joints(0.8, 0.5))
    assert run.kinds == [(1, "started"), (1, "blended"), (2, "started"), (2, "finished")]
    corner = turned(0.8)
    left = next(cycle for cycle, _, kind in run.events if kind == "blended")
    away = np.linalg.norm(FIVE.fkine(run.q)[:, :3, 3] - FIVE.fkine(corner)[:3, 3], axis=1)
    assert away[left - 2] >= 0.05
    assert away[left - 1] <= 0.05
    assert np.abs(run.qd).max() <= 1.0 * 1.001
    assert np.abs(run.qdd).max() <= 2.0 * 1.001
    # Joint 1 has not stopped before joint 2 sets off.
    assert (np.abs(run.qd[:, 1]) > 1e-3)[np.abs(run.qd[:, 0]) > 1e-3].any()


def test_joint_moves_and_lines_blend_into_each_other() -> None:
    run = followed(joints(0.6, 0.2, r=0.05), line(0.05, 0.2, -0.1, r=0.05), joints(-0.5))
    assert [kind for _, kind in run.kinds if kind != "started"] == ["blended"] * 2 + ["finished"]
    assert (np.abs(run.qdd) <= np.array(FIVE.acceleration) * 1.02).all()
    np.testing.assert_allclose(run.q[-1], turned(-0.5), atol=1e-12)


def test_a_motion_back_on_itself_blends() -> None:
    run = followed(line(0.0, 0.2, r=0.05), line(0.0, 0.0))
    assert run.kinds[1] == (1, "blended")
    assert run.tool_acceleration().max() <= 1.0 * 1.02
    assert FIVE.fkine(run.q)[:, 1, 3].max() < at(0, 0.2)[1, 3] - 0.01


def test_a_radius_longer_than_a_motion_takes_half_of_it() -> None:
    run = followed(*(line(0.02 * (key + 1), 0.02 * (key % 2), r=0.5) for key in range(6)))
    assert [kind for _, kind in run.kinds if kind != "started"] == ["blended"] * 5 + ["finished"]
    assert run.tool_acceleration().max() <= 1.0 * 1.03


@pytest.mark.parametrize("radius", [5e-324, 1e-300, 1e-12, 9e-7])
def test_a_radius_of_less_than_a_micrometre_is_none(radius: float) -> None:
    run = followed(joints(0.3, r=radius), line(0.0, 0.1, r=radius), line(0.1, 0.1))
    assert [kind for _, kind in run.kinds].count("finished") == 3


def test_a_blend_needs_its_successor_in_time() -> None:
    late = Recorder(moving(line(0.0, 0.2, r=0.02)))
    plan = line(0.1, 0.2)
    alone = plan(line_move(FIVE, HOME, at(0, 0.2), 0.25, 1.0).q_end).duration
    late.tick(1000)
    late.mover.append(2, plan)
    late.until_rest()
    late.hangs_together()
    assert late.kinds == [(1, "started"), (1, "finished"), (2, "started"), (2, "finished")]
    assert len(late.setpoints) == pytest.approx((0.2 / 0.25 + 0.25 + alone) / CYCLE, abs=3)


@pytest.mark.slow
@given(st.integers(0, 1049), st.floats(0.005, 0.15), st.floats(0.3, 1.0))
@settings(max_examples=examples(25))
def test_a_successor_at_any_time_breaks_no_limit(when: int, radius: float, speed: float) -> None:
    run = Recorder()
    run.mover.set_speed(speed)
    run.mover.append(1, line(0.0, 0.2, r=radius))
    run.tick(when)
    run.mover.append(2, line(0.1, 0.1, 0.1))
    run.until_rest()
    run.hangs_together()
    assert run.tool_speed().max() <= 0.25 * 1.001
    assert run.tool_acceleration().max() <= 1.0 * 1.02
    np.testing.assert_allclose(FIVE.fkine(run.q[-1]), at(0.1, 0.1, 0.1), atol=1e-9)


@pytest.mark.slow
def test_a_pause_in_a_blend_stays_on_it() -> None:
    whole = corner_run(0.05, v=0.5, a=2.0)
    begin = next(cycle for cycle, key, kind in whole.events if (key, kind) == (0, "blended"))
    for after in (0, 1, 40, 120):
        run = Recorder()
        for key, (x, y, z) in enumerate(SQUARE):
            run.mover.append(key, line(x, y, z, v=0.5, a=2.0, r=0.05 if key < 3 else 0.0))
        run.tick(begin + after)
        run.mover.pause()
        run.until_rest()
        run.mover.resume()
        run.until_rest()
        run.hangs_together()
        assert run.kinds == whole.kinds
        away = np.abs(run.q[::7, None] - whole.q[None]).max(axis=2).min(axis=1)
        assert away.max() < 2e-3


def test_it_tells_how_far_a_motion_has_come() -> None:
    run = Recorder(moving(line(0.0, 0.25)))

    def travel_now() -> Travel | None:
        return run.mover.travel

    assert travel_now() is None
    duration = 0.25 / 0.25 + 0.25
    for cycle in range(1, 1200, 100):
        run.tick(cycle - len(run.setpoints))
        travel = travel_now()
        assert travel is not None
        assert travel.elapsed == pytest.approx(cycle * CYCLE)
        left = duration - travel.elapsed
        assert travel.ends_within(left + 1e-6)
        assert not travel.ends_within(left - 1e-6)
        assert travel.distance + travel.left == pytest.approx(0.25, abs=1e-9)
        reached = np.linalg.norm(FIVE.fkine(run.q[-1])[:3, 3] - at()[:3, 3])
        assert travel.distance == pytest.approx(reached, abs=2e-5)
        assert run.mover.progress == pytest.approx(travel.distance / 0.25)
    run.mover.set_speed(0.5)
    run.tick(3)
    assert travel_now() is not None
    left = len(run.setpoints)
    run.until_rest()
    assert travel_now() is None
    assert len(run.setpoints) > left + 40


@pytest.mark.parametrize("seed", range(40))
def test_lines_and_arcs_anywhere_keep_every_limit_of_every_arm(seed: int) -> None:
    rng = np.random.default_rng(seed)
    any_arm = arm(models()[seed % len(models())])
    q = rng.uniform(-2.5, 2.5, 6)
    v, a, r = rng.uniform(0.05, 2.0), rng.uniform(0.3, 10.0), rng.uniform(0.0, 0.1)
    run = Recorder(Mover(any_arm, q, 2 * CYCLE), any_arm)
    for key in range(4):
        near = [any_arm.fkine(q + 0.3 * rng.normal(size=6)) for _ in range(2)]
        mode = int(rng.integers(3))

        def plan(at: Array, near: list[Array] = near, mode: int = mode) -> Segment:
            nonlocal q
            if mode == 2:
                segment = line_move(any_arm, at, near[0], v, a, r)
            else:
                segment = arc_move(any_arm, at, near[0], near[1], v, a, r, mode=mode)
            q = segment.q_end
            return segment

        with suppress(PlanError):
            run.mover.append(key, plan)
    run.until_rest(500_000)
    if not run.setpoints:
        return
    assert run.tool_speed().max() <= v * 1.02
    assert run.tool_acceleration().max() <= a * 1.02
    assert (np.abs(run.qd) <= np.array(any_arm.velocity) * 1.02).all()
    assert (np.abs(run.qdd) <= np.array(any_arm.acceleration) * 1.02).all()


PLANS: list[Callable[[Array], Segment]] = [
    joints(0.5, 0.2, r=0.05),
    joints(-0.2, 0.1, 0.2, v=2.0, a=4.0),
    line(0.05, 0.1, r=0.03),
    line(-0.05, -0.1, 0.1, v=0.5, a=2.0, r=0.2),
    line(0.0, 0.0, -0.1),
    lambda q: line_move(
        FIVE, q, at(0.0, 0.1) @ Pose(0, 0, 0, 0.2, 0.1, -0.3).matrix, 0.3, 1.0, 0.02
    ),
]
STEPS = st.one_of(
    st.tuples(st.just("append"), st.integers(0, len(PLANS) - 1)),
    st.tuples(st.just("tick"), st.integers(1, 400)),
    st.tuples(st.sampled_from(["pause", "resume", "stop"]), st.none()),
    st.tuples(st.just("set_speed"), st.floats(0.01, 1.0)),
)


@given(st.lists(STEPS, min_size=2, max_size=25))
@settings(max_examples=examples(60))
def test_whatever_happens_every_motion_ends_once_and_no_limit_is_exceeded(
    steps: list[tuple[str, Any]],
) -> None:
    run = Recorder()
    appended: list[int] = []
    for key, (what, value) in enumerate(steps):
        if what == "append":
            with suppress(PlanError):  # while it is stopping
                run.mover.append(key, PLANS[value])
                appended.append(key)
        elif what == "tick":
            run.tick(value)
        elif what == "set_speed":
            run.mover.set_speed(value)
        else:
            getattr(run.mover, what)()
        if not run.mover.moving:
            np.testing.assert_array_equal(run.mover.setpoint.qd, np.zeros(6))
    run.mover.set_speed(1.0)
    run.mover.resume()
    run.until_rest()
    run.tick()
    run.hangs_together(STOPPING * max(FIVE.acceleration))
    ends = [key for key, kind in run.kinds if kind != "started"]
    assert ends == appended
    started = [key for key, kind in run.kinds if kind == "started"]
    assert started == [key for key in appended if key in started]
    assert (np.abs(run.qd) <= np.array(FIVE.velocity) * 1.02).all()
    assert (np.abs(run.qdd) <= np.array(FIVE.acceleration) * 1.02).all()
