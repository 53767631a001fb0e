"""Kinematics of the controller, force control, settings: what they do beyond one call."""

from __future__ import annotations

import itertools
import math
from typing import Any

import anyio
import pytest
from for_each import for_each
from wire.lanes import noted

import aioduco
from aioduco import Joints, Load, Pose
from aioduco._wire import rpc
from aioduco.api.kinematics import Reachability
from aioduco.testing import eventually_async
from api.cases import END_ERRORS, Case
from api.desk import Desk
from api.motion_cases import HOME, NEAR, OTHER, POSE
from api.setting_cases import CAPS, DAMP, FORCE, ON, PRESS

STARTED = [case for case in FORCE if case.answer == 4 and not case.moves]


async def test_a_pose_out_of_reach_is_an_error(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("cal_ikine", lambda p, q_near, tool, wobj: q_near)
    desk.answer("cal_fkine", lambda q, tool, wobj: POSE if q == NEAR else OTHER)
    with pytest.raises(aioduco.Unreachable, match="out of the arm's reach"):
        await robot.kinematics.cal_ikine(OTHER, q_near=NEAR)
    assert await robot.kinematics.cal_ikine(POSE, q_near=NEAR) == Joints(*NEAR)
    for nothing in ([], [math.nan] * 6):
        desk.answer("cal_ikine", nothing)
        with pytest.raises(aioduco.Unreachable, match="no joints"):
            await robot.kinematics.cal_ikine(POSE)


async def test_joints_are_led_back_with_the_same_frames(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("cal_ikine", HOME)
    desk.answer("cal_fkine", POSE)
    await robot.kinematics.cal_ikine(POSE, wobj=OTHER)
    (asked,), (checked,) = desk.received("cal_ikine"), desk.received("cal_fkine")
    assert asked.args == (POSE, [], [], OTHER)
    assert checked.args == (HOME, [], OTHER)


async def test_where_a_mounted_arms_base_is_does_not_depend_on_its_motion(
    robot: aioduco.Robot, desk: Desk
) -> None:
    """The work object of cal_ikine is in the world, that of cal_fkine at the base."""
    wall, wobj, pose = Pose(0, 0, 1, 0, math.pi / 2, 0), Pose(*OTHER), Pose(*POSE)
    tips = {tuple(HOME): wall.inverse() @ wobj @ pose, tuple(NEAR): pose}
    desk.answer("cal_ikine", HOME)
    desk.answer("cal_fkine", lambda q, tool, wobj: [*Pose(*wobj).inverse() @ tips[tuple(q)]])
    now = rpc.RobotStatus(jointActualPosition=NEAR, cartActualPosition=[*wall @ pose])
    desk.answer("getRobotStatus", now)
    desk.answer("get_tcp_pose", [*pose.shifted(z=0.01)])  # a moment earlier or later
    assert await robot.kinematics.cal_ikine(pose, wobj=wobj) == Joints(*HOME)


async def test_one_orientation_has_many_angles(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("cal_ikine", HOME)
    desk.answer("cal_fkine", [*POSE[:3], POSE[3] - 2 * 3.141592653589793, *POSE[4:]])
    assert await robot.kinematics.cal_ikine(POSE) == Joints(*HOME)


async def check(robot: aioduco.Robot) -> Reachability:
    return await robot.kinematics.reach_check(
        base=POSE, wobj=POSE, tool=POSE, ref_pos=HOME, check_points=[POSE, OTHER]
    )


async def test_what_cannot_be_reached(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("reach_check", rpc.ReachabilityParam(result=False, joints_pos=[HOME]))
    found = await check(robot)
    assert not found
    assert found.joints == ()


async def test_reach_without_joints_is_no_answer(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("reach_check", rpc.ReachabilityParam(result=True, joints_pos=[HOME]))
    with pytest.raises(aioduco.ControllerError, match="1 of 2 poses"):
        await check(robot)


async def test_a_load_goes_out_as_it_came_in(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("get_tool_load", [1.5, 0.1, 0.2, 0.3])
    desk.answer("set_load_data", 1234)
    load = await robot.frames.get_tool_load()
    assert load == Load(mass=1.5, x=0.1, y=0.2, z=0.3)
    await robot.frames.set_load_data(load)
    desk.answer("get_tool_load", [])
    with pytest.raises(aioduco.StaleState, match="0 of 4"):
        await robot.frames.get_tool_load()


async def test_what_returns_nothing_by_the_manual(robot: aioduco.Robot, desk: Desk) -> None:
    for taken in (0, 1, 2, 4, 1000):
        desk.answer("set_load_data", taken)
        await robot.frames.set_load_data(Load(1.0))
    for code, error in [(-1, aioduco.Refused), *END_ERRORS.items()]:
        desk.answer("set_load_data", code)
        with pytest.raises(error):
            await robot.frames.set_load_data(Load(1.0))


@pytest.mark.parametrize(("mode", "interval"), [(0, 5.0), (1, 0.25)])
async def test_a_track_has_the_interval_of_its_mode(
    robot: aioduco.Robot, desk: Desk, mode: int, interval: float
) -> None:
    desk.answer("start_record_track", 1000)
    await robot.motion.start_record_track("seam", mode)
    await robot.motion.start_record_track("seam", mode, interval=1.0)
    default, given = desk.received("start_record_track")
    assert default.args == ("seam", mode, "", "", interval)
    assert given.args[-1] == pytest.approx(1.0 if mode else 57.29577951308232)


# -- force control: functions that answer with the id of a task ------------------------------------


@pytest.mark.parametrize("case", STARTED, ids=str)
async def test_a_task_is_followed_to_its_end(robot: aioduco.Robot, desk: Desk, case: Case) -> None:
    desk.begins(case.name)
    await case.method(robot)(**case.args)
    (task,) = (one for one in desk.tasks.values() if one.name == case.name)
    assert task.state is aioduco.TaskState.FINISHED
    assert not robot.tasks


async def test_a_task_that_fails(robot: aioduco.Robot, desk: Desk) -> None:
    desk.errors = ["an old error"]
    for reason in ("no force sensor", "the sensor is not calibrated"):
        desk.begins("fc_start", end=aioduco.TaskState.ERROR, error=reason)
        with pytest.raises(aioduco.TaskFailed) as failed:
            await robot.force.fc_start()
        assert failed.value.errors == (reason,)


async def test_a_setting_that_fails_says_why(robot: aioduco.Robot, desk: Desk) -> None:
    desk.errors = ["an old error"]
    for reason in ("no such signal", "the device does not answer"):
        desk.fails("modbus_write", 6, reason)
        with pytest.raises(aioduco.TaskFailed) as failed:
            await robot.modbus.modbus_write("pump", 1)
        assert failed.value.errors == (reason,)
    desk.fails("modbus_delete_signal", 7, "it is in use")
    with pytest.raises(aioduco.TaskIllegal) as illegal:
        await robot.modbus.modbus_delete_signal("pump")
    assert illegal.value.errors == ("it is in use",)
    desk.fails("set_tool_data", 0, "35 kg at most")
    with pytest.raises(aioduco.Refused, match=r"\(answer 0\): 35 kg at most$"):
        await robot.frames.set_tool_data("grip", POSE, Load(40.0))
    desk.fails("set_system_value_bool", 1, "there is no 'busy'")
    with pytest.raises(aioduco.Refused, match=r"\(answer 1\): there is no 'busy'$"):
        await robot.registers.set_system_value_bool("busy", True)


@pytest.mark.parametrize(
    ("section", "name", "args", "answer"),
    [
        ("registers", "get_system_value_double", ("count",), 0.0),
        ("modbus", "modbus_set_frequency", ("count", 20), None),
    ],
)
async def test_what_a_call_was_refused_for_is_no_error_of_the_next_command(
    robot: aioduco.Robot, desk: Desk, section: str, name: str, args: tuple[Any, ...], answer: Any
) -> None:
    desk.begins("fc_start", end=aioduco.TaskState.ERROR, error="no force sensor")
    with pytest.raises(aioduco.TaskFailed):
        await robot.force.fc_start()

    desk.fails(name, answer, f"{name}: there is no 'count'")
    with pytest.raises(aioduco.Refused, match="there is no 'count'"):
        await getattr(getattr(robot, section), name)(*args)
    desk.begins("fc_start", end=aioduco.TaskState.ERROR, error="it is not calibrated")
    with pytest.raises(aioduco.TaskFailed) as failed:
        await robot.force.fc_start()
    assert failed.value.errors == ("it is not calibrated",)


async def test_a_variable_that_goes_with_its_project_is_missed(
    robot: aioduco.Robot, desk: Desk
) -> None:
    """It was read as 0 after that."""
    desk.answer("get_system_value_double", 1.5)
    assert await robot.registers.get_system_value_double("count") == 1.5
    desk.fails("get_system_value_double", 0.0, "get_system_value_double: there is no 'count'")
    with pytest.raises(aioduco.Refused, match="there is no 'count'"):
        await robot.registers.get_system_value_double("count")


@for_each(
    "section, name, args, when",
    [
        ("registers", "get_system_value_double", ("count",), 2),
        ("modbus", "modbus_set_frequency", ("pump", 20), 1),
    ],
)
async def test_an_error_of_something_else_refuses_nothing(
    robot: aioduco.Robot, desk: Desk, section: str, name: str, args: tuple[object, ...], when: int
) -> None:
    """A call that only the error list tells of was refused by the words of a collision."""
    count = itertools.count(1)

    def call(*_: object) -> float:
        if next(count) == when:
            desk.errors = [*desk.errors, "Joint 4 检测到碰撞"]
        return 0.0

    desk.answer(name, call)
    await getattr(getattr(robot, section), name)(*args)


async def test_a_recording_that_does_not_begin(robot: aioduco.Robot, desk: Desk) -> None:
    desk.begins("start_record_track", end=aioduco.TaskState.ILLEGAL, lasting=0.0)
    with pytest.raises(aioduco.TaskIllegal, match="start_record_track"):
        await robot.motion.start_record_track("seam", 0)
    desk.answer("start_record_track", 0)
    with pytest.raises(aioduco.Refused, match="start_record_track"):
        await robot.motion.start_record_track("a/b", 0)
    desk.begins("start_record_track", lasting=60.0)  # as long as the recording
    await robot.motion.start_record_track("seam", 0)


async def test_a_direction_that_gives_way_has_damping(robot: aioduco.Robot, desk: Desk) -> None:
    with pytest.raises(aioduco.ParameterError, match=r"damp\[2\]"):
        await robot.force.fc_config(ON, PRESS, [1000.0, 0, 0, 0, 57.0, 0], CAPS)
    assert desk.received("fc_config") == ()
    desk.answer("fc_config", 4)
    await robot.force.fc_config(ON, PRESS, DAMP, CAPS)
    (call,) = desk.received("fc_config")
    assert call.args == (ON, PRESS, DAMP, CAPS, [0.0] * 6, "", "", 0)


async def test_a_condition_has_an_axis(robot: aioduco.Robot, desk: Desk) -> None:
    force, none = robot.force, [0.0] * 6
    for wait in (force.fc_wait_pos, force.fc_wait_vel, force.fc_wait_ft):
        desk.answer(wait.__name__, 4)
        with pytest.raises(aioduco.ParameterError, match=r"range.*at least one above 0"):
            await wait(none, none, absolute=False, duration=0.1, timeout=5.0)
        assert desk.received(wait.__name__) == ()
        await wait(none, [0.0] * 5 + [0.1], absolute=False, duration=0.1, timeout=5.0)


@pytest.mark.parametrize("name", ["fc_stop", "simulation"])
async def test_the_arm_must_stand(robot: aioduco.Robot, desk: Desk, name: str) -> None:
    async def call() -> None:
        await (robot.force.fc_stop() if name == "fc_stop" else robot.settings.simulation(True))

    desk.begins(name)
    desk.motion_time = 30.0
    await robot.motion.movej2(HOME, 1.0, 1.0).start()
    with pytest.raises(aioduco.RobotStateError, match="the arm moves"):
        await call()
    assert desk.received(name) == ()
    await robot.stop()
    await call()
    assert len(desk.received(name)) == 1


async def test_a_motion_that_is_being_sent_counts(robot: aioduco.Robot, desk: Desk) -> None:
    desk.motion_time = 30.0
    let = desk.hold("get_last_error", [])
    raised: list[BaseException] = []
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(robot.motion.movej2(HOME, 1.0, 1.0).start)
        await eventually_async(lambda: bool(desk.received("get_last_error")))
        tasks.start_soon(noted, raised, aioduco.RobotStateError, robot.settings.simulation(True))
        for _ in range(3):
            await robot.state.get_tcp_pose()
        let.set()
    assert len(raised) == 1
    assert desk.received("simulation") == ()


@pytest.mark.parametrize("name", ["fc_stop", "simulation"])
@pytest.mark.parametrize("cancelled", [False, True])
async def test_no_motion_is_sent_meanwhile(
    robot: aioduco.Robot, desk: Desk, name: str, cancelled: bool
) -> None:
    let = desk.hold(name)
    scope = anyio.CancelScope()

    async def call() -> None:
        with scope:
            await (robot.force.fc_stop() if name == "fc_stop" else robot.settings.simulation(True))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(call)
        await eventually_async(lambda: bool(desk.received(name)))
        if cancelled:
            scope.cancel()
        tasks.start_soon(robot.motion.movej2(HOME, 1.0, 1.0).start)
        for _ in range(3):
            await robot.state.get_tcp_pose()
        assert desk.received("movej2") == ()
        let.set()
    assert len(desk.received("movej2")) == 1


async def test_a_switch_that_is_refused_says_why(robot: aioduco.Robot, desk: Desk) -> None:
    reason = "simulation: motions are under way or wait"
    desk.begins("simulation", end=aioduco.TaskState.ILLEGAL, error=reason)
    with pytest.raises(aioduco.TaskIllegal, match=r"(?s)simulation.*motions are under way or wait"):
        await robot.settings.simulation(True)


async def test_another_program_moves_the_arm(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("robotmoving", True)
    with pytest.raises(aioduco.RobotStateError, match="the arm moves"):
        await robot.force.fc_stop()
    desk.answer("robotmoving", False)
    assert desk.received("fc_stop") == ()


async def test_poses_are_values(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("get_wobj", [*POSE, 9.0])
    assert await robot.frames.get_wobj() == Pose(*POSE)
