"""Commands at a limit, again and again: set-points, velocities, jogs, streams."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import suppress
from itertools import cycle
from types import SimpleNamespace

import anyio
import numpy as np
import pytest

import aioduco
from aioduco import (
    EnvelopeViolated,
    Jog,
    JogFrame,
    Pose,
    RealtimePoint,
    Snapshot,
    StreamError,
    StreamLeavesEnvelope,
    TaskStopped,
)
from aioduco.envelope import Envelope, JointMargin, SingularityMargin, ToolForce, ToolSpeed, Zone
from aioduco.models.trace import CallFinished, TraceEvent
from aioduco.sim import Simulator
from aioduco.supervision.command import MotionCommand
from aioduco.testing import eventually_async

from .conftest import AT, FLAT, SPEED, START, THREAD, fastest, stand, turned, wall
from .trials import ARM, CYCLE, LAG, Seen, least

#: how far beyond a limit the arm may ever be, however often a program commands [m]
BEYOND = 0.02


def nearest(seen: Seen) -> float:
    return least(FLAT, seen.q)


# -- set-points call by call -------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["servoj", "servoj_pose", "servo_tcp", "servol"])
async def test_set_points_end_at_the_wall(robot: aioduco.Robot, seen: Seen, kind: str) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    here = await robot.state.get_tcp_pose()
    refused = sent = 0
    for number in range(1, 80):
        step = 0.003 * number
        place = Pose(here.x, here.y + step, *here[2:])
        motion: MotionCommand
        if kind == "servoj":
            motion = robot.motion.servoj(turned(2 * step), v=1.0, a=5.0)
        elif kind == "servo_tcp":
            motion = robot.motion.servo_tcp((0, 0.003, 0, 0, 0, 0), v=1.0, a=5.0, frame="base")
        else:
            motion = getattr(robot.motion, kind)(place, v=1.0, a=5.0)
        try:
            await motion.start()
            sent += 1
        except EnvelopeViolated:
            refused += 1
    assert refused > 20
    assert sent > 20
    # on a busy machine the arm follows later than the last set-point was sent
    await eventually_async(lambda: nearest(seen) < 0.02)
    await robot.stop()
    assert nearest(seen) > -LAG


@pytest.mark.slow
async def test_a_set_point_is_checked_on_the_way_of_each_joint(robot: aioduco.Robot) -> None:
    """Each joint turns at its own pace: the way bends, where that of a joint motion is straight."""
    bend, target = (0.4, *START[1:3], -0.4, *START[4:]), (0.9, *START[1:3], -0.4, *START[4:])
    at = ARM.fkine(bend)[:3, 3]
    robot.envelope = Envelope("gcr5_910", Zone.sphere(at, 0.01, bodies=("flange",)))
    with pytest.raises(EnvelopeViolated):
        await robot.motion.servoj(target, v=1.0, a=5.0).start()
    assert not robot.tasks
    await robot.motion.movej2(target, v=3.0, a=20.0)


async def test_a_set_point_is_checked_from_where_the_arm_is(robot: aioduco.Robot) -> None:
    """On its way to the last target it may be anywhere."""
    raised = (0.0, -0.25, *START[2:])
    at = ARM.fkine((-0.5, *raised[1:]))[:3, 3]
    await stand(robot, *turned(-1.0))
    robot.envelope = Envelope("gcr5_910", Zone.sphere(at, 0.03, bodies=("flange",)))
    task = await robot.motion.servoj(START, v=0.05, a=5.0).start()
    # from there the way is clear, but not from where the arm is
    with pytest.raises(EnvelopeViolated):
        await robot.motion.servoj(raised, v=0.05, a=5.0).start()
    await task.cancel()


async def refuses_at_speed(robot: aioduco.Robot, samples: AsyncIterator[Snapshot]) -> bool:
    """Whether a weak set-point is refused when the arm was just seen to be fast."""
    for _ in range(40):
        if (await anext(samples)).status.joint_speeds[0] > 0.5:
            try:
                await robot.motion.servoj(turned(0.18), v=1.0, a=0.1).start()
            except EnvelopeViolated:
                return True
            return False
    return False


@pytest.mark.slow
async def test_a_weaker_acceleration_must_still_stop_the_arm(
    robot: aioduco.Robot, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    with robot.feed.subscribe() as samples:
        # a busy machine may get no sample of a whole motion, or know of it when the arm stands
        for goal in cycle((0.18, 0.0)):
            await robot.motion.servoj(turned(goal), v=1.0, a=20.0).start()
            if await refuses_at_speed(robot, samples):
                break
    await robot.stop()
    assert nearest(seen) > -LAG


@pytest.mark.slow
async def test_a_loop_asks_the_controller_for_nothing_more(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While set-points follow each other, their frames and the arm's position are known."""
    monkeypatch.setattr("aioduco.supervision.envelope_watch._FRESH", math.inf)
    robot.envelope = Envelope("gcr5_910", wall())
    names: list[str] = []

    def note(event: TraceEvent) -> None:
        if isinstance(event, CallFinished):
            names.append(event.function)

    calls = robot._supervisor.calls
    calls.observers = [*calls.observers, note]
    # so slow that the arm is on its way until the end, and stands by the watch
    await robot.motion.servoj(turned(0.1), v=0.0005, a=5.0).start()
    assert "get_actual_joints_position" in names
    # a busy machine brings the watch its first sample late
    watch = robot._supervisor.envelope._watch
    await eventually_async(lambda: watch.fresh() is not None)
    del names[:]
    for number in range(20):
        await robot.motion.servoj(turned(0.1 + 0.001 * number), v=0.0005, a=5.0).start()
    assert not {"get_actual_joints_position", "get_wobj", "get_flange_pose"} & {*names}
    await robot.stop()


