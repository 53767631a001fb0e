"""`robot.blocking`: motions by calls that the controller answers at their end.

`test_motions_answered_at_end.py` tests how they end, by a stop, an error or a lost connection.
"""

from __future__ import annotations

import inspect
import time
from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import anyio
import pytest
from client.bench import HOME, POSE, BenchTask
from for_each import for_each
from wire.lanes import noted

import aioduco
import aioduco.sync
from aioduco import Jog, Outcome, ProgramState, TaskState
from aioduco._wire import idl
from aioduco.sim import Simulator
from aioduco.supervision import gate
from aioduco.supervision.gate import PermitEnding
from aioduco.testing import eventually_async
from api.cases import NOBODY, Case, blocking_cases, cases
from api.desk import HELD, Desk

READY = [0.0, 0.0, 1.57, 0.0, -1.57, 0.0]
#: functions with `block` that are not motions, and motions that only a command ends
ELSEWHERE = {
    "waits by itself, and moves nothing": {
        *("power_on", "power_off", "enable", "disable", "shutdown", "restart", "simulation"),
        *("stop", "pause", "resume", "abort", "speed_stop", "end_teach_mode", "stop_manual_move"),
    },
    "is sent with block true": {
        *("set_standard_digital_out", "set_tool_digital_out", "set_analog_output_mode"),
        *("set_standard_analog_voltage_out", "set_standard_analog_current_out"),
        *("set_baudrate_485", "set_baudrate_can", "set_eaxis_param", "set_eaxiss_scheme_param"),
        *("add_eaxis_scheme", "delete_eaxis_scheme", "set_servo_config", "apply_servo_config"),
        *("trackEnqueue", "trackEnqueueOp", "realtime_data_enqueue"),
    },
    "only a command ends it": {"teach_mode", "move_jog_eaxis"},
}


@pytest.fixture
def desk(desk: Desk) -> Desk:
    """A controller whose motions block if they are asked to."""
    for case in cases():
        if case.moves and "block" in idl.functions()[case.name].parameters:
            if case.name not in desk._answers or case.name == "move_jog":  # by a step
                desk.moves(case.name)
            desk.blocks(case.name)
    return desk


def line(robot: aioduco.Robot, r: float = 0.0) -> Awaitable[TaskState]:
    return robot.blocking.movel(POSE, v=0.2, a=0.5, r=r)


# -- what is there ---------------------------------------------------------------------------------


def test_every_function_with_block_is_there_or_elsewhere_for_a_reason() -> None:
    blocks = {name for name, one in idl.functions().items() if "block" in one.parameters}
    there = {name for name in blocks if hasattr(NOBODY.blocking, name)}
    assert blocks - there == set().union(*ELSEWHERE.values())
    assert there == {case.name for case in blocking_cases()}


@for_each("case", blocking_cases())
def test_it_takes_what_the_motion_takes(case: Case) -> None:
    (motion,) = (one for one in cases() if one.name == case.name)
    ours, theirs = (inspect.signature(one.method(NOBODY)) for one in (case, motion))
    expected = [one for name, one in theirs.parameters.items() if name in case.args]
    assert list(ours.parameters.values()) == expected
    assert set(theirs.parameters) - set(case.args) <= {"time"}
    text = inspect.getdoc(case.method(NOBODY)) or ""
    for name in ours.parameters:
        assert f"\n    {name}: " in text
    assert f"`robot.{motion.section}.{case.name}`" in text
    assert "manual" in text.lower()
    assert "await" not in text


# -- what is sent, and what comes back -------------------------------------------------------------


@pytest.mark.parametrize("case", blocking_cases(), ids=str)
async def test_a_blocking_call_returns_the_state_at_its_end(
    robot: aioduco.Robot, desk: Desk, case: Case
) -> None:
    desk.motion_time = 0.02
    state = await case.method(robot)(**case.args)
    assert state is TaskState.FINISHED
    assert isinstance(state, TaskState)
    (call,) = desk.received(case.name)
    assert call.args == case.wire
    assert not robot.tasks
    if case.name not in HELD:
        assert not desk.moving()
    assert "stop" not in desk.commands


