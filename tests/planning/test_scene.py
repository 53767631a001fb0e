"""Scenes: what the arm touches, how far it is from it, and what may be done with a scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from interpreter import python

from aioduco import Joints, Load, ParameterError, Pose, SceneError
from aioduco.descriptions import ToolDescription
from aioduco.envelope import Zone
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics import calibrate_tool_tip, check, identify_load_by_torques, models
from aioduco.planning import Ground, Mesh, Planner, PointCloud, Region, Scene
from aioduco.sim import Simulator
from aioduco.sim.physics.world import World
from aioduco.sim.scene import Box, Cylinder, Rod, Sphere, Table, mjcf_of
from aioduco.testing.preflight.margins import margins

READY = Joints.deg(0, 0, 90, 0, -90, 0)


@for_each("model", models())
def test_an_arm_that_stands_ready_is_free(model: str) -> None:
    scene = Scene(model)
    assert not scene.collides(READY)
    assert scene.clearance(READY).distance > 0.01


@for_each("radius", [0.02, 0.05])
def test_a_distance_is_that_of_the_geometry(radius: float) -> None:
    """A sphere under the flange's face: the flange's disc ends at the flange's origin."""
    scene = Scene("gcr5_910")
    tip = scene.arm.fkine(READY)
    below = tip @ np.array([0.0, 0.0, radius + 0.03, 1.0])
    scene.add(Sphere(at=tuple(below[:3]), radius=radius, name="ball"))
    found = scene.clearance(READY)
    assert found.pair is not None
    # The wrist's round housing ends at the same height.
    assert found.pair[0] in ("flange", "link5")
    assert found.distance == pytest.approx(0.03, abs=1e-6)
    assert "is 30.0 mm from ball" in str(found)


@pytest.mark.parametrize(
    "thing",
    [
        Box(at=(0.492, 0.1405, 0.42), size=(0.1, 0.1, 0.1), name="it"),
        Cylinder(at=(0.492, 0.1405, 0.42), radius=0.05, length=0.1, name="it"),
        Sphere(at=(0.492, 0.1405, 0.42), radius=0.05, name="it"),
        Mesh(
            at=(0.492, 0.1405, 0.42),
            vertices=[
                [x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)
            ],
            name="it",
        ),
        PointCloud(
            at=(0.492, 0.1405, 0.435), points=[[0.0, 0.0, 0.0], [0.03, 0.0, 0.0]], name="it"
        ),
        Ground(at=(0.0, 0.0, 0.45), name="it"),
    ],
    ids=lambda thing: type(thing).__name__,
)
@pytest.mark.cases(6)
def test_every_kind_of_thing_is_touched(thing: Box) -> None:
    scene = Scene("gcr5_910", [thing])
    found = scene.clearance(READY)
    assert found.distance < 0.0
    assert found.pair is not None
    assert found.pair[1] == "it"
    scene.move("it", (0.0, 5.0, -5.0))
    assert not scene.collides(READY)


def test_a_box_and_the_mesh_of_its_corners_are_equally_far() -> None:
    half = 0.06
    corners = [[x, y, z] for x in (0, 2 * half) for y in (0, 2 * half) for z in (0, 2 * half)]
    box = Scene("gcr5_910", [Box(at=(0.75, 0.1, 0.5), size=(2 * half,) * 3, name="it")])
    mesh = Scene(
        "gcr5_910", [Mesh(at=(0.75 - half, 0.1 - half, 0.5 - half), vertices=corners, name="it")]
    )
    random = np.random.default_rng(0)
    seen = 0
    for _ in range(200):
        q = Joints.of(READY.array + random.uniform(-0.4, 0.4, 6))
        one, other = box.clearance(q), mesh.clearance(q)
        if one.pair is not None and one.pair[1] == "it" and one.distance > 0.0:
            seen += 1
            assert other.distance == pytest.approx(one.distance, abs=1e-5)
    assert seen > 5


