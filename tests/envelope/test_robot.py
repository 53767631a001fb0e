"""The envelope of a robot, on a simulated arm: motions, streams, jogs, forces."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import suppress
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, NamedTuple, TypeVar

import anyio
import numpy as np
import pytest

import aioduco
import aioduco.sync
from aioduco import (
    EnvelopeViolated,
    Outcome,
    Pose,
    StaleState,
    StreamLeavesEnvelope,
    StreamStopped,
    TaskState,
    TaskStopped,
    WeavePlane,
    WeaveShape,
    WorkerOptions,
)
from aioduco.envelope import (
    Action,
    Crossing,
    Envelope,
    SingularityMargin,
    ToolForce,
    ToolSpeed,
    Zone,
)
from aioduco.envelope.checker import EnvelopeChecker
from aioduco.models.realtime import RealtimePoint
from aioduco.sim import Simulator
from aioduco.sim.handlers.frames import FrameHandlers
from aioduco.sim.handlers.state import StateHandlers
from aioduco.streaming.shared.words import Reason
from aioduco.streaming.stream import Stream
from aioduco.supervision.concurrency import Silence
from aioduco.supervision.envelope_watch import EnvelopeWatch
from aioduco.supervision.events import EnvelopeLeft, EnvelopeUnwatched, Event
from aioduco.supervision.state_feed import Subscription
from aioduco.testing import FaultProxy, HalfOpen, eventually_async

from .conftest import (
    AT,
    FLAT,
    SPEED,
    START,
    THREAD,
    fastest,
    stand,
    standing_time,
    turned,
    wall,
)
from .trials import ARM, LAG, Seen, least, margins

TOOL = Pose(0, 0, 0, 0, 0, 0)

E = TypeVar("E", bound=Event)


async def test_a_joint_motion_beyond_a_zone_is_not_sent(robot: aioduco.Robot, seen: Seen) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    with pytest.raises(EnvelopeViolated, match=r"was not sent.*'wall'.*tool") as refused:
        await robot.motion.movej2(turned(0.6), v=1.0, a=5.0)
    error = refused.value
    assert (error.limit, error.body) == ("wall", "tool")
    assert error.margin < 0
    assert error.place[1] > AT[1] + 0.1
    assert not robot.tasks
    assert await robot.state.get_actual_joints_position() == pytest.approx(START, abs=1e-4)
    robot.envelope = None
    await robot.motion.movej2(turned(0.6), v=3.0, a=20.0)
    assert least((wall(),), seen.q) < 0


async def test_the_envelope_of_another_arm_is_refused(robot: aioduco.Robot) -> None:
    robot.envelope = Envelope("gcr10_1300", Zone.plane((0, 0, -5.0), (0, 0, 1)))
    said = r"robot\.envelope is .*one of the arm that is there, .*not where a gcr10_1300 has it"
    with pytest.raises(aioduco.ParameterError, match=said):
        await robot.motion.movej2(turned(0.1), v=1.0, a=5.0)
    with pytest.raises(aioduco.ParameterError, match=said):
        async with robot.servo.joints(v=1.0, a=5.0, options=THREAD):
            raise AssertionError("entered")
    point = RealtimePoint.joint_position(START)
    with pytest.raises(aioduco.ParameterError, match=said):
        await robot.realtime.realtime_data_enqueue([point])
    assert not robot.tasks
    robot.envelope = Envelope("gcr5_910", Zone.plane((0, 0, -5.0), (0, 0, 1)))
    await robot.motion.movej2(turned(0.1), v=1.0, a=5.0)


@pytest.mark.slow
async def test_the_ways_of_lines_and_arcs_are_known(robot: aioduco.Robot) -> None:
    """Their ends are within the envelope; only what lies between them is not."""
    here = await robot.state.get_tcp_pose()
    pillar = Zone.box((AT[0], AT[1] + 0.1, AT[2]), (0.05, 0.05, 0.05), name="pillar")
    robot.envelope = Envelope("gcr5_910", pillar)
    behind = Pose(here.x, here.y + 0.2, *here[2:])
    with pytest.raises(EnvelopeViolated, match="movel"):
        await robot.motion.movel(behind, v=0.5, a=2.0)
    beside = Pose(here.x + 0.1, here.y + 0.1, *here[2:])
    await robot.motion.movec(beside, behind, v=1.0, a=5.0)
    with pytest.raises(EnvelopeViolated, match="tcp_move"):
        # the tool's y axis points to the base's x, its x axis to -y
        await robot.motion.tcp_move(Pose(0.2, 0, 0, 0, 0, 0), v=0.5, a=2.0)


@pytest.mark.slow
async def test_names_of_tool_and_work_object_are_taken_into_account(robot: aioduco.Robot) -> None:
    await robot.frames.set_wobj("bench", Pose(0.1, 0.2, 0.3, 0, 0, 0.5))
    await robot.frames.set_tool_data("long", Pose(0, 0, 0.2, 0, 0, 0), [0.1, 0, 0, 0])
    await robot.frames.set_wobj("base", TOOL)
    await robot.frames.set_tool_data("none", TOOL, [0.1, 0, 0, 0])
    table = Zone.plane((0, 0, AT[2] - 0.15), (0, 0, 1), bodies=("tool",), name="table")
    robot.envelope = Envelope("gcr5_910", table)
    short = await robot.state.get_tcp_pose_coord("none", "bench")
    down = Pose(short.x, short.y, short.z - 0.1, *short[3:])
    await robot.motion.movel(down, v=1.0, a=5.0, tool="none", wobj="bench")
    await robot.motion.movel(short, v=1.0, a=5.0, tool="none", wobj="bench")
    # the tip of the long tool is below the table already: what does not lead back is refused
    long = await robot.state.get_tcp_pose_coord("long", "bench")
    deeper = Pose(long.x, long.y, long.z - 0.01, *long[3:])
    with pytest.raises(EnvelopeViolated, match="'table'"):
        await robot.motion.movel(deeper, v=1.0, a=5.0, tool="long", wobj="bench")


async def test_a_frame_that_is_defined_anew_while_the_arm_moves_is_not_taken_for_the_old_one(
    robot: aioduco.Robot, seen: Seen
) -> None:
    zone = wall()
    robot.envelope = Envelope("gcr5_910", zone)
    await robot.frames.set_wobj("part", Pose(0, 0, 0, 0, 0, 0))
    here = await robot.state.get_tcp_pose()
    await robot.motion.movel(here.shifted(x=-0.01), v=0.2, a=1.0, wobj="part")
    first = await robot.motion.movel(here, v=0.05, a=1.0, wobj="part").start()
    await robot.frames.set_wobj("part", Pose(0, 0.3, 0, 0, 0, 0))
    await robot.frames.set_wobj("other", Pose(0, 0, 0, 0, 0, 0))  # which is in use, as before
    # its path is not known, and is watched; on a busy computer the arm stands: then it is refused
    with pytest.raises((TaskStopped, EnvelopeViolated)):
        await robot.motion.movel(here, v=0.3, a=1.0, wobj="part")
    with suppress(TaskStopped):
        await first
    tool = ARM.fkine(np.array(seen.q))[:, :3, 3]
    assert margins(zone, tool).min() > -LAG
    await stand(robot, *START)


async def test_a_frame_that_is_defined_anew_while_a_stream_runs_does_not_lead_it_beyond(
    robot: aioduco.Robot, seen: Seen
) -> None:
    zone = wall()
    robot.envelope = Envelope("gcr5_910", zone)
    await robot.frames.set_wobj("part", Pose(0, 0, 0, 0, 0, 0))
    here = await robot.state.get_tcp_pose()
    stream = robot.servo.pose(v=1.0, a=5.0, rate=100, wobj="part", options=THREAD)

    async def follow() -> None:
        async with stream:
            await stream.send(here)
            await robot.frames.set_wobj("part", Pose(0, 0.3, 0, 0, 0, 0))
            for _ in range(200):
                await stream.send(here)

    with pytest.raises(StreamLeavesEnvelope, match="'wall'"):
        await follow()
    await robot.frames.set_wobj("other", Pose(0, 0, 0, 0, 0, 0))
    tool = ARM.fkine(np.array(seen.q))[:, :3, 3]
    assert margins(zone, tool).min() > -LAG


@pytest.mark.slow
async def test_a_motion_is_sent_more_slowly(robot: aioduco.Robot, seen: Seen) -> None:
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.2, action="slow"), wall(0.1, "slow", 0.1))
    await robot.motion.movej2(turned(0.15), v=3.0, a=20.0)
    target = Pose(AT[0], AT[1] + 0.15, AT[2], math.pi, 0, -math.pi / 2)
    speeds = [fastest(seen)]
    seen.clear()
    await robot.motion.movel(target, v=1.0, a=5.0)
    speeds.append(fastest(seen))
    assert speeds[0] <= 0.2 * 1.05
    assert speeds[0] > 0.15
    assert speeds[1] <= 0.1 * 1.05
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.2))
    with pytest.raises(EnvelopeViolated, match="m/s"):
        await robot.motion.movel(Pose(*AT, math.pi, 0, -math.pi / 2), v=0.25, a=5.0)


async def test_a_motion_that_cannot_be_slow_enough_names_the_limit(robot: aioduco.Robot) -> None:
    robot.envelope = Envelope("gcr5_910", wall(-0.1, "slow", 0.005))
    with pytest.raises(EnvelopeViolated, match=r"of 0\.005, below the least one, 0\.01") as caught:
        await robot.motion.movel(Pose(*AT, math.pi, 0, -math.pi / 2).shifted(y=0.1), v=0.1, a=1.0)
    assert caught.value.limit == "wall"


async def test_stop_ends_what_runs_before_it(robot: aioduco.Robot) -> None:
    robot.envelope = Envelope("gcr5_910", wall(0.1, "stop"))
    first = await robot.motion.movej2(turned(-3.0), v=0.05, a=1.0).start()
    with pytest.raises(EnvelopeViolated, match="the arm was stopped"):
        await robot.motion.movej2(turned(0.6), v=1.0, a=5.0)
    with pytest.raises(TaskStopped):
        await first


async def before_a_corner(
    robot: aioduco.Robot, action: Action = "refuse"
) -> tuple[Pose, Pose, Pose]:
    """Where the tool is, a corner and what lies behind it; a blend would cut a zone beside it."""
    here = await robot.state.get_tcp_pose()
    corner = Pose(here.x, here.y + 0.2, *here[2:])
    end = Pose(here.x - 0.2, here.y + 0.2, *here[2:])
    at = here.x - 0.05, here.y + 0.15, here.z
    edge = Zone.sphere(at, 0.03, bodies=("tool",), action=action, name="edge")
    robot.envelope = Envelope("gcr5_910", edge)
    return here, corner, end


@pytest.mark.slow
async def test_the_corner_that_a_blend_cuts_is_checked(
    robot: aioduco.Robot, sim: Simulator
) -> None:
    here, corner, end = await before_a_corner(robot)
    with standing_time(sim):
        await robot.motion.movel(corner, v=0.5, a=2.0, r=0.15).start()
        with pytest.raises(EnvelopeViolated, match="'edge'"):
            await robot.motion.movel(end, v=0.5, a=2.0).start()
    await robot.stop()
    await robot.motion.movel(here, v=1.0, a=5.0)
    with standing_time(sim):
        await robot.motion.movel(corner, v=0.5, a=2.0, r=0.03).start()
        blended = await robot.motion.movel(end, v=0.5, a=2.0).start()
    await blended
    await robot.motion.movel(here, v=1.0, a=5.0)
    with standing_time(sim):
        await robot.motion.movej_pose(corner, v=10, a=10, r=1).start()
        with pytest.raises(EnvelopeViolated, match="'edge'"):  # percent of an unknown radius
            await robot.motion.movel(end, v=0.5, a=2.0).start()


async def test_a_corner_is_checked_between_its_chords_and_as_the_joints_turn(
    robot: aioduco.Robot, sim: Simulator
) -> None:
    post = Zone.sphere((0.180, 0.470, 0.455), 0.013, bodies=("tool",), name="post")
    robot.envelope = Envelope("gcr5_910", post)
    up = (1.2, -1.0, *START[2:])
    with standing_time(sim):
        await robot.motion.movej2(turned(1.2), v=1.0, a=5.0, r=0.25).start()
        with pytest.raises(EnvelopeViolated, match="'post'"):  # its blend leads through the middle
            await robot.motion.movej2(up, v=1.0, a=5.0).start()


@pytest.mark.slow
async def test_a_corner_through_a_zone_that_slows_is_gone_through_slowly(
    robot: aioduco.Robot, sim: Simulator, seen: Seen
) -> None:
    here, corner, end = await before_a_corner(robot, "slow")
    with standing_time(sim):
        await robot.motion.movel(corner, v=0.5, a=2.0, r=0.15).start()
        with pytest.raises(EnvelopeViolated, match=r"'edge'.*must be slow"):
            await robot.motion.movel(end, v=0.5, a=2.0).start()
    await robot.stop()
    await robot.motion.movel(here, v=1.0, a=5.0)
    seen.clear()
    with standing_time(sim):
        first = await robot.motion.movel(corner, v=0.1, a=2.0, r=0.15).start()
        last = await robot.motion.movel(end, v=0.5, a=2.0).start()
    await last
    assert first.outcome is Outcome.BLENDED
    assert fastest(seen) <= 0.1 * 1.05


async def test_a_corner_of_joint_motions_that_is_too_fast_in_a_zone_that_slows_ends_in_a_stop(
    robot: aioduco.Robot, sim: Simulator, seen: Seen
) -> None:
    """Each motion alone is slow enough; how fast the tool is while it does both is not known."""
    robot.envelope = Envelope("gcr5_910", wall(-1.0, "slow", 0.1))
    lift = (0.0, -0.4, *START[2:])
    bend = (0.0, -0.4, START[2], 1.0, *START[4:])
    with standing_time(sim):
        await robot.motion.movej2(lift, v=1.0, a=5.0, r=0.08).start()
        last = await robot.motion.movej2(bend, v=1.0, a=5.0).start()
    with pytest.raises(TaskStopped) as caught:
        await last
    assert isinstance(caught.value.__cause__, EnvelopeViolated)


async def test_a_weave_over_a_line_beside_the_wall_is_stopped_before_it(
    robot: aioduco.Robot, seen: Seen
) -> None:
    """The line itself is within the envelope."""
    zone = wall(0.005)
    robot.envelope = Envelope("gcr5_910", zone)
    await robot.compound.combine_motion_config(
        WeaveShape.SINE, WeavePlane.WORK_OBJECT_XY, fq=2.0, amp=0.03
    )
    await robot.compound.enable_combine_motion()
    try:
        here = await robot.state.get_tcp_pose()
        with pytest.raises(TaskStopped) as caught:
            await robot.motion.movel(here.shifted(x=-0.2), v=0.1, a=1.0)
    finally:
        await robot.compound.disable_combine_motion()
    assert isinstance(caught.value.__cause__, EnvelopeViolated)
    tool = ARM.fkine(np.array(seen.q))[:, :3, 3]
    assert margins(zone, tool).min() > -LAG
    await robot.motion.movel(here, v=0.1, a=1.0)


@pytest.mark.slow
async def test_a_blocking_call_is_checked_as_the_motion_is(
    robot: aioduco.Robot, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.2, action="slow"), wall())
    with pytest.raises(EnvelopeViolated, match=r"movej2 was not sent.*'wall'"):
        await robot.blocking.movej2(turned(0.6), v=1.0, a=5.0)
    assert await robot.blocking.movej2(turned(0.1), v=3.0, a=20.0) is TaskState.FINISHED
    assert await robot.state.get_actual_joints_position() == pytest.approx(turned(0.1), abs=1e-3)
    assert fastest(seen) <= 0.2 * 1.05


@pytest.mark.slow
async def test_what_blends_after_a_blocking_call_is_watched(
    robot: aioduco.Robot, sim: Simulator
) -> None:
    """Its call is answered while the arm moves, so the next one begins nobody knows where."""
    _, corner, end = await before_a_corner(robot)
    sim.speed = 0.01  # the second comes in time
    assert await robot.blocking.movel(corner, v=0.5, a=2.0, r=0.15) is TaskState.INTERRUPT
    async with anyio.create_task_group() as tg:

        async def second() -> None:
            with pytest.raises(TaskStopped):
                await robot.blocking.movel(end, v=0.5, a=2.0)

        tg.start_soon(second)
        await eventually_async(lambda: len(sim.tasks) == 2)
        sim.speed = SPEED
    assert not await robot.state.robotmoving()
    robot.envelope = None


@pytest.mark.slow
async def test_a_stream_in_a_process_ends_before_the_wall(robot: aioduco.Robot, seen: Seen) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    points = START.array + np.linspace(0, 1, 400)[:, None] * np.array([0.8, 0, 0, 0, 0, 0])
    stream = robot.servo.joints(v=1.5, a=10.0, rate=250, options=WorkerOptions(timeout=10.0))
    with pytest.raises(StreamLeavesEnvelope, match="'wall'") as ended:
        async with stream:
            await stream.play(points)
    assert (ended.value.limit, ended.value.body) == ("wall", "tool")
    assert stream.reason is Reason.ENVELOPE
    assert seen.setpoints
    assert 0 <= least(FLAT, seen.setpoints) < 0.01
    assert least(FLAT, seen.q) >= -LAG
    assert not await robot.state.robotmoving()


@pytest.mark.slow
async def test_a_stream_that_begins_in_a_slow_zone_goes_on(
    robot: aioduco.Robot, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", wall(-0.1, "slow", 0.05), ToolSpeed(0.05, action="slow"))
    points = START.array + np.linspace(0, 1, 80)[:, None] * np.array([0.06, 0, 0, 0, 0, 0])
    stream = robot.servo.joints(
        v=1.5, a=10.0, rate=100, source_rate=50, upsample="ruckig", options=THREAD
    )
    async with stream:
        await stream.play(points)
    assert stream.reason is Reason.NONE or stream.reason is Reason.CLOSED
    assert seen.setpoints[-1][0] == pytest.approx(points[-1][0], abs=1e-3)


async def test_a_stream_that_the_watch_stops_names_the_limit(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    fast = Crossing("tool speed", "tool", (0.1, 0.2, 0.3), -0.05, "m/s", "slow")

    def too_fast(watch: EnvelopeWatch, *_: object) -> Crossing | None:
        return fast if watch._coordinator.streams else None

    monkeypatch.setattr(EnvelopeWatch, "_too_fast", too_fast)
    robot.envelope = Envelope("gcr5_910", ToolSpeed(1.0, action="slow"))
    stream = robot.speed.joints(a=5.0, dead_man=5.0, hold=5.0, latest=False, options=THREAD)
    with pytest.raises(StreamLeavesEnvelope, match=r"was stopped.*'tool speed'") as ended:
        await lead(stream, [[-0.1, 0, 0, 0, 0, 0]] * 10_000)
    assert (ended.value.limit, ended.value.margin) == ("tool speed", -0.05)
    assert ended.value.statistics is not None


def test_the_watch_stops_what_is_too_fast() -> None:
    """A stream that is slowed if it is too fast twice in a row; all else at once."""
    watch = EnvelopeWatch.__new__(EnvelopeWatch)
    watch._fast = False
    for action, streams, found in (
        ("slow", [1], [False, True, True, False, False, True]),
        ("slow", [], [True, True, True, False, True, True]),
        ("refuse", [1], [True, True, True, False, True, True]),
    ):
        watch._coordinator = SimpleNamespace(streams=streams)  # type: ignore[assignment]  # of it only this is used
        speed_limit = ToolSpeed(0.1, action=action)  # type: ignore[arg-type]  # one of the actions
        checker = EnvelopeChecker(Envelope("gcr5_910", speed_limit).packed(TOOL))
        speeds = [0.11, 0.101, 0.12, 0.1, 0.11, 0.11]
        assert [watch._too_fast(checker, speed) is not None for speed in speeds] == found


async def lead(stream: Stream, points: list[list[float]]) -> None:
    """Send points in a stream, until it ends."""
    async with stream:
        for point in points:
            await stream.send(point)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["servoj_pose", "servo_tcp", "servo_tcp base", "track"])
async def test_each_stream_of_places_ends_before_the_wall(
    robot: aioduco.Robot, seen: Seen, kind: str
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    x, y, *others = await robot.state.get_tcp_pose()
    step, points = 0.0025, [[x, y + 0.0025 * number, *others] for number in range(1, 60)]
    if kind == "servoj_pose":
        stream = robot.servo.pose(v=1.5, a=10.0, rate=100, options=THREAD)
    elif kind == "servo_tcp":
        stream = robot.servo.tcp_offset(v=1.5, a=10.0, rate=100, options=THREAD)
        points = [[-step, 0, 0, 0, 0, 0]] * 60
    elif kind == "servo_tcp base":
        stream = robot.servo.tcp_offset(v=1.5, a=10.0, rate=100, frame="base", options=THREAD)
        points = [[0, step, 0, 0, 0, 0]] * 60
    else:
        stream = robot.track.stream("pose", speed=0.3, acc=2.0, options=THREAD)
    with pytest.raises(StreamLeavesEnvelope, match="'wall'"):
        await lead(stream, points)
    nearest = least(FLAT, [await robot.state.get_actual_joints_position(), *seen.q])
    assert nearest >= -LAG
    # Points of a track are checked before it begins, as far as they are there: if all are, none is
    # sent. Where others end before the wall depends on how busy the machine is.
    assert nearest < 0.09 or kind == "track"


@pytest.mark.slow
async def test_the_realtime_queue_ends_before_the_wall(
    robot: aioduco.Robot, sim: Simulator, seen: Seen
) -> None:
    robot.envelope = Envelope("gcr5_910", wall(0.03))
    x, y, *others = await robot.state.get_tcp_pose()
    points = [[x, y + 0.0003 * number, *others] for number in range(1, 200)]
    sim.speed = 1.0  # the queue is emptied by the controller's clock
    stream = robot.realtime.stream(
        "pose", v=(0.3, 1.0), a=(2.0, 4.0), com_lost_time=0.5, depth=100, options=THREAD
    )
    try:
        with pytest.raises(StreamLeavesEnvelope, match="'wall'"):
            await lead(stream, points)
    finally:
        sim.speed = SPEED
    assert 0.07 - LAG <= least(FLAT, seen.q) < 0.095


async def until(events: Subscription[Event], kind: type[E]) -> AsyncIterator[E]:
    async for event in events:
        if isinstance(event, kind):
            yield event
            return


class Beside(NamedTuple):
    robot: aioduco.Robot
    proxy: FaultProxy

    def kill_feed(self) -> None:
        self.proxy.on("getRobotIOStatus", HalfOpen(), times=None)

    async def feed_comes_back(self) -> None:
        self.proxy.clear()
        self.proxy.cut()
        samples = self.robot.feed.statistics().samples
        await eventually_async(lambda: self.robot.feed.statistics().samples > samples)


@pytest.fixture
async def beside(sim: Simulator, robot: aioduco.Robot) -> AsyncIterator[Beside]:
    """A robot that watches its envelope, and whose feed alone can be killed: other calls pass."""
    del robot  # it has brought the arm up
    with FaultProxy(sim.host, sim.port) as proxy:
        async with aioduco.connect(
            proxy.host, proxy.port, clock=sim.clock, lag_limit=None, call_timeout=60.0
        ) as watching:
            watching.envelope = Envelope("gcr5_910", wall(0.5))
            await watching.feed.latest(max_age=60.0)
            yield Beside(watching, proxy)


@pytest.mark.slow
async def test_a_motion_is_stopped_when_no_samples_come_and_others_are_not_sent(
    beside: Beside,
) -> None:
    robot = beside.robot
    with robot.events.subscribe() as events:
        move = await robot.motion.movej2(turned(-3.0), v=0.02, a=1.0).start()
        beside.kill_feed()
        with pytest.raises(TaskStopped, match="the envelope is not watched: no sample") as stopped:
            await move
        told = [event async for event in until(events, EnvelopeUnwatched)]
    assert isinstance(stopped.value.__cause__, StaleState)
    assert told[-1].severity == "alarm"
    assert told[-1].seconds > robot.feed.silence_limit
    assert not await robot.state.robotmoving()
    with pytest.raises(StaleState, match="movej2 was not sent, since the envelope is not watched"):
        await robot.motion.movej2(turned(0.0), v=1.0, a=5.0)
    with pytest.raises(StaleState, match="servoj was not sent"):
        async with robot.servo.joints(v=1.0, a=5.0, options=THREAD):
            raise AssertionError("entered")
    assert not robot.tasks
    await beside.feed_comes_back()
    await eventually_async(lambda: not watch_of(robot)._blind)
    await robot.motion.movej2(turned(0.0), v=1.0, a=5.0)


@pytest.mark.slow
async def test_a_stream_is_stopped_when_no_samples_come(beside: Beside) -> None:
    stream = beside.robot.servo.joints(v=1.0, a=5.0, hold=60.0, options=THREAD)
    beside.kill_feed()
    with pytest.raises(StreamStopped, match="the envelope is not watched: no sample") as stopped:
        await lead(stream, [list(START)] * 1_000_000)
    assert stopped.value.statistics is not None


@pytest.mark.slow
async def test_an_arm_that_another_program_moves_is_stopped_when_no_samples_come(
    beside: Beside, robot: aioduco.Robot
) -> None:
    move = await robot.motion.movej2(turned(-3.0), v=0.02, a=1.0).start()
    beside.kill_feed()
    with pytest.raises(TaskStopped):
        await move


async def test_a_motion_is_not_resumed_when_no_samples_come(
    beside: Beside, robot: aioduco.Robot
) -> None:
    task = await robot.motion.movej2(turned(-3.0), v=0.02, a=1.0).start()
    await robot.pause()
    beside.kill_feed()
    await eventually_async(lambda: watch_of(beside.robot)._blind)
    with pytest.raises(StaleState, match="resume was not sent, since the envelope is not watched"):
        await beside.robot.resume()
    assert not beside.proxy.calls("resume")
    assert not task.done
    await robot.stop()


async def test_a_motion_after_one_that_was_resumed_is_on_a_known_path(
    robot: aioduco.Robot,
) -> None:
    """It would be stopped before the wall by its speed, although its path ends there."""
    robot.envelope = Envelope(ARM, wall())
    task = await robot.motion.movej2(turned(-0.05), v=0.02, a=1.0).start()
    await robot.pause()
    await robot.resume()
    await task
    motion = await robot.motion.movej2(turned(0.1), v=1.0, a=5.0).start()
    assert not watch_of(robot).unchecked
    await motion


@pytest.mark.slow
async def test_a_standing_arm_is_not_stopped_when_no_samples_come(beside: Beside) -> None:
    beside.kill_feed()
    await eventually_async(lambda: watch_of(beside.robot)._blind)
    asked = len(beside.proxy.calls("robotmoving"))
    await eventually_async(lambda: len(beside.proxy.calls("robotmoving")) > asked + 2)
    assert not beside.robot.statistics().stop_attempts


def watch_of(robot: aioduco.Robot) -> EnvelopeWatch:
    return robot._supervisor.envelope._watch


def test_a_standstill_of_the_loop_is_no_silence() -> None:
    silence = Silence(0.02)
    assert silence.look(10.0, 3.0) == 0.0
    assert silence.look(10.02, 3.0) == pytest.approx(0.02)
    assert silence.look(20.0, 3.0) == pytest.approx(0.09)  # the loop stood still for 10 s
    assert silence.look(20.02, 20.01) == 0.0
    assert silence.look(20.05, 20.01) == pytest.approx(0.03)


@pytest.mark.slow
async def test_a_jog_is_stopped_before_the_wall(robot: aioduco.Robot, seen: Seen) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    with robot.events.subscribe() as events:
        with pytest.raises(TaskStopped) as stopped:
            await robot.motion.speedl([0, 0.3, 0, 0, 0, 0], a=2.0, time=3.0, frame="base")
        told = [each async for each in until(events, EnvelopeLeft)]
    assert told[-1].crossing.limit == "wall"
    assert isinstance(stopped.value.__cause__, EnvelopeViolated)
    assert 0 <= least(FLAT, seen.q) < 0.09


@pytest.mark.parametrize("gone", [[math.nan] * 6, []])
async def test_an_arm_whose_joint_speeds_are_not_reported_is_stopped_and_not_moved(
    robot: aioduco.Robot, seen: Seen, monkeypatch: pytest.MonkeyPatch, gone: list[float]
) -> None:
    robot.envelope = Envelope("gcr5_910", wall())
    with robot.events.subscribe() as events:
        move = robot.motion.speedl([0, 0.05, 0, 0, 0, 0], a=2.0, time=3.0, frame="base")
        task = await move.start()
        without(monkeypatch, jointActualVelocity=gone)
        with pytest.raises(TaskStopped, match="does not report the speed of each joint") as stopped:
            await task
        told = await anext(each async for each in until(events, EnvelopeUnwatched))
    assert "speed of each joint" in told.reason
    assert isinstance(stopped.value.__cause__, StaleState)
    assert least(FLAT, seen.q) >= 0
    refusal = r"movej2 was not sent.*speed of each joint.*away \(None\)"
    with pytest.raises(StaleState, match=refusal):
        await robot.motion.movej2(turned(0.1), v=1.0, a=5.0)
    monkeypatch.undo()
    await eventually_async(lambda: not robot.tasks)
    sample = (await robot.feed.latest()).sequence
    await robot.wait_for(lambda state: state.sequence > sample + 2, timeout=5.0)
    await robot.motion.movej2(turned(0.1), v=1.0, a=5.0)


async def test_a_tool_speed_that_is_not_reported_stops_what_was_not_checked(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot.envelope = Envelope("gcr5_910", ToolSpeed(0.5))
    move = robot.motion.speedl([0, 0.02, 0, 0, 0, 0], a=2.0, time=3.0, frame="base")
    task = await move.start()
    without(monkeypatch, cartActualVelocity=[])
    with pytest.raises(TaskStopped, match=r"'tool speed': tool .*has a value that the c"):
        await task


def without(monkeypatch: pytest.MonkeyPatch, **gone: Any) -> None:
    """Let the controller not report some numbers of its status."""
    tell = StateHandlers.getRobotStatus
    monkeypatch.setattr(
        StateHandlers, "getRobotStatus", lambda handlers: replace(tell(handlers), **gone)
    )


@pytest.mark.parametrize("wanted", [True, False])
async def test_a_force_stops_the_arm_whether_or_not_the_program_wants_forces(
    robot: aioduco.Robot, sim: Simulator, wanted: bool
) -> None:
    robot.envelope = Envelope("gcr5_910", ToolForce(40.0, name="push"))
    robot.feed.forces = wanted
    move = await robot.motion.movej2(turned(-3.0), v=0.02, a=1.0).start()
    sim.push([0, 0, 60.0, 0, 0, 0])
    try:
        with pytest.raises(TaskStopped) as stopped:
            await move
    finally:
        sim.push([0.0] * 6)
    cause = stopped.value.__cause__
    assert isinstance(cause, EnvelopeViolated)
    assert (cause.limit, cause.body) == ("push", "tool")
    robot.envelope = None
    assert not robot.feed.force_readers


@pytest.mark.slow
@pytest.mark.parametrize("gone", [[math.nan] * 6, []])
async def test_a_force_that_is_not_reported_stops_a_moving_arm(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch, gone: list[float]
) -> None:
    robot.envelope = Envelope("gcr5_910", ToolForce(40.0, name="push"))
    move = await robot.motion.movej2(turned(-3.0), v=0.02, a=1.0).start()
    monkeypatch.setattr(FrameHandlers, "get_tcp_force", lambda _: gone)
    with pytest.raises(TaskStopped, match="'push': tool has a value that the controller does not"):
        await move
    monkeypatch.undo()
    await robot.motion.movej2(turned(0.1), v=1.0, a=5.0)


@pytest.mark.slow
async def test_an_envelope_that_comes_during_a_stream_stops_it_before_the_wall(
    robot: aioduco.Robot, seen: Seen
) -> None:
    """Its worker does not know the envelope: the watch of the state looks ahead."""
    stream = robot.servo.joints(v=1.0, a=5.0, options=THREAD)

    async def later() -> None:
        await eventually_async(lambda: stream.taken > 5)
        robot.envelope = Envelope("gcr5_910", wall())

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(later)
        with pytest.raises((StreamLeavesEnvelope, aioduco.StreamStopped)):
            await lead(stream, [list(turned(0.002 * number)) for number in range(400)])
    assert least(FLAT, seen.q) >= 0


async def test_singularities_are_kept_away_from(robot: aioduco.Robot) -> None:
    robot.envelope = Envelope("gcr5_910", SingularityMargin(0.1))
    with pytest.raises(EnvelopeViolated, match="singularities"):
        await robot.motion.movej2((0, 0, 1.5, 0, 0.5, 0), v=1.0, a=5.0)


async def test_without_an_envelope_nothing_is_asked_or_checked(robot: aioduco.Robot) -> None:
    assert robot.envelope is None
    samples = robot.feed.statistics().samples
    asked = robot.statistics().lanes["call"].calls
    await robot.motion.movej2(turned(0.1), v=3.0, a=20.0)
    assert robot.statistics().lanes["call"].calls == asked
    assert robot.feed.statistics().samples == samples == 0
    with pytest.raises(aioduco.ParameterError):
        robot.envelope = "table"  # type: ignore[assignment]  # it is refused


def test_programs_that_wait_have_it_too(sim: Simulator) -> None:
    with aioduco.sync.connect(sim.host, sim.port, clock=sim.clock, lag_limit=None) as robot:
        robot.bring_up()
        robot.motion.movej2(START, v=3.9, a=40.0)
        robot.envelope = Envelope("gcr5_910", wall())
        assert robot.envelope is not None
        with pytest.raises(EnvelopeViolated):
            robot.motion.movej2(turned(0.6), v=1.0, a=5.0)
