"""The driver's core on a simulated arm, without ROS: goals, services, readings."""

from __future__ import annotations

import math
import signal
import time
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import anyio
import numpy as np
import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco import Pose, TaskState
from aioduco._process.reporting import reporter
from aioduco.api.force import Force
from aioduco.api.frames import Frames
from aioduco.api.state import State
from aioduco.errors import ConnectionLost, ParameterError
from aioduco.integrations.ros.arm_node import ArmNode, NodeSettings, arm_node
from aioduco.integrations.ros.arm_readings import DiagnosisLevel, diagnosis, placed_frames
from aioduco.integrations.ros.arm_services import ArmServices
from aioduco.integrations.ros.shutdown import cancel_on_signal
from aioduco.integrations.ros.trajectory_goals import (
    ErrorCode,
    GoalPoint,
    GoalRules,
    NamedTolerance,
)
from aioduco.integrations.ros.trajectory_server import GoalProgress, TrajectoryServer
from aioduco.kinematics import arm
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

from .goals import NAMES, PROFILE, START, WRONG, Client, goal, way
from .nodes import Sink, running


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(programs={"wave": [["movej2", [0.5, *START[1:]], 0.3, 5.0]]}) as sim:
        yield sim


@pytest.fixture
def sink() -> Sink:
    return Sink()


@pytest.fixture
async def node(sim: Simulator, sink: Sink) -> AsyncIterator[ArmNode]:
    async with running(sim, sink, wrench=True) as node:
        yield node


async def settled(node: ArmNode, *clients: Client) -> None:
    for client in clients:
        node.goals.submit(client)
    await eventually_async(lambda: all(client.done for client in clients))


async def moving(client: Client) -> None:
    """Until the arm is well on its way."""
    await eventually_async(lambda: client.seen and client.seen[-1].time > 0.3)


async def test_an_end_by_a_signal_says_how_long_it_may_take(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """With a controller that does not answer, nothing else said why the driver did not end."""
    caplog.set_level("INFO", "aioduco")
    usual = signal.getsignal(signal.SIGTERM)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(cancel_on_signal, tasks.cancel_scope)
        await eventually_async(lambda: signal.getsignal(signal.SIGTERM) is not usual)
        signal.raise_signal(signal.SIGTERM)
    reporter.flush()
    assert "SIGTERM: the driver ends as soon as the arm is known to stand" in caplog.text


@pytest.mark.slow
async def test_wrong_goals_move_nothing_and_disturb_nothing(node: ArmNode, sim: Simulator) -> None:
    stray = goal(count=50, points=[p._replace(time=p.time * 3) for p in goal(count=50).points])
    client, wrong = Client(stray), [Client(make()) for make, _ in WRONG.values()]
    node.goals.submit(client)
    await moving(client)
    for each in wrong:
        node.goals.submit(each)
    # A stamp that counts from another time than this computer's is old, or far ahead, all the same.
    assert all(each.told == ["rejected"] for each in wrong)
    await eventually_async(lambda: client.done)
    assert client.told == ["accepted", "succeeded"], client.text
    assert np.abs(client.seen[-1].error).max() < 0.1
    elsewhere = Client(goal())
    await settled(node, elsewhere)
    assert (elsewhere.told, elsewhere.code) == (["rejected"], ErrorCode.INVALID_GOAL)
    np.testing.assert_allclose(sim.joints, way(1.0), atol=0.011)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["cancel", "client", "all"])
async def test_a_goal_that_is_given_up_ends_at_rest(
    node: ArmNode, sim: Simulator, how: str
) -> None:
    client = Client(goal(count=50, duration=3.0, far=0.8))
    node.goals.submit(client)
    await moving(client)
    if how == "cancel":
        node.goals.cancel(client)
    elif how == "client":
        client.here = False
    else:
        node.goals.cancel_all("the master is gone")
    await eventually_async(lambda: client.done)
    assert not sim.moving
    assert 0.0 < sim.joints[0] - START[0] < 0.79
    assert client.told == ["accepted", "cancelled"]


@pytest.mark.slow
@pytest.mark.parametrize("first", ["measured", "later"])
async def test_a_newer_goal_takes_over_from_the_moving_arm(
    node: ArmNode, sim: Simulator, first: str
) -> None:
    older = Client(goal(count=50, duration=6.0, far=0.8))
    speeds: list[Any] = []
    sim.observe(lambda snapshot, _: speeds.append(snapshot.setpoint.qd.copy()))
    node.goals.submit(older)
    await moving(older)
    end = way(1.0, -0.2)
    points = [GoalPoint(tuple(older.seen[-1].actual)), GoalPoint(end, time=3.0)]
    newer = Client(goal(points=points[first == "later" :], goal_time_tolerance=60.0))
    await settled(node, newer)
    sim.observe(None)
    assert (older.told, newer.told) == (["accepted", "cancelled"], ["accepted", "succeeded"])
    assert "took over" in older.text
    np.testing.assert_allclose(sim.joints, end, atol=0.011)
    assert np.abs(np.diff(speeds, axis=0)).max() < 0.05  # 50 rad/s²: no step
    times = [place.time for place in newer.seen]
    assert times == sorted(times)


