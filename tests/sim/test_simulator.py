"""The whole simulated controller over its wire: programs move the arm and stop it."""

from __future__ import annotations

import logging
import math
import threading

import numpy as np
import psutil
import pytest
from for_each import for_each

import aioduco
from aioduco._wire.rpc import Op, RobotStatus
from aioduco.errors import ConnectionLost, ControllerError, ParameterError
from aioduco.kinematics import models
from aioduco.models.enums import RobotState, TaskState
from aioduco.models.pose import Joints, Pose
from aioduco.sim.simulator import READY, Simulator
from aioduco.testing import nothing_forgiven

from .conftest import (
    OUT_OF_RANGE,
    Aside,
    Connect,
    Program,
    Started,
    a_program,
    advance_until,
    standing_time,
)

SLOW = 0.02


def test_a_program_brings_the_robot_up_and_moves_it(sim: Simulator, connect: Connect) -> None:
    robot = connect(sim)
    assert robot.get_robot_state() == [4, 0, 4, 1]
    assert robot.to(0, 0, 1.5, 0, -1.5, 0) == TaskState.ILLEGAL
    robot.bring_up()
    assert robot.get_robot_state() == [6, 0, 5, 1]
    goal = Joints(0.5, 0.1, 1.4, 0.2, -1.5, 0.3)
    assert robot.to(*goal) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints.almost_equal(goal, 1e-3)
    assert robot.get_actual_joints_position() == pytest.approx(list(goal), abs=1e-3)


def test_a_line_ends_at_its_pose_and_an_unreachable_one_moves_nothing(
    sim: Simulator, robot: Program
) -> None:
    goal = Pose.of(robot.get_tcp_pose()).shifted(z=-0.1, x=0.05)
    assert robot.line(list(goal)) == TaskState.FINISHED
    sim.wait_until(lambda: not sim.moving)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(goal, position=1e-3, rotation=2e-3)
    there = sim.joints
    assert robot.line(list(goal.shifted(x=5.0))) == TaskState.ERROR
    assert "reach" in robot.get_last_error()[-1]
    assert robot.get_robot_state() == [6, 0, 5, 1]
    assert sim.joints.almost_equal(there, 1e-4)


@pytest.mark.slow
def test_an_offset_in_the_tools_frame_is_added_to_the_end_of_the_motion_before(
    sim: Simulator, robot: Program
) -> None:
    offset = Pose(0.0, 0.0, 0.05, 0.0, 0.0, 0.0)
    expected = Pose.of(robot.get_tcp_pose()) @ offset @ offset
    ids = [robot.tcp_move(list(offset), 0.1, 1.0, 0.0, "", False, Op(), False) for _ in range(2)]
    sim.wait_until(lambda: robot.get_noneblock_taskstate(ids[1]) == TaskState.FINISHED, 60.0)
    sim.wait_until(lambda: not sim.moving)
    assert Pose.of(robot.get_tcp_pose()).almost_equal(expected, position=1e-3, rotation=2e-3)


@pytest.mark.slow
def test_a_pose_is_reached_near_the_joints_given(sim: Simulator, robot: Program) -> None:
    goal = Pose.from_matrix(sim.arm.fkine(Joints.of(READY))).shifted(x=0.05)
    branches = sim.arm.ikine_all(goal)
    near = Joints.of(branches[-1])
    assert robot.movej_pose2(list(goal), 2.0, 5.0, 0.0, near, "", "", True, Op(), False) == 4
    sim.wait_until(lambda: not sim.moving)
    assert sim.joints.almost_equal(near, 1e-3)


@pytest.mark.slow
def test_percent_speeds_of_the_older_functions(sim: Simulator, robot: Program) -> None:
    def duration(goal: float, v: float) -> float:
        with standing_time(sim):
            begin = sim.time
            id_ = robot.movej([goal, *READY[1:]], v, 50.0, 0.0, False, Op(), False)
            advance_until(sim, lambda: robot.get_noneblock_taskstate(id_) == 4, every=20)
            return sim.time - begin

    fast = duration(0.5, 50.0)
    assert duration(0.0, 5.0) > 2 * fast
    assert robot.movej(READY, 101.0, 50.0, 0.0, True, Op(), False) == 8
    goal = robot.get_tcp_pose()
    assert robot.movej_pose(goal, 0.0, 50.0, 0.0, [], "", "", True, Op(), False) == 8
    assert robot.movej_pose(goal, 10.0, 50.0, 0.0, [], "", "", True, Op(), False) == 4


