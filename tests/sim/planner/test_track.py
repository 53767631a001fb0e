"""The track pool and its followers."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from aioduco.models.pose import Pose
from aioduco.sim.planner.follower import FollowError
from aioduco.sim.planner.track_pool import CAPACITY, JointTrack, ToolTrack, TrackPool

from .motions import CYCLE, FIVE, HOME, ran

NONE = np.zeros(6)


def pool(points: Iterable[Any]) -> TrackPool:
    filled = TrackPool()
    assert filled.put((tuple(point), None) for point in points)
    return filled


def joints(filled: TrackPool, v: float = 1.0, a: float = 5.0) -> JointTrack:
    return JointTrack(FIVE, HOME, CYCLE, filled, v, a)


def at(offset: list[float]) -> np.ndarray:
    moved: np.ndarray = HOME + np.array(offset)
    return moved


def run(follower: Any) -> np.ndarray:
    rows = ran(follower)
    assert follower.failure is None
    return rows


def wave(count: int = 60, length: float = 1.5) -> list[np.ndarray]:
    u = np.linspace(0.0, 1.0, count + 1)[1:]
    return [
        at([length * s, 0.2 * np.sin(4 * s), 0.0, 0.1 * s, 0.0, 0.3 * np.sin(3 * s)]) for s in u
    ]


def test_each_point_is_reached_in_order_without_a_stop_between_them() -> None:
    points = wave()
    rows = run(joints(pool(points)))
    last = 0
    for point in points:
        off = np.abs(rows[last:, 0] - point).max(axis=1)
        nearest = int(off.argmin())
        assert off[nearest] < 2e-3
        last += nearest
    assert np.abs(rows[-1, 0] - points[-1]).max() < 1e-9
    leading = np.abs(rows[:, 1]).max(axis=1)
    moving = np.flatnonzero(leading > 0.5)
    assert leading[moving[0] : moving[-1]].min() > 0.45


def test_speed_and_acceleration_are_those_of_the_joint_that_turns_furthest() -> None:
    rows = run(joints(pool(wave()), v=0.8, a=3.0))
    assert np.abs(rows[:, 1]).max() == pytest.approx(0.8, rel=0.02)
    assert np.abs(rows[:, 2]).max() < 3.0 * 1.02
    steps = np.diff(rows[:, 0], axis=0)
    assert np.abs(steps - CYCLE * rows[1:, 1]).max() < 1e-5


@pytest.mark.parametrize(
    "places",
    [
        [*np.arange(0.02, 0.4, 0.02), *np.arange(0.36, 0.0, -0.02)],
        [0.1, 0.2, 0.25, 0.2501, 0.2, 0.1, 0.0],
        [0.1, 0.2, 0.3, 0.2999],
    ],
    ids=["even", "two close ones at the turn", "a turn close to the end"],
)
def test_a_way_back_is_slowed_down_for_its_corner(places: list[float]) -> None:
    points = [at([place, 0, 0, 0, 0, 0]) for place in places]
    rows = run(joints(pool(points), v=1.0, a=5.0))
    assert np.abs(rows[:, 2]).max() < 5.0


def test_behind_a_way_back_it_is_no_faster_than_asked_for() -> None:
    points = [at([place, 0, 0, 0, 0, 0]) for place in (0.05, 0.1, 0.05, 0.0, -0.05)]
    rows = run(joints(pool(points), v=0.1, a=20.0))
    assert np.abs(rows[:, 1]).max() == pytest.approx(0.1, rel=0.02)


def test_a_thousand_dense_points_are_as_fast_as_one_line() -> None:
    dense = [at([0.001 * i, 0, 0, 0, 0, 0]) for i in range(1, CAPACITY + 1)]
    filled = pool(dense)
    rows = run(joints(filled, v=1.0, a=4.0))
    # half of the acceleration is kept for bends
    assert len(rows) * CYCLE == pytest.approx(1.0 / 1.0 + 1.0 / 2.0, rel=0.02)
    assert len(filled) == 0


def test_points_that_come_while_it_slows_down_for_the_last_one_wait_until_it_stands() -> None:
    filled = pool([at([0.5, 0, 0, 0, 0, 0])])
    follower = joints(filled)
    speeds = []
    for _ in range(20_000):
        speeds.append(follower.tick(NONE, NONE).qd[0])
        if len(speeds) > 200 and speeds[-1] < 0.8 * max(speeds):
            break
    filled.put([(tuple(at([1.0, 0, 0, 0, 0, 0])), None)])
    rows = run(follower)
    assert rows[-1, 0, 0] == pytest.approx(1.0, abs=1e-9)
    stands = np.flatnonzero(rows[:, 1, 0] == 0.0)
    assert rows[stands[0], 0, 0] == pytest.approx(0.5, abs=1e-6)


def test_points_that_come_in_time_keep_it_going() -> None:
    points = wave()
    filled = pool(points[:15])
    follower = joints(filled, v=0.5)
    speeds = []
    for point in points[15:]:
        while len(filled) > 10:
            speeds.append(np.abs(follower.tick(NONE, NONE).qd).max())
        filled.put([(tuple(point), None)])
    assert min(speeds[400:]) > 0.4


def test_a_pool_that_is_emptied_lets_the_arm_come_to_rest() -> None:
    filled = pool(wave())
    follower = joints(filled)
    for _ in range(800):
        point = follower.tick(NONE, NONE)
    assert point.qd[0] > 0.5
    filled.clear()
    rows = run(follower)
    assert np.abs(rows[:, 2]).max() < 5.0 * 1.05
    assert rows[-1, 0, 0] < 1.2
    assert (rows[-1, 1] == 0.0).all()


def test_events_of_points_are_told_when_they_are_reached() -> None:
    seen: list[tuple[str, float]] = []
    rows: list[float] = []
    filled = TrackPool()
    filled.put(
        (
            (tuple(at([0.1, 0, 0, 0, 0, 0])), lambda: seen.append(("a", rows[-1]))),
            (tuple(at([0.2, 0, 0, 0, 0, 0])), lambda: seen.append(("b", rows[-1]))),
        )
    )
    follower = joints(filled)
    while not follower.ended:
        rows.append(follower.tick(NONE, NONE).q[0])
    assert [name for name, _ in seen] == ["a", "b"]
    assert [q for _, q in seen] == pytest.approx([0.1, 0.2], abs=1e-3)


def test_pause_resume_and_stop() -> None:
    follower = joints(pool(wave()))
    for _ in range(500):
        follower.tick(NONE, NONE)
    follower.pause()
    for _ in range(1000):
        follower.tick(NONE, NONE)
    assert not follower.moving
    follower.resume()
    rows = run(follower)
    assert np.abs(rows[-1, 0] - wave()[-1]).max() < 1e-9
    follower = joints(pool(wave()))
    for _ in range(500):
        follower.tick(NONE, NONE)
    follower.stop()
    assert len(run(follower)) < 200


@pytest.mark.slow
def test_a_tool_goes_through_poses() -> None:
    start = Pose.from_matrix(FIVE.fkine(HOME))
    angles = np.linspace(0.0, np.pi, 40)[1:]
    goals = [
        start.shifted(x=0.1 * np.sin(a), z=0.1 * (np.cos(a) - 1)) @ Pose(0, 0, 0, 0, 0, 0.3 * a)
        for a in angles
    ]
    follower = ToolTrack(FIVE, HOME, CYCLE, pool(goals), 0.2, 1.0, tool=np.eye(4), wobj=np.eye(4))
    rows = run(follower)
    points = FIVE.fkine(rows[:, 0])[:, :3, 3]
    centre = np.array([start.x, start.y, start.z - 0.1])
    assert np.abs(np.linalg.norm(points - centre, axis=1) - 0.1).max() < 5e-4
    speed = np.linalg.norm(np.diff(points, axis=0), axis=1) / CYCLE
    assert speed.max() == pytest.approx(0.2, rel=0.02)
    assert Pose.from_matrix(FIVE.fkine(rows[-1, 0])).almost_equal(
        goals[-1], position=1e-6, rotation=1e-6
    )


@pytest.mark.parametrize(
    ("ahead", "v", "a", "most"),
    [(0.0, 0.5, 2.0, 2.0), (0.001, 0.05, 0.5, max(FIVE.acceleration))],
    ids=["on the spot", "with little way"],
)
def test_a_tool_that_turns_back_is_slowed_down_for_it(
    ahead: float, v: float, a: float, most: float
) -> None:
    start = Pose.from_matrix(FIVE.fkine(HOME))
    turns = [*np.arange(0.05, 0.5, 0.05), *np.arange(0.4, -0.01, -0.05)]
    goals = [
        start.shifted(x=-ahead * count) @ Pose(0, 0, 0, 0, 0, turn)
        for count, turn in enumerate(turns, 1)
    ]
    options: Any = {"tool": np.eye(4), "wobj": np.eye(4)}
    rows = run(ToolTrack(FIVE, HOME, CYCLE, pool(goals), v, a, **options))
    assert np.abs(rows[:, 2]).max() < most


def test_a_point_out_of_reach_ends_it() -> None:
    follower = ToolTrack(
        FIVE, HOME, CYCLE, pool([[5.0, 0, 0, 0, 0, 0]]), 0.2, 1.0, tool=np.eye(4), wobj=np.eye(4)
    )
    follower.tick(NONE, NONE)
    assert follower.failure is not None
    assert "reach" in str(follower.failure)


def test_a_point_that_left_the_pool_is_not_mistaken_for_another() -> None:
    filled = pool([[float(number)] * 6 for number in range(4)])
    filled.take_to(1)
    assert filled.get(2) == ((2.0,) * 6, None)
    assert filled.get(4) is None
    for number in (0, 1):
        with pytest.raises(FollowError, match="left the track pool"):
            filled.get(number)
