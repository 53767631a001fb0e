"""A bound leaves room for the rounding of binary32, and nothing more; the bound itself is sent."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

import aioduco
from aioduco import Joints, JointTrajectory, ParameterError, TaughtPoints, descriptions, kinematics
from aioduco.integrations.ros.joint_commands import check_command
from aioduco.integrations.ros.trajectory_goals import NamedLimits
from aioduco.models import ranges
from aioduco.models.bounds import ROUNDING, least, most, shown
from aioduco.models.rules import Duration, Number, Rule, Vector
from aioduco.planning import Planner, Scene
from aioduco.recording.playback import WaypointFile

ARMS = [kinematics.arm(name) for name in kinematics.models()]
#: a joint at 2π as a controller sends it: above the limit
READ = float(np.float32(2 * math.pi))


def numbers() -> list[tuple[str, Number]]:
    """Every rule of a number that has a bound, those within vectors included."""
    found: list[tuple[str, Number]] = []
    for name, rule in vars(ranges).items():
        if not isinstance(rule, Rule):
            continue
        inner = getattr(rule, "rule", rule)
        elements = inner.element if isinstance(inner, Vector) else (inner,)
        for each in elements:
            number = each._number if isinstance(each, Duration) else each
            if isinstance(number, Number):
                found.append((name, number))
    return found


def test_every_bound_takes_its_reading_and_sends_itself() -> None:
    taken = 0
    for name, rule in numbers():
        for bound, open_ in ((rule.low, rule.open_low), (rule.high, False)):
            if not math.isfinite(bound) or open_:
                continue
            for value in (np.float32(bound), float(np.float32(bound))):
                sent = rule(name, value)
                assert type(sent) is float
                assert rule.low <= sent <= rule.high, (name, value)
                taken += sent != float(value)
    assert taken > 10


def test_what_is_beyond_a_bound_by_more_than_rounding_is_refused() -> None:
    for name, rule in numbers():
        for bound, way in ((rule.low, -1.0), (rule.high, 1.0)):
            if math.isfinite(bound):
                beyond = bound + way * max(abs(bound) * 2.01 * ROUNDING, 1e-300)
                with pytest.raises(ParameterError):
                    rule(name, beyond)


def test_every_printed_bound_can_be_typed_back() -> None:
    for name, rule in numbers():
        for word in rule.expected.replace(",", " ").split():
            try:
                value = float(word)
            except ValueError:
                continue
            if not (rule.open_low and value == rule.low):
                assert rule.low <= rule(name, value) <= rule.high
                assert rule.low <= value <= rule.high, (name, rule.expected)


@given(st.floats(1e-6, 1e6), st.integers(2, 12), st.sampled_from([1.0, -1.0]))
def test_a_bound_is_shown_to_the_inside(size: float, digits: int, sign: float) -> None:
    bound = sign * size
    low, high = (float(shown(bound, low=each, digits=digits)) for each in (True, False))
    assert high <= bound <= low
    assert low - high <= 10.0 ** (math.floor(math.log10(size)) + 2 - digits)


@given(st.floats(width=64, allow_nan=False, allow_infinity=False, min_value=-1e30, max_value=1e30))
def test_rounding_to_binary32_never_leaves_a_bound(bound: float) -> None:
    if abs(bound) > 1e-30:  # below lie numbers that binary32 cannot hold
        assert least(bound) <= float(np.float32(bound)) <= most(bound)


@for_each("arm", ARMS)
def test_a_joint_read_at_its_limit_keeps_its_branch(arm: kinematics.Arm) -> None:
    for joint in range(6):
        for value in (READ, -READ, 2 * math.pi, -2 * math.pi):
            q = np.array([0.5, -0.26, 1.83, 0.3, -1.57, 0.2])
            q[joint] = value
            back = arm.ikine(arm.fkine(q), q)
            assert np.abs(back - q).max() < 1e-6
            assert np.abs(back).max() <= 2 * math.pi


def test_a_reading_at_the_limit_is_taken_everywhere_and_the_limit_is_sent() -> None:
    at_limit = Joints(0.5, -0.26, 1.83, 0.0, -1.57, READ)
    near = Joints(0.5, -0.26, 1.83, 0.0, -1.57, 6.2)
    limit = 2 * math.pi

    assert JointTrajectory([at_limit, near], [0.0, 1.0]).positions[0, 5] == limit
    file = WaypointFile.new()
    file.add("park", at_limit)
    assert file.waypoints[0].joints[5] == limit
    assert TaughtPoints({"park": at_limit}).joints("park") == at_limit

    robot = aioduco.connect("192.0.2.1")
    for call in (
        robot.motion.movej2(at_limit, v=1.0, a=1.0),
        robot.motion.movel(
            aioduco.Pose(0.4, 0.1, 0.3, 3.1, 0.0, 0.0), v=0.2, a=0.5, q_near=at_limit
        ),
    ):
        call.mark_used()
    assert kinematics.check([at_limit], arm="gcr5_910", near=near).ok
    assert ARMS[0].within_limits(at_limit)
    profile = NamedLimits.of("gcr5_910")
    names = profile.joint_names
    assert check_command(names, list(at_limit), profile)[5] == limit


@pytest.mark.slow
def test_a_plan_begins_and_ends_at_a_reading_at_the_limit() -> None:
    at_limit = Joints(0.5, -0.26, 1.83, 0.0, -1.57, READ)
    near = Joints(0.5, -0.26, 1.83, 0.0, -1.57, 6.0)
    with Planner(Scene("gcr5_910")) as planner:
        for start, goal in ((at_limit, near), (near, at_limit)):
            plan = planner.plan_blocking(start, goal)
            assert np.abs(plan.trajectory.positions).max() <= 2 * math.pi


@pytest.mark.slow
def test_a_written_limit_is_within_the_arms() -> None:
    for arm in ARMS:
        root = ET.fromstring(descriptions.urdf(arm))
        limits = [each.attrib for each in root.iter("limit")]
        assert len(limits) == 6
        profile = NamedLimits.of(arm.name)
        for joint, limit in enumerate(limits):
            assert arm.lower[joint] <= float(limit["lower"]) < float(limit["upper"])
            assert float(limit["upper"]) <= arm.upper[joint]
            assert float(limit["velocity"]) <= arm.velocity[joint]
            assert float(limit["effort"]) <= arm.effort[joint]
        for side in ("lower", "upper"):
            given_ = [float(limit[side]) for limit in limits]
            assert check_command(profile.joint_names, given_, profile) == tuple(given_)
