"""The track pool counts its points, and refuses more than fit."""

from __future__ import annotations

import anyio
import numpy as np
import pytest
from wire.lanes import noted

import aioduco
from aioduco import Joints, PointOp, Pose, TaskState
from aioduco.supervision.gate import PermitEnding
from aioduco.testing import Cut, FaultProxy, Place, eventually_async
from api.desk import Desk
from api.motion_cases import HOME, POSE


@pytest.fixture
def pool(desk: Desk) -> Desk:
    for name in ("trackEnqueue", "trackEnqueueOp", "trackClearQueue"):
        desk.answer(name, 4)
    desk.answer("getQueueSize", 3)
    desk.motion_time = 0.02
    for name in ("trackJointMotion", "trackCartMotion"):
        desk.moves(name)
    return desk


async def test_the_usual_order(robot: aioduco.Robot, pool: Desk) -> None:
    await robot.track.trackClearQueue()
    await robot.track.trackEnqueue(Joints(*HOME) for _ in range(10))
    await robot.track.trackJointMotion(1.0, 2.0)
    assert pool.commands == ["trackClearQueue", "trackEnqueue", "trackJointMotion"]


async def test_a_full_pool_is_an_error_of_its_own(robot: aioduco.Robot, pool: Desk) -> None:
    for name in ("trackEnqueue", "trackEnqueueOp"):
        pool.answer(name, -1)
    with pytest.raises(aioduco.TrackPoolFull, match="1000 points") as caught:
        await robot.track.trackEnqueue([Pose(*POSE)])
    assert isinstance(caught.value, aioduco.Refused)
    assert caught.value.code == -1
    with pytest.raises(aioduco.TrackPoolFull):
        await robot.track.trackEnqueueOp([PointOp(POSE)])


async def test_poses_are_not_followed_as_joints(robot: aioduco.Robot, pool: Desk) -> None:
    await robot.track.trackEnqueue([Pose(*POSE)])
    with pytest.raises(aioduco.RobotStateError, match="Pose into the pool"):
        robot.track.trackJointMotion(1.0, 2.0)
    await robot.track.trackCartMotion(0.1, 0.2)
    await robot.track.trackClearQueue()
    await robot.track.trackEnqueueOp([PointOp(Joints(*HOME))])
    with pytest.raises(aioduco.RobotStateError, match="Joints into the pool"):
        robot.track.trackCartMotion(0.1, 0.2)
    assert "trackJointMotion" not in pool.commands


async def test_points_that_came_after_a_motion_was_made_are_not_taken_for_others(
    robot: aioduco.Robot, pool: Desk
) -> None:
    motion = robot.track.trackJointMotion(1.0, 2.0)
    await robot.track.trackEnqueue([Pose(*POSE)])
    with pytest.raises(aioduco.RobotStateError, match="Pose into the pool"):
        await motion
    assert "trackJointMotion" not in pool.commands


async def test_the_pool_holds_one_kind_until_it_is_empty(robot: aioduco.Robot, pool: Desk) -> None:
    await robot.track.trackEnqueue([Joints(*HOME)])
    with pytest.raises(aioduco.RobotStateError, match="were not sent"):
        await robot.track.trackEnqueue([Pose(*POSE)])
    with pytest.raises(aioduco.RobotStateError, match="trackClearQueue"):
        await robot.track.trackEnqueueOp([PointOp(POSE)])
    assert await robot.track.getQueueSize() == 3
    with pytest.raises(aioduco.RobotStateError, match="trackClearQueue"):
        await robot.track.trackEnqueue([Pose(*POSE)])
    pool.answer("getQueueSize", 0)
    assert await robot.track.getQueueSize() == 0
    await robot.track.trackEnqueue([Pose(*POSE)])
    assert len(pool.received("trackEnqueue")) == 2


async def test_plain_numbers_are_taken_for_what_the_pool_holds(
    robot: aioduco.Robot, pool: Desk
) -> None:
    far = [[7.0, 0.1, 0.6, 3.1, 0.0, -1.5]]
    await robot.track.trackEnqueue(np.array(far))
    await robot.track.trackEnqueue([Joints(*HOME)])
    with pytest.raises(aioduco.ParameterError, match=r"points\[0\]\[0\] is 7.0.*rad"):
        await robot.track.trackEnqueue(far)
    await robot.track.trackEnqueue([HOME])
    assert pool.received("trackEnqueue")[-1].args == ([HOME], True)