# -- velocities and jogs, again and again ------------------------------------------------------


def hammered(robot: aioduco.Robot, kind: str) -> MotionCommand:
    """A motion towards the wall."""
    motion = robot.motion
    match kind:
        case "speedj":
            return motion.speedj((0.6, 0, 0, 0, 0, 0), a=3.0, time=0.5)
        case "speedl":
            return motion.speedl((0, 0.3, 0, 0, 0, 0), a=3.0, time=0.5, frame="base")
        case "speedl turning":
            # the tool's y axis points along the base's x; it turns about that, and swings out
            return motion.speedl((-0.3, 0, 0, 0, 0, 0.3), a=3.0, time=0.5)
        case "jog":
            return motion.move_jog(Jog.joint(1, 1, 100.0), time=0.5)
        case "jog base":
            return motion.move_jog(Jog.cartesian("y", 1, 100.0), time=0.5)
        case "jog tool":
            return motion.move_jog(Jog.cartesian("x", -1, 100.0, frame=JogFrame.TOOL), time=0.5)
        case "jog wobj":
            jog = Jog.cartesian("y", 1, 100.0, frame=JogFrame.WORK_OBJECT)
            return motion.move_jog(jog, time=0.5)
        case "jog world":
            return motion.move_jog(Jog.cartesian("y", 1, 100.0, frame=JogFrame.WORLD), time=0.5)
        case "jog steps":
            return motion.move_jog(Jog.joint(1, 1, 100.0, step=0.03))
        case _:
            return motion.move_jog(Jog.cartesian("y", 1, 100.0, step=0.03))


HAMMERED = [
    *("speedj", "speedl", "speedl turning", "jog", "jog base", "jog tool", "jog wobj"),
    *("jog world", "jog steps", "jog steps base"),
]


