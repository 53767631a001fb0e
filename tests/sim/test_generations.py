"""Controllers of other generations, as this package's clients meet them."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest

import aioduco
from aioduco import (
    ControllerError,
    Jog,
    JogDirections,
    ParameterError,
    Robot,
    TaskState,
    UnknownFunction,
)
from aioduco._wire import newer
from aioduco.compat import DucoCobot
from aioduco.sim import Simulator
from aioduco.sim.server.generations import GENERATIONS


@pytest.fixture
async def robot(request: pytest.FixtureRequest) -> AsyncIterator[tuple[Robot, Simulator]]:
    """A robot at a controller of the generation that the test names."""
    with Simulator(speed=float("inf"), generation=request.param) as sim:
        async with aioduco.connect(sim.host, sim.port) as connected:
            await connected.bring_up()
            yield connected, sim


def at(*generations: str) -> pytest.MarkDecorator:
    return pytest.mark.parametrize("robot", generations, indirect=True)


async def turn(robot: Robot, sim: Simulator, direction: int, **directions: Any) -> float:
    before = sim.joints[0]
    await robot.motion.move_jog(Jog.joint(1, direction, 50, step=0.1), **directions)
    return sim.joints[0] - before


@at("3.8", "4.3")
async def test_a_jog_turns_where_its_sign_says(robot: tuple[Robot, Simulator]) -> None:
    assert await turn(*robot, 1) == pytest.approx(0.1, abs=1e-3)
    assert await turn(*robot, -1) == pytest.approx(-0.1, abs=1e-3)


@at("older")
async def test_a_version_that_says_nothing(robot: tuple[Robot, Simulator]) -> None:
    assert not robot[0].version.controller.known
    with pytest.raises(ParameterError, match="wrong way"):
        await turn(*robot, 1)
    given = JogDirections.MANUAL_3_8
    assert await turn(*robot, 1, directions=given) == pytest.approx(0.1, abs=1e-3)


@at("oldest", "first")
async def test_without_jogs(robot: tuple[Robot, Simulator]) -> None:
    with pytest.raises(UnknownFunction):
        await turn(*robot, 1, directions=JogDirections.MANUAL_3_8)


@at(*GENERATIONS)
async def test_each_is_driven_by_the_same_program(robot: tuple[Robot, Simulator]) -> None:
    connected, sim = robot
    await connected.motion.movej2([0.2, 0.1, 1.5, 0.0, -1.5, 0.0], v=1.0, a=2.0)
    assert sim.joints[0] == pytest.approx(0.2, abs=1e-3)
    torques = (await connected.state.getRobotStatus()).torques
    assert (torques is not None) is (sim.generation == "4.3")


@at(*GENERATIONS)
async def test_a_shift_of_the_work_object_begins_and_ends(robot: tuple[Robot, Simulator]) -> None:
    shift = aioduco.Pose(0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
    for active, there in ((True, shift), (False, aioduco.Pose(*[0.0] * 6))):
        await robot[0].frames.set_wobj_offset(shift, active)
        assert (await robot[0].frames.get_wobj()).almost_equal(there)


@at("older", "oldest", "first")
async def test_fc_move_of_older_controllers_blocks(robot: tuple[Robot, Simulator]) -> None:
    force = robot[0].force
    await force.fc_start()
    await force.fc_wait_pos([0.0] * 6, [1.0] * 6, absolute=False, duration=0.0, timeout=10.0)
    await force.fc_wait_logic((1, 0, 0))
    assert await robot[0].blocking.fc_move() is TaskState.FINISHED


@at("4.3")
async def test_what_reach_check_found(robot: tuple[Robot, Simulator]) -> None:
    pose = await robot[0].state.get_tcp_pose()
    nothing = [0.0] * 6
    lifted = [0.0, 0.0, 3.0, 0.0, 0.0, 0.0]
    frames: dict[str, Any] = {"base": nothing, "ref_pos": robot[1].joints}
    points = [[pose[0], pose[1], pose[2] - 3.0, *pose[3:]], list(pose)]
    found = await robot[0].kinematics.reach_check(
        **frames, wobj=lifted, tool=nothing, check_points=points
    )
    assert (found.reachable, found.index, found.singularity) == (False, 1, 4)


RAIL = {"rail": [(-1.0, 1.0, 0.5, 2.0)]}


def with_rail(sim: Simulator) -> Any:
    """The vendor's class, with arm and rail enabled."""
    robot = DucoCobot(sim.host, sim.port)
    robot.open()
    robot.power_on(True)
    robot.enable(True)
    robot.enable_eaxis_scheme("rail")
    return robot