async def test_kinds_do_not_mix(robot: aioduco.Robot, pool: Desk) -> None:
    with pytest.raises(aioduco.ParameterError, match=r"points\[1\]"):
        await robot.track.trackEnqueue([Joints(*HOME), Pose(*POSE)])
    with pytest.raises(aioduco.ParameterError, match=r"points\[1\]"):
        await robot.track.trackEnqueueOp([PointOp(POSE), PointOp(Joints(*HOME))])
    with pytest.raises(aioduco.ParameterError, match="1001 points"):
        await robot.track.trackEnqueue([Pose(*POSE)] * 1001)
    assert pool.commands == []


async def test_kinds_do_not_mix_while_points_are_checked(
    robot: aioduco.Robot, pool: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def checked(*_: object, **__: object) -> None:
        await anyio.lowlevel.checkpoint()

    monkeypatch.setattr(robot._supervisor.envelope, "admit", checked)
    raised: list[BaseException] = []
    async with anyio.create_task_group() as tasks:
        for point in (Joints(*HOME), Pose(*POSE)):
            call = robot.track.trackEnqueue([point])
            tasks.start_soon(noted, raised, aioduco.RobotStateError, call)
    assert len(raised) == 1
    assert pool.commands == ["trackEnqueue"]


async def test_points_that_were_not_taken_leave_no_trace(robot: aioduco.Robot, pool: Desk) -> None:
    pool.answer("trackEnqueue", 7)
    with pytest.raises(aioduco.TaskIllegal):
        await robot.track.trackEnqueue([Joints(*HOME)])
    pool.answer("trackEnqueue", 4)
    await robot.track.trackEnqueue([Pose(*POSE)])


async def test_points_whose_fate_is_unknown_count(pool: Desk, proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        proxy.on("trackEnqueue", Cut(Place.AFTER_REQUEST))
        with pytest.raises(aioduco.OutcomeUnknown):
            await robot.track.trackEnqueue([Joints(*HOME)])
        with pytest.raises(aioduco.RobotStateError):
            await robot.track.trackEnqueue([Pose(*POSE)])


async def test_points_of_which_the_answer_says_nothing_count(
    robot: aioduco.Robot, pool: Desk
) -> None:
    pool.answer("trackEnqueue", TaskState.RUNNING)
    with pytest.raises(aioduco.Refused):
        await robot.track.trackEnqueue([Joints(*HOME)])
    await robot.stop()
    assert "trackClearQueue" in pool.commands


async def test_points_after_the_arm_followed_some_are_stopped_at_the_end(pool: Desk) -> None:
    """The arm may follow them by itself (manual 1.3.12), and no task tells of it."""
    async with aioduco.connect(pool.host, pool.port) as robot:
        await robot.track.trackEnqueue([Joints(*HOME)])
        await robot.track.trackJointMotion(1.0, 2.0)
        await robot.track.trackEnqueue([Joints(*HOME)])
    assert pool.commands[-1] == "stop"


# A stop leaves points in the pool, which the next motion through it would follow first.


async def test_a_stop_empties_a_pool_with_points_of_this_program(
    robot: aioduco.Robot, pool: Desk
) -> None:
    await robot.stop()
    assert "trackClearQueue" not in pool.commands
    await robot.track.trackEnqueue([Pose(*POSE)])
    before = len(pool.commands)
    await robot.stop()
    # on two connections: a busy machine may serve the later one first
    assert set(pool.commands[before:]) == {"stop", "trackClearQueue"}
    # its kind is forgotten
    await robot.track.trackEnqueue([Joints(*HOME)])
    await robot.track.trackJointMotion(1.0, 2.0)
    assert pool.commands[-2:] == ["trackEnqueue", "trackJointMotion"]
    assert pool.commands.count("trackClearQueue") == 1


@pytest.mark.parametrize(
    "ending", [PermitEnding.LAPSED, PermitEnding.HUNG, PermitEnding.STOPPED, PermitEnding.PAUSED]
)
async def test_it_is_emptied_before_anything_else_if_another_one_stopped_the_arm(
    robot: aioduco.Robot, pool: Desk, ending: PermitEnding
) -> None:
    """A guard, a controller without a heartbeat, `stop_now`; but a pause is resumed."""
    await robot.track.trackEnqueue([Joints(*HOME)])
    robot._supervisor.gate.end(ending)
    await robot.track.trackEnqueue([Joints(*HOME)])
    await robot.track.trackJointMotion(1.0, 2.0)
    emptied = [] if ending is PermitEnding.PAUSED else ["trackClearQueue"]
    assert pool.commands == ["trackEnqueue", *emptied, "trackEnqueue", "trackJointMotion"]


async def test_a_motion_through_the_pool_does_not_follow_points_from_before_a_stop_now(
    robot: aioduco.Robot, pool: Desk
) -> None:
    await robot.track.trackEnqueue([Joints(*HOME)])
    robot.stop_now()
    await robot.track.trackJointMotion(1.0, 2.0)
    assert pool.commands == ["trackEnqueue", "stop", "trackClearQueue", "trackJointMotion"]


@pytest.mark.parametrize("followed", [False, True])
async def test_points_that_arrive_after_a_stop_are_not_followed_later(
    robot: aioduco.Robot, pool: Desk, followed: bool
) -> None:
    await robot.track.trackEnqueue([Joints(*HOME)])
    if followed:
        await robot.track.trackJointMotion(1.0, 2.0)
    before = len(pool.commands)
    late = pool.hold("trackEnqueue", 4)
    raised: list[BaseException] = []

    async with anyio.create_task_group() as group:
        put = robot.track.trackEnqueue([Joints(*HOME)])
        group.start_soon(noted, raised, aioduco.DucoError, put)
        await eventually_async(lambda: len(pool.received("trackEnqueue")) == 2)
        group.start_soon(robot.stop)  # waits for the answer if the arm follows the pool
        await eventually_async(lambda: "trackClearQueue" in pool.commands[before:])
        arrived = len(pool.commands)
        late.set()
    assert isinstance(raised[0], aioduco.TaskStopped)
    await robot.track.trackJointMotion(1.0, 2.0)
    assert "trackClearQueue" in pool.commands[arrived:-1]
    assert pool.commands[-1] == "trackJointMotion"


@pytest.mark.parametrize("stopped", [False, True])
async def test_a_program_that_ends_leaves_no_points_for_the_next_one(
    pool: Desk, stopped: bool
) -> None:
    async with aioduco.connect(pool.host, pool.port) as robot:
        await robot.track.trackEnqueue([Joints(*HOME)])
        if stopped:  # by another program, or the controller
            robot._supervisor.gate.end(PermitEnding.LAPSED)
    assert pool.commands == ["trackEnqueue", "trackClearQueue"]


async def test_a_program_without_points_in_the_pool_does_not_empty_it(pool: Desk) -> None:
    async with aioduco.connect(pool.host, pool.port) as robot:
        assert await robot.track.getQueueSize() == 3
    assert pool.commands == []


async def test_a_pool_that_cannot_be_emptied_is_not_followed(pool: Desk, proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        await robot.track.trackEnqueue([Joints(*HOME)])
        proxy.on("trackClearQueue", Cut(Place.BEFORE_REPLY), times=None)
        await robot.stop()
        with pytest.raises(aioduco.RobotStateError, match="trackClearQueue was not answered"):
            await robot.track.trackJointMotion(1.0, 2.0)
        proxy.clear()
        await robot.track.trackJointMotion(1.0, 2.0)
    assert pool.commands.count("trackJointMotion") == 1


@pytest.mark.parametrize("answer", [TaskState.ILLEGAL, -1])
async def test_a_pool_whose_emptying_is_refused_is_not_followed(
    robot: aioduco.Robot, pool: Desk, answer: int
) -> None:
    """As while an emergency stop is pressed; it is emptied as soon as the controller allows it."""
    await robot.track.trackEnqueue([Joints(*HOME)])
    pool.answer("trackClearQueue", answer)
    await robot.stop()
    with pytest.raises(aioduco.RobotStateError, match="trackClearQueue was not answered, or ref"):
        await robot.track.trackJointMotion(1.0, 2.0)
    pool.answer("trackClearQueue", TaskState.FINISHED)
    await robot.track.trackJointMotion(1.0, 2.0)
    assert pool.commands[-2:] == ["trackClearQueue", "trackJointMotion"]
