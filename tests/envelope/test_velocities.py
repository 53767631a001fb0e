"""The paths of velocities, jogs and servo set-points, as the simulated controller makes them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco import Jog, JogDirections, JogFrame
from aioduco.envelope import Envelope, Zone
from aioduco.envelope.checker import BESIDE, STOPPING, EnvelopeChecker
from aioduco.envelope.servo import check_servo, servo_ways
from aioduco.envelope.velocities import Ahead, velocity_way
from aioduco.envelope.ways import Start, Way, check_way, joint_way, polyline
from aioduco.models.pose import Pose
from aioduco.sim.planner.velocity_follower import JointVelocity, ToolVelocity

from .trials import ARM, START, TOOL, least, places, random_zones

WOBJ = Pose(0.1, 0.2, 0.3, 0.4, -0.5, 0.6)
#: reaches its velocity at once
SUDDEN = replace(ARM, acceleration=(1e9,) * 6)
Q = tuple((START + 0.1).tolist())
CYCLE = 1e-3
SECONDS = 0.3
OLDER = JogDirections.MANUAL_3_8
BASE = np.eye(3)


def jog(axis: str, frame: JogFrame, sense: int = 1) -> Ahead:
    made = Jog.cartesian(axis, sense, 80.0, frame=frame)  # type: ignore[arg-type]
    return Ahead("move_jog", (made.wire(OLDER), False), sense)


def way_of(motion: Ahead, seconds: float = SECONDS) -> Way | None:
    return velocity_way(ARM, motion, Start(Q, TOOL, WOBJ), seconds)


def along(axis: int, speed: float) -> list[float]:
    return [speed if number == axis else 0.0 for number in range(6)]


MOTIONS: list[tuple[Ahead, list[float], Any]] = [
    (Ahead("speedl", ([0.2, -0.1, 0.1, 0, 0, 0], 1.0, -1, False), 0),
     [0.2, -0.1, 0.1, 0, 0, 0], None),
    (Ahead("speedl", ([0.2, 0.1, -0.1, 0.5, -1.0, 2.0], 1.0, -1, False), 0),
     [0.2, 0.1, -0.1, 0.5, -1.0, 2.0], None),
    (jog("y", JogFrame.BASE), along(1, 0.2), BASE),
    (jog("rz", JogFrame.BASE, -1), along(5, -0.4), BASE),
    (jog("x", JogFrame.TOOL, -1), along(0, -0.2), None),
    (jog("ry", JogFrame.TOOL), along(4, 0.4), None),
    (jog("z", JogFrame.WORK_OBJECT), along(2, 0.2), WOBJ.matrix[:3, :3]),
]  # fmt: skip


@pytest.mark.parametrize(("motion", "twist", "frame"), MOTIONS)
def test_the_tool_goes_where_the_path_leads(
    motion: Ahead, twist: list[float], frame: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "aioduco.envelope.velocities.STOPPING", math.inf
    )  # it ends where the reaction does
    way = way_of(motion)
    assert way is not None
    follower = ToolVelocity(SUDDEN, np.array(Q), CYCLE, TOOL.matrix, frame)
    follower.aim(np.array(twist), 1e9)
    for number in range(1, round(SECONDS / CYCLE) + 1):
        q = follower.tick(np.array(Q), np.zeros(6)).q
        if number % 30 == 0:
            there = way.at([number * CYCLE / SECONDS])[0]
            tip = ARM.fkine(q) @ TOOL.matrix
            np.testing.assert_allclose(there[9:], tip[:3, 3], atol=2e-4)
            np.testing.assert_allclose(there[:9], tip[:3, :3].ravel(), atol=2e-3)
    np.testing.assert_allclose(way.configs[-1], there, atol=1e-12)


@for_each("kind", ["speedj", "jog"])
def test_the_joints_go_where_the_path_leads(kind: str) -> None:
    """And so far beyond it that they have come to rest there."""
    speeds = along(2, -0.4)
    made = Jog.joint(3, -1, 80.0)
    motion = Ahead("move_jog", (made.wire(OLDER), False), -1)
    if kind == "speedj":
        motion = Ahead("speedj", (speeds, 1.0, -1, False), 0)
    way = way_of(motion)
    assert way is not None
    follower = JointVelocity(SUDDEN, np.array(Q), CYCLE)
    follower.aim(np.array(speeds), 1e9)
    for _ in range(round(SECONDS / CYCLE)):
        q = follower.tick(np.array(Q), np.zeros(6)).q
    braking = -(0.4**2) / (2 * STOPPING)
    assert way.configs[-1] == pytest.approx((q + along(2, braking)).tolist(), abs=1e-3)
    assert way.v == pytest.approx(0.4)


def test_a_velocity_that_the_controller_ends_sooner_leads_less_far() -> None:
    ways = [
        way_of(Ahead("speedj", (along(0, 0.4), 1.0, time, False), 0)) for time in (-1, 1000, 100)
    ]
    ends = [way.configs[-1][0] - Q[0] for way in ways if way is not None]
    assert ends[0] == ends[1]
    assert ends[2] == pytest.approx(ends[0] - 0.4 * (SECONDS - 0.1))


def test_the_world_of_a_jog_is_not_known() -> None:
    assert way_of(jog("x", JogFrame.WORLD)) is None


def test_a_step_is_known_to_its_end() -> None:
    made = Jog.cartesian("z", -1, 10.0, step=0.07)
    way = way_of(Ahead("move_jog", (made.wire(OLDER), False), -1), 9.0)
    assert way is not None
    moved = np.array(way.configs[-1][9:]) - np.array(way.configs[0][9:])
    np.testing.assert_allclose(moved, [0, 0, -0.07], atol=1e-12)
    made = Jog.joint(4, 1, 10.0, step=0.3)
    way = way_of(Ahead("move_jog", (made.wire(OLDER), False), 1), 9.0)
    assert way is not None
    assert np.array(way.configs[-1]) - Q == pytest.approx(along(3, 0.3))


# -- leaving a limit, and what is known to be within it -----------------------------------------


def checker(*limits: Any) -> EnvelopeChecker:
    return EnvelopeChecker(Envelope(ARM, *limits).packed(TOOL))


@for_each("depth, shape", product([BESIDE / 2, 0.05], ["plane", "sphere", "box", "keep in"]))
def test_limits_are_left_straight_and_not_crossed_again(shape: str, depth: float) -> None:
    tip = places(START)[0, 0]
    far = 0.3
    zone = {
        "plane": Zone.plane((0, tip[1] - depth, 0), (0, -1, 0), bodies=("tool",)),
        "sphere": Zone.sphere((tip[0], tip[1] + far - depth, tip[2]), far, bodies=("tool",)),
        "box": Zone.box(
            (tip[0], tip[1] + far - depth, tip[2]), (0.4, 2 * far, 0.4), bodies=("tool",)
        ),
        "keep in": Zone.sphere((0, 0, tip[2]), math.hypot(tip[0], tip[1]) - depth, keep="in",
                               bodies=("tool",)),
    }[shape]  # fmt: skip
    assert least((zone,), START) == pytest.approx(-depth, abs=1e-9)
    look, q = checker(zone), tuple(START.tolist())
    out = (-0.5, *q[1:]) if shape != "keep in" else (*q[:2], q[2] + 0.3, *q[3:])
    deeper = (0.02, *q[1:]) if shape != "keep in" else (*q[:2], q[2] - 0.1, *q[3:])
    assert check_way(look, joint_way(q, out, 1.0))[0] is None
    assert check_way(look, joint_way(q, deeper, 1.0))[0] is not None
    # out, and in again
    found, _ = check_way(look, polyline([q, out, deeper], 1.0))
    assert found is not None
    assert (check_way(look, joint_way(q, q, 1.0))[0] is None) == (depth < BESIDE)


def test_other_limits_hold_while_one_is_left() -> None:
    tip = places(START)[0, 0]
    left = Zone.plane((0, tip[1] - 0.05, 0), (0, -1, 0), bodies=("tool",), name="left")
    other = Zone.plane((0, tip[1] - 0.1, 0), (0, 1, 0), bodies=("tool",), name="other")
    look, q = checker(left, other), tuple(START.tolist())
    found, _ = check_way(look, joint_way(q, (-0.5, *q[1:]), 1.0))
    assert found is not None
    assert found.limit == "other"


@pytest.mark.parametrize("seed", range(8))
def test_what_is_known_is_not_looked_at_again_and_decides_alike(seed: int) -> None:
    """A loop of set-points, each judged as if the arm's position were new."""
    rng = np.random.default_rng(seed)
    here = START + rng.uniform(-0.4, 0.4, 6)
    zones = random_zones(rng, here)
    known, new = checker(*zones), checker(*zones)
    q = last = tuple(here.tolist())
    way = rng.uniform(-1.0, 1.0, 6)
    refused = 0
    for number in range(60):
        target = tuple((here + 0.02 * number * way + rng.uniform(-0.01, 0.01, 6)).tolist())
        paths = servo_ways(q, last, target, 1.0)
        found, _ = check_servo(known, q, last, target, 1.0)
        judged = [check_way(new, path)[0] for path in paths]
        assert (found is None) == (not any(judged))
        for path in paths:
            for a, b in pairwise(path.configs):
                assert max(abs(x - y) for x, y in zip(a, b, strict=True)) <= 0.02 + 1e-9
        if found is not None:
            refused += 1
            continue
        assert least(zones, np.array([path.configs[-1] for path in paths])) >= -1e-9
        q, last = last, target
    assert refused < 60


def test_each_joint_turns_at_its_own_pace() -> None:
    q = tuple(START.tolist())
    target = (q[0] + 0.5, q[1] - 0.2, q[2] + 0.2, *q[3:])
    (way,) = servo_ways(q, q, target, 1.0)
    configs = np.array(way.configs)
    turned = np.abs(configs - np.array(q))
    np.testing.assert_allclose(turned[:, 1], np.minimum(turned[:, 0], 0.2), atol=1e-12)
    assert way.configs[-1] == target
    assert len(servo_ways(q, (q[0] + 0.1, *q[1:]), target, 1.0)) > 3
