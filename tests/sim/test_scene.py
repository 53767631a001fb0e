"""Scenes: things that stand around the arm, what it carries, and where it is mounted."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco.errors import ParameterError, SceneError
from aioduco.kinematics import arm, gravity
from aioduco.models.pose import Pose
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.scene import Box, Cylinder, Pad, Rod, Sphere, Table, Thing, mjcf_of, mounting_of
from aioduco.sim.simulator import READY, Simulator
from aioduco.testing.waiting import eventually

from .conftest import Connect, Started, let_pass

mujoco: Any = importlib.import_module("mujoco")  # compiled, without types
FIVE = arm("gcr5_910")
HOME = np.radians([0, 0, 90, 0, -90, 0])
PROBE = mjcf_of([Rod(length=0.1, mass=0.2)], free=False)
TIP = FIVE.fkine(HOME)[:3, 3] - [0.0, 0.0, 0.1]


def hold(world: World, pose: Pose, cycles: int = 1500) -> None:
    setpoint = JointSetPoint.at_rest(FIVE.ikine(pose.matrix, HOME))
    for _ in range(cycles):
        world.step(setpoint)


def lowered(by: float) -> Pose:
    pose = FIVE.fkine(HOME)
    pose[2, 3] -= by
    return Pose.from_matrix(pose)


@pytest.mark.parametrize("stiffness", [2_000.0, 30_000.0, 150_000.0])
@pytest.mark.parametrize("kind", [Pad, Table])
def test_a_spring_gives_way_by_its_stiffness(kind: type[Pad | Table], stiffness: float) -> None:
    thing = kind(at=TIP.tolist(), stiffness=stiffness)
    world = World(FIVE, q=HOME, scene=mjcf_of([thing]), tool=PROBE)
    hold(world, lowered(0.001 + 10.0 / stiffness))
    sunk = FIVE.fkine(HOME)[2, 3] - FIVE.fkine(world.q)[2, 3]
    weight = 0.2 * 9.81
    assert world.qd == pytest.approx(np.zeros(6), abs=2e-4)
    # The sensor feels the table from below and the probe's weight; the flange looks down.
    assert -world.wrench[2] - -weight == pytest.approx(stiffness * sunk, rel=0.02)
    assert stiffness * sunk > 10.0
    hold(world, lowered(-0.01))
    assert world.wrench[2] == pytest.approx(weight, abs=0.01)


def test_things_fall_and_lie_still() -> None:
    ball = Sphere(at=(0.6, 0.3, 0.2), radius=0.05, mass=1.0, name="ball")
    world = World(FIVE, q=HOME, scene=mjcf_of([ball]))
    still = [world.still]
    for cycles in (100, 2000):
        hold(world, lowered(0.0), cycles)
        still.append(world.still)
    assert still == [True, False, True]
    # The floor is 10 mm below the base.
    assert world.data.body("scene/ball").xpos[2] == pytest.approx(0.04, abs=1e-3)
    assert np.abs(world.q - HOME).max() < 1e-5


@pytest.mark.slow
def test_the_physics_go_on_until_what_falls_lies() -> None:
    box = Box(at=(0.6, 0.3, 3.0), mass=1.0, size=(0.1, 0.1, 0.1))
    with Simulator(speed=math.inf, scene=[box]) as sim:
        sim.wait_until(lambda: sim.time > 2.0)
        steps = sim.statistics().cycles
    assert 0.7 < steps * 1e-3 < 2.0


def test_a_scene_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "tetra.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    )
    (tmp_path / "cell.xml").write_text(
        """<mujoco model="cell"><compiler meshdir="parts" angle="degree"/>
        <option timestep="0.01" gravity="0 0 0"/>
        <asset><mesh name="tetra" file="tetra.obj" scale="0.1 0.1 0.1"/></asset>
        <worldbody><geom name="floor" type="plane" size="1 1 1" pos="0 0 -0.5"/>
        <body name="base" pos="0.6 0 0"><geom type="mesh" mesh="tetra"/></body></worldbody>
        </mujoco>"""
    )
    world = World(FIVE, q=HOME, scene=mjcf_of(tmp_path / "cell.xml"))
    names = [world.model.geom(i).name for i in range(world.model.ngeom)]
    assert "scene/floor" in names
    assert "floor" not in names
    assert world.model.opt.timestep == 0.001
    assert world.model.opt.gravity[2] == pytest.approx(-9.81)
    assert world.model.body("scene/base").pos[0] == 0.6


@for_each("before", ["\ufeff", "\n", "\ufeff\r\n  "])
def test_a_scene_as_text_may_begin_as_its_file_does(before: str) -> None:
    text = "<mujoco><worldbody><geom name='post' size='0.1' pos='1 0 0'/></worldbody></mujoco>"
    world = World(FIVE, q=HOME, scene=mjcf_of(before + text))
    assert world.model.geom("scene/post").size[0] == 0.1


def test_drives_of_a_tool_keep_their_power_when_the_brakes_fall() -> None:
    gripper = """<mujoco><worldbody><geom size="0.03" mass="0.2"/>
    <body name="finger" pos="0 0 0.1"><joint name="jaw" type="slide" axis="1 0 0" damping="5"/>
    <geom size="0.01" mass="0.05"/></body></worldbody>
    <actuator><position name="jaw" joint="jaw" kp="100"/></actuator></mujoco>"""
    world = World(FIVE, q=HOME, tool=gripper)
    world.brake(True)
    world.data.actuator("tool/jaw").ctrl[0] = 0.02
    hold(world, lowered(0.0), 1000)
    assert world.data.joint("tool/jaw").qpos[0] == pytest.approx(0.02, abs=1e-3)
    assert np.abs(world.q - HOME).max() < 1e-5


@for_each(
    "scene, says",
    [
        ("nowhere.xml", "does not exist"),
        ("<mujoco><boddy/></mujoco>", "no MJCF"),
        ("<mujoco><worldbody><body><joint/></body></worldbody></mujoco>", "no model: "),
        ([Sphere(name="a"), Sphere(name="a")], "repeated name"),
    ],
)
def test_a_scene_that_is_none(scene: Any, says: str) -> None:
    with pytest.raises(SceneError, match=says):
        Simulator(scene=scene).start()


@for_each("stiffness", [None, 1e4])
def test_a_table_and_a_pedestal_stand_on_the_floor(stiffness: float | None) -> None:
    table = mjcf_of([Table(at=(0.5, 0.2, 0.4), stiffness=stiffness, name="table")])
    raised = mounting_of("floor", FIVE, 0.5)
    world = World(FIVE, q=HOME, scene=table, mounting=raised, pedestal=True)
    model, data = world.model, world.data
    mujoco.mj_forward(model, data)
    kinds, floor = mujoco.mjtGeom, data.geom("floor").xpos[2]
    table_body = model.body("scene/table").id
    legs = [
        geom
        for geom in range(model.ngeom)
        if model.geom_bodyid[geom] == table_body and model.geom_type[geom] == kinds.mjGEOM_CYLINDER
    ]
    assert len(legs) == 4
    for leg in legs:
        assert data.geom_xpos[leg][2] - model.geom_size[leg][1] == pytest.approx(floor)
    column = model.geom("pedestal").id
    assert data.geom_xpos[column][2] - model.geom_size[column][2] == pytest.approx(floor)


def test_a_stiffness_that_cannot_be_has_its_unit() -> None:
    with pytest.raises(ParameterError, match="stiffness is -1, but must be a number above 0 N/m;"):
        Table(stiffness=-1)
    with pytest.raises(ParameterError, match="damping is -1, but must be a number above 0;"):
        Pad(damping=-1)


def test_a_condition_that_must_be_awaited_does_not_count_as_true() -> None:
    async def asked() -> bool:
        return False

    with Simulator() as sim, pytest.raises(ParameterError, match="must be awaited"):
        sim.wait_until(asked)  # type: ignore[arg-type]  # on purpose


def test_a_signal_that_is_not_there_raises_for_a_test_and_reads_as_zero_for_a_client() -> None:
    with Simulator() as sim:
        for num in (0, 17):
            with pytest.raises(IndexError, match="there are 1 to 16"):
                _ = sim.signals.standard_in[num]
            with pytest.raises(IndexError, match="there are 1 to 16"):
                sim.get_digital_output(num)
        sim.set_digital_input(2, True)
        assert [*sim.signals.standard_in] == [False, True, *[False] * 14]
        assert sim.signals.standard_in.read(17) is False


def test_what_is_no_observer_is_refused_while_it_runs() -> None:
    with Simulator() as sim, pytest.raises(ParameterError, match="observer is 3"):
        sim.observe(3)  # type: ignore[arg-type]  # it is refused


def test_what_is_no_scene_is_refused_before_the_start() -> None:
    with pytest.raises(SceneError, match="no thing"):
        Simulator(scene=["box"])  # type: ignore[list-item]  # on purpose
    for scene in list[Any]([3, np.array(3)]):
        with pytest.raises(SceneError, match="is no scene"):
            Simulator(scene=scene)
    with pytest.raises(SceneError, match="no mounting is called 'roof'"):
        Simulator(mounting="roof")  # type: ignore[arg-type]  # on purpose
    with pytest.raises(SceneError, match="mounting is"):
        Simulator(mounting=[0.0, 1.0])


@for_each(
    "wrong",
    [
        lambda: Box(size=(0.1, 0.0, 0.1)),
        lambda: Box(at=(0.0, math.nan, 0.0)),
        lambda: Box(at=(0.0, 0.0)),
        lambda: Sphere(radius=-1.0),
        lambda: Cylinder(length=math.inf),
        lambda: Sphere(mass=-1.0),
        lambda: Pad(stiffness=0.0),
        lambda: Table(stiffness=math.nan),
        lambda: Box(name=3),  # type: ignore[arg-type]  # on purpose
        lambda: Box(colour="red"),  # type: ignore[arg-type]  # on purpose
        lambda: Box(colour=(255, 0, 0)),
    ],
)
def test_things_that_cannot_be(wrong: Callable[[], Thing]) -> None:
    with pytest.raises(ParameterError):
        wrong()


def test_every_thing_is_mjcf_with_and_without_a_mass() -> None:
    things = [
        kind(at=(i, j, 1.0, 0.1, 0.2, 0.3), mass=mass, name=f"{kind.__name__}{j}")
        for i, kind in enumerate((Box, Cylinder, Pad, Rod, Sphere, Table))
        for j, mass in enumerate((0.0, 2.0))
    ]
    world = World(FIVE, scene=mjcf_of(things))
    # Four of them are loose; pads are on springs, with a mass or without.
    assert world.model.nv == 6 + 4 * 6 + 2
    assert World(FIVE, tool=mjcf_of(things, free=False)).model.nv == 6 + 2


@pytest.mark.slow
def test_a_process_of_its_own_takes_scene_tool_and_mounting(connect: Connect) -> None:
    options: dict[str, Any] = {
        "speed": 1000.0,
        "scene": [Table(at=(0.5, 0.0, 0.3))],
        "tool": [Rod(mass=0.5)],
        "mounting": "ceiling",
    }
    standing = World(FIVE, q=np.array(READY), tool=mjcf_of(options["tool"], free=False))
    hold(standing, lowered(0.0), 300)
    torque = standing.reading().torque
    assert abs(torque[1]) > 1.0
    with Simulator.spawn(**options) as sim:
        robot = connect(sim)
        robot.bring_up()
        torques = robot.get_actual_joints_torque
        eventually(lambda: np.allclose(torques(), -torque, atol=0.01))


@pytest.mark.parametrize("place", ["floor", "wall", "ceiling", (0.1, 0.2, 1.0, 0.4, -0.7, 2.0)])
def test_the_weight_pulls_downwards_however_the_arm_is_mounted(place: Any) -> None:
    mounting = mounting_of(place, FIVE)
    world = World(FIVE, q=HOME, mounting=mounting)
    hold(world, lowered(0.0), 300)
    assert np.abs(world.q - HOME).max() < 1e-5
    empty = world.reading().torque
    world.load(2.0, (0.0, 0.0, 0.1))
    hold(world, lowered(0.0), 300)
    assert np.abs(world.q - HOME).max() < 1e-5
    weight = 2.0 * gravity(mounting)
    assert np.linalg.norm(weight) == pytest.approx(2.0 * 9.81)
    flange = FIVE.fkine(HOME)
    wrench = np.concatenate([weight, np.cross(flange[:3, 2] * 0.1, weight)])
    np.testing.assert_allclose(
        world.reading().torque - empty, -FIVE.jacobian(HOME).T @ wrench, atol=1e-3
    )
    # A push is along the axes of the base.
    before = flange[:3, :3] @ world.wrench[:3]
    world.push([1.0, 2.0, 3.0, 0.0, 0.0, 0.0])
    hold(world, lowered(0.0), 300)
    after = flange[:3, :3] @ world.wrench[:3]
    np.testing.assert_allclose(after - before, [1.0, 2.0, 3.0], atol=0.05)


@pytest.mark.slow
def test_forces_at_the_tool_are_without_the_weight_at_a_wall(started: Started) -> None:
    sim, robot = started(mounting="wall")
    assert robot.set_load_data([3.0, 0.0, 0.02, 0.05]) == 4
    let_pass(sim, 1.0)
    assert robot.get_tcp_force() == pytest.approx([0.0] * 6, abs=0.05)


@pytest.mark.usefixtures("real_cycle")
def test_time_goes_on_by_whole_cycles_and_the_same_each_time() -> None:
    box = Box(at=(0.5, 0.0, 0.3), size=(0.05, 0.05, 0.05), mass=0.1, name="box")
    with Simulator(speed=float("inf"), scene=[box]) as sim:
        with pytest.raises(RuntimeError, match="not locked"):
            sim.advance(1)
        with pytest.raises(RuntimeError, match="not locked"):
            sim.arrange({})
        sim.lock_time()
        ways = []
        for _ in range(2):
            sim.arrange({"box": (0.7, -0.4, 0.5, 0.0, 0.3, 0.0)})
            begun = sim.time
            way = []
            for cycles in (1, 7, 20):
                sim.advance(cycles)
                way.append(sim.positions[sim.place("box")])
            assert sim.time == pytest.approx(begun + 0.028, abs=1e-9)
            ways.append(np.array(way))
        first, second = ways
        np.testing.assert_array_equal(first, second)
        fallen = 0.5 - 0.5 * 9.81 * 0.028**2
        assert sim.thing("box").z == pytest.approx(fallen, abs=5e-4)
        with pytest.raises(ParameterError, match="one of the things"):
            sim.arrange({"ball": (0, 0, 0, 0, 0, 0)})
        with pytest.raises(ValueError, match="from 1 to"):
            sim.advance(0)
        locked = sim.time
        sim.unlock_time()
        sim.wait_until(lambda: sim.time > locked + 0.1)