@pytest.mark.parametrize(("r", "radius"), [(10.0, 0.02), (49.0, 0.098)])
def test_percent_of_the_largest_radius(
    sim: Simulator, robot: Program, r: float, radius: float
) -> None:
    """A blended motion ends where its blend begins: a radius before its end."""
    corner = [0.5, *READY[1:]]
    tip = Pose.of(robot.cal_fkine(corner, [], []))
    with standing_time(sim):
        first = robot.movej(corner, 50.0, 50.0, r, False, Op(), False)
        second = robot.to(0.5, 0.3, *READY[2:], block=False)
        advance_until(sim, lambda: robot.get_noneblock_taskstate(first) == TaskState.INTERRUPT)
        assert math.dist(robot.get_tcp_pose()[:3], tip[:3]) == pytest.approx(radius, abs=2e-3)
    assert robot.ended(second) is TaskState.FINISHED
    assert robot.movej(corner, 50.0, 50.0, 50.1, True, Op(), False) == 8
    assert robot.movej_pose(list(tip), 50.0, 50.0, 50.1, [], "", "", True, Op(), False) == 8


@pytest.mark.slow
@pytest.mark.parametrize("line", [False, True])
def test_the_controller_chooses_an_acceleration_when_told_to(
    sim: Simulator, robot: Program, line: bool
) -> None:
    """The highest that the arm can do (manual 1.3.5), as if a program asked for too much."""
    here, there = list(robot.get_tcp_pose()), list(robot.get_tcp_pose())
    there[2] -= 0.1

    def duration(back: bool, a: float, *, chosen: bool) -> float:
        with standing_time(sim):
            begin = sim.time
            if line:
                goal = here if back else there
                id_ = robot.movel(goal, 1.0, a, 0.0, [], "", "", False, Op(), chosen)
            else:
                joints = [0.0 if back else 0.5, *READY[1:]]
                id_ = robot.movej2(joints, 2.0, a, 0.0, False, Op(), chosen)
            advance_until(sim, lambda: robot.get_noneblock_taskstate(id_) == TaskState.FINISHED)
            return sim.time - begin

    highest = duration(False, 1e3, chosen=False)
    assert duration(True, 0.5, chosen=True) == pytest.approx(highest, rel=0.1)
    assert duration(False, 0.5, chosen=False) > 1.5 * highest


# -- tasks ---------------------------------------------------------------------------------------


def test_a_call_that_does_not_block_returns_an_id_and_a_blend_ends_the_first_as_interrupted(
    sim: Simulator, robot: Program
) -> None:
    with standing_time(sim):
        first = robot.to(0.5, *READY[1:], r=0.05, block=False)
        second = robot.to(0.5, 0.3, *READY[2:], r=0.05, block=False)
        assert 1000 <= first < second
        advance_until(sim, lambda: robot.get_noneblock_taskstate(first) == TaskState.RUNNING)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(second) == TaskState.FINISHED, 60.0)
    assert robot.get_noneblock_taskstate(first) == TaskState.INTERRUPT


def test_one_connection_waits_while_another_works(
    sim: Simulator, robot: Program, aside: Aside
) -> None:
    moving = aside(sim, lambda other: other.to(1.0, *READY[1:], v=SLOW))
    sim.wait_until(lambda: sim.moving)
    assert sim.tasks[0].name == "movej2"
    assert robot.robotmoving()
    assert not moving.done()
    assert sim.drop_connections() == 2
    with pytest.raises(ConnectionLost):
        moving.result(30)
    assert sim.moving