def test_a_cloud_of_points_is_as_far_as_its_nearest_point() -> None:
    tip = Scene("gcr5_910").arm.fkine(READY)
    random = np.random.default_rng(1)
    points = random.uniform(-0.3, 0.3, (400, 3)) - np.array([0.0, 0.0, 0.37])
    cloud = PointCloud(at=tuple(tip[:3, 3]), points=points, radius=0.01, name="cloud")
    near = Scene("gcr5_910", [cloud]).clearance(READY)
    spheres = [
        Sphere(at=tuple(tip[:3, 3] + point), radius=0.01)
        for point in points[np.argsort(-points[:, 2])[:10]]
    ]
    nearest = Scene("gcr5_910", spheres).clearance(READY).distance
    assert near.distance <= nearest + 1e-9
    assert near.distance < 0.09


def test_the_nearest_thing_is_found_behind_thousands_of_points() -> None:
    tip = Scene("gcr5_910").arm.fkine(READY)
    points = np.random.default_rng(1).uniform(-0.1, 0.1, (2000, 3))
    cloud = PointCloud(at=(*tip[:2, 3], 1.2), points=points, radius=0.003, name="cloud")
    ball = Sphere(at=tuple((tip @ (0.0, 0.0, 0.05, 1.0))[:3]), radius=0.02, name="ball")
    scene = Scene("gcr5_910", [cloud, ball])
    found = scene.checker().clearance(READY.array, 1.5, itself=False)
    assert found.pair is not None
    assert found.pair[1] == "ball"


def test_things_have_names_and_can_be_taken_away() -> None:
    scene = Scene("gcr5_910", [Box(name="one"), Box()])
    assert [thing.name for thing in scene] == ["one", "thing2"]
    with pytest.raises(SceneError, match="a thing called 'one' already"):
        scene.add(Box(name="one"))
    before = scene.revision
    scene.remove("one")
    assert "one" not in scene
    assert scene.revision > before
    with pytest.raises(SceneError, match="nothing is called 'one'"):
        scene.remove("one")
    with pytest.raises(ParameterError, match="padding"):
        Scene("gcr5_910", padding=0.0)


@for_each("name", ["link3", "base", "flange", "tool", "floor", "world"])
def test_no_thing_is_called_like_a_part_of_the_arm_and_no_part_is_held(name: str) -> None:
    """Allowed to touch link5, such a thing called link3 let the arm touch itself."""
    scene = Scene("gcr5_910", [Box(at=(0.5, 0.0, 0.1), name="part")], tool=[Rod()])
    with pytest.raises(SceneError, match="another name"):
        scene.add(Box(name=name))
    for other in (name, "scene/part"):
        with pytest.raises(SceneError, match="could hold: part"):
            scene.attach(other, READY)
    assert not scene.attached


def test_no_flange_holds_a_plane_without_an_end() -> None:
    scene = Scene("gcr5_910", [Ground(at=(0.0, 0.0, -0.5), name="table")])
    with pytest.raises(SceneError, match="plane without an end"):
        scene.attach("table", READY)
    assert scene.clearance(READY)


def test_what_is_held_moves_with_the_arm_and_stays_where_it_is_let_go() -> None:
    part = Box(at=(0.45, 0.1, 0.35), size=(0.04, 0.04, 0.04), name="part")
    scene = Scene("gcr5_910", [part], tool=[Rod(length=0.05)])
    turned = Joints.deg(40, 0, 90, 0, -90, 0)
    before = scene.arm.fkine(READY)
    scene.attach("part", READY)
    assert scene.attached == ("part",)
    post = Cylinder(at=(0.0, 0.0, 0.0), radius=0.02, length=0.1, name="post")
    place = scene.arm.fkine(turned) @ np.linalg.inv(before) @ np.array([*part.at, 1.0])
    scene.add(post)
    scene.move("post", tuple(place[:3]))
    assert scene.clearance(READY).distance > 0.0
    assert scene.clearance(turned).pair == ("part", "post")
    scene.allow("part", "post")
    assert not scene.collides(turned)
    scene.detach("part", turned)
    assert scene["part"].at[:3] == pytest.approx(place[:3], abs=1e-9)
    assert not list(scene.attached)
    with pytest.raises(SceneError, match="is held"):
        scene.detach("part", turned)
    for change in (scene.attach, scene.detach):
        scene.attach("part", turned)
        with pytest.raises(ParameterError, match="not degrees"):
            change("part", turned.degrees)


