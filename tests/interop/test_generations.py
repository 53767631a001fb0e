"""A client of each generation, by the Apache compiler, at a simulator of that generation."""

from __future__ import annotations

import contextlib
import importlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from client.older import OLDER

from aioduco._wire import idl
from aioduco.models.pose import Pose
from aioduco.sim import Simulator
from aioduco.testing import eventually

from . import generations
from .conftest import Generated, _need, connected

pytestmark = [pytest.mark.interop, pytest.mark.slow]

FINISHED, WRONG = 4, 8
TURNED = [1.0, 0.2, 1.4, 0.1, -1.4, 0.3]
#: by generation with jogs, the numbers of a positive and of a negative one
JOGS = {"3.8": (1, -1), "older": (1, -1), "4.3": (0, 1)}
PARTS = ("RPCRobot", "ttypes")
RAIL = {"rail": [(-1.0, 1.0, 0.5, 2.0)]}


@pytest.fixture(scope="module")
def clients(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Generated]]:
    """What the compiler wrote, by generation."""
    _need("thrift", "thrift-compiler")
    out = tmp_path_factory.mktemp("generations")
    generations.generate(out)
    sys.path.insert(0, str(out))
    try:
        yield {
            name: Generated(*(importlib.import_module(f"{package}.{part}") for part in PARTS))
            for name, package in ((name, generations.package(name)) for name in generations.NAMES)
        }
    finally:
        sys.path.remove(str(out))
        for name in [name for name in sys.modules if name.startswith("generation_")]:
            del sys.modules[name]


@dataclass(frozen=True)
class Cell:
    """A client that was brought up, and its controller."""

    robot: Any
    structs: Any
    sim: Simulator


@contextlib.contextmanager
def cell(clients: dict[str, Generated], client: str, controller: Any) -> Iterator[Cell]:
    with (
        Simulator(speed=float("inf"), generation=controller, external_axes=RAIL) as sim,
        connected(clients[client], sim.host, sim.port) as robot,
    ):
        assert robot.power_on(True) == FINISHED
        assert robot.enable(True) == FINISHED
        yield Cell(robot, clients[client].structs, sim)


@pytest.fixture
def newer(clients: dict[str, Generated]) -> Iterator[Cell]:
    with cell(clients, "4.3", "4.3") as made:
        yield made


def unknown(call: Any, *args: Any) -> bool:
    """Whether the controller says that it does not have a function."""
    thrift = importlib.import_module("thrift.Thrift")
    with pytest.raises(thrift.TApplicationException) as caught:
        call(*args)
    return bool(caught.value.type == thrift.TApplicationException.UNKNOWN_METHOD)


def move(robot: Any, joints: list[float]) -> int:
    """A joint move; what a generation has behind `block` is left out."""
    rest = len(robot.movej2.__code__.co_varnames[: robot.movej2.__code__.co_argcount]) - 6
    answer: int = robot.movej2(joints, 2.0, 4.0, 0.0, True, *[None] * rest)
    return answer


@pytest.mark.parametrize("name", generations.NAMES)
def test_its_own_client_moves_the_arm(clients: dict[str, Generated], name: str) -> None:
    with cell(clients, name, name) as made:
        assert move(made.robot, TURNED) == FINISHED
        assert made.robot.getRobotStatus().jointActualPosition == pytest.approx(TURNED, abs=1e-3)
        made.sim.set_digital_input(3, True)
        eventually(lambda: made.robot.getRobotIOStatus().digitalInputs[2])


@pytest.mark.parametrize("name", generations.NAMES)
def test_it_has_the_functions_of_its_generation(clients: dict[str, Generated], name: str) -> None:
    """Called by the client that knows every function: `generation_3_8` and what 4.3 adds."""
    lacks = OLDER[name]["lacks"] if name in OLDER else []
    with cell(clients, "4.3", name) as made:
        for function in ("get_robot_version", "get_base", "get_tcp_pose_command"):
            has = function in idl.functions() if name != "4.3" else True
            if has and function not in lacks:
                getattr(made.robot, function)()
            else:
                assert unknown(getattr(made.robot, function))


@pytest.mark.parametrize("name", JOGS)
def test_a_jog_goes_where_its_number_says(clients: dict[str, Generated], name: str) -> None:
    with cell(clients, name, name) as made:
        for number, sign in zip(JOGS[name], (1, -1), strict=True):
            before = made.sim.joints[0]
            jog = made.structs.MoveJogTaskParam(number, 2, 0, 50.0, 0, True, 0.1, 0.0)
            assert made.robot.move_jog(jog, True) not in (WRONG, 7)
            assert made.sim.joints[0] - before == pytest.approx(0.1 * sign, abs=1e-3)


def test_one_scale_for_all_joints_in_hand_guiding(clients: dict[str, Generated]) -> None:
    with cell(clients, "older", "older") as made:
        assert made.robot.set_hand_teach_parameter(0, 100, 100, 0, [True] * 6) == FINISHED


def test_the_oldest_does_not_know_the_third_trigger(clients: dict[str, Generated]) -> None:
    op = importlib.import_module(f"{generations.package('3.8')}.ttypes").Op()
    op.time_or_dist_1, op.trig_io_1, op.trig_value_1 = 1, 3, True
    op.time_or_dist_3, op.trig_io_3, op.trig_value_3 = 1, 4, True
    with cell(clients, "3.8", "oldest") as made:
        move_ = made.robot.movej2(TURNED, 0.2, 4.0, 0.0, False, op, False)
        eventually(lambda: made.sim.get_digital_output(3))
        assert made.robot.stop(True) == FINISHED
        assert made.robot.get_noneblock_taskstate(move_) == 3
        assert not made.sim.get_digital_output(4)


