"""The limits of an envelope: their checks and their texts."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from for_each import for_each

from aioduco.envelope import (
    Crossing,
    Envelope,
    JointMargin,
    SingularityMargin,
    ToolForce,
    ToolSpeed,
    Zone,
)
from aioduco.envelope.checker import EnvelopeChecker
from aioduco.envelope.ways import Start, check_way, way_of
from aioduco.errors import ParameterError
from aioduco.kinematics import Arm, DhCorrections, arm
from aioduco.kinematics.forward import frames
from aioduco.models.pose import Joints, Pose
from aioduco.models.rotation import quaternion_from_matrix

ARM = arm("gcr5_910")
START = (0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)
TOOL = Pose(0.02, -0.03, 0.15, 0.1, 0.2, 0.3)
NONE = Pose(0, 0, 0, 0, 0, 0)
SPHERE = Zone.sphere((0, 0, 1), 0.2)


def checker(
    *limits: Any, tool: Pose = TOOL, by_tip: bool = False, known: Arm = ARM
) -> EnvelopeChecker:
    """A checker, with what it is told as it passes the process border."""
    packed = json.loads(json.dumps(Envelope(known, *limits).packed(tool)))
    return EnvelopeChecker(packed, by_tip=by_tip)


def tip_of(matrix: np.ndarray) -> tuple[float, ...]:
    return (*matrix[:3, :3].ravel().tolist(), *matrix[:3, 3].tolist())


#: of which the lengths alone have the tip some 20 mm elsewhere
CALIBRATED = replace(
    ARM,
    geometry=ARM.geometry._replace(
        corrections=DhCorrections(
            *map(tuple, np.random.default_rng(7).normal(0.0, 0.01, (4, 6)).tolist())
        )
    ),
)


@for_each("known", [ARM, CALIBRATED])
def test_places_are_those_of_the_kinematics(known: Arm) -> None:
    rng = np.random.default_rng(1)
    by_joints = checker(tool=TOOL, known=known)
    below = Zone.plane((0, 0, -2), (0, 0, 1))
    by_tip = checker(below, tool=TOOL, by_tip=True, known=known)
    for q in rng.uniform(-3, 3, (50, 6)):
        chain = frames(known.geometry, q)
        tip = chain[6] @ TOOL.matrix
        wanted = np.array([tip[:3, 3], chain[2][:3, 3], chain[6][:3, 3]])
        np.testing.assert_allclose(by_joints.places(tuple(q.tolist())), wanted, atol=1e-12)
        by_tip.seed = tuple((q + rng.uniform(-0.01, 0.01, 6)).tolist())
        np.testing.assert_allclose(by_tip.places(tip_of(tip)), wanted, atol=1e-9)


SHAPES = {
    "sphere": Zone.sphere((0.3, -0.2, 0.5), 0.2, bodies=("tool",)),
    "box": Zone.box((0.3, -0.2, 0.5, 0.4, -0.8, 1.2), (0.2, 0.4, 0.6), bodies=("tool",)),
    "plane": Zone.plane((0.3, -0.2, 0.5), (0.3, -0.8, 0.5), bodies=("tool",)),
}


@for_each("shape", SHAPES)
def test_margins_are_the_distances_that_mujoco_finds(shape: str) -> None:
    zone, radius = SHAPES[shape], 1e-6
    turn = np.array(zone.turn).reshape(3, 3)
    if shape == "plane":
        normal = np.array(zone.size)
        side = np.cross(normal, [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        turn = np.stack([side, np.cross(normal, side), normal], axis=1)
    quaternion = " ".join(map(str, quaternion_from_matrix(turn)))
    size = {"sphere": zone.size, "box": np.array(zone.size) / 2, "plane": (9, 9, 1)}[shape]
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody>
        <geom type="{shape}" pos="{" ".join(map(str, zone.at))}" quat="{quaternion}"
              size="{" ".join(map(str, size))}"/>
        <body mocap="true"><geom type="sphere" size="{radius}"/></body>
        </worldbody></mujoco>"""
    )
    data, seen = mujoco.MjData(model), checker(zone, tool=NONE)
    for q in np.random.default_rng(2).uniform(-3, 3, (60, 6)):
        found = seen.margins(tuple(q.tolist()))[0]
        data.mocap_pos[0] = found.place
        mujoco.mj_kinematics(model, data)
        distance = mujoco.mj_geomDistance(model, data, 0, 1, 5.0, None) + radius
        if distance > 0.01 or shape != "box":  # how deep it is in a box is another's convention
            assert found.margin == pytest.approx(distance, abs=1e-5)
        else:
            assert found.margin <= 0.01


