"""Mass and centre of simulated loads, and the stated uncertainty."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco import Load, Pose
from aioduco.errors import CalibrationError, ParameterError
from aioduco.kinematics import arm, gravity, identify_load_by_forces, identify_load_by_torques
from aioduco.sim import Simulator

GCR5 = arm("gcr5_910")
DOWN = np.array([0.0, 0.0, -9.81])
HOME = np.array([0.0, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0])
#: turns of the joints from there: wrist and elbow, to several sides
POSES = HOME + np.array([
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [0.0, -0.4, 0.3, 0.6, 0.5, 0.0],
    [0.0, 0.3, -0.4, -0.6, -0.5, 0.8],
    [0.0, -0.4, 0.6, 0.2, -0.7, 1.6],
    [0.0, 0.4, -0.2, -0.7, 0.6, -0.8],
    [0.0, 0.3, 0.3, 0.6, -0.5, -1.6],
    [0.0, -0.4, -0.4, -0.3, 0.8, 0.8],
    [0.0, 0.0, 0.5, -0.8, 0.0, 2.4],
])  # fmt: skip


def wrenches(load: Load, down: np.ndarray = DOWN) -> np.ndarray:
    """Force and torque of a load on the flange, along its axes."""
    weight = load.mass * (np.swapaxes(GCR5.fkine(POSES)[:, :3, :3], 1, 2) @ down)
    return np.hstack([weight, np.cross(load[1:], weight)])


def torques(load: Load, down: np.ndarray = DOWN) -> np.ndarray:
    """Torques of a load on the joints."""
    turns = GCR5.fkine(POSES)[:, :3, :3]
    in_base = np.einsum("nij,nkj->nki", turns, wrenches(load, down).reshape(-1, 2, 3))
    found: np.ndarray = np.einsum("nij,ni->nj", GCR5.jacobian(POSES), in_base.reshape(-1, 6))
    return found


def apart(one: Load, other: Load) -> tuple[float, float]:
    """How far two loads differ [kg, m]."""
    return abs(one.mass - other.mass), float(np.linalg.norm(np.subtract(one, other)[1:]))


@pytest.mark.slow
def test_forces_give_a_hidden_load_within_what_is_stated() -> None:
    held = np.zeros(2)
    for seed in range(300):
        draw = np.random.default_rng(seed)
        hidden = Load(draw.uniform(1.0, 4.0), *draw.uniform(-0.1, 0.1, 3))
        noise = draw.normal(0.0, 1.0, (8, 6)) * np.repeat([0.05, 0.002], 3)
        read = wrenches(hidden) + noise + draw.uniform(-5.0, 5.0, 6)
        found = identify_load_by_forces(GCR5.fkine(POSES), read)
        off = apart(found.load, hidden)
        assert off[0] < 0.02 * hidden.mass
        held += np.less(off, found.uncertainty)
    assert (held / 300 > 0.92).all()
    assert (held / 300 < 0.99).all()


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    "noise",
    [(0.04, 0.04, 0.03, 0.01, 0.01, 0.01), (0.02,) * 6, (0.2, 0.01, 0.02, 0.03, 0.005, 0.02)],
)
def test_torques_give_a_hidden_load_within_what_is_stated(
    noise: tuple[float, ...], thorough: bool
) -> None:
    held, mass_off = np.zeros(2), []
    trials = 300 if thorough else 100
    for seed in range(trials):
        draw = np.random.default_rng(seed)
        hidden = Load(draw.uniform(1.0, 4.0), *draw.uniform(-0.1, 0.1, 3))
        read = torques(hidden) + draw.normal(0.0, noise, (8, 6)) + draw.uniform(-2.0, 2.0, 6)
        found = identify_load_by_torques(GCR5, POSES, read)
        mass_off.append(abs(found.load.mass / hidden.mass - 1.0))
        off = apart(found.load, hidden)
        held += np.less(off, found.uncertainty)
    assert np.quantile(mass_off, 0.95) < 0.02
    assert (held / trials > (0.91 if thorough else 0.86)).all()


def test_a_load_that_the_controller_knows_is_added() -> None:
    known, beyond = Load(1.0, 0.0, 0.0, 0.05), Load(2.0, 0.02, -0.03, 0.1)
    found = identify_load_by_torques(GCR5, POSES, torques(beyond), known=known)
    assert np.allclose(found.load, known.with_load(beyond))
    # one that is lighter than the controller was told
    less = identify_load_by_torques(GCR5, POSES, -torques(Load(0.4, 0.0, 0.0, 0.05)), known=known)
    assert np.allclose(less.load, (0.6, 0.0, 0.0, 0.05))
    for wrong in (1.0, [1.0, 0.0, 0.0, 0.05]):
        with pytest.raises(ParameterError, match=r"known is .* a Load"):
            identify_load_by_torques(GCR5, POSES, torques(beyond), known=wrong)  # type: ignore[arg-type]  # the point


def test_an_arm_is_named_by_its_model() -> None:
    hidden = Load(2.0, 0.02, -0.03, 0.1)
    assert np.allclose(identify_load_by_torques("gcr5_910", POSES, torques(hidden)).load, hidden)
    for wrong in ("gcr5", None):
        with pytest.raises(ParameterError, match=r"gcr5_910|the name of a model"):
            identify_load_by_torques(wrong, POSES, torques(hidden))  # type: ignore[arg-type]  # the point


def test_gravity_follows_the_mounting() -> None:
    hidden, down = Load(2.0, 0.02, -0.03, 0.1), gravity(Pose(0.0, 0.0, 2.0, 0.0, np.pi / 2, 0.0))
    assert np.allclose(down, (9.81, 0.0, 0.0))
    assert np.allclose(gravity("wall"), down)
    assert np.allclose(gravity("ceiling"), -gravity("floor"))
    with pytest.raises(ParameterError, match="did you mean 'ceiling'"):
        gravity("celing")  # type: ignore[arg-type]  # the wrong name is the point
    with pytest.raises(ParameterError, match="not degrees"):
        gravity(Pose(0.0, 0.0, 2.0, 180.0, 0.0, 0.0))
    by_forces = identify_load_by_forces(GCR5.fkine(POSES), wrenches(hidden, down), gravity=down)
    by_torques = identify_load_by_torques(GCR5, POSES, torques(hidden, down), gravity=down)
    assert np.allclose(by_forces.load, hidden)
    assert np.allclose(by_torques.load, hidden)


def test_loads_add_and_change_frames() -> None:
    tool, held = Load(1.0, 0.0, 0.0, 0.1), Load(3.0, 0.1, 0.2, 0.3)
    assert np.allclose(tool.with_load(held), (4.0, 0.075, 0.15, 0.25))
    assert np.allclose(tool.with_load(held).without_load(tool), held)
    assert Load(0.0).with_load(Load(0.0)) == Load(0.0)
    at = Pose(0.0, 0.0, 0.2, np.pi, 0.0, 0.0)
    assert np.allclose(held.in_tool(at), (3.0, 0.1, -0.2, -0.1))
    assert np.allclose(held.in_tool(at).in_flange(at), held)
    with pytest.raises(ParameterError, match="lighter"):
        tool.without_load(held)
    for change in (tool.with_load, tool.without_load):
        with pytest.raises(ParameterError, match="a Load"):
            change([0.5, 0.0, 0.0, 0.1])  # type: ignore[arg-type]  # that is the test


def test_poses_that_leave_the_load_open_are_refused() -> None:
    turned = HOME + np.outer(np.linspace(-1.0, 1.0, 8), [0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
    tilted = HOME + np.outer(np.linspace(-0.3, 0.3, 8), [0.0, 0.0, 0.0, 0.0, 1.0, 0.0])
    with pytest.raises(CalibrationError, match="tilt the flange too little"):
        identify_load_by_forces(GCR5.fkine(turned), wrenches(Load(1.0)))
    with pytest.raises(CalibrationError, match="too little"):
        identify_load_by_forces(GCR5.fkine(tilted), wrenches(Load(1.0)))
    with pytest.raises(CalibrationError, match="turn the joints 2, 3, 5 and 6"):
        identify_load_by_torques(GCR5, turned, torques(Load(1.0)))


def test_readings_without_a_load_are_told() -> None:
    """Also without any error, as of a simulator: nothing is divided by zero."""
    noise = np.random.default_rng(1).normal(0.0, 0.02, (8, 6))
    for read in (noise, np.zeros((8, 6)), np.ones((8, 6))):
        with pytest.raises(CalibrationError, match="show no load"):
            identify_load_by_forces(GCR5.fkine(POSES), read)
        with pytest.raises(CalibrationError, match="show no load"):
            identify_load_by_torques(GCR5, POSES, read)
    with pytest.raises(CalibrationError, match="opposite sign"):
        identify_load_by_forces(GCR5.fkine(POSES), -wrenches(Load(1.0)))


def test_wrong_arguments_are_refused() -> None:
    frames, read = GCR5.fkine(POSES), wrenches(Load(1.0))
    with pytest.raises(ParameterError, match="5 poses"):
        identify_load_by_forces(frames[:5], read[:5])
    with pytest.raises(ParameterError, match="wrenches"):
        identify_load_by_forces(frames, read[:7])
    with pytest.raises(ParameterError, match="torques"):
        identify_load_by_torques(GCR5, POSES, np.full((8, 6), np.nan))
    with pytest.raises(ParameterError, match="gravity"):
        identify_load_by_forces(frames, read, gravity=(0.0, 0.0))


@for_each("known", [2.0, Load(-1.0), Load(np.nan), Load("2")])  # type: ignore[arg-type]  # a text
def test_what_is_no_known_load_is_refused(known: Any) -> None:
    read = torques(Load(1.0, 0.0, 0.0, 0.1))
    with pytest.raises(ParameterError, match="known"):
        identify_load_by_torques(GCR5, POSES, read, known=known)


@for_each("joints", [None, 5, POSES[:, :5], [Pose(*q) for q in POSES], "12345678"])
def test_what_is_no_list_of_joints_is_refused(joints: Any) -> None:
    with pytest.raises(ParameterError, match="joints"):
        identify_load_by_torques(GCR5, joints, torques(Load(1.0)))


@pytest.mark.slow
async def test_a_load_hidden_on_a_simulated_arm_is_found_by_both_sensors() -> None:
    draw = np.random.default_rng(3)
    hidden = Load(2.5, 0.03, -0.02, 0.08)
    flanges, forces, external = [], [], []
    options: dict[str, Any] = {"heartbeat": None}
    with Simulator(real_readings=True, speed=np.inf, joints=HOME) as sim:
        sim.load(hidden.mass, hidden[1:])
        async with aioduco.connect(sim.host, sim.port, **options) as robot:
            await robot.bring_up()
            await robot.settings.collision_detect(0)  # it is heavier than the controller knows
            for q in POSES:
                await robot.motion.movej2(q, v=1.0, a=2.0)
                await sim.wait_until_async(lambda: sim.view.standing)
                flanges.append(await robot.state.get_flange_pose())
                read = [await robot.force.fc_get_ft() for _ in range(30)]
                forces.append(np.mean(read, axis=0))
                noisy = await robot.state.get_ext_torque() + draw.normal(0.0, 0.3, (30, 6))
                external.append(noisy.mean(axis=0))
    for found in (
        identify_load_by_forces(flanges, forces),
        identify_load_by_torques(GCR5, POSES, external),
    ):
        assert abs(found.load.mass / hidden.mass - 1.0) < 0.02
        assert np.linalg.norm(np.subtract(found.load, hidden)[1:]) < 0.01


@for_each("wrong", ["down", None, [1.0], [10**400, 0, 0], [np.nan, 0, 0]])
def test_what_is_no_gravity_and_no_reading_is_refused_by_name(wrong: Any) -> None:
    frames, read = GCR5.fkine(POSES), wrenches(Load(1.0, 0.0, 0.0, 0.1))
    with pytest.raises(ParameterError, match="gravity"):
        identify_load_by_forces(frames, read, gravity=wrong)
    with pytest.raises(ParameterError, match="wrenches"):
        identify_load_by_forces(frames, [[10**400] * 6] * 8)