async def test_other_calls_and_other_blocking_calls_go_on_beside_it(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.motion_time = 30.0
    states: list[TaskState] = []

    async def one() -> None:
        states.append(await line(robot))

    async with anyio.create_task_group() as tg:
        tg.start_soon(one)
        tg.start_soon(one)
        await eventually_async(lambda: len(desk.received("movel")) == 2)
        assert list(await robot.state.get_tcp_pose()) == POSE
        assert not states
        desk.arrive()
        await eventually_async(lambda: len(states) == 1)
        desk.arrive()
    assert states == [TaskState.FINISHED, TaskState.FINISHED]


async def test_a_motion_that_is_read_ahead_may_move_on(desk: Desk) -> None:
    desk.motion_time = 30.0
    start = desk._answers["movel"]

    def ahead(*args: Any) -> int:
        start(*args[:7], False, *args[8:])
        return int(TaskState.INTERRUPT)

    desk.answer("movel", ahead)
    async with aioduco.connect(desk.host, desk.port) as robot:
        assert await line(robot, r=0.05) is TaskState.INTERRUPT
        assert desk.moving()
    assert not desk.moving()
    assert desk.commands == ["movel", "stop"]


async def test_a_started_motion_blends_into_a_blocking_one(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.motion_time = 30.0
    task = await robot.motion.movel(POSE, v=0.2, a=0.5, r=0.05).start()
    desk.motion_time = 0.1
    blocking = desk._answers["movel"]

    def comes(*args: Any) -> int:
        """The first motion lasts until the second has come, however late that is."""
        desk.tasks[task.id].end = time.monotonic() + 0.5
        state: int = blocking(*args)
        return state

    desk.answer("movel", comes)
    assert await line(robot) is TaskState.FINISHED
    assert await task is Outcome.BLENDED


async def test_a_started_motion_does_not_blend_into_one_that_was_refused(
    robot: aioduco.Robot, desk: Desk
) -> None:
    task = await robot.motion.movej2(HOME, v=1.0, a=1.0, r=0.05).start()
    desk.answer("movel", -1)
    desk.tasks[task.id].successor = True
    with pytest.raises(aioduco.Refused):
        await line(robot)
    with pytest.raises(aioduco.TaskInterrupted):
        await task


@pytest.mark.parametrize(
    "call",
    [
        lambda robot: robot.blocking.move_jog(Jog.joint(1, 1, vel=10)),
        lambda robot: robot.blocking.speedj([0.1, 0, 0, 0, 0, 0], a=1.0, time=None),
        lambda robot: robot.blocking.speedl([0.1, 0, 0, 0, 0, 0], a=1.0, time=None),
    ],
    ids=["move_jog", "speedj", "speedl"],
)
async def test_what_only_a_command_ends_is_refused(
    robot: aioduco.Robot, desk: Desk, call: Callable[[aioduco.Robot], Awaitable[TaskState]]
) -> None:
    with pytest.raises(aioduco.ParameterError, match=r"ends by itself.*robot\.motion\."):
        await call(robot)
    assert desk.commands == []


# -- the gate --------------------------------------------------------------------------------------


async def test_it_waits_through_a_pause(robot: aioduco.Robot, desk: Desk) -> None:
    desk.motion_time = 0.2
    states: list[TaskState] = []

    async def one() -> None:
        states.append(await line(robot))

    async with anyio.create_task_group() as tg:
        tg.start_soon(one)
        await eventually_async(lambda: desk.received("movel"))
        await robot.pause()
        assert not states
        await robot.resume()
    assert states == [TaskState.FINISHED]
    assert "stop" not in desk.commands


@pytest.mark.parametrize("comes", [True, False])
async def test_one_that_is_served_after_a_pause_does_not_move(desk: Desk, comes: bool) -> None:
    """The arm is stopped if it does not come in time: nothing would pause it."""
    desk.motion_time = 30.0
    let = desk.hold("movel", desk._answers["movel"])

    async def let_late() -> None:
        seen, count = ("pause", 3) if comes else ("stop", 1)
        await eventually_async(lambda: len(desk.received(seen)) >= count)
        let.set()

    async with (
        aioduco.connect(desk.host, desk.port, call_timeout=10.0 if comes else 0.2) as robot,
        anyio.create_task_group() as tg,
    ):
        moving = robot.blocking.movel(POSE, v=0.2, a=0.5)

        async def one() -> None:
            with pytest.raises(aioduco.TaskStopped):
                await moving

        tg.start_soon(one)
        await eventually_async(lambda: desk.received("movel"))
        tg.start_soon(let_late)
        assert await robot.pause() is comes
        assert not desk.moving()
        assert ("stop" in desk.commands) is not comes
        await robot.stop()


@pytest.mark.cases(2)
@pytest.mark.parametrize("by", ["this program", "another"])
async def test_leaving_the_robot_stops_what_is_paused_behind_an_early_answer(
    desk: Desk, by: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise it would go on when anybody resumes, after its program has ended."""
    monkeypatch.setattr(gate, "_STANDING", 0.0)  # it was seen to stand for long enough

    def early(*_: Any) -> int:
        desk._add(BenchTask("speedl", now := time.monotonic(), now + 30.0))
        return TaskState.FINISHED

    desk.answer("speedl", early)
    async with aioduco.connect(desk.host, desk.port) as robot:
        await robot.blocking.speedl([0, 0, 0.02, 0, 0, 0], a=0.5, time=20.0)
        if by == "this program":
            await robot.pause()
        else:
            desk._pause(False)
            desk.states[1] = ProgramState.PAUSED
            arm, looks = robot._supervisor.stop_coordinator, len(desk.received())
            await eventually_async(lambda: not arm.moving or len(desk.received()) > looks + 9)
    desk._resume(False)
    assert not desk.moving()


async def test_one_whose_heartbeat_was_lost_is_stopped_and_says_so(
    robot: aioduco.Robot, desk: Desk
) -> None:
    desk.motion_time = 30.0
    async with anyio.create_task_group() as group:

        async def lose() -> None:
            await eventually_async(desk.moving)
            robot._supervisor.gate.end(PermitEnding.LAPSED)

        group.start_soon(lose)
        with pytest.raises(aioduco.TaskStopped, match="the heartbeat was lost while") as caught:
            await line(robot)
    assert isinstance(caught.value.__cause__, aioduco.HeartbeatLost)
    assert not desk.moving()


async def test_after_a_stop_nothing_that_waited_for_a_connection_is_sent(desk: Desk) -> None:
    desk.motion_time = 30.0
    errors: list[BaseException] = []
    async with (
        aioduco.connect(desk.host, desk.port, pool_size=1) as robot,
        anyio.create_task_group() as tg,
    ):
        tg.start_soon(noted, errors, aioduco.TaskStopped, line(robot))
        await eventually_async(desk.moving)
        tg.start_soon(noted, errors, aioduco.TaskStopped, line(robot))
        lane = robot._supervisor.blocking
        await eventually_async(lambda: lane.statistics().waiting)
        await robot.stop()
    assert len(errors) == 2
    assert len(desk.received("movel")) == 1


@pytest.mark.parametrize("ended", [aioduco.Robot.stop, aioduco.Robot.abort, aioduco.Robot.pause])
async def test_a_stop_does_not_wait_for_what_waits_for_a_connection(
    desk: Desk, ended: Callable[[aioduco.Robot], Awaitable[object]]
) -> None:
    """It is refused when it has one; what keeps the connections moves nothing."""
    errors: list[BaseException] = []
    let = desk.hold("enable_eaxis_scheme")
    async with (
        aioduco.connect(desk.host, desk.port, pool_size=1) as robot,
        anyio.create_task_group() as tg,
    ):
        tg.start_soon(robot.external_axes.enable_eaxis_scheme, "rail")
        await eventually_async(lambda: desk.received("enable_eaxis_scheme"))
        tg.start_soon(noted, errors, aioduco.TaskStopped, line(robot))
        lane = robot._supervisor.blocking
        await eventually_async(lambda: lane.statistics().waiting)
        await ended(robot)
        assert not errors  # it waits still
        let.set()
    assert len(errors) == 1
    assert not desk.received("movel")


async def test_in_a_permit_that_has_ended_nothing_is_sent(robot: aioduco.Robot, desk: Desk) -> None:
    with robot.permit("pick"):
        await robot.stop()
        with pytest.raises(aioduco.TaskStopped, match="was not sent"):
            await line(robot)
    assert desk.received("movel") == ()
    assert await line(robot) is TaskState.FINISHED


async def test_another_programs_stop_ends_a_permit(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("movel", TaskState.STOPPED)
    with robot.permit("pick"):
        with pytest.raises(aioduco.TaskStopped, match="movel was stopped"):
            await line(robot)
        with pytest.raises(aioduco.TaskStopped, match="was not sent"):
            await line(robot)
    assert len(desk.received("movel")) == 1


async def test_a_robot_that_is_not_open_sends_nothing(desk: Desk) -> None:
    with pytest.raises(aioduco.RobotStateError, match="movel was not sent"):
        await line(aioduco.connect(desk.host, desk.port))
    async with aioduco.connect(desk.host, desk.port) as robot:
        pass
    with pytest.raises(aioduco.RobotStateError, match="movel was not sent"):
        await line(robot)


async def test_a_velocity_in_another_frame_is_turned(robot: aioduco.Robot, desk: Desk) -> None:
    desk.answer("get_flange_pose", POSE)
    await robot.blocking.speedl([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], a=0.5, time=0.03, frame="base")
    await robot.motion.speedl([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], a=0.5, time=0.03, frame="base")
    blocking, other = desk.received("speedl")
    assert blocking.args == (*other.args[:3], True)
    assert other.args[0] != [0.0, 0.0, 0.1, 0.0, 0.0, 0.0]


# -- for programs that wait ------------------------------------------------------------------------


def test_it_is_the_same_for_programs_that_wait(desk: Desk) -> None:
    desk.motion_time = 0.02
    with aioduco.sync.connect(desk.host, desk.port) as robot:
        assert robot.blocking.movel(POSE, v=0.2, a=0.5) is TaskState.FINISHED
    assert desk.received("movel")[0].args[7] is True


# -- a simulated arm -------------------------------------------------------------------------------


@pytest.mark.slow
async def test_on_a_simulated_arm_it_blends_as_the_manual_says(sim: Simulator) -> None:
    async with aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot:
        await robot.bring_up()
        assert await robot.blocking.movej2(READY, v=1.0, a=2.0) is TaskState.FINISHED
        await robot.motion.set_blend_ahead(50)
        start = await robot.state.get_tcp_pose()
        corner, end = start.shifted(x=0.1), start.shifted(x=0.1, z=0.03)
        states = [
            await robot.blocking.movel(corner, v=0.03, a=1.0, r=0.03),
            await robot.blocking.movel(end, v=0.03, a=1.0),
        ]
        assert states == [TaskState.INTERRUPT, TaskState.FINISHED]
        assert (await robot.state.get_tcp_pose()).distance(end)[0] < 1e-3
        assert not await robot.state.robotmoving()


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator(speed=5.0) as sim:
        yield sim
