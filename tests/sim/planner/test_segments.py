"""Planned motions: where they go, how long they take, and what is refused."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given, settings
from hypothesis import strategies as st
from quick import examples

from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix
from aioduco.sim.planner.path import Path, PlanError, differentiate
from aioduco.sim.planner.segments import Segment, arc_move, joint_move, line_move
from aioduco.sim.planner.timing import backward, fastest

from .motions import FIVE, HOME, shifted, trapezoid

OFFSET = st.floats(-0.12, 0.12)  # the reach ends at 0.15 along all three axes


def flanges(segment: Segment, count: int = 400) -> Array:
    """Poses of the flange at even distances."""
    assert segment.path is not None
    return FIVE.fkine(segment.path.sample(np.linspace(0, segment.length, count))[:, 0])


def joint_speeds(segment: Segment) -> Array:
    """Joint speeds over the time law [rad/s]. Shape (n, 6)."""
    assert segment.path is not None
    assert segment.limits is not None
    law = fastest(segment.limits, backward(segment.limits, 0.0), 0.0, 0.0)
    states = [law.at(t) for t in np.linspace(0, law.duration, 500)]
    path = segment.path
    return np.array([path.state(path.piece(s), s, v, a)[1] for _, s, v, a in states])


def code(caught: pytest.ExceptionInfo[PlanError]) -> str:
    return caught.value.code


@given(st.lists(st.floats(-1.5, 1.5), min_size=6, max_size=6), st.floats(0.1, 3), st.floats(0.1, 9))
def test_a_joint_move_is_straight_and_takes_the_time_of_its_furthest_joint(
    way: list[float], v: float, a: float
) -> None:
    goal = HOME + np.array(way)
    segment = joint_move(FIVE, HOME, goal, v, a)
    furthest = max(map(abs, way))
    if furthest < 1e-9:
        assert segment.path is None
        return
    assert segment.duration == pytest.approx(trapezoid(furthest, v, a), rel=1e-6)
    assert segment.path is not None
    samples = segment.path.sample(np.linspace(0, segment.length, 5))[:, 0]
    np.testing.assert_allclose(samples, np.linspace(HOME, goal, 5), atol=1e-9)


def test_a_joint_move_keeps_to_the_speed_of_the_slower_joints() -> None:
    slow = replace(FIVE, velocity=(3.9, 0.5, 3.9, 3.9, 3.9, 3.9))
    segment = joint_move(slow, HOME, HOME + np.array([1, 1, 0, 0, 0, 0]), 2.0, 4.0)
    assert segment.duration == pytest.approx(trapezoid(1.0, 0.5, 4.0), rel=1e-6)
    # The drives end an acceleration without limit.
    fast = joint_move(FIVE, HOME, HOME + np.array([1, 0, 0, 0, 0, 0]), 2.0, math.inf)
    assert fast.duration == pytest.approx(trapezoid(1.0, 2.0, FIVE.acceleration[0]), rel=1e-6)


@pytest.mark.slow
@given(OFFSET, OFFSET, OFFSET, st.floats(-0.8, 0.8), st.floats(0.05, 0.25), st.floats(0.1, 1.0))
@settings(max_examples=examples(60))
def test_a_line_is_straight_and_takes_the_time_of_a_trapezoid(
    x: float, y: float, z: float, turn: float, v: float, a: float
) -> None:
    target = shifted(HOME, x, y, z) @ Pose(0, 0, 0, 0, 0, turn).matrix
    length = math.hypot(x, y, z)
    if length < max(0.01, abs(turn) / 20):
        return  # so little way for the turn that the joints' own accelerations count
    segment = line_move(FIVE, HOME, target, v, a)
    start = Pose.from_matrix(FIVE.fkine(HOME))
    end = Pose.from_matrix(target)
    poses = flanges(segment, 100)
    for part, pose in zip(np.linspace(0, 1, 100), poses, strict=True):
        here = start.interpolate(end, part)
        assert here.almost_equal(Pose.from_matrix(pose), position=2e-5, rotation=2e-5)
    np.testing.assert_allclose(FIVE.fkine(segment.q_end), target, atol=1e-9)
    if np.abs(joint_speeds(segment)).max() < 0.9 * min(FIVE.velocity):
        assert segment.duration == pytest.approx(trapezoid(length, v, a), rel=0.02)


def test_a_line_keeps_the_tool_on_it_when_the_flange_is_not() -> None:
    tool = Pose(0.05, 0.0, 0.2, 0.0, 0.3, 0.0).matrix
    start = FIVE.fkine(HOME) @ tool
    target = start @ Pose(0.0, 0.0, 0.0, 0.4, 0.5, 0.6).matrix
    target[:3, 3] += 0.05, 0.1, 0.0
    segment = line_move(FIVE, HOME, target @ np.linalg.inv(tool), 0.1, 0.5, tool=tool)
    tips = segment.tcp(np.linspace(0, segment.length, 200))
    direction = (target - start)[:3, 3] / np.linalg.norm((target - start)[:3, 3])
    off = tips[:, :3, 3] - start[:3, 3]
    off -= np.outer(off @ direction, direction)
    assert np.abs(off).max() < 1e-5
    np.testing.assert_allclose(tips[-1], target, atol=1e-9)
    flange = flanges(segment)[:, :3, 3]
    straight = np.linspace(flange[0], flange[-1], len(flange))
    assert np.linalg.norm(flange - straight, axis=1).max() > 0.005


def test_a_turn_on_the_spot_takes_its_speed_as_radians() -> None:
    target = FIVE.fkine(HOME) @ Pose(0, 0, 0, 0, 0, 0.9).matrix
    segment = line_move(FIVE, HOME, target, 0.5, 1.0)
    assert segment.duration == pytest.approx(trapezoid(0.9, 0.5, 1.0), rel=1e-3)


@pytest.mark.parametrize("mode", [0, 1, 2])
def test_an_arc_is_round_and_keeps_its_acceleration_across_it(mode: int) -> None:
    via, target = shifted(HOME, 0.1, 0.1), shifted(HOME, 0.0, 0.2)
    segment = arc_move(FIVE, HOME, via, target, 0.2, 0.8, mode=mode)
    assert segment.length == pytest.approx(0.1 * math.pi)
    centre = shifted(HOME, 0.0, 0.1)[:3, 3]
    points = flanges(segment)[:, :3, 3]
    np.testing.assert_allclose(np.linalg.norm(points - centre, axis=1), 0.1, atol=2e-5)
    # 0.4 m/s² across leave 0.69 of 0.8 m/s² along at full speed.
    assert trapezoid(segment.length, 0.2, 0.8) < segment.duration
    assert segment.duration < trapezoid(segment.length, 0.2, 0.69)
    turn = rotvec_from_matrix(FIVE.fkine(HOME)[:3, :3].T @ flanges(segment)[-1, :3, :3])
    assert np.linalg.norm(turn) == pytest.approx(math.pi if mode == 2 else 0.0, abs=1e-9)


@pytest.mark.parametrize("radius", [0.1, 1e-3, 1e-4])
def test_a_fast_arc_is_as_fast_as_its_bend_allows(radius: float) -> None:
    """A tiny one, which its bend slows down to a fiftieth and less, is near no singularity."""
    via, target = shifted(HOME, radius, radius), shifted(HOME, 0.0, 2.0 * radius)
    segment = arc_move(FIVE, HOME, via, target, 2.0, 1.0, mode=1)
    assert segment.limits is not None
    assert max(segment.limits.ceiling) == pytest.approx(0.98 * radius * 1.0, rel=1e-3)


def test_a_circle_ends_where_it_began() -> None:
    first, second = shifted(HOME, 0.1, 0.1), shifted(HOME, 0.0, 0.2)
    segment = arc_move(FIVE, HOME, first, second, 0.3, 1.0, mode=1, full=True)
    assert segment.length == pytest.approx(0.2 * math.pi)
    np.testing.assert_allclose(segment.q_end, HOME, atol=1e-9)
    with pytest.raises(PlanError, match="not 1 or 2"):
        arc_move(FIVE, HOME, first, second, 0.3, 1.0, full=True)


@for_each(
    "turn, shift",
    product(
        [0.0, 1e-11, 1e-9, 3e-9, 1e-8, 1e-7, 1e-6, 1e-5, 0.5],
        [0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1.1e-6, 1e-5],
    ),
)
def test_a_line_to_where_the_tool_is_nearly_already_is_no_singularity(
    turn: float, shift: float
) -> None:
    start = np.radians([30.0, -15.0, 105.0, 0.0, -90.0, 0.0])
    target = FIVE.fkine(start)
    target[:3, :3] = target[:3, :3] @ matrix_from_rotvec(np.array([0.0, 0.0, turn]))
    target[:3, 3] += shift, 0.0, 0.0
    segment = line_move(FIVE, start, target, 0.2, 0.5)
    np.testing.assert_allclose(FIVE.fkine(segment.q_end), target, atol=1.5e-6)
    assert segment.duration < 3.0


def test_joints_turn_no_faster_than_they_can_on_a_line_past_a_singularity() -> None:
    # The wrist's centre passes the axis of joint 1 at a distance: joint 1 has to turn fast.
    q = FIVE.ikine(Pose(0.40, -0.22, 0.5, math.pi, 0, 0), HOME)
    target = Pose(-0.40, -0.22, 0.5, math.pi, 0, 0).matrix
    segment = line_move(FIVE, q, target, 2.0, 5.0)
    speeds = np.abs(joint_speeds(segment)).max(axis=0)
    assert (speeds <= np.array(FIVE.velocity) * 1.02).all()
    assert speeds.max() > 0.9 * FIVE.velocity[int(speeds.argmax())]
    assert segment.duration > 1.2 * trapezoid(0.8, 2.0, 5.0)


@for_each(
    "q, name",
    [
        (np.zeros(6), "singularity"),
        (np.radians([0, 20, 0, 30, -90, 0]), "elbow"),
        (np.radians([0, 20, 60, 30, 0, 0]), "wrist"),
    ],
)
def test_a_line_from_a_singularity_is_refused(q: Array, name: str) -> None:
    with pytest.raises(PlanError, match=name) as caught:
        line_move(FIVE, q, shifted(q, y=0.05), 0.1, 0.5)
    assert code(caught) == "singular"


def test_a_line_through_a_singularity_is_refused() -> None:
    # Turning about the tool's own y axis brings joint 5 through zero.
    q = np.radians([10, 20, 60, 30, -25, 15])
    beyond = np.radians([10, 20, 60, 30, 25, 15])
    with pytest.raises(PlanError) as caught:
        line_move(FIVE, q, FIVE.fkine(beyond), 0.1, 0.5)
    assert code(caught) == "singular"


def test_poses_out_of_reach_are_refused() -> None:
    with pytest.raises(
        PlanError, match=r"leaves the reach of the arm, by at least 0\.\d+ m"
    ) as far:
        line_move(FIVE, HOME, shifted(HOME, x=0.9), 0.1, 0.5)
    assert code(far) == "unreachable"
    # Both ends are in reach, but what is between them is too close to the axis of joint 1.
    q = FIVE.ikine(Pose(0.35, 0.02, 0.5, math.pi, 0, 0), HOME)
    with pytest.raises(PlanError) as through:
        line_move(FIVE, q, Pose(-0.35, 0.02, 0.5, math.pi, 0, 0).matrix, 0.1, 0.5)
    assert code(through) in ("unreachable", "singular")


def test_joint_limits_are_kept() -> None:
    with pytest.raises(PlanError, match=r"joint 2 would leave -6\.283 to 6\.283 rad") as caught:
        joint_move(FIVE, HOME, HOME + np.array([0, 6.3, 0, 0, 0, 0]), 1.0, 1.0)
    assert code(caught) == "limits"
    narrow = replace(FIVE, upper=(0.05, 6, 6, 6, 6, 6))
    with pytest.raises(PlanError, match="joint 1 would leave") as on_line:
        line_move(narrow, HOME, shifted(HOME, y=0.2), 0.1, 0.5)
    assert code(on_line) == "limits"


@for_each("v, a, r", [(0, 1, 0), (1, 0, 0), (1, 1, -1), (math.nan, 1, 0)])
def test_parameters_that_make_no_sense_are_refused(v: float, a: float, r: float) -> None:
    with pytest.raises(PlanError) as joint:
        joint_move(FIVE, HOME, HOME + 0.1, v, a, r)
    with pytest.raises(PlanError) as line:
        line_move(FIVE, HOME, shifted(HOME, 0.1), v, a, r)
    assert code(joint) == code(line) == "parameter"


def test_a_motion_to_where_the_arm_is_takes_no_time() -> None:
    for segment in (
        joint_move(FIVE, HOME, HOME, 1.0, 1.0),
        line_move(FIVE, HOME, FIVE.fkine(HOME), 1.0, 1.0),
    ):
        assert segment.path is None
        assert (segment.length, segment.duration) == (0.0, 0.0)
        np.testing.assert_array_equal(segment.q_end, HOME)


def test_whole_turns_of_the_joints_are_kept_along_a_line() -> None:
    wound = HOME + np.array([2 * math.pi, 0, 0, 0, 0, 2 * math.pi])
    segment = line_move(FIVE, wound, shifted(HOME, y=-0.1), 0.1, 0.5)
    plain = line_move(FIVE, HOME, shifted(HOME, y=-0.1), 0.1, 0.5)
    np.testing.assert_allclose(segment.q_end - wound, plain.q_end - HOME, atol=1e-9)


def wave(s: Array) -> Array:
    """Six joints, each a different smooth function."""
    return np.stack([np.sin((1 + 0.3 * i) * s + i) for i in range(6)], axis=-1)


def sampled(count: int, length: float) -> Path:
    q = wave(np.linspace(0, length, count + 1))
    return Path.through(q, *differentiate(q, length / count), length)


@for_each("degree", range(7))
def test_differences_are_exact_for_polynomials(degree: int) -> None:
    polynomial = np.polynomial.Polynomial(np.arange(1.0, degree + 2))
    s = np.linspace(0, 1, 12)
    slope, bend = differentiate(polynomial(s)[:, None], s[1])
    np.testing.assert_allclose(slope[:, 0], polynomial.deriv(1)(s), rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(bend[:, 0], polynomial.deriv(2)(s), rtol=1e-7, atol=1e-8)


def test_path_keeps_to_the_function_it_was_sampled_from() -> None:
    path = sampled(40, 3.0)
    s = np.linspace(0, 3, 997)
    q, slope, bend = np.moveaxis(path.sample(s), 1, 0)
    step = 1e-5
    np.testing.assert_allclose(q, wave(s), atol=1e-6)
    np.testing.assert_allclose(slope, (wave(s + step) - wave(s - step)) / (2 * step), atol=1e-4)
    curve = (wave(s + 1e-4) - 2 * wave(s) + wave(s - 1e-4)) / 1e-8
    np.testing.assert_allclose(bend, curve, atol=1e-2)


def test_speeds_and_accelerations_follow_from_the_distance() -> None:
    path = sampled(40, 3.0)
    v, a, step = 0.7, -0.4, 1e-4

    def q(t: float) -> Array:
        s = 1.3 + v * t + 0.5 * a * t * t
        joints: Array = path.state(path.piece(s), s, 0.0, 0.0)[0]
        return joints

    state = path.state(path.piece(1.3), 1.3, v, a)
    np.testing.assert_allclose(state[0], q(0.0), atol=0)
    np.testing.assert_allclose(state[1], (q(step) - q(-step)) / (2 * step), atol=1e-7)
    np.testing.assert_allclose(state[2], (q(step) - 2 * q(0.0) + q(-step)) / step**2, atol=1e-6)


def test_position_slope_and_bend_are_continuous_between_pieces() -> None:
    path = sampled(20, 3.0)
    for s in path.bounds[1:-1]:
        piece = path.piece(s)
        before, after = path.state(piece - 1, s, 1.0, 0.5), path.state(piece, s, 1.0, 0.5)
        np.testing.assert_allclose(before, after, atol=1e-11)


def test_slices_and_joins_keep_the_path() -> None:
    path = sampled(20, 3.0)
    s = np.linspace(0.4, 2.75, 300)
    part = path.slice(0.4, 2.75)
    assert (part.start, part.end) == (0.4, 2.75)
    np.testing.assert_array_equal(part.sample(s), path.sample(s))
    again = path.slice(0.0, 1.15).then(path.slice(1.15, 3.0))
    np.testing.assert_allclose(again.sample(s), path.sample(s), atol=1e-12)
    at_node = path.slice(path.bounds[3], path.bounds[7])
    assert at_node.bounds == path.bounds[3:8]
    moved = path.slice(0.0, 1.0).then(path.slice(2.0, 3.0))
    np.testing.assert_allclose(
        moved.sample(np.array([1.5])), path.sample(np.array([2.5])), atol=1e-12
    )


def test_a_straight_path_is_linear_in_its_length() -> None:
    q0, q1 = np.arange(6.0), np.arange(6.0)[::-1]
    path = Path.straight(q0, q1, 5.0)
    np.testing.assert_allclose(path.sample(np.array([2.0]))[0, 0], q0 + 0.4 * (q1 - q0))
    np.testing.assert_allclose(path.sample(np.array([2.0]))[0, 1], (q1 - q0) / 5.0)


def test_pieces_are_found_forward_from_a_hint() -> None:
    path = sampled(20, 2.0)
    piece = 0
    for s in np.linspace(0.0, 2.0, 777):
        piece = path.piece(s, piece)
        assert piece == path.piece(s)
        assert path.bounds[piece] <= s <= path.bounds[piece + 1]