def test_a_crossing_between_two_places_is_found() -> None:
    """Neither end is beyond the zone, and no corner of it is near."""
    needle = Zone.sphere((0.492, 0.1405 + 0.02, 0.442), 0.001, bodies=("tool",))
    look = checker(needle, tool=NONE)
    ends = [tuple(ARM.ikine(Pose(0.492, y, 0.442, math.pi, 0, -math.pi / 2), START).tolist())
            for y in (0.1405, 0.1845)]  # fmt: skip
    assert look.begin(ends[0]) is None
    found = look.sweep(ends[0], ends[1])
    assert found is not None
    assert (found.body, found.limit) == ("tool", "sphere to keep out")
    clear = checker(Zone.sphere((0.492, 0.1645, 0.46), 0.001, bodies=("tool",)), tool=NONE)
    assert clear.begin(ends[0]) is None
    assert clear.sweep(ends[0], ends[1]) is None


def test_a_joint_near_its_limit_is_named() -> None:
    look = checker(JointMargin(0.2, name="turns"))
    found = look.begin((0.0, 0.0, 1.5, 0.0, -1.5, 2 * math.pi - 0.1))
    assert found is not None
    assert (found.limit, found.body, found.unit) == ("turns", "joint 6", "rad")
    assert found.margin == pytest.approx(-0.1)


def test_a_sweep_through_a_singularity_is_found_though_its_ends_are_far_from_it() -> None:
    look = checker(SingularityMargin(0.05))
    assert look.begin(START) is None
    before = (0.0, 0.0, math.pi / 2, 0.0, -0.3, 0.0)
    behind = (0.0, 0.0, math.pi / 2, 0.0, 0.3, 0.0)
    assert look.begin(before) is None
    found = look.sweep(before, behind)
    assert found is not None
    assert (found.body, found.unit) == ("arm", "")


def test_slow_speed_passes_a_limit_that_slows() -> None:
    zone = Zone.box((0.492, 0.3, 0.442), (0.4, 0.2, 0.4), action="slow", speed=0.05)
    look = checker(zone, tool=NONE)
    assert look.times
    assert look.begin(START) is None
    inside = (0.4, *START[1:])
    found = look.sweep(START, inside, 0.06)
    assert found is not None
    assert (found.action, look.slow_speed(found.limit)) == ("slow", 0.05)
    assert look.sweep(START, inside, 0.05) is None


def test_where_it_stands_a_little_beyond_it_may_leave_and_not_go_further() -> None:
    at = ARM.fkine(START)[:3, 3]
    wall = Zone.plane((0, at[1] - 0.001, 0), (0, -1, 0), bodies=("tool",))
    look = checker(wall, tool=NONE)
    assert look.begin(START) is None
    assert look.sweep(START, (0.01, *START[1:])) is not None
    assert look.sweep(START, (-0.01, *START[1:])) is None
    deep = checker(Zone.plane((0, at[1] - 0.01, 0), (0, -1, 0), bodies=("tool",)), tool=NONE)
    assert deep.begin(START) is not None


def test_limits_of_one_name_are_numbered() -> None:
    envelope = Envelope("gcr5_910", ToolSpeed(0.5), ToolSpeed(0.2), ToolForce(50.0, name="push"))
    assert envelope.titles == ("tool speed", "tool speed 2", "push")
    assert "push" in repr(envelope)


def test_a_crossing_says_what_and_where() -> None:
    found = Crossing("table", "elbow", (0.1, 0.2, 0.3), -0.0123, "m", "refuse")
    assert str(found) == "'table': elbow at (0.100, 0.200, 0.300) m has a margin of -0.0123 m"
    slow = found._replace(action="slow")
    assert str(slow).startswith("'table' (there the tool must be slow): elbow at")
    assert str(found._replace(margin=-3e-8)).endswith("m is at the limit")