def test_minus_one_is_no_direction_of_manual_4_3(newer: Cell) -> None:
    jog = newer.structs.MoveJogTaskParam(-1, 2, 0, 50.0, 0, True, 0.1, 0.0)
    assert newer.robot.move_jog(jog, True) == WRONG


def test_a_turn_of_the_tool_takes_its_step_from_the_joints_field(newer: Cell) -> None:
    before = Pose(*newer.robot.get_tcp_pose())
    jog = newer.structs.MoveJogTaskParam(0, 1, 5, 50.0, 1, True, 0.2, 0.0)
    assert newer.robot.move_jog(jog, True) not in (WRONG, 7)
    turned = Pose(*newer.robot.get_tcp_pose()) @ before.inverse()
    assert turned.rz == pytest.approx(0.2, abs=1e-3)


def test_reach_check_takes_the_tool_before_the_work_object(newer: Cell) -> None:
    near, nothing = list(newer.sim.joints), [0.0] * 6
    pose = newer.robot.get_tcp_pose()
    turned, lifted = [0.0, 0.0, 0.0, 0.0, 0.0, 2.0], [0.0, 0.0, 3.0, 0.0, 0.0, 0.0]
    found = newer.robot.reach_check(nothing, nothing, turned, near, [pose])
    assert (found.result, found.index, found.singularity_type) == (True, 0, 0)
    below = [pose[0], pose[1], pose[2] - 3.0, *pose[3:]]
    assert newer.robot.reach_check(nothing, nothing, lifted, near, [below]).result
    found = newer.robot.reach_check(nothing, lifted, nothing, near, [below, pose])
    assert (found.result, found.index, found.singularity_type) == (False, 1, 4)


def test_more_fields_of_the_status(newer: Cell) -> None:
    status = newer.robot.getRobotStatus()
    assert status.jointAuxiliaryPosition == status.jointActualPosition
    assert status.jointGravityTorque == []
    assert len(status.jointActualTorque) == 6


def test_an_arc_of_a_fixed_radius_is_refused(newer: Cell) -> None:
    x, y, z, *turn = newer.robot.get_tcp_pose()
    middle, end = [x, y + 0.03, z + 0.03, *turn], [x, y + 0.06, z, *turn]
    arc: tuple[Any, ...] = (
        middle,
        end,
        0.2,
        0.5,
        0.0,
        0,
        [],
        "",
        "",
        True,
        newer.structs.Op(),
        True,
    )
    assert newer.robot.movec(*arc, 0.1) == WRONG
    assert newer.robot.movec(*arc, 0.0) == FINISHED
    assert newer.robot.get_tcp_pose()[:3] == pytest.approx(end[:3], abs=1e-3)


def test_schemes_of_external_axes_come_in_lists(newer: Cell) -> None:
    assert newer.robot.enable_eaxis_scheme("rail") == FINISHED
    to = (["rail"], [[0.5, 0.0, 0.0]], [0.5])
    assert newer.robot.movej2_eaxis(TURNED, 2.0, 4.0, 0.0, *to, True, None, False) == FINISHED

    def stands() -> bool:
        (state,) = newer.robot.get_eaxis_info()
        return (state.vel, state.acc) == (0.0, 0.0) and state.pos == pytest.approx(0.5)

    eventually(stands)  # the cycle after the last set-point
    two = (["rail"] * 2, [[0.1, 0.0, 0.0]] * 2, [0.5] * 2)
    assert newer.robot.movej2_eaxis(TURNED, 2.0, 4.0, 0.0, *two, True, None, False) == 7


@pytest.mark.parametrize(("generation", "tool"), [("3.8", False), ("4.3", True)])
def test_the_speed_of_servo_tcp(clients: dict[str, Generated], generation: str, tool: bool) -> None:
    """That of the fastest joint by manual 3.8, that of the tool by 4.3."""
    joints, tips = [0.0], [0.0]

    def look(snapshot: Any, *_: object) -> None:
        joints.append(float(np.abs(snapshot.setpoint.qd).max()))
        rates = made.sim.arm.jacobian(snapshot.setpoint.q) @ snapshot.setpoint.qd
        tips.append(float(np.linalg.norm(rates[:3])))

    with cell(clients, generation, generation) as made:
        made.sim.observe(look)
        gains = ("", True, 200.0, 25.0, 10.0, 1.0)
        made.robot.servo_tcp([0.0, 0.0, -0.03, 0.0, 0.0, 0.0], 0.02, 5.0, *gains)
        made.sim.observe(None)
    assert max(tips if tool else joints) == pytest.approx(0.02, rel=0.2)
    assert max(joints if tool else tips) != pytest.approx(0.02, rel=0.2)


def test_functions_without_arguments(newer: Cell) -> None:
    robot = newer.robot
    assert robot.get_base() == [0.0] * 6
    assert robot.get_home_pose() == pytest.approx(list(newer.sim.joints), abs=1e-6)
    assert robot.get_installation() == [0.0, 0.0]
    assert robot.get_tcp_pose_command() == pytest.approx(robot.get_tcp_pose(), abs=1e-3)
    assert robot.get_tcp_speed_command() == [0.0] * 6
    assert robot.get_simulation_state() is False
    assert move(robot, [0.0]) == 7
    assert robot.get_last_error()
    robot.clear_error_message()
    assert robot.get_last_error() == []
    assert not unknown(robot.enable_laser_track)