@pytest.mark.slow
@pytest.mark.parametrize("kind", HAMMERED)
async def test_a_loop_of_motions_does_not_creep(
    robot: aioduco.Robot, seen: Seen, kind: str
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    stopped = refused = 0
    for _ in range(12):
        try:
            await hammered(robot, kind)
        except EnvelopeViolated:
            refused += 1
        except aioduco.TaskError:
            stopped += 1
    # the world's axes are those of the base only if the arm stands on a floor, which is not known:
    # the arm is stopped there, later on a busy machine. While it stops, a motion is refused, too
    assert stopped > 0 if kind == "jog world" else refused >= 4
    assert nearest(seen) > (-BEYOND if kind == "jog world" else -LAG)
    assert nearest(seen) < 0.08


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["speedj", "speedl", "jog"])
async def test_a_loop_that_does_not_wait_does_not_creep(
    robot: aioduco.Robot, seen: Seen, kind: str
) -> None:
    """Each motion is sent while the one before it runs, or is being stopped."""
    robot.envelope = Envelope("gcr5_910", wall())
    violated = 0
    with anyio.fail_after(120.0), robot.feed.subscribe("latest") as samples:
        async for _ in samples:
            try:
                await hammered(robot, kind).start()
            except EnvelopeViolated:
                violated += 1
            except (TaskStopped, aioduco.Refused):
                pass
            if violated > 10:
                break
    await robot.stop()
    assert nearest(seen) > -LAG


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["joints", "linear"])
async def test_streams_of_speeds_opened_again_and_again_do_not_creep(
    robot: aioduco.Robot, seen: Seen, kind: str
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    ended = 0
    for _ in range(8):
        if kind == "joints":
            speeds = [0.6, 0.0, 0.0, 0.0, 0.0, 0.0]
            stream = robot.speed.joints(a=5.0, dead_man=2.0, hold=2.0, latest=False, options=THREAD)
        else:
            speeds = [0.0, 0.3, 0.0, 0.0, 0.0, 0.0]
            stream = robot.speed.linear(
                a=2.0, v=0.3, frame="base", dead_man=2.0, hold=2.0, latest=False, options=THREAD
            )
        with suppress(StreamError):
            async with stream:
                for _ in range(100):
                    await stream.send(speeds)
        ended += stream.reason.name in ("ENVELOPE", "STOPPED", "HALTED")
    assert ended >= 4
    assert nearest(seen) > -LAG


@pytest.mark.slow
async def test_streams_of_positions_opened_again_and_again_do_not_creep(
    robot: aioduco.Robot, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    for _ in range(6):
        q = list(await robot.state.get_actual_joints_position())
        stream = robot.servo.joints(v=1.0, a=5.0, rate=100, options=THREAD)
        with suppress(StreamLeavesEnvelope):
            async with stream:
                for _ in range(50):
                    q[0] += 0.005
                    await stream.send(q)
    assert nearest(seen) > -2 * LAG
    assert nearest(seen) < 0.02


# -- beyond a limit ----------------------------------------------------------------------------

BACK = [
    lambda motion: motion.speedj((-0.3, 0, 0, 0, 0, 0), a=3.0, time=0.1),
    lambda motion: motion.speedl((0, -0.1, 0, 0, 0, 0), a=3.0, time=0.1, frame="base"),
    lambda motion: motion.move_jog(Jog.joint(1, -1, 100.0), time=0.1),
    lambda motion: motion.move_jog(Jog.cartesian("y", -1, 100.0, step=0.01)),
    lambda motion: motion.servoj(turned(0.3), v=0.5, a=5.0),
    lambda motion: motion.movej2(turned(0.3), v=0.5, a=5.0),
    lambda motion: motion.tcp_move((0.02, 0, 0, 0, 0, 0), v=0.2, a=2.0),
]
FORTH = [
    lambda motion: motion.speedj((0.01, 0, 0, 0, 0, 0), a=3.0, time=0.1),
    lambda motion: motion.speedl((0.1, 0, 0, 0, 0, 0), a=3.0, time=0.1, frame="base"),  # along
    lambda motion: motion.move_jog(Jog.joint(1, 1, 1.0), time=0.1),
    lambda motion: motion.move_jog(Jog.cartesian("y", -1, 1.0, frame=JogFrame.WORLD), time=0.1),
    lambda motion: motion.servoj(turned(0.41), v=0.5, a=5.0),
    lambda motion: motion.movej2(turned(0.401), v=0.5, a=5.0),
    lambda motion: motion.spline([Pose(0.5, 0.1, 0.4, math.pi, 0, 0)], v=0.1, a=1.0),
    lambda motion: motion.teach_mode(),
]


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(BACK)))
async def test_an_arm_beyond_a_limit_is_led_back(
    robot: aioduco.Robot, seen: Seen, number: int
) -> None:
    await stand(robot, *turned(0.4))  # 9 cm beyond
    robot.envelope = Envelope("gcr5_910", wall(), JointMargin(0.2), SingularityMargin(0.01))
    before = nearest(seen)
    await BACK[number](robot.motion)
    assert nearest(seen) >= before - 1e-3
    q = await robot.state.get_actual_joints_position()
    assert q[0] < 0.4 - 1e-3


