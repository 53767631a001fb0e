"""Random streams through a worker's generator, without a controller: each set-point is judged."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from aioduco.envelope import Crossing, Envelope, JointMargin, SingularityMargin, ToolSpeed, Zone
from aioduco.envelope.checker import EnvelopeChecker
from aioduco.kinematics.forward import frames
from aioduco.streaming.shared.space import JOINT_SPACE, Config, Limits
from aioduco.streaming.worker.checked import EnvelopeCheck
from aioduco.streaming.worker.setpoints import PositionGenerator

from .trials import ARM, ROUNDING, START, TOOL, least, places, random_zones

PERIOD = 0.004
LIMITS = Limits((2.0,) * 6, (10.0,) * 6, (100.0,) * 6)


class Joints:
    """Set-points that are joints."""

    kind: type[EnvelopeChecker] = EnvelopeChecker

    def __init__(self, *limits: Any) -> None:
        packed = json.loads(json.dumps(Envelope(ARM, *limits).packed(TOOL)))
        self.checker = self.kind(packed)

    def seen(self, config: Config) -> Sequence[float]:
        return config


def stream(way: str, targets: np.ndarray, *limits: Any) -> tuple[np.ndarray, list[Crossing]]:
    """The set-points on the way along the targets, until it comes to rest; and what it crossed.

    Without limits it is followed wherever it leads.
    """
    start = tuple(targets[0].tolist())
    crossed: list[Crossing] = []
    check = None
    if limits:
        joints = Joints(*limits)
        check = EnvelopeCheck(
            *(joints.checker, joints.seen, JOINT_SPACE, PERIOD, start, crossed.append),
            curved=way == "ruckig",
        )
        assert check.begin() is None
    generator = PositionGenerator(way, JOINT_SPACE, LIMITS, PERIOD, start, check=check)
    sent = [start]
    for target in targets[1:]:
        generator.aim(tuple(target.tolist()), PERIOD, PERIOD)
        sent.append(generator.step())
        if crossed:
            break
    while not generator.at_rest:
        sent.append(generator.brake())
        assert len(sent) < 10_000
    return np.array(sent), crossed


class CountingChecker(EnvelopeChecker):
    """Counts how often a zone is looked at closely."""

    looks = 0

    def _sweep_zone(self, *given: Any) -> Crossing | None:
        type(self).looks += 1
        return super()._sweep_zone(*given)


class PlainChecker(CountingChecker):
    """Looks at each zone in each sweep."""

    def clear(self, start: Sequence[float], more: float) -> bool:
        """Nothing is clear without a look."""
        del start, more
        return False

    def _near(self, start: Sequence[float], elbow: float, wrist: float) -> bool:
        """Each zone may be near."""
        del start, elbow, wrist
        for zone in self._zones:
            zone.near = True
        return True


def wander(rng: np.random.Generator) -> np.ndarray:
    """Targets that wander off, now and then by a jump."""
    here = START + rng.uniform(-0.4, 0.4, 6)
    shares = (1 - np.cos(np.linspace(0, math.pi, 150))) / 2
    one, two = rng.uniform(-0.8, 0.8, (2, 6))
    targets = np.concatenate([here + shares[:, None] * one, here + one + shares[:, None] * two])
    if rng.random() < 0.3:
        targets[rng.integers(50, 250) :] += rng.uniform(-0.3, 0.3, 6)
    return targets


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_what_is_left_out_changes_no_decision(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same set-points, bit for bit, and the same crossing as if every zone were looked at."""
    rng = np.random.default_rng(seed)
    CountingChecker.looks = PlainChecker.looks = 0
    ended = 0
    for number in range(9):
        way = ("none", "cubic", "ruckig")[number % 3]
        targets = wander(rng)
        limits: list[Any] = [
            replace(zone, action="slow", speed=0.05) if rng.random() < 0.15 else zone
            for _ in range(3)
            for zone in random_zones(rng, targets[0], room=0.02)
        ]
        if number % 2:
            margins = JointMargin(rng.uniform(0.1, 1.5)), SingularityMargin(rng.uniform(0.01, 0.3))
            start = tuple(targets[0].tolist())
            limits += [each for each in margins if Joints(each).checker.begin(start) is None]
        found = []
        for kind in (CountingChecker, PlainChecker):
            monkeypatch.setattr(Joints, "kind", kind)
            sent, crossed = stream(way, targets, *limits)
            found.append((sent.tobytes(), crossed))
        assert found[0] == found[1]
        ended += bool(found[0][1])
    assert ended > 0
    assert CountingChecker.looks < PlainChecker.looks / 3