def test_a_contact_that_is_allowed_is_none_until_it_is_forbidden() -> None:
    scene = Scene("gcr5_910", [Box(at=(0.492, 0.1405, 0.42), size=(0.1, 0.1, 0.1), name="it")])
    found = scene.clearance(READY)
    assert found.pair is not None
    touching = set()
    while (found := scene.clearance(READY)).distance < 0.0:
        assert found.pair is not None
        touching.add(found.pair)
        scene.allow(*found.pair)
    assert touching
    scene.forbid(*touching.pop())
    assert scene.collides(READY)
    with pytest.raises(SceneError, match=r"nothing is called 'nobody'; there are [a-z]"):
        scene.allow("nobody", "it")
    with pytest.raises(SceneError, match=r"nothing is called 'nobody'; there are [a-z]"):
        scene.forbid("nobody", "it")


PALM = """<mujoco><worldbody><body name="palm"><geom size="0.01"/><body pos="0 0 0.1">
    <geom size="0.02"/></body></body></worldbody></mujoco>"""


@for_each("tool", [[Rod(length=0.1)], PALM])
def test_all_of_a_tool_is_allowed_to_touch_a_thing(tool: Any) -> None:
    scene = Scene("gcr5_910", tool=tool)
    x, y, z = scene.arm.fkine(READY)[:3, 3]
    scene.add(Box(at=(x, y, z - 0.13), size=(0.1, 0.1, 0.1), name="it"))
    assert scene.clearance(READY).pair == ("tool", "it")
    scene.allow("tool", "it")
    assert not scene.collides(READY)
    scene.forbid("tool", "it")
    assert scene.collides(READY)


def test_a_sprung_table_is_allowed_to_be_touched_as_a_whole() -> None:
    scene = Scene("gcr5_910", [Table(at=(0.492, 0.1405, 0.46), stiffness=1e4, name="it")])
    for body in ("link4", "link5", "link6", "flange"):
        scene.allow("it", body)
    assert not scene.collides(READY)


def test_a_thing_whose_name_begins_as_that_of_another_is_not_allowed_with_it() -> None:
    shelf = Box(at=(-0.5, 0.1405, 0.4), size=(0.1, 0.1, 0.1), name="shelf")
    box = Box(at=(0.492, 0.1405, 0.43), size=(0.1, 0.1, 0.1), name="shelf/left")
    scene = Scene("gcr5_910", [shelf, box])
    for body in ("link4", "link5", "link6", "flange"):
        scene.allow("shelf", body)
    assert scene.collides(READY)