def test_stop_from_another_connection_ends_a_blocking_move(
    sim: Simulator, robot: Program, aside: Aside
) -> None:
    moving = aside(sim, lambda other: other.to(1.0, *READY[1:], v=SLOW))
    sim.wait_until(lambda: sim.joints[0] > 0.001)
    assert robot.stop(True) == TaskState.FINISHED
    assert not sim.moving
    assert moving.result(30) == TaskState.STOPPED
    assert robot.get_robot_state() == [6, 0, 5, 1]
    there = sim.joints
    assert 0.0 < there[0] < 0.9
    assert robot.to(*there) == TaskState.FINISHED


def test_a_popup_pauses_all_tasks(sim: Simulator, robot: Program) -> None:
    with standing_time(sim):
        robot.to(0.4, *READY[1:], v=SLOW, block=False)
        advance_until(sim, lambda: sim.joints[0] > 0.001)
        robot.log_info("nothing happens")
        robot.log_error("look here")
    sim.wait_until(lambda: sim.view.program == 3)
    assert robot.get_last_error() == ["look here"]
    assert robot.abort(True) == TaskState.FINISHED


@pytest.mark.slow
def test_global_speed_scales_time(sim: Simulator, robot: Program) -> None:
    def duration(goal: float) -> float:
        begin = sim.time
        assert robot.to(goal, *READY[1:], v=0.5) == TaskState.FINISHED
        return sim.time - begin

    # So long that the time that calls take in between, on a fast clock, is little beside it.
    whole = duration(3.0)
    assert robot.speed(50.0) == TaskState.FINISHED
    assert robot.get_global_speed() == 50
    assert robot.speed(55.5) == TaskState.FINISHED
    assert (sim.view.speed, robot.get_global_speed()) == (55.5, 55)
    assert robot.speed(50.0) == TaskState.FINISHED
    assert duration(0.0) > 1.5 * whole
    for wrong in (0.0, 101.0, math.nan, -5.0):
        assert robot.speed(wrong) == OUT_OF_RANGE
    assert robot.get_global_speed() == 50


# -- what a controller refuses -------------------------------------------------------------------


@for_each(
    "change, ends",
    [
        ({"joints_list": [0.0] * 5}, 7),
        ({"joints_list": []}, 7),
        ({"joints_list": [0.0] * 7}, 7),
        ({"joints_list": [math.nan] * 6}, 8),
        ({"joints_list": [math.inf] + [0.0] * 5}, 8),
        ({"joints_list": [6.3] + [0.0] * 5}, 8),
        ({"v": 0.0}, 8),
        ({"v": -1.0}, 8),
        ({"v": math.nan}, 8),
        ({"v": 4.0}, 8),
        ({"a": 0.0}, 8),
        ({"a": math.nan}, 8),
        ({"r": -0.1}, 8),
        ({"r": math.nan}, 8),
    ],
)
def test_wrong_parameters_of_a_joint_motion(
    strict: Program, change: dict[str, object], ends: int
) -> None:
    args: dict[str, object] = {"joints_list": list(READY), "v": 1.0, "a": 1.0, "r": 0.0}
    args.update(change)
    assert strict.connection.call("movej2", (*args.values(), True, Op(), False)) == ends
    assert not strict.robotmoving()
    assert strict.get_last_error()[-1].startswith("movej2: ")


@pytest.mark.slow
def test_a_speed_far_above_its_range_is_the_highest(sim: Simulator, robot: Program) -> None:
    def hurry() -> None:
        with nothing_forgiven(sim):
            for v in (30.0, 100.0):
                assert robot.to(v / 100.0, *READY[1:], v=v) == TaskState.FINISHED

    with pytest.raises(AssertionError, match="speed above its range: 2 times"):
        hurry()
    with nothing_forgiven(sim):
        assert robot.to(*READY) == TaskState.FINISHED
        assert robot.to(*READY, v=math.inf) == TaskState.PARAMETER_MISMATCH
        assert robot.to(*READY, v=-30.0) == TaskState.PARAMETER_MISMATCH