@pytest.mark.parametrize("number", range(len(FORTH)))
async def test_an_arm_beyond_a_limit_is_led_nowhere_else(robot: aioduco.Robot, number: int) -> None:
    await stand(robot, *turned(0.4))
    robot.envelope = Envelope("gcr5_910", wall())
    with pytest.raises(EnvelopeViolated, match="'wall'"):
        await FORTH[number](robot.motion)
    assert not robot.tasks
    assert await robot.state.get_actual_joints_position() == pytest.approx(turned(0.4), abs=1e-3)


async def test_the_way_back_may_not_cross_another_limit(robot: aioduco.Robot) -> None:
    await stand(robot, *turned(0.4))
    behind = Zone.plane((0, AT[1] + 0.15, 0), (0, 1, 0), bodies=("flange",), name="behind")
    robot.envelope = Envelope("gcr5_910", wall(), behind)
    with pytest.raises(EnvelopeViolated, match="'behind'"):
        await robot.motion.movej2(turned(0.0), v=0.5, a=5.0)
    with pytest.raises((EnvelopeViolated, TaskStopped)):
        await robot.motion.speedj((-0.5, 0, 0, 0, 0, 0), a=3.0, time=3.0)
    q = np.array(await robot.state.get_actual_joints_position())
    assert least((behind,), q) > -LAG


@pytest.mark.slow
async def test_nothing_that_stands_is_refused(robot: aioduco.Robot) -> None:
    """A velocity of zero ends a motion: it is allowed anywhere."""
    await stand(robot, *turned(0.4))
    robot.envelope = Envelope("gcr5_910", wall())
    await robot.motion.speedj((0, 0, 0, 0, 0, 0), a=3.0, time=0.05)


@pytest.mark.slow
async def test_a_speed_stream_from_beyond_a_limit_only_leads_back(robot: aioduco.Robot) -> None:
    await stand(robot, *turned(0.4))
    robot.envelope = Envelope("gcr5_910", wall())

    async def follow(speed: float) -> None:
        async with robot.speed.joints(
            a=5.0, dead_man=2.0, hold=2.0, latest=False, options=THREAD
        ) as stream:
            for _ in range(10):
                await stream.send([speed, 0, 0, 0, 0, 0])

    with pytest.raises(StreamLeavesEnvelope):
        await follow(0.05)
    assert await robot.state.get_actual_joints_position() == pytest.approx(turned(0.4), abs=2e-3)
    await follow(-0.05)
    assert (await robot.state.get_actual_joints_position())[0] < 0.399


# -- what else was let through -----------------------------------------------------------------