@pytest.mark.slow
async def test_a_goal_that_took_over_is_cancelled_paused_and_replaced(
    node: ArmNode, sim: Simulator
) -> None:
    goals = [Client(goal(count=50, duration=6.0, far=far)) for far in (0.8, 0.6, 0.7)]
    for client in goals:
        client.goal = replace(client.goal, points=client.goal.points[1:])
        node.goals.submit(client)
        await moving(client)
    assert [client.told for client in goals] == [["accepted", "cancelled"]] * 2 + [["accepted"]]
    assert await node.goals.pause()
    assert not sim.moving
    assert node.goals.resume()
    last = goals[-1]
    count = len(last.seen)
    await eventually_async(lambda: len(last.seen) > count + 5)
    node.goals.cancel(last)
    await eventually_async(lambda: last.done)
    assert last.told == ["accepted", "cancelled"]
    assert not sim.moving


@pytest.mark.slow
async def test_a_goal_that_is_late_by_its_own_times_has_its_code(
    node: ArmNode, sim: Simulator
) -> None:
    # not even the stream is open by then
    client = Client(goal(duration=0.5, goal_time_tolerance=1e-6))
    await settled(node, client)
    assert (client.told, client.code) == (
        ["accepted", "aborted"],
        ErrorCode.GOAL_TOLERANCE_VIOLATED,
    )
    assert not sim.moving


@pytest.mark.slow
async def test_tolerances_of_speeds(node: ArmNode, monkeypatch: pytest.MonkeyPatch) -> None:
    wide = [NamedTolerance(name, 0.0, 2.0) for name in NAMES]
    slow = [NamedTolerance(name, 0.02, 0.02) for name in NAMES]
    client = Client(goal(count=50, path_tolerance=wide, goal_tolerance=slow))
    await settled(node, client)
    assert client.told == ["accepted", "succeeded"], client.text
    assert (await node.services.movej(START, 3.0, 20.0)).success
    read = State.get_actual_joints_speed

    async def faster(self: State) -> Any:
        return await read(self) + np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])

    # by much: a busy machine looks at a few moments only
    monkeypatch.setattr(State, "get_actual_joints_speed", faster)
    tight = [NamedTolerance(NAMES[2], 0.0, 0.5)]
    client = Client(goal(count=50, duration=5.0, path_tolerance=tight))
    await settled(node, client)
    assert client.code == ErrorCode.PATH_TOLERANCE_VIOLATED
    assert "speed of joint_3" in client.text


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["client", "middleware"])
async def test_a_goal_that_is_left_is_stopped_at_once_if_asked_for(
    node: ArmNode, sim: Simulator, lost: str
) -> None:
    rules = GoalRules(goal_time=60.0)  # a busy machine begins it late
    goals = TrajectoryServer(
        node.robot, PROFILE, rules, wall=time.time, through="servoj", stop_at_loss=True
    )
    client = Client(goal(count=50, duration=3.0, far=0.8))
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(goals.run)
        goals.submit(client)
        await moving(client)
        if lost == "client":
            client.here = False
        else:
            await goals.cancel_on_loss("the master is gone")
        await eventually_async(lambda: client.done)
        tasks.cancel_scope.cancel()
    # Not cancelled: a stop of the controller ended it.
    assert (client.told, client.code) == (
        ["accepted", "aborted"],
        ErrorCode.PATH_TOLERANCE_VIOLATED,
    )
    await eventually_async(lambda: not sim.moving)
    assert 0.0 < sim.joints[0] - START[0] < 0.79


@pytest.mark.slow
async def test_a_stop_ends_a_goal_and_waits_behind_nothing(node: ArmNode, sim: Simulator) -> None:
    client = Client(goal(count=50, duration=3.0, far=0.8))
    node.goals.submit(client)
    await moving(client)
    assert not (await node.services.movej(START, 1.0, 1.0)).success
    assert not (await node.services.set_tool("t", (0.0,) * 6, 0.0, (0.0,) * 3)).success
    assert (await node.services.stop()).success
    assert not sim.moving
    await eventually_async(lambda: client.done)
    assert client.told == ["accepted", "aborted"]
    assert client.code == ErrorCode.PATH_TOLERANCE_VIOLATED
    assert client.text.endswith("Send a new goal to go on")