@for_each(
    "change, ends",
    [
        ({"tool": "gripper"}, 7),
        ({"wobj": "pallet"}, 7),
        ({"p": [0.0] * 5}, 8),
        ({"p": [math.nan] * 6}, 8),
        ({"p": [0.5, 0.0, 0.5, 6.3, 0.0, 0.0]}, 8),
        ({"p": [1000.1, 0.0, 0.5, 3.0, 0.0, 0.0]}, 8),
        ({"v": 0.001}, 8),
        ({"q_near": [0.0] * 3}, 7),
    ],
)
def test_wrong_parameters_of_a_line(strict: Program, change: dict[str, object], ends: int) -> None:
    args: dict[str, object] = {
        "p": strict.get_tcp_pose(),
        "v": 0.1,
        "a": 1.0,
        "r": 0.0,
        "q_near": [],
        "tool": "",
        "wobj": "",
    }
    args.update(change)
    assert strict.connection.call("movel", (*args.values(), True, Op(), False)) == ends
    assert not strict.robotmoving()


def test_a_refusal_without_blocking_is_an_id_whose_task_has_ended(robot: Program) -> None:
    id_ = robot.movej2([math.nan] * 6, 1.0, 1.0, 0.0, False, Op(), False)
    assert id_ >= 1000
    assert robot.get_noneblock_taskstate(id_) == TaskState.PARAMETER_MISMATCH


@pytest.mark.usefixtures("real_cycle")
def test_a_motion_that_has_finished_is_no_longer_moving(sim: Simulator, robot: Program) -> None:
    """However fast it was, and though the arm itself still swings out a little."""
    for goal in (0.6, 0.0):
        assert robot.movej2([goal, *READY[1:]], 3.9, 50.0, 0.0, True, Op(), False) == 4
        assert robot.robotmoving() is False
    sim.wait_until(lambda: not sim.moving)


@pytest.mark.slow
def test_what_is_expected_and_what_is_are_of_one_cycle(sim: Simulator, robot: Program) -> None:
    """Else a joint at 2 rad/s would seem to be 2 mrad behind, besides what it really is."""
    seen: list[RobotStatus] = []
    with standing_time(sim):
        robot.movej2([1.5, *READY[1:]], 2.0, 5.0, 0.0, False, Op(), False)
        advance_until(sim, lambda: robot.getRobotStatus().jointExpectVelocity[0] > 1.99)
        while len(seen) < 20:
            seen.append(robot.getRobotStatus())
            sim.advance(1)
    assert all(one.jointExpectVelocity[0] > 1.99 for one in seen)
    behind = [one.jointExpectPosition[0] - one.jointActualPosition[0] for one in seen]
    assert max(map(abs, behind)) < 0.5e-3


# -- accidents -----------------------------------------------------------------------------------


def test_the_emergency_stop_ends_a_blocking_move_and_the_arm_stands(
    sim: Simulator, robot: Program, aside: Aside
) -> None:
    moving = aside(sim, lambda other: other.to(2.0, *READY[1:], v=1.0))
    sim.wait_until(lambda: sim.joints[0] > 0.05)
    sim.emergency_stop()
    assert moving.result(30) == TaskState.ERROR
    assert robot.get_robot_state() == [4, 0, 9, 1]
    status = robot.getRobotStatus()
    assert status.emcStopSignal
    assert status.slaveReady == [False] * 6
    sim.wait_until(lambda: not sim.moving)
    sim.release_emergency_stop()
    assert [robot.power_off(True), robot.power_on(True), robot.enable(True)] == [4, 4, 4]
    assert robot.to(*READY) == TaskState.FINISHED


@pytest.mark.slow
def test_a_lost_connection_stops_nothing_without_a_heartbeat(
    sim: Simulator, robot: Program, connect: Connect
) -> None:
    id_ = robot.to(0.5, *READY[1:], v=0.1, block=False)
    sim.wait_until(lambda: sim.moving)
    robot.connection.close()
    again = connect(sim)
    sim.wait_until(lambda: again.get_noneblock_taskstate(id_) == TaskState.FINISHED, 60.0)


# -- the end -------------------------------------------------------------------------------------


def test_shutdown_answers_and_takes_the_network_down(connect: Connect) -> None:
    told = threading.Event()
    with Simulator(speed=math.inf, on_shutdown=told.set) as sim:
        robot = connect(sim)
        assert robot.shutdown(True) == TaskState.FINISHED
        assert told.wait(20)
        assert sim.halted
        with pytest.raises(ConnectionLost):
            robot.get_robot_state()