@pytest.mark.cases(1)
@pytest.mark.parametrize("seed", range(8))
def test_the_same_holds_for_poses_of_the_tool(seed: int) -> None:
    """With zones for the elbow, too, which need the joints."""
    rng = np.random.default_rng(seed)
    CountingChecker.looks = PlainChecker.looks = 0
    for _ in range(3):
        joints = wander(rng)
        tips = frames(ARM.geometry, joints)[:, 6] @ TOOL.matrix
        configs = [(*tip[:3, :3].ravel().tolist(), *tip[:3, 3].tolist()) for tip in tips[:150]]
        packed = Envelope(ARM, *random_zones(rng, joints[0])).packed(TOOL)
        found = []
        for kind in (CountingChecker, PlainChecker):
            checker = kind(packed, by_tip=True)
            checker.seed = tuple(joints[0].tolist())
            checker.begin(configs[0])
            found.append([checker.sweep(*two) for two in pairwise(configs)])
        assert found[0] == found[1]
    assert CountingChecker.looks < PlainChecker.looks / 2


def test_a_way_between_poses_that_no_joints_reach_is_checked() -> None:
    """Its ends are clear of the zone that it leads through."""
    far = Zone.sphere((3.0, 0.0, 0.5), 0.1, bodies=("tool",))
    other = Zone.sphere((0.0, 0.0, -5.0), 0.1, bodies=("elbow",))  # so that joints are sought
    checker = EnvelopeChecker(Envelope(ARM, far, other).packed(TOOL), by_tip=True)
    checker.seed = tuple(START.tolist())
    one, two = ((1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0, 3.0, y, 0.5) for y in (-0.5, 0.5))
    assert checker.begin(one) is None
    found = checker.sweep(one, two)
    assert found is not None
    assert found.limit == far.title


@pytest.mark.parametrize("way", ["none", "cubic", "ruckig"])
def test_no_set_point_is_beyond_a_zone(way: str, thorough: bool) -> None:
    """And each keeps to the stream's limits, also while it brakes before a zone."""
    rng = np.random.default_rng(sum(way.encode()))
    # Straight ahead, where it could not stop, is not where the targets lead.
    ahead = 0.3 if way == "ruckig" else 0.15
    ended = outside = 0
    for _ in range(40 if thorough else 5):
        targets = wander(rng)
        zones = random_zones(rng, targets[0])
        sent, crossed = stream(way, targets, *zones)
        assert least(zones, sent) >= -ROUNDING, zones
        speed = np.diff(sent, axis=0) / PERIOD
        assert np.abs(speed).max() <= LIMITS.velocity[0] * (1 + 1e-6)
        assert np.abs(np.diff(speed, axis=0)).max() / PERIOD <= LIMITS.acceleration[0] * (1 + 1e-6)
        free, _ = stream(way, targets)
        outside += least(zones, free) < -0.01
        ended += bool(crossed)
        if least(zones, targets) < -0.01 and not crossed:
            # what a limiter cuts short may pass a zone by
            assert least(zones, free) > -0.05
        if crossed:
            assert min(least(zones, targets), least(zones, free)) < ahead, "ended for nothing"
    # Without the check many of them are beyond a zone.
    assert outside >= 1
    assert ended >= outside


