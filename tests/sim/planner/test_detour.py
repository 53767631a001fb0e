"""Paths through singularities: on the curve away from them, smooth and near it past them."""

from __future__ import annotations

import numpy as np
import pytest

from aioduco.kinematics import Arm, arm, models
from aioduco.models.rotation import Array
from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import Segment, arc_move, line_move
from aioduco.sim.planner.tracing import NEAR
from aioduco.sim.planner.weaving import Weave

from .motions import CYCLE, FIVE, ticks_of

#: joint 5 changes its sign between the two
BEFORE = np.array([0.0, 0.3, 1.2, 0.0, 0.3, 0.0])
BEHIND = np.array([0.0, 0.3, 1.2, 0.0, -0.3, 0.0])
#: the same with a turn on the way, so that the singularity is only grazed
ASIDE = np.array([0.1, 0.3, 1.0, 0.3, -0.3, 0.4])


def line(q0: Array, q1: Array, of: Arm = FIVE, v: float = 0.1) -> Segment:
    return line_move(of, q0, of.fkine(q1), v, 1.0, around=True)


def off_the_line(segment: Segment, q0: Array, q1: Array, of: Arm = FIVE) -> tuple[Array, Array]:
    """Distances from the line over the way along it, and how near a singularity is [m, 1]."""
    assert segment.path is not None
    q = segment.path.sample(np.linspace(0.0, segment.length, 2001))[:, 0]
    points = of.fkine(q)[:, :3, 3]
    start, end = of.fkine(q0)[:3, 3], of.fkine(q1)[:3, 3]
    along = (end - start) / np.linalg.norm(end - start)
    away = points - start
    distance: Array = np.linalg.norm(away - (away @ along)[:, None] * along, axis=1)
    near = np.array([min(of.singularity(each)[:3]) for each in q])
    return distance, near


@pytest.mark.parametrize(("behind", "most"), [(BEHIND, 3e-3), (ASIDE, 8e-3)])
def test_the_tool_leaves_its_line_only_near_the_singularity(behind: Array, most: float) -> None:
    with pytest.raises(PlanError) as caught:
        line_move(FIVE, BEFORE, FIVE.fkine(behind), 0.1, 1.0)
    assert caught.value.code == "singular"
    segment = line(BEFORE, behind)
    distance, near = off_the_line(segment, BEFORE, behind)
    assert distance[near > 1.05 * NEAR].max() < 1e-5
    assert 1e-5 < distance.max() < most
    np.testing.assert_allclose(FIVE.fkine(segment.q_end), FIVE.fkine(behind), atol=1e-9)


@pytest.mark.parametrize("name", models())
def test_joints_pass_smoothly_and_within_their_limits(name: str) -> None:
    each = arm(name)
    mover = Mover(each, BEFORE, CYCLE)
    mover.append(1, lambda q: line(q, ASIDE, each))
    ticks = ticks_of(mover)
    speeds = [tick.setpoint.qd for tick in ticks]
    changes = [tick.setpoint.qdd for tick in ticks]
    assert ticks[-1].events[-1].kind == "finished"
    assert (np.abs(speeds).max(axis=0) < 1.02 * np.array(each.velocity)).all()
    assert (np.abs(changes).max(axis=0) < 1.05 * np.array(each.acceleration)).all()
    assert (np.abs(speeds[5:-5]).max(axis=1) > 0.0).all()  # without a stop
    np.testing.assert_allclose(each.fkine(mover.setpoint.q), each.fkine(ASIDE), atol=1e-9)


def test_a_tool_that_leaves_its_line_is_no_faster_than_asked_for() -> None:
    far = np.array([0.5, 0.5, 1.0, 0.5, -0.4, 0.4])
    mover = Mover(FIVE, BEFORE, CYCLE)
    mover.append(1, lambda q: line(q, far))
    points = FIVE.fkine(np.array([tick.setpoint.q for tick in ticks_of(mover)]))[:, :3, 3]
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / CYCLE
    assert speeds.max() == pytest.approx(0.1, rel=1e-2)


@pytest.mark.slow
def test_a_path_may_begin_and_end_at_a_singularity() -> None:
    straight = np.array([0.0, 0.3, 1.2, 0.0, 0.0, 0.0])
    for q0, q1 in ((straight, BEHIND), (BEFORE, straight)):
        segment = line(q0, q1)
        assert segment.path is not None
        np.testing.assert_allclose(segment.path.sample(np.zeros(1))[0, 0], q0, atol=1e-9)
        np.testing.assert_allclose(FIVE.fkine(segment.q_end), FIVE.fkine(q1), atol=1e-7)


def test_an_arc_and_a_weave_pass_one_too() -> None:
    start, end = FIVE.fkine(BEFORE), FIVE.fkine(BEHIND)
    via = start.copy()
    via[:3, 3] = 0.5 * (start + end)[:3, 3] + [0.0, 0.01, 0.0]
    round_it = arc_move(FIVE, BEFORE, via, end, 0.1, 1.0, around=True)
    np.testing.assert_allclose(FIVE.fkine(round_it.q_end), end, atol=1e-9)
    weave = Weave(WeaveShape.SINE, WeavePlane.WORK_OBJECT_XZ, 5.0, 0.002)
    woven = line_move(FIVE, BEFORE, end, 0.02, 1.0, weave=weave, around=True)
    np.testing.assert_allclose(FIVE.fkine(woven.q_end), end, atol=1e-9)


def test_what_is_out_of_reach_stays_so() -> None:
    far = FIVE.fkine(BEFORE)
    far[0, 3] += 1.0
    with pytest.raises(PlanError) as caught:
        line_move(FIVE, BEFORE, far, 0.1, 1.0, around=True)
    assert caught.value.code == "unreachable"