@pytest.mark.slow
async def test_a_restart_is_awaited_to_its_end() -> None:
    async with Simulator(speed=10.0) as sim, aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        before = sim.time
        await robot.system.restart(timeout=60.0)
        assert sim.view.robot == RobotState.POWER_OFF
        assert sim.time > before + 1.0
        assert (await robot.bring_up()).states.robot is RobotState.ENABLE
        with pytest.raises(aioduco.RobotStateError, match="has not started after"):
            await robot.system.restart(timeout=0.001)


@pytest.mark.slow
def test_who_sees_a_controller_started_again_can_connect(connect: Connect) -> None:
    seen: list[tuple[bool | None, int]] = []

    class Watched(Simulator):
        def _network(self, up: bool | None) -> None:
            seen.append((up, self._running().runtime._snapshot.view.robot))
            super()._network(up)

    with Watched(speed=math.inf) as sim:
        robot = connect(sim)
        robot.bring_up()
        with standing_time(sim):
            assert robot.restart(False) >= 1000
        sim.wait_until(lambda: len(seen) == 2 and sim.view.robot == RobotState.POWER_OFF)
        sim.wait_until(lambda: sim.connections == 0)
        with pytest.raises(ConnectionLost):
            robot.get_robot_state()
        assert connect(sim).get_robot_state() == [4, 0, 4, 1]
    assert seen == [(False, RobotState.START), (True, RobotState.INITIALIZE)]


def test_closing_ends_blocked_calls_and_leaves_no_thread_or_socket(aside: Aside) -> None:
    def program(robot: Program) -> int:
        robot.bring_up()
        return robot.to(1.0, *READY[1:], v=0.001)

    process = psutil.Process()
    threads, descriptors = set(threading.enumerate()), process.num_fds()
    with Simulator(speed=math.inf) as sim:
        moving = aside(sim, program)
        sim.wait_until(lambda: sim.moving)
    with pytest.raises((ConnectionLost, ControllerError)):
        moving.result(30)
    started = set(threading.enumerate()) - threads
    assert [thread.name for thread in started if thread.name.startswith("sim-")] == []
    assert process.num_fds() == descriptors


async def test_the_same_in_async_code() -> None:
    async with Simulator(speed=math.inf) as sim:
        assert sim.port > 0
        await sim.wait_until_async(lambda: sim.time > 0.01)
        with pytest.raises(TimeoutError):
            await sim.wait_until_async(lambda: sim.moving, timeout=0.05)
        assert str(sim.port) in repr(sim)
    assert "not running" in repr(sim)


def test_a_simulator_is_entered_before_it_is_used_and_once() -> None:
    sim = Simulator()
    with pytest.raises(RuntimeError, match="not running"):
        _ = sim.time
    sim.close()
    with sim, pytest.raises(RuntimeError, match="running already"):
        sim.start()
    with sim:
        assert sim.time >= 0.0