def test_it_comes_near_to_a_wall_before_it_ends() -> None:
    targets = START + np.linspace(0, 1, 250)[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    at = places(START)[0, 0]
    wall = Zone.plane((0, at[1] + 0.1, 0), (0, -1, 0), bodies=("tool",))
    sent, crossed = stream("none", targets, wall)
    assert len(crossed) == 1
    assert 0 <= least((wall,), sent) < 0.005
    assert crossed[0].limit == "plane to keep in"


@pytest.mark.parametrize("way", ["none", "ruckig"])
def test_a_tool_that_is_too_fast_is_slowed(way: str) -> None:
    """To less than the limit, so that the watch of the state does not stop the arm."""
    targets = START + np.linspace(0, 0.5, 250)[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    sent, crossed = stream(way, targets, ToolSpeed(0.1, action="slow"))
    assert not crossed
    speed = np.linalg.norm(np.diff(places(sent)[:, 0], axis=0), axis=1) / PERIOD
    assert speed.max() <= 0.09 + 1e-4
    assert speed.mean() > 0.05


def test_a_stream_ends_before_the_tool_is_too_fast_and_no_slower_than_it_may_be() -> None:
    """A jerk limit lets it speed up for a while after it begins to brake."""
    rise = np.linspace(0, 1.0, 250)
    targets = START + (0.5 * rise**2)[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    for way in ("none", "ruckig"):
        sent, crossed = stream(way, targets, ToolSpeed(0.1))
        assert [each.limit for each in crossed] == ["tool speed"]
        speed = np.linalg.norm(np.diff(places(sent)[:, 0], axis=0), axis=1) / PERIOD
        assert 0.08 < speed.max() <= 0.1 + 1e-4


@pytest.mark.parametrize("way", ["none", "ruckig"])
@pytest.mark.parametrize(
    "limit",
    [
        Zone.plane((0, 10.0, 0), (0, 1, 0), action="slow", speed=0.1),
        Zone.box((0, 0, 0), (3, 3, 3), action="slow", speed=0.1, bodies=("elbow",)),
        JointMargin(5.0, action="slow", speed=0.1),
        SingularityMargin(0.99, action="slow", speed=0.1),
    ],
    ids=["plane", "elbow", "joints", "singular"],
)
def test_a_stream_that_begins_where_it_is_slowed_goes_on_slowly(way: str, limit: Any) -> None:
    end = np.array([-0.3, 0.02, 0.02, 0, 0, 0])
    crossed: list[Crossing] = []
    joints = Joints(limit)
    start = tuple(START.tolist())
    check = EnvelopeCheck(
        *(joints.checker, joints.seen, JOINT_SPACE, PERIOD, start, crossed.append),
        curved=way == "ruckig",
    )
    assert check.begin() is None
    generator = PositionGenerator(way, JOINT_SPACE, LIMITS, PERIOD, start, check=check)
    target = tuple((START + end).tolist())
    generator.aim(target, PERIOD, PERIOD)
    sent = [start]
    while max(abs(a - b) for a, b in zip(sent[-1], target, strict=True)) > 0.01:
        sent.append(generator.step())
        assert not crossed
        assert len(sent) < 1500
    speed = np.linalg.norm(np.diff(places(np.array(sent))[:, 0], axis=0), axis=1) / PERIOD
    assert 0.06 < speed.max() <= 0.092


def test_a_stream_is_slowed_beyond_a_zone_alone() -> None:
    targets = START + np.linspace(0, 0.5, 250)[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    wall = places(START)[0, 0, 1] + 0.08
    zone = Zone.plane((0, wall, 0), (0, -1, 0), action="slow", speed=0.1, bodies=("tool",))
    sent, crossed = stream("none", targets, zone)
    assert not crossed
    tool = places(sent)[:, 0]
    speed = np.linalg.norm(np.diff(tool, axis=0), axis=1) / PERIOD
    beyond = tool[1:, 1] > wall
    assert beyond.any()
    assert speed[~beyond].max() > 0.2
    assert speed[beyond].max() <= 0.1 + 1e-9