def test_who_may_touch_the_floor_touches_other_things_of_the_world_all_the_same() -> None:
    """Fixed things of an MJCF file that are in no body were invisible to it."""
    wall = '<geom name="wall" type="box" pos="0.492 0.1405 0.4" size="0.1 0.1 0.1"/>'
    floor = '<geom name="floor" type="plane" pos="0 0 0.4" size="1 1 1"/>'
    for geoms in (wall, floor + wall):
        scene = Scene("gcr5_910", around=f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
        for number in range(1, 7):
            scene.allow("floor", f"link{number}")
        scene.allow("floor", "flange")
        found = scene.clearance(READY)
        assert found.pair is not None
        assert found.pair[1] == "wall"
        assert found.distance < -0.05


@for_each("name", ["part", "plate", "pedestal"])
def test_link_1_touches_what_is_called_like_that_on_which_an_arm_stands(name: str) -> None:
    geom = f'<geom name="{name}" type="box" pos="0.05 0 0.15" size="0.05 0.05 0.05"/>'
    scene = Scene("gcr5_910", around=f"<mujoco><worldbody>{geom}</worldbody></mujoco>")
    found = scene.clearance(READY)
    assert found.pair is not None
    assert found.pair[0] == "link1"
    assert found.distance < -0.05


def test_things_that_touch_one_another_as_a_pair_do_not_collide() -> None:
    around = """<mujoco><worldbody>
        <geom name="table" type="box" pos="1 1 0.3" size="0.2 0.2 0.02"/>
        <body pos="1 1 0.339"><freejoint/><geom name="part" size="0.02"/></body>
        </worldbody><contact><pair geom1="table" geom2="part"/></contact></mujoco>"""
    found = Scene("gcr5_910", around=around).clearance(READY)
    assert found == Scene("gcr5_910").clearance(READY)


def test_the_scene_of_a_running_simulator_is_as_it_is_now() -> None:
    box = Box(at=(0.4, 0.3, 0.5), size=(0.1, 0.1, 0.1), mass=0.5, name="box")
    table = Box(at=(0.4, 0.3, 0.1), size=(0.3, 0.3, 0.2), name="table")
    with Simulator(speed=math.inf, scene=[box, table]) as simulator:
        simulator.wait_until(lambda: simulator.time > 1.0)
        scene = Scene.from_simulator(simulator)
    resting = 0.25 - 0.01  # fallen onto the table, whose top is at 0.2
    tip = scene.arm
    above = tip.ikine([0.4, 0.3, resting + 0.05 + 0.02, math.pi, 0.0, 0.0], READY)
    found = scene.clearance(Joints.of(above))
    assert found.pair is not None
    assert found.pair[1] == "box"
    assert found.distance == pytest.approx(0.01, abs=2e-3)
    scene.attach("box", Joints.of(above))
    lifted = tip.ikine([0.4, -0.3, 0.6, math.pi, 0.0, 0.0], READY)
    assert not scene.collides(Joints.of(lifted))


@for_each("gripper", ["robotiq_2f85", "vacuum"])
def test_the_scene_of_a_simulator_has_its_gripper(gripper: str) -> None:
    box = Box(at=(0.4, 0.3, 0.05), size=(0.1, 0.1, 0.1), mass=0.5, name="box")
    with Simulator(speed=math.inf, scene=[box], gripper=gripper, joints=READY) as simulator:
        simulator.wait_until(lambda: simulator.time > 2.0)  # the fingers stand
        scene = Scene.from_simulator(simulator)
        rest = simulator.positions[6:]
    assert scene.loose == pytest.approx(rest, abs=1e-3)
    x, y, z = scene.arm.fkine(READY)[:3, 3]
    scene.add(Sphere(at=(x, y, z - 0.06), radius=0.02, name="ball"))
    assert scene.clearance(READY).pair == ("tool", "ball")


def test_a_simulated_drawer_can_be_held_and_other_things_stay_where_they_are() -> None:
    around = """<mujoco><worldbody>
        <body name="drawer" pos="-1 1 0.5"><joint type="slide"/><geom size="0.1"/></body>
        <body name="ball" pos="1 1 0.5"><freejoint/><geom size="0.05"/></body>
        <body name="box" pos="1 -1 0.5"><freejoint/><geom size="0.05"/>
          <body><joint name="lid"/><geom pos="0.1 0 0" size="0.04"/></body></body>
        </worldbody></mujoco>"""
    with Simulator(scene=around) as simulator:
        scene = Scene.from_simulator(simulator)
    ball, lid = scene.loose[1:8].tolist(), scene.loose[15:].tolist()
    scene.attach("drawer", READY)
    assert scene.loose[:7].tolist() == ball
    scene.attach("box", READY)
    assert scene.attached == ("drawer", "box")
    assert scene.loose.tolist() == [*lid, *ball]
    model = scene.compiled()  # the lid first, then the ball
    assert np.diff([*model.jnt_qposadr[6:], model.nq]).tolist() == [1, 7]


@for_each("mounting", ["floor", "wall", "ceiling"])
def test_the_mounting_is_the_simulators(mounting: str) -> None:
    scene = Scene("gcr3_618", mounting=mounting)  # type: ignore[arg-type] # one of the three
    assert not scene.collides(READY)
    below = scene.mounting.matrix @ scene.arm.fkine(READY) @ np.array([0, 0, 0.06, 1.0])
    scene.add(Sphere(at=tuple(below[:3]), radius=0.03, name="ball"))
    found = scene.clearance(READY)
    assert found.pair is not None
    assert found.pair[1] == "ball"
    assert found.distance == pytest.approx(0.03, abs=1e-6)


def test_preflight_tells_the_same_distance() -> None:
    things = [
        Box(at=(0.75, 0.1, 0.5), size=(0.1, 0.1, 0.4), name="post"),
        Sphere(at=(0.45, -0.1, 0.45), radius=0.08, name="ball"),
    ]
    scene = Scene("gcr5_910", things)
    world = World(scene.arm, scene=mjcf_of(things, free=False))
    random = np.random.default_rng(3)
    seen: set[str] = set()
    for _ in range(60):
        q = READY.array + random.uniform(-1.2, 1.2, 6)
        here = scene.clearance(Joints.of(q))
        if here.pair is None or here.pair[1] not in scene:
            continue  # nothing is near, or the arm itself
        samples = {"time": np.zeros(1), "q": q[None], "qd": np.zeros((1, 6)), "positions": q[None]}
        margin = margins({"calls": []}, samples, "gcr5_910", world)[-1]
        assert margin.of == "obstacle"
        assert margin.what == " and ".join(here.pair)
        assert margin.value == pytest.approx(here.distance, abs=1e-6)
        seen.add(here.pair[1])
    assert seen == {"post", "ball"}


def test_what_is_given_wrongly_is_refused() -> None:
    with pytest.raises(ParameterError, match="vertices"):
        Mesh(vertices=[[0.0, 0.0, 0.0]], name="flat")
    with pytest.raises(ParameterError, match="points"):
        PointCloud(points=np.zeros((3, 2)))
    with pytest.raises(SceneError, match="does not exist"):
        Mesh(file="nowhere.stl")
    with pytest.raises(SceneError, match="no thing"):
        Scene("gcr5_910", ["box"])  # type: ignore[list-item] # what a user may give
    for things in list[Any]([Box(), np.array(1.0)]):
        with pytest.raises(SceneError, match="no list of things"):
            Scene("gcr5_910", things)
    for model in (5, "gcr5_911"):
        with pytest.raises(ParameterError, match="model"):
            Scene(model)  # type: ignore[arg-type] # what a user may give
    assert arm_of("gcr5_910") is Scene("gcr5_910").arm


def test_a_thing_without_a_name_gets_one_that_is_free() -> None:
    scene = Scene("gcr5_910", [Box(), Box(name="thing3"), Box()])
    assert [thing.name for thing in scene] == ["thing1", "thing3", "thing4"]
    scene.remove("thing1")
    scene.add(Box(), Box())
    assert [thing.name for thing in scene] == ["thing3", "thing4", "thing5", "thing6"]


def test_a_thing_keeps_its_place_whatever_becomes_of_the_callers_list() -> None:
    at = [0.5, 0.0, 0.2]
    box = Box(at=at, name="box")
    scene = Scene("gcr5_910", [box])
    at[0] = 9.0
    assert scene["box"].at == box.at == (0.5, 0.0, 0.2)
    assert box == Box(at=np.array([0.5, 0.0, 0.2]), name="box")
    assert hash(box) == hash(Box(at=(0.5, 0.0, 0.2), name="box"))
    points = np.zeros((4, 3))
    cloud, mesh = PointCloud(points=points), Mesh(vertices=points)
    points[0] = 1.0
    assert cloud == PointCloud(points=np.zeros((4, 3))) != PointCloud(points=points)
    assert mesh == Mesh(vertices=np.zeros((4, 3))) != Mesh(vertices=points)
    assert hash(cloud) == hash(PointCloud(points=np.zeros((4, 3))))


@for_each("at", [5, {1.0, 2.0, 3.0}, "123", None])
def test_a_thing_is_moved_to_no_place_that_is_none(at: Any) -> None:
    scene = Scene("gcr5_910", [Box(name="box")])
    with pytest.raises(ParameterError, match="at"):
        scene.move("box", at)
    assert scene.revision == 1


@for_each(
    "give",
    [
        lambda pose: Box(at=pose),
        lambda pose: Scene("gcr5_910", [Box(name="box")]).move("box", pose),
        lambda pose: Planner(Scene("gcr5_910"), tool=pose),
        lambda pose: ToolDescription(tcp=pose),
        lambda pose: check([pose], arm="gcr5_910", near=[0.0] * 6),
        lambda pose: check([], arm="gcr5_910", near=[0.0] * 6, tool=pose),
        lambda pose: check([], arm="gcr5_910", near=[0.0] * 6, wobj=pose),
        lambda pose: calibrate_tool_tip([pose] * 6),
        lambda pose: Zone.box(pose, (0.1, 0.1, 0.1)),
        lambda pose: Load(1.0).in_tool(pose),
        lambda pose: Load(1.0).in_flange(pose),
    ],
)
def test_a_pose_in_degrees_is_refused(give: Callable[[list[float]], object]) -> None:
    """A thing, or a tool, was turned by another angle: plans led through it."""
    with pytest.raises(ParameterError, match="radians, not degrees"):
        give([0.5, 0.0, 0.3, 0.0, 0.0, 90.0])


@for_each(
    "give",
    [
        lambda q: Scene("gcr5_910").clearance(q),
        lambda q: Scene("gcr5_910").collides(q),
        lambda q: Scene("gcr5_910").picture(q),
        lambda q: Planner(Scene("gcr5_910")).plan_blocking(q, READY),
        lambda q: Planner(Scene("gcr5_910")).line_blocking(q, Pose(0.5, 0.0, 0.3, 3.0, 0.0, 0.0)),
        lambda q: check([READY], arm="gcr5_910", near=q),
        lambda q: identify_load_by_torques("gcr5_910", [q] * 6, [q] * 6),
        lambda q: Region(Pose(0.5, 0.0, 0.3, math.pi, 0.0, 0.0), turn=(0.0, 0.0, 180.0)),
    ],
)
def test_joints_in_degrees_are_refused(give: Callable[[Any], object]) -> None:
    """Distances were those of an arm that stands elsewhere."""
    with pytest.raises(ParameterError, match="radians, not degrees"):
        give(READY.degrees)


_MANY_THREADS = """
import sys, threading
from aioduco.planning import Scene
from aioduco.sim.scene import Box

sys.setswitchinterval(1e-5)
scene = Scene("gcr5_910", [Box(at=(0.5, 0.0, 0.3), size=(0.1, 0.1, 0.6), name="box")])
places = [[0.01 * n, 0.3, 1.0, 0.0, -1.0, 0.0] for n in range(200)]
alone = [scene.clearance(q) for q in places]
wrong = []

def look():
    wrong.extend(q for _ in range(5) for q, d in zip(places, alone) if scene.clearance(q) != d)

threads = [threading.Thread(target=look) for _ in range(4)]
for each in threads:
    each.start()
for each in threads:
    each.join()
print(len(wrong))
"""


def test_threads_may_ask_a_scene_at_once() -> None:
    """MuJoCo's data are for one thread: the interpreter crashed."""
    found = python("-c", _MANY_THREADS)
    assert (found.returncode, found.stdout.strip()) == (0, "0"), found.stderr


_MANY_CHANGES = """
import sys, threading
from aioduco.planning import Scene
from aioduco.sim.scene import Box

sys.setswitchinterval(1e-5)
scene = Scene("gcr5_910")

def add(names):
    for name in names:
        scene.add(Box(name=name))

each = [[f"{kind}{number}" for number in range(100)] for kind in "abcd"]
threads = [threading.Thread(target=add, args=(names,)) for names in each]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
print(sorted(thing.name for thing in scene) == sorted(sum(each, [])), scene.revision)
"""


def test_what_threads_add_at_once_is_all_there() -> None:
    """Of two things that were added at once one was lost: a plan led through it."""
    found = python("-c", _MANY_CHANGES)
    assert found.stdout.strip() == "True 401", found.stderr