@for_each(
    "options, said",
    [
        ({"model": "ur5"}, "model is 'ur5'"),
        ({"model": 5}, "model is 5"),
        ({"joints": [0.0] * 5}, "joints is"),
        ({"joints": [math.nan] * 6}, "is nan"),
        ({"joints": [30, -15, 105, 0, -90, 0]}, "(radians, not degrees)"),
        ({"port": 99999}, "port is 99999, but must be a whole number from 0 to 65535"),
        ({"port": "7003"}, "port is '7003'"),
        ({"status_port": -1}, "status_port is -1"),
        ({"force_port": 2**16}, "force_port is 65536"),
        ({"seed": -1}, "seed is -1"),
        ({"model": 0}, "model is 0"),
        ({"profile": 5}, "profile is 5"),
        ({"strict": "no"}, "strict is 'no'"),
        ({"real_readings": 1}, "real_readings is 1"),
        ({"values": ["speed"]}, "values is ['speed']"),
        ({"external_axes": 3}, "external_axes is 3"),
        ({"programs": ["main"]}, "programs is ['main']"),
        ({"on_shutdown": "end"}, "on_shutdown is 'end'"),
    ],
)
def test_wrong_options_are_named(options: dict[str, object], said: str) -> None:
    with pytest.raises(ParameterError) as refused:
        Simulator(**options)  # type: ignore[arg-type]  # that is the test
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("method", "arguments", "said"),
    [
        ("push", (None,), "wrench is None"),
        ("push", ([math.nan] * 6,), "wrench[0] is nan"),
        ("load", (1.0, None), "centre is None"),
        ("load", ("x",), "mass is 'x'"),
        ("drag", (np.ones((6, 1)),), "dry is"),  # this ended the simulation
        ("drag", ([1.0] * 5,), "dry is"),
        ("drag", ([1.0] * 5 + [-1.0],), "dry[5] is -1"),
        ("drag", ([1.0] * 6, ["1"] * 6), "viscous[0] is '1'"),
        ("collide", (None,), "joint is None"),
        ("collide", (2.7,), "joint is 2.7"),
        ("collide", (7,), "1 to 6"),
        ("switch_mode", ("auto",), "mode is 'auto'"),
        ("set_digital_input", (3, "off"), "value is 'off'"),
        ("set_tool_digital_input", (1, 2), "value is 2"),
        ("advance", (None,), "cycles is None"),
        ("rule", (None, 2), "output is None"),
        ("rule", (1, True), "input is True"),
        ("rule", (1, 2.5), "input is 2.5"),
        ("where", ([],), "name is []"),
        ("render", (), "positions is True"),
    ],
)
def test_what_a_method_cannot_take_is_named_and_nothing_changes(
    sim: Simulator, method: str, arguments: tuple[object, ...], said: str
) -> None:
    options = {"positions": True} if method == "render" else {}
    with pytest.raises(ParameterError) as refused:
        getattr(sim, method)(*arguments, **options)
    assert said in str(refused.value)
    with pytest.raises(IndexError, match="no signal '3'"):
        sim.get_digital_output("3")  # type: ignore[arg-type]  # that is the test
    now = sim.time
    sim.wait_until(lambda: sim.time > now)


def test_after_its_observer_has_raised_each_method_says_so(
    caplog: pytest.LogCaptureFixture,
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("of the test")

    with caplog.at_level(logging.CRITICAL), Simulator() as sim:
        sim.observe(fail)
        with pytest.raises(RuntimeError, match="of the test"):
            sim.wait_until(lambda: False)
        for act in (sim.lock_time, sim.statistics, sim.emergency_stop):  # the first one waited
            with pytest.raises(RuntimeError, match="of the test"):
                act()
        with pytest.raises(RuntimeError, match="of the test"):
            sim.push([0.0] * 6)


@pytest.mark.slow
def test_the_same_program_gives_the_same_joints_at_any_speed(started: Started) -> None:
    ends = []
    for speed in (math.inf, 20.0):
        sim, robot = started(speed=speed)
        assert robot.to(0.3, 0.1, 1.5, 0.0, -1.5, 0.0) == TaskState.FINISHED
        sim.wait_until(lambda sim=sim: not sim.moving)  # type: ignore[misc]
        ends.append(sim.joints)
    assert ends[0].almost_equal(ends[1], 1e-5)


@pytest.mark.parametrize("model", models())
def test_each_arm_moves_by_joints_and_along_a_line(model: str) -> None:
    with Simulator(model, speed=math.inf) as sim, a_program(sim) as robot:
        robot.bring_up()
        series, _, name = model.upper().partition("_")
        assert robot.get_robot_type()[:2] == [series, name]
        goal = np.array(READY) + np.array([0.4, 0.1, -0.2, 0.1, 0.3, -0.5])
        assert robot.to(*goal, v=2.0) == TaskState.FINISHED
        sim.wait_until(lambda: not sim.moving)
        assert np.abs(np.array(sim.joints) - goal).max() < 1e-4
        target = Pose.of(robot.get_tcp_pose()).shifted(x=-0.02, y=0.05, z=0.03)
        answer = robot.movel(list(target), 0.25, 2.0, 0.0, [], "", "", True, Op(), False)
        assert answer == TaskState.FINISHED
        sim.wait_until(lambda: not sim.moving)
        there = Pose.of(robot.get_tcp_pose())
        assert there.almost_equal(target, position=2e-4, rotation=2e-4)
        assert robot.get_last_error() == []