async def test_after_a_refusal_the_next_motion_is_checked_too(robot: aioduco.Robot) -> None:
    """Also while the motion before it runs: it begins where that one ends."""
    robot.envelope = Envelope("gcr5_910", wall())
    first = await robot.motion.movej2(turned(-2.0), v=0.05, a=1.0).start()
    for _ in range(3):
        with pytest.raises(EnvelopeViolated):
            await robot.motion.movej2(turned(0.6), v=1.0, a=5.0).start()
    assert [task.name for task in robot.tasks] == ["movej2"]
    await first.cancel()


async def test_a_motion_behind_an_unknown_one_is_checked(robot: aioduco.Robot) -> None:
    """Where it begins is not known, but where it ends is."""
    robot.envelope = Envelope("gcr5_910", wall())
    async with robot.motion.speedj((-0.1, 0, 0, 0, 0, 0), a=3.0, time=5.0):
        with pytest.raises(EnvelopeViolated):
            await robot.motion.movej2(turned(0.6), v=3.0, a=40.0).start()


@pytest.mark.slow
async def test_a_stream_that_is_not_opened_leaves_the_watch_on(
    robot: aioduco.Robot, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    task = await robot.motion.speedj((0.6, 0, 0, 0, 0, 0), a=3.0, time=5.0).start()
    with pytest.raises(aioduco.RobotStateError):
        async with robot.servo.joints(v=1.0, a=5.0, rate=100, options=THREAD):
            pass
    with pytest.raises(TaskStopped):
        await task
    assert nearest(seen) > 0


async def test_an_envelope_that_is_set_while_the_arm_moves_holds(
    robot: aioduco.Robot, seen: Seen
) -> None:
    task = await robot.motion.movej2(turned(1.0), v=0.5, a=5.0).start()
    robot.envelope = Envelope("gcr5_910", wall())
    with pytest.raises(TaskStopped):
        await task
    assert nearest(seen) > 0


async def test_points_of_splines_tracks_and_the_queue_are_checked(robot: aioduco.Robot) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    here = await robot.state.get_tcp_pose()
    beyond = Pose(here.x, here.y + 0.15, *here[2:])
    with pytest.raises(EnvelopeViolated):
        await robot.motion.spline([here, beyond], v=0.1, a=1.0)
    with pytest.raises(EnvelopeViolated):
        await robot.motion.move_spiral(here, beyond, 1.0, 0.0, 0.0, 1, v=0.1, a=1.0)
    with pytest.raises(EnvelopeViolated):
        await robot.track.trackEnqueue([aioduco.Joints(*turned(q)) for q in (0.0, 0.1, 0.5)])
    points = [RealtimePoint.joint_position(turned(q)) for q in (0.0, 0.5)]
    with pytest.raises(EnvelopeViolated):
        await robot.realtime.realtime_data_enqueue(points)
    assert await robot.track.getQueueSize() == 0
    assert await robot.realtime.get_realtime_data_queue_size() == 0


async def test_points_are_refused_to_an_arm_that_follows_the_pool_beyond_a_limit(
    robot: aioduco.Robot,
) -> None:
    await robot.track.trackEnqueue([aioduco.Joints(*turned(0.001 * n)) for n in range(10)])
    await robot.track.trackJointMotion(1.0, 2.0)
    await stand(robot, *turned(0.4))
    robot.envelope = Envelope("gcr5_910", wall())
    with pytest.raises(EnvelopeViolated, match="not known to lead back"):
        await robot.track.trackEnqueue([aioduco.Joints(*turned(0.3))])


# -- speeds, margins, forces -------------------------------------------------------------------


SPEEDS = [
    lambda motion: motion.speedj((-0.8, 0, 0, 0, 0, 0), a=5.0, time=0.5),
    lambda motion: motion.speedl((0, -0.4, 0, 0, 0, 0), a=5.0, time=0.5, frame="base"),
    lambda motion: motion.move_jog(Jog.joint(1, -1, 100.0), time=0.5),
    lambda motion: motion.move_jog(Jog.cartesian("y", -1, 100.0), time=0.5),
    lambda motion: motion.move_jog(Jog.cartesian("y", -1, 100.0, step=0.1)),
    lambda motion: motion.servoj(turned(-0.5), v=1.0, a=20.0),
    lambda motion: motion.servoj_pose(
        Pose(AT[0], AT[1] - 0.2, AT[2], math.pi, 0, -math.pi / 2), v=1.0, a=20.0
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize("number", range(len(SPEEDS)))
async def test_a_limit_of_the_speed_slows_a_command(
    robot: aioduco.Robot, seen: Seen, number: int
) -> None:
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.1, action="slow"))
    await SPEEDS[number](robot.motion)
    assert 0.05 < fastest(seen) <= 0.1 * 1.05


@pytest.mark.parametrize("number", range(len(SPEEDS)))
async def test_a_limit_of_the_speed_refuses_a_command(robot: aioduco.Robot, number: int) -> None:
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.1))
    with pytest.raises(EnvelopeViolated, match="m/s"):
        await SPEEDS[number](robot.motion)


