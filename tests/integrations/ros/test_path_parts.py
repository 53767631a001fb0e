"""Parts of a path: the whole at a factor of its speed, and what remains for an arm at rest."""

from __future__ import annotations

import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco import JointTrajectory
from aioduco.integrations.ros.path_parts import (
    nearest_time,
    path_from_motion,
    rest_of_path,
    whole_path,
)

from .goals import PROFILE, START

HERE = np.array(START)
WAY = np.array([0.5, -0.2, 0.1, 0.3, -0.4, 0.6])
TRAJECTORY = JointTrajectory([HERE, HERE + WAY, HERE - WAY], [0.0, 1.0, 3.0])
PATH = TRAJECTORY.curve(START)


@for_each("factor", [1.0, 0.5, 0.01])
def test_a_whole_path_at_a_factor_of_its_speed(factor: float) -> None:
    part = whole_path(TRAJECTORY, factor)
    curve = part.trajectory.curve(START)
    times = np.linspace(0.0, 3.0 / factor, 50)
    np.testing.assert_allclose(curve.at(times), PATH.at(times * factor), atol=1e-9)
    assert part.path_time(times[20]) == pytest.approx(times[20] * factor)


@given(
    st.floats(0.0, 3.0),
    st.floats(0.01, 1.0),
    st.lists(st.floats(-0.2, 0.2), min_size=6, max_size=6),
)
def test_what_remains_leads_from_rest_onto_the_path(
    begin: float, factor: float, off: list[float]
) -> None:
    actual = PATH.at(np.array([begin]))[0] + off
    part = rest_of_path(PATH, actual, begin=begin, factor=factor, profile=PROFILE)
    curve = part.trajectory.curve(actual)
    times = np.linspace(0.0, part.trajectory.duration, 2000)
    places, speeds = curve.at(times), curve.velocity(times)
    np.testing.assert_allclose(places[0], actual, atol=1e-9)
    np.testing.assert_allclose(places[-1], HERE - WAY, atol=1e-9)
    assert np.abs(speeds[[0, -1]]).max() < 1e-6
    assert (np.abs(speeds).max(axis=0) <= np.array(PROFILE.velocity) * 1.02).all()
    # and is on the path again before long, going forward
    on_path = [part.path_time(time) for time in times]
    assert (np.diff(on_path) >= -1e-9).all()
    assert on_path[0] == pytest.approx(begin, abs=1e-6)
    late = times > times[-1] / 2 + 2.0
    np.testing.assert_allclose(places[late], PATH.at(np.array(on_path))[late], atol=2e-3)


SIX = st.lists(st.floats(-0.1, 0.1), min_size=6, max_size=6)


@pytest.mark.slow
@given(st.floats(0.0, 2.5), st.floats(0.05, 1.0), SIX, SIX)
def test_a_moving_arm_comes_onto_the_path_without_a_step(
    begin: float, factor: float, off: list[float], drift: list[float]
) -> None:
    at = np.array([begin])
    place = PATH.at(at)[0] + off
    speed = factor * PATH.velocity(at)[0] + drift
    part = path_from_motion(PATH, place, speed, begin=begin, factor=factor, profile=PROFILE)
    left = (3.0 - begin) / factor
    if part is None:
        assert left < 2.4
        return
    assert part.trajectory.duration == pytest.approx(left)
    curve = part.trajectory.curve(place)
    times = np.linspace(0.0, left, 4000)
    places, speeds = curve.at(times), curve.velocity(times)
    np.testing.assert_allclose(places[[0, -1]], [place, HERE - WAY], atol=1e-9)
    np.testing.assert_allclose(speeds[0], speed, atol=1e-9)
    assert np.abs(speeds[-1]).max() < 1e-6
    assert (np.abs(speeds).max(axis=0) <= np.array(PROFILE.velocity) * 1.02).all()
    changes = np.abs(np.diff(speeds, axis=0)) / (times[1] - times[0])
    own = np.abs(np.diff(PATH.velocity(np.linspace(0.0, 3.0, 4000)), axis=0)) / (3.0 / 3999)
    assert changes.max() <= PROFILE.acceleration + own.max() * factor**2 + 0.5
    late = times > 2.4
    on_path = np.array([part.path_time(time) for time in times])
    np.testing.assert_allclose(places[late], PATH.at(on_path)[late], atol=2e-3)


def test_what_remains_of_a_long_path_is_the_path() -> None:
    """Ten minutes with a wiggle of a second, of which the arm has done one."""
    times = np.linspace(0.0, 600.0, 5001)
    wiggle = 0.05 * np.sin(2.0 * np.pi * times)[:, None] * np.eye(6)[0]
    path = JointTrajectory(HERE + wiggle, times).curve(START)
    begin, factor = 60.03, 0.5
    here = path.at(np.array([begin]))[0]
    speed = factor * path.velocity(np.array([begin]))[0]
    moving = path_from_motion(path, here, speed, begin=begin, factor=factor, profile=PROFILE)
    for part in (moving, rest_of_path(path, here, begin=begin, factor=factor, profile=PROFILE)):
        assert part is not None
        looks = np.linspace(3.0, part.trajectory.duration, 20_000)
        on_path = path.at(np.array([part.path_time(time) for time in looks]))
        np.testing.assert_allclose(part.trajectory.curve(here).at(looks), on_path, atol=1e-6)


def test_where_a_moving_arm_cannot_come_onto_the_path_in_time() -> None:
    here = PATH.at(np.array([2.9]))[0]
    far = here + 0.3
    made = path_from_motion(PATH, far, np.zeros(6), begin=2.9, factor=1.0, profile=PROFILE)
    assert made is None


def test_the_nearest_time_is_looked_for_in_a_window() -> None:
    there = PATH.at(np.array([2.0]))[0].tolist()
    assert nearest_time(PATH, there, 1.8, 2.5) == pytest.approx(2.0, abs=0.011)
    assert nearest_time(PATH, there, 2.3, 2.5) == pytest.approx(2.3, abs=0.011)
    assert nearest_time(PATH, there, 3.1, 4.0) == 3.0