@for_each(
    "make",
    [
        lambda: Zone.sphere((0, 0, 0), 0.0),
        lambda: Zone.sphere((0, 0), 1.0),
        lambda: Zone.box((0, 0, math.nan), (1, 1, 1)),
        lambda: Zone.box((0, 0, 0), (1, -1, 1)),
        lambda: Zone.plane((0, 0, 0), (0, 0, 0)),
        lambda: Zone.plane((0, 0, 0), (0, 0, 1), bodies=("wrist",)),  # type: ignore[arg-type]  # it is refused
        lambda: Zone.plane((0, 0, 0), (0, 0, 1), bodies=()),
        lambda: Zone.box("123", "111"),  # type: ignore[arg-type]  # it is refused
        lambda: Zone.box({0.1, 0.2, 0.3}, (1, 1, 1)),  # type: ignore[arg-type]  # it has no order
        lambda: Zone.box(Joints(1, 1, 1, 0, 0, 0), (1, 1, 1)),
        lambda: Zone.box((True, False, True), (1, 1, 1)),
        lambda: replace(SPHERE, size=(math.nan,)),
        lambda: replace(SPHERE, size=(1.0, 1.0)),
        lambda: replace(SPHERE, at=(0.0, 0.0)),
        lambda: replace(SPHERE, at=(500.0, 0.0, 0.0)),
        lambda: replace(SPHERE, shape="ball"),  # type: ignore[arg-type]  # it is refused
        lambda: replace(SPHERE, shape="box"),
        lambda: replace(Zone.box((0, 0, 0), (1, 1, 1)), turn=(1.0, 0.0, 0.0)),
        lambda: replace(Zone.box((0, 0, 0), (1, 1, 1)), turn=(2.0, 0, 0, 0, 2.0, 0, 0, 0, 2.0)),
        lambda: replace(Zone.plane((0, 0, 0), (0, 0, 1)), size=(0.0, 0.0, 0.0)),
        lambda: replace(Zone.plane((0, 0, 0), (0, 0, 1)), keep="out"),
        lambda: ToolSpeed(0.0),
        lambda: ToolSpeed(0.1, action="ignore"),  # type: ignore[arg-type]  # it is refused
        lambda: SingularityMargin(1.5),
        lambda: JointMargin("5°"),  # type: ignore[arg-type]  # it is refused
        lambda: Envelope("gcr5_911"),
        lambda: Envelope("gcr5_910", 0.5),  # type: ignore[arg-type]  # it is refused
        lambda: Envelope("gcr5_910", *[ToolSpeed(0.5)] * 101),
    ],
)
def test_what_is_no_limit_is_refused(make: Any) -> None:
    with pytest.raises(ParameterError):
        make()


def test_the_normal_of_a_changed_plane_has_length_one_too() -> None:
    plane = Zone.plane((0, 0, 0), (0, 0, 1))
    assert replace(plane, size=(0, 0, 10)) == plane
    slanted = Zone.plane((0, 0, 0), (1, 2, 3))
    assert replace(slanted, name="") == slanted


@for_each(
    "make",
    [
        lambda: Zone.box((500, 300, 200), (0.3, 0.2, 0.4)),
        lambda: Zone.box((0, 0, 0.2), (300, 200, 400)),
        lambda: Zone.box((500, 300, 200, 0, 0, 1.57), (0.3, 0.2, 0.4)),
        lambda: Zone.sphere((0, 0, 0), 800, keep="in"),
        lambda: Zone.plane((0, 0, -200), (0, 0, 1)),
    ],
)
def test_millimetres_are_no_zone_that_no_arm_ever_meets(make: Any) -> None:
    with pytest.raises(ParameterError, match=r"\(millimetres\?\)"):
        make()