@pytest.mark.slow
@pytest.mark.parametrize("how", ["due later", "waits", "slower"])
async def test_after_a_stop_no_goal_begins_or_goes_on(
    node: ArmNode, sim: Simulator, how: str
) -> None:
    """Of a goal that stands before its begin, or between two parts, too."""
    due = time.time() + 0.5
    clients = [Client(goal(count=50, duration=3.0, far=0.8))]
    if how == "due later":
        clients = [Client(goal(stamp=due))]
    for client in clients:
        node.goals.submit(client)
    if how != "due later":
        await moving(clients[0])
    if how == "waits":
        clients.append(Client(goal(points=[GoalPoint(way(1.0), time=1.0)], stamp=due)))
        node.goals.submit(clients[1])
    elif how == "slower":
        node.goals.scale(0.5)
    assert (await node.services.stop()).success
    there = np.array(sim.joints)
    await eventually_async(lambda: all(client.done for client in clients))
    assert [client.told[-1] for client in clients].count("succeeded") == 0
    if how == "due later":
        assert "stopped" in clients[0].text
    await eventually_async(lambda: time.time() > due and not node.goals.busy)
    await settled(node, Client(goal(points=())))  # the driver goes on
    assert not sim.moving
    np.testing.assert_allclose(sim.joints, there, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("service", ["start_force_mode", "play"])
@pytest.mark.parametrize("halt", [ArmServices.stop, ArmServices.pause])
async def test_after_a_stop_or_a_pause_no_service_goes_on_to_move_the_arm(
    node: ArmNode, monkeypatch: pytest.MonkeyPatch, service: str, halt: Any
) -> None:
    """Of one that had not sent its motion yet."""
    section, name = {
        "start_force_mode": (Force, "fc_start"), "play": (State, "get_robot_state")
    }[service]  # fmt: skip
    call = getattr(section, name)

    async def halted_meanwhile(self: Any) -> Any:
        answer = await call(self)
        monkeypatch.undo()
        assert (await halt(node.services)).success
        return answer

    services = node.services
    assert (await services.load_program("wave")).success
    monkeypatch.setattr(section, name, halted_meanwhile)
    if service == "play":
        reply = await services.play()
    else:
        pushed = (0.0, 0.0, 5.0, 0.0, 0.0, 0.0)
        reply = await services.start_force_mode((True,) * 6, pushed, (0.0,) * 6, (0.0,) * 6, 0)
    assert not reply.success, reply.message
    assert "not sent, since the arm was stopped" in reply.message
    assert not node.robot.tasks
    assert not await node.robot.force.fc_mode_is_active()


@pytest.mark.slow
@pytest.mark.parametrize("ended", [True, False], ids=["ended", "not ended"])
async def test_force_control_whose_begin_was_not_answered_is_ended(
    node: ArmNode, monkeypatch: pytest.MonkeyPatch, ended: bool
) -> None:
    start, stop = Force.fc_start, Force.fc_stop

    async def begun(self: Force) -> None:
        await start(self)
        raise ConnectionLost("fc_start was sent, and not answered")

    async def lost(self: Force) -> None:
        raise ConnectionLost("the cable is out")

    services = node.services
    monkeypatch.setattr(Force, "fc_start", begun)
    monkeypatch.setattr(Force, "fc_stop", stop if ended else lost)
    pushed = (0.0, 0.0, 5.0, 0.0, 0.0, 0.0)
    reply = await services.start_force_mode((True,) * 6, pushed, (0.0,) * 6, (0.0,) * 6, 0)
    assert not reply.success
    if ended:
        assert reply.message.endswith("not answered. Force control was ended")
    else:
        assert reply.message.endswith("Force control may be on: call stop_force_mode")
        monkeypatch.setattr(Force, "fc_stop", stop)
        assert (await services.stop_force_mode()).success
    assert not await node.robot.force.fc_mode_is_active()


async def test_an_arm_that_is_not_ready_refuses_goals(node: ArmNode, sim: Simulator) -> None:
    await node.robot.system.disable()
    client = Client(goal())
    await settled(node, client)
    assert (client.told, client.code) == (["rejected"], ErrorCode.INVALID_GOAL)
    assert "bring_up" in client.text


async def test_errors_name_services_and_not_functions_of_python(
    node: ArmNode, sim: Simulator
) -> None:
    assert (await node.services.bring_up()).success
    node.robot._supervisor.gate.hang()
    refused = await node.services.movej(START, 3.0, 20.0)
    assert refused.message.endswith("the event loop hung; call ~/recover to go on")
    client = Client(goal())
    await settled(node, client)
    assert "~/recover" in client.text
    assert "robot." not in client.text
    assert (await node.services.recover()).success
    assert (await node.services.movej(START, 3.0, 20.0)).success


@pytest.mark.slow
async def test_services_do_what_they_say(node: ArmNode, sim: Simulator) -> None:
    services = node.services
    assert "tare" not in (await services.bring_up()).message
    sim.collide(3)
    assert "After the collision it may still touch" in (await services.bring_up()).message
    assert (await services.set_digital_output(3, True)).success
    assert sim.get_digital_output(3)
    assert (await services.set_tool_output(1, True)).success
    assert (await services.set_load(0.5, (0.0, 0.0, 0.05))).success
    assert (await services.set_tool("gripper", (0, 0, 0.1, 0, 0, 0), 0.5, (0, 0, 0.05))).success
    pose = await node.robot.state.get_tcp_pose()
    assert (await services.movel(pose.shifted(z=0.02), 0.2, 1.0)).success
    for refused in (
        await services.set_digital_output(99, True),
        await services.set_tool_output(0, True),
        await services.set_load(-1.0, (0.0,) * 3),
        await services.set_load(1.0, (0.0,) * 2),
        await services.set_tool("", (0.0,) * 6, 0.0, (0.0,) * 3),
        await services.movej(START[:5], 1.0, 1.0),
        await services.movej(START, float("nan"), 1.0),
        await services.movel(pose, -1.0, 1.0),
    ):
        assert not refused.success
        assert refused.message


@pytest.mark.slow
async def test_a_pause_and_its_end(node: ArmNode, sim: Simulator) -> None:
    replies = []

    async def move() -> None:
        replies.append(await node.services.movej(way(1.0), 0.2, 5.0))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(move)
        running = TaskState.RUNNING
        await eventually_async(lambda: [task.state for task in node.robot.tasks] == [running])
        assert (await node.services.pause()).success
        assert not sim.moving
        assert (await node.services.resume()).success
    assert replies[0].success
    again = await node.services.resume()
    assert (again.success, again.message) == (False, "nothing was paused")
    # set-points are ignored from now on
    again = await node.services.pause()
    assert (again.success, again.message) == (True, "the arm stands; there was no motion to pause")
    np.testing.assert_allclose(sim.joints, way(1.0), atol=1e-3)


@pytest.mark.slow
async def test_a_pause_while_a_goal_waits_is_of_the_motion_that_moves_the_arm(
    node: ArmNode, sim: Simulator
) -> None:
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(node.services.movej, way(1.0, 0.8), 0.1, 5.0)
        await eventually_async(lambda: sim.moving)
        node.goals.submit(waits := Client(goal(stamp=time.time() + 50.0)))
        assert (await node.services.pause()).success
        assert not sim.moving
        assert (await node.services.resume()).success
        await eventually_async(lambda: sim.moving)
        assert waits.told == []
        assert (await node.services.stop()).success
    await eventually_async(lambda: waits.done)


@pytest.mark.slow
async def test_of_a_paused_goal_the_place_of_the_standing_arm_is_published(
    node: ArmNode, sim: Simulator, sink: Sink
) -> None:
    """It was that of the last feedback, from which the arm had still braked."""
    client = Client(goal(count=50, duration=4.0, far=1.5))
    node.goals.submit(client)
    await moving(client)
    assert (await node.services.pause()).success
    joints = np.array(sim.joints)
    await eventually_async(lambda: sink.place and np.abs(sink.place.actual - joints).max() < 1e-3)
    assert sink.place is not None
    np.testing.assert_allclose(sink.place.desired, joints, atol=0.011)


@pytest.mark.slow
@pytest.mark.usefixtures("node")
async def test_the_flange_follows_a_change_of_the_tool_at_the_rate_of_the_states(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """For a second it was placed by the tool before: the tool was asked for once a second."""
    asked: Counter[str] = Counter()

    def counted(name: str) -> None:
        function = getattr(Frames, name)

        async def called(self: Frames) -> Any:
            asked[name] += 1
            return await function(self)

        monkeypatch.setattr(Frames, name, called)

    counted("get_tcp_offset")
    counted("get_tool_load")  # once a second
    await eventually_async(lambda: asked["get_tcp_offset"] > 5 * asked["get_tool_load"] > 0)


@pytest.mark.slow
async def test_what_is_published(node: ArmNode, sim: Simulator, sink: Sink) -> None:
    await eventually_async(lambda: sink.forces and "flange_controller" in sink.frames)
    # Samples from before the arm came to START may have been the newest.
    await eventually_async(
        lambda: sink.reading and np.allclose(sink.reading.position, sim.joints, atol=1e-3)
    )
    there = arm("gcr5_910").fkine(START)[:3, 3]
    await eventually_async(
        lambda: np.allclose(sink.frames["flange_controller"].position, there, atol=2e-3)
    )
    sink.listens = False
    await eventually_async(lambda: not sink.frames)  # joints go on, without them
    await eventually_async(lambda: sink.snapshot)
    await eventually_async(lambda: sink.percent == 100.0 and sink.factor == 1.0)
    await eventually_async(lambda: sink.tool_fields and sink.place is not None)
    assert len(sink.tool_fields["offset"]) == 6
    await eventually_async(lambda: sink.diagnoses[-1].level == DiagnosisLevel.OK)
    sim.emergency_stop()
    try:
        await eventually_async(lambda: sink.diagnoses[-1].level == DiagnosisLevel.ERROR)
        assert "release" in sink.diagnoses[-1].message
    finally:
        sim.release_emergency_stop()
    assert diagnosis(None, None, time.monotonic(), 0.0).level == DiagnosisLevel.STALE


@pytest.mark.slow
async def test_no_old_place_of_the_arm_is_published_as_the_present_one(
    node: ArmNode, sink: Sink, monkeypatch: pytest.MonkeyPatch
) -> None:
    await eventually_async(lambda: sink.place)
    silent = 0

    async def lost(self: State) -> None:
        nonlocal silent
        silent += 1
        raise ConnectionLost("the cable is out")

    monkeypatch.setattr(State, "getRobotStatus", lost)
    await eventually_async(lambda: silent > 1)
    sink.place, silent = None, 0
    await eventually_async(lambda: silent > 2)  # each in as long as two places take
    assert sink.place is None


@pytest.mark.slow
async def test_the_force_is_along_the_axes_of_its_frame(
    node: ArmNode, sim: Simulator, sink: Sink
) -> None:
    """Its message is in `tcp_controller`; the tool looks down."""
    sim.push([0.0, 0.0, -10.0, 0.0, 0.0, 0.0])
    try:
        await eventually_async(lambda: sink.forces and abs(sink.forces[-1][2]) > 9.0)
        along = np.array(sim.arm.fkine(sim.joints))[:3, :3].T @ [0.0, 0.0, -10.0]
        await eventually_async(lambda: np.allclose(sink.forces[-1][:3], along, atol=0.3))
    finally:
        sim.push([0.0] * 6)


def test_the_error_is_the_reference_less_the_feedback() -> None:
    """As JointTrajectoryControllerState of control_msgs says, and the JTC of ROS 1 and 2 does."""
    behind = GoalProgress(0.0, desired=np.full(6, 0.3), actual=np.full(6, 0.1))
    np.testing.assert_allclose(behind.error, 0.2)


ANGLE = st.floats(-math.pi, math.pi) | st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi])
POSE = st.builds(Pose, *[st.floats(-1.0, 1.0)] * 3, *[ANGLE] * 3)