@pytest.mark.parametrize("kind", ["servol", "servo_tcp"])
async def test_a_set_point_with_a_speed_of_the_tool_is_slowed(kind: str) -> None:
    """By manual 4.3 its v is the tool's."""
    q: list[np.ndarray] = []
    with Simulator(speed=SPEED, joints=START, cycle=CYCLE, generation="4.3") as sim:
        sim.observe(lambda snapshot, _: q.append(snapshot.setpoint.q.copy()))
        async with aioduco.connect(sim.host, sim.port, clock=sim.clock, lag_limit=None) as robot:
            await robot.bring_up()
            robot.envelope = Envelope("gcr5_910", wall(-0.3, action="slow"))
            if kind == "servol":
                to = Pose(AT[0], AT[1] + 0.15, AT[2], math.pi, 0, -math.pi / 2)
                await robot.motion.servol(to, v=0.5, a=20.0)
            else:
                await robot.motion.servo_tcp(Pose(0.15, 0, 0, 0, 0, 0), v=0.5, a=20.0)
    tool = ARM.fkine(np.array(q))[:, :3, 3]
    # the simulator takes the ratio of both ways: it is a fifth faster in between
    assert 0.08 < np.linalg.norm(np.diff(tool, axis=0), axis=1).max() / CYCLE <= 0.1 * 1.25