@pytest.mark.slow
def test_a_scheme_of_external_axes_says_how_fast_it_is() -> None:
    seen: list[tuple[float, float]] = []
    with Simulator(speed=float("inf"), generation="4.3", external_axes=RAIL) as sim:
        robot = with_rail(sim)

        def look(*_: object) -> None:
            (state,) = sim.external_axes.states()
            seen.append((state.speed, state.acceleration))

        sim.observe(look)
        robot.move_jog_eaxis("rail", 1, 100.0, True)
        sim.observe(None)
        (scheme,) = robot.get_eaxis_info()
        robot.close()
    speeds, changes = np.array(seen).T
    assert speeds.max() == pytest.approx(0.5, abs=1e-3)
    assert changes.max() == pytest.approx(2.0, rel=0.1)
    assert isinstance(scheme, newer.EAxissInfo)
    assert scheme.pos == pytest.approx(1.0)
    assert scheme.vel == 0.0


@at("3.8", "4.3")
async def test_functions_of_4_3(robot: tuple[Robot, Simulator]) -> None:
    connected, sim = robot
    if sim.generation == "3.8":
        with pytest.raises(UnknownFunction):
            await connected.frames.get_base()
        return
    assert await connected.frames.get_base() == sim.mounting
    assert await connected.settings.get_simulation_state() is False
    assert await connected.state.get_tcp_pose_command() == await connected.state.get_tcp_pose()
    await connected.state.clear_error_message()
    with pytest.raises(ControllerError, match="no laser sensor"):
        await connected.compound.enable_laser_track()


def test_installation_of_a_wall() -> None:
    with Simulator(generation="4.3", mounting="wall", speed=float("inf")) as sim:
        robot = DucoCobot(sim.host, sim.port)
        robot.open()
        assert robot.get_base() == pytest.approx(list(sim.mounting))
        tilt, towards = robot.get_installation()
        robot.close()
    leaning = [np.sin(tilt) * np.cos(towards), np.sin(tilt) * np.sin(towards), np.cos(tilt)]
    assert leaning == pytest.approx(sim.mounting.matrix[:3, 2].tolist())


def test_an_unknown_generation() -> None:
    with pytest.raises(ParameterError, match='"first", "oldest", "older"'):
        Simulator(generation="5.0")  # type: ignore[arg-type]


@pytest.mark.slow
async def test_external_axes_of_4_3_move_with_the_arm() -> None:
    with Simulator(speed=float("inf"), generation="4.3", external_axes=RAIL) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
            axes = robot.external_axes
            await axes.enable_eaxis_scheme("rail")
            await axes.move_eaxis("rail", [0.1, 0.0, 0.0], 0.5)
            turned = list(sim.joints)
            turned[0] = 0.2
            moves = [
                axes.movej2_eaxis(turned, 1.0, 2.0, "rail", [0.2, 0.0, 0.0], 0.5),
                axes.movel_eaxis(
                    await robot.state.get_tcp_pose(), 0.2, 0.5, "rail", [0.3, 0.0, 0.0], 0.5
                ),
            ]
            for move, end in zip(moves, (0.2, 0.3), strict=True):
                await move
                (scheme,) = await axes.get_eaxis_info()
                assert scheme.position == pytest.approx(end, abs=1e-6)
            pose = await robot.state.get_tcp_pose()
            x, y, z, *turn = pose
            await robot.blocking.movec_eaxis(
                [x, y - 0.02, z + 0.02, *turn], [x, y - 0.04, z, *turn], 0.2, 0.5, "rail",
                [0.4, 0.0, 0.0], 0.5,
            )  # fmt: skip
            (scheme,) = await axes.get_eaxis_info()
            assert scheme.position == pytest.approx(0.4, abs=1e-6)


def test_a_program_for_the_newer_class_names_schemes_in_lists() -> None:
    with Simulator(speed=float("inf"), generation="4.3", external_axes=RAIL) as sim:
        robot = with_rail(sim)
        assert robot.move_eaxis(["rail"], [[0.25, 0.0, 0.0]], [0.5], True) == 4
        (scheme,) = robot.get_eaxis_info()
        robot.close()
    assert scheme.pos == pytest.approx(0.25)