@for_each(
    "make",
    [lambda: ToolSpeed(250), lambda: Zone.plane((0, 0, 0), (0, 0, 1), action="slow", speed=100)],
)
def test_millimetres_per_second_are_no_limit_that_holds_nothing(make: Any) -> None:
    with pytest.raises(ParameterError, match="must be a number above 0, up to 20 m/s"):
        make()


@for_each("function", ["movec", "move_circle"])
def test_a_circle_through_points_close_together_is_as_large_as_it_is(function: str) -> None:
    """Points half a millimetre apart, and less than a micrometre off a line: taken for a line."""
    here = Pose.from_matrix(ARM.fkine(START))
    points = here.shifted(x=-1e-3), here.shifted(x=-5e-4, z=5e-7)
    sides = [1e-3, 5e-4, 5e-4]
    radius = math.prod(sides) / (4 * (1e-3 * 5e-7 / 2))
    way = way_of(ARM, function, (*points, 0.1, 0.1, 0.0, 1, None, "", ""), Start(START, NONE, NONE))
    assert way is not None
    furthest = max(math.dist(each[9:], here[:3]) for each in way.configs)
    assert furthest == pytest.approx(2 * radius, rel=1e-3)


def test_a_line_beside_a_singularity_is_followed_on_its_branch() -> None:
    """From a nearly stretched arm: the other elbow was nearer, and half a metre elsewhere."""
    start = (1.302992, -1.732852, -0.001245, -1.280740, 0.146806, 1.280101)
    here = ARM.fkine(start)
    to = Pose(-0.318419, -0.19721, -0.303645, -2.5663, -0.125788, 2.590429)
    end = np.array([0.961348, -1.728597, -1.999298, 2.740390, 1.497340, -0.117605])
    elbow = frames(ARM.geometry, end)[2][:3, 3]
    args = (to, 0.1, 0.1, 0.0, None, "", "")
    way = way_of(ARM, "movel", args, Start(start, NONE, NONE))
    assert way is not None
    assert math.dist(way.configs[0][9:], here[:3, 3]) < 1e-9
    np.testing.assert_allclose(way.end, end, atol=1e-3)
    limit = Zone.sphere(elbow.tolist(), 0.05, bodies=("elbow",))
    line = checker(limit, tool=NONE, by_tip=True)
    line.seed = start
    found, _ = check_way(line, way)
    assert found is not None
    assert found.body == "elbow"


@for_each("nearest", [0.0, 0.002, 0.02])
def test_a_line_beside_a_singularity_comes_too_close_to_it(nearest: float) -> None:
    middle = np.array([0.3, -0.2, 1.6, 0.1, nearest, 0.4])
    passed, q = ARM.fkine(middle), middle
    across = np.array([-math.sin(0.3), math.cos(0.3), 0.0])
    ends = [passed.copy(), passed.copy()]
    ends[0][:3, 3] -= 0.06 * across
    ends[1][:3, 3] += 0.06 * across
    for share in np.linspace(0.0, 1.0, 600):
        at = passed.copy()
        at[:3, 3] -= share * 0.06 * across
        q = ARM.ikine(at, q)
    args = (Pose.from_matrix(ends[1]), 0.1, 0.1, 0.0, None, "", "")
    way = way_of(ARM, "movel", args, Start(tuple(q.tolist()), NONE, NONE))
    assert way is not None
    line = checker(SingularityMargin(0.05), tool=NONE, by_tip=True)
    line.seed = tuple(q.tolist())
    assert min(line.margins(way.configs[0]), key=lambda each: each.margin).margin > 0.0
    found, _ = check_way(line, way)
    assert found is not None
    assert found.body == "arm"


def test_margins_leave_out_a_zone_of_bodies_whose_places_are_not_known() -> None:
    """The elbow, for a pose of the tool that no joints reach."""
    seen = checker(
        Zone.plane((0, 0, -2), (0, 0, 1), bodies=("elbow",), name="elbow"),
        Zone.plane((0, 0, -2), (0, 0, 1), bodies=("tool", "elbow"), name="both"),
        by_tip=True,
    )
    seen.seed = START
    far = np.eye(4)
    far[:3, 3] = 5.0, 0.0, 0.0
    assert [(each.limit, each.body) for each in seen.margins(tip_of(far))] == [("both", "tool")]