@pytest.mark.slow
async def test_a_set_point_is_slowed_within_a_slow_zone_alone(
    robot: aioduco.Robot, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", wall(0.1, action="slow", speed=0.05))
    await robot.motion.servoj(turned(0.15), v=1.0, a=20.0)
    assert fastest(seen) > 0.1
    seen.clear()
    await robot.motion.servoj(turned(0.3), v=1.0, a=20.0)
    assert fastest(seen) <= 0.05 * 1.05


@pytest.mark.slow
async def test_a_stream_of_speeds_is_slowed(robot: aioduco.Robot, seen: Seen) -> None:
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.1, action="slow"))
    for stream, speeds in (
        (robot.speed.joints(a=5.0, dead_man=2.0, hold=2.0, latest=False, options=THREAD),
         [-0.6, 0.0, 0.0, 0.0, 0.0, 0.0]),
        (robot.speed.linear(a=5.0, dead_man=2.0, hold=2.0, latest=False, options=THREAD),
         [0.2, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ):  # fmt: skip
        seen.clear()
        async with stream:
            for _ in range(20):
                await stream.send(speeds)
        assert 0.05 < fastest(seen) <= 0.1 * 1.05


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["speedj", "servoj", "jog"])
async def test_margins_of_joints_are_kept(robot: aioduco.Robot, seen: Seen, kind: str) -> None:
    limit = 2 * math.pi - 0.3
    await stand(robot, *START[:5], limit - 0.4)
    robot.envelope = Envelope("gcr5_910", JointMargin(0.3))
    violated = 0
    for number in range(1, 9):
        try:
            if kind == "speedj":
                await robot.motion.speedj((0, 0, 0, 0, 0, 0.8), a=3.0, time=0.5)
            elif kind == "jog":
                await robot.motion.move_jog(Jog.joint(6, 1, 100.0), time=0.5)
            else:
                q = limit - 0.4 + 0.08 * number
                await robot.motion.servoj((*START[:5], q), v=1.0, a=5.0)
        except (EnvelopeViolated, TaskStopped):
            violated += 1
    assert violated >= 3
    assert max(q[5] for q in seen.q) < limit + LAG


@pytest.mark.slow
async def test_a_force_that_grows_stops_the_arm_again(robot: aioduco.Robot, sim: Simulator) -> None:
    """A program that tries again pushes no harder; it may lead the arm back."""
    robot.envelope = Envelope("gcr5_910", ToolForce(40.0, name="push"))
    sim.push([0, 0, 50.0, 0, 0, 0])
    try:
        with pytest.raises(TaskStopped):
            await robot.motion.movej2(turned(-2.0), v=0.02, a=1.0)
        await robot.stop()
        task = await robot.motion.movej2(turned(-2.0), v=0.02, a=1.0).start()
        with anyio.fail_after(30.0), robot.feed.subscribe() as samples:
            async for sample in samples:
                if abs(sample.status.joint_speeds[0]) > 0.01:
                    break
        assert not task.done  # the force has not grown
        sim.push([0, 0, 70.0, 0, 0, 0])
        with pytest.raises(TaskStopped):
            await task
    finally:
        sim.push([0.0] * 6)


# -- the watch while it stops the arm ----------------------------------------------------------


@pytest.mark.slow
async def test_an_arm_that_moves_again_while_a_stop_is_confirmed_is_stopped_again(
    robot: aioduco.Robot, sim: Simulator, seen: Seen, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another program goes on commanding; no pile of tasks stops the arm."""
    supervisor = robot._supervisor
    robot.envelope = Envelope("gcr5_910", wall())
    confirmed = anyio.Event()
    resting = 0

    async def rest(*_: object) -> None:
        nonlocal resting
        resting += 1
        await confirmed.wait()
        resting -= 1

    monkeypatch.setattr(supervisor.stop_coordinator, "rest", rest)
    other = aioduco.connect(sim.host, sim.port, clock=sim.clock, heartbeat=None, lag_limit=None)
    async with other as second:
        task = await robot.motion.speedj((0.6, 0, 0, 0, 0, 0), a=3.0, time=5.0).start()
        with anyio.fail_after(60.0), robot.feed.subscribe() as samples:
            async for _ in samples:
                if resting:
                    break
        stops = supervisor.stop_channel.stops
        with anyio.fail_after(60.0):
            while supervisor.stop_channel.stops < stops + 3:
                with suppress(aioduco.TaskError):  # it is refused while the arm brakes
                    await second.motion.speedj((0.6, 0, 0, 0, 0, 0), a=3.0, time=1.0)
                assert resting == 1
        assert nearest(seen) > -BEYOND
        confirmed.set()
        with suppress(TaskStopped):
            await task


@pytest.mark.slow
async def test_the_watch_waits_for_no_other_call(
    robot: aioduco.Robot, seen: Seen, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The program may have as many calls under way as the pool has connections."""
    robot.envelope = Envelope("gcr5_910", wall())
    task = await robot.motion.speedj((0.6, 0, 0, 0, 0, 0), a=3.0, time=5.0).start()
    busy = SimpleNamespace(get_tcp_offset=anyio.sleep_forever)
    monkeypatch.setattr(robot._supervisor.envelope._watch, "_rpc", busy)
    with anyio.fail_after(60.0), pytest.raises(TaskStopped):
        await task
    assert nearest(seen) > 0