@given(POSE, POSE)
def test_frames_are_those_of_the_poses(tip: Pose, offset: Pose) -> None:
    status: Any = SimpleNamespace(pose=tip)
    frames = placed_frames(status, offset, "left_")
    assert [frame.name for frame in frames] == ["left_tcp_controller", "left_flange_controller"]
    assert placed_frames(status, None, "left_") == frames[:1]
    for frame, pose in zip(frames, (tip, tip @ offset.inverse()), strict=True):
        np.testing.assert_allclose(frame.position, [pose.x, pose.y, pose.z], atol=1e-9)
        same = float(np.dot(frame.quaternion, pose.quaternion("xyzw")))
        assert abs(same) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("model", ["gcr5_910", "GCR5-910", "gcr20_1100"])
async def test_an_arm_of_another_model_is_told(
    sim: Simulator, caplog: pytest.LogCaptureFixture, model: str
) -> None:
    """Its joints are slower: the goals that the driver takes would leave the path."""
    async with arm_node(NodeSettings(host=sim.host, port=sim.port, model=model, heartbeat=10.0)):
        pass
    reporter.flush()
    said = [each for each in caplog.messages if "set the parameter model" in each]
    assert len(said) == (model == "gcr20_1100"), caplog.messages


@for_each("wrong", [{"rate": 0.0}, {"feedback_rate": 51.0}, {"slow_rate": -1.0}])
def test_settings_are_checked(wrong: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match="Hz"):
        NodeSettings(host="127.0.0.1", **wrong)  # type: ignore[arg-type]  # one of several floats
