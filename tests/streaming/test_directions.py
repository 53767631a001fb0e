"""Velocities and offsets in the frame that the program names: up goes up."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Any

import anyio
import numpy as np
import pytest

import aioduco
from aioduco.errors import ParameterError, StaleState, StreamRefused
from aioduco.models.load import Load
from aioduco.models.pose import Joints, Pose
from aioduco.sim import Simulator
from aioduco.streaming.shared.turning import composed, in_tool, turned
from aioduco.testing import eventually_async

from .conftest import THREAD

#: the flange looks down, tilted and turned, so that none of its axes is one of the base's
TILTED = Joints.deg(20, -15, 105, -15, -70, 30)
#: turned about z and tilted; the work object in use
BENCH = Pose(0.3, 0.1, 0.2, 0.1, -0.2, 0.7)
TIP = Pose(0.02, 0.0, 0.1, 0.3, 0.0, 0.0)
FRAMES = ("base", "tool", "wobj")
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture
async def robot(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        await robot.frames.set_tool_data("tip", TIP, Load(0.0, 0.0, 0.0, 0.0))
        await robot.frames.set_wobj("bench", BENCH)
        await robot.motion.movej2(TILTED, v=3.0, a=20.0)
        yield robot


async def tip(robot: aioduco.Robot) -> Pose:
    return await robot.state.get_tcp_pose()


async def axes(robot: aioduco.Robot, frame: str) -> np.ndarray:
    """The axes of a frame in the base, in the columns. Shape (3, 3)."""
    if frame == "base":
        return np.eye(3)
    return (BENCH if frame == "wobj" else await tip(robot)).matrix[:3, :3]


def simulated(sim: Simulator) -> Pose:
    """Where the tool of the simulated arm is, at once."""
    return Pose.from_matrix(sim.arm.fkine(sim.joints) @ TIP.matrix)


def moved(start: Pose, end: Pose) -> tuple[np.ndarray, np.ndarray]:
    """By how much, along and about the axes of the base [m, rad]."""
    turn = Pose.from_matrix(end.matrix @ np.linalg.inv(start.matrix)).rotvec
    return end.matrix[:3, 3] - start.matrix[:3, 3], np.array(turn)


@pytest.mark.slow
@pytest.mark.parametrize("frame", FRAMES)
async def test_one_velocity_leads_along_the_axes_of_its_frame(
    robot: aioduco.Robot, sim: Simulator, frame: Any
) -> None:
    start, up = await tip(robot), (await axes(robot, frame)) @ UP
    async with robot.motion.speedl([0, 0, 0.1, 0, 0, 0], a=1.0, time=None, frame=frame):
        await eventually_async(lambda: np.linalg.norm(moved(start, simulated(sim))[0]) > 0.04, 30.0)
    way, _ = moved(start, await tip(robot))
    np.testing.assert_allclose(way / np.linalg.norm(way), up, atol=0.01)
    middle, up = await tip(robot), (await axes(robot, frame)) @ UP
    async with robot.motion.speedl([0, 0, 0, 0, 0, 0.4], a=2.0, time=None, frame=frame):
        await eventually_async(lambda: np.linalg.norm(moved(middle, simulated(sim))[1]) > 0.2, 30.0)
    way, turn = moved(middle, await tip(robot))
    assert np.linalg.norm(way) < 2e-3
    np.testing.assert_allclose(turn / np.linalg.norm(turn), up, atol=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("frame", FRAMES)
async def test_one_offset_leads_along_the_axes_of_its_frame(
    robot: aioduco.Robot, frame: Any
) -> None:
    start, there = await tip(robot), await axes(robot, frame)
    motion = robot.motion.servo_tcp([0.02, 0, 0.03, 0, 0, 0.1], v=0.5, a=2.0, frame=frame)
    await motion
    way, turn = moved(start, await tip(robot))
    np.testing.assert_allclose(there.T @ way, [0.02, 0.0, 0.03], atol=2e-3)
    np.testing.assert_allclose(there.T @ turn, [0.0, 0.0, 0.1], atol=4e-3)
    # The same motion is turned anew, by where the tool is then.
    middle, there = await tip(robot), await axes(robot, frame)
    assert "frame" in repr(motion) or frame == "tool"
    await motion
    np.testing.assert_allclose(
        there.T @ moved(middle, await tip(robot))[0], [0.02, 0.0, 0.03], atol=2e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("frame", FRAMES)
async def test_a_stream_of_velocities_keeps_its_direction_while_the_tool_turns(
    robot: aioduco.Robot, sim: Simulator, frame: Any
) -> None:
    start = await tip(robot)
    there = await axes(robot, frame)
    # The simulated controller changes turning speeds by `a`, too. A busy machine may hold the
    # program up between two speeds.
    stream = robot.speed.linear(
        a=5.0, turn_a=5.0, frame=frame, dead_man=2.0, hold=2.0, options=THREAD
    )
    twist = [0.0, 0.0, 0.1, 0.8, 0.0, 0.0]
    async with stream:
        async for _ in stream.ticks():
            await stream.send(twist)
            if np.linalg.norm(moved(start, simulated(sim))[1]) > 0.3:
                break
    way, turn = (there.T @ each for each in moved(start, await tip(robot)))
    if frame == "tool":
        # It turns about its own x, and goes along its own z: a bow, by the axes of the start.
        assert abs(way[0]) < 4e-3
        assert way[1] < -2e-3
    else:
        assert np.linalg.norm(way[:2]) < 4e-3
    assert way[2] > 0.03
    assert turn[0] > 0.2
    assert np.linalg.norm(turn[1:]) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frame", "tool"), [("base", ""), ("tool", ""), ("wobj", ""), ("wobj", "default")]
)
async def test_a_stream_of_offsets_adds_up_in_its_frame(
    robot: aioduco.Robot, frame: Any, tool: str
) -> None:
    async def place() -> Pose:
        return await robot.state.get_tcp_pose_coord(tool, "") if tool else await tip(robot)

    in_use = BENCH if tool else Pose(0, 0, 0, 0, 0, 0)
    start = in_use @ await place()
    there = {"base": np.eye(3), "wobj": BENCH.matrix[:3, :3], "tool": start.matrix[:3, :3]}[frame]
    offset = [0.001, 0.0, 0.002, 0.0, 0.01, 0.0]
    opened = robot.servo.tcp_offset(v=1.0, a=5.0, tool=tool, frame=frame, hold=10.0, options=THREAD)
    async with opened as stream:
        for _ in range(20):
            await stream.send(offset)
    way, turn = moved(start, in_use @ await place())
    np.testing.assert_allclose(there.T @ turn, [0.0, 0.2, 0.0], atol=5e-3)
    if frame != "tool":
        np.testing.assert_allclose(there.T @ way, [0.02, 0.0, 0.04], atol=2e-3)
    else:
        wanted = Pose(0, 0, 0, 0, 0, 0)
        for _ in range(20):
            wanted = wanted @ Pose.of(offset)
        np.testing.assert_allclose(there.T @ way, wanted.matrix[:3, 3], atol=2e-3)


@pytest.mark.slow
async def test_a_motion_that_is_turned_waits_in_a_run_for_those_before_it(
    robot: aioduco.Robot,
) -> None:
    """The one before turns the tool; the offset is along the base all the same."""
    turned_away = Joints.deg(60, -15, 105, -15, -70, 30)
    await robot.motion.run(
        robot.motion.movej2(turned_away, v=3.0, a=20.0),
        robot.motion.servo_tcp([0, 0, 0.03, 0, 0, 0], v=0.5, a=2.0, frame="base"),
    )
    start = Pose.from_matrix(
        aioduco.kinematics.arm("gcr5_910").fkine(np.array(turned_away)) @ TIP.matrix
    )
    np.testing.assert_allclose(moved(start, await tip(robot))[0], [0.0, 0.0, 0.03], atol=2e-3)


@pytest.mark.slow
async def test_what_cannot_be_turned_is_not_sent(robot: aioduco.Robot) -> None:
    start = await tip(robot)
    for wrong in (
        lambda: robot.motion.speedl([0, 0, 0.1, 0, 0, 0], a=1.0, frame="flange"),  # type: ignore[arg-type]  # wrong on purpose
        lambda: robot.motion.speedl([0, 0, 0.1, 0, 0, 0], a=1.0, wobj="bench"),
        lambda: robot.motion.speedl([0, 0, 0.1, 0.5, 0, 0], a=1.0, frame="base"),
        lambda: robot.speed.linear(a=1.0, frame="world"),  # type: ignore[arg-type]  # wrong on purpose
        lambda: robot.servo.tcp_offset(v=1.0, a=1.0, frame="base", wobj="bench"),
        lambda: robot.realtime.stream("joint_velocity", v=1.0, a=1.0, frame="base"),
    ):
        with pytest.raises(ParameterError):
            wrong()
    with pytest.raises(StaleState, match="nowhere"):
        await robot.motion.speedl([0, 0, 0.1, 0, 0, 0], a=1.0, frame="wobj", wobj="nowhere")
    async with anyio.create_task_group():
        opened = robot.speed.linear(a=1.0, frame="wobj", wobj="nowhere", options=THREAD)
        with pytest.raises(StreamRefused, match="get_tcp_pose_coord"):  # noqa: PT012 - a stream
            async with opened as stream:
                await stream.send([0, 0, 0.1, 0, 0, 0])
                await stream.ended()
    # it may have been coming to rest at the start, to within 0.2 mm
    assert (await tip(robot)).almost_equal(start, position=1e-3, rotation=1e-3)


def test_turning_there_and_back_is_nothing() -> None:
    place = composed([BENCH, TIP])
    twist = [0.1, -0.2, 0.3, 0.4, 0.5, -0.6]
    matrix = BENCH.matrix @ TIP.matrix
    there = turned(twist, place, back=False)
    np.testing.assert_allclose(there[:3], matrix[:3, :3] @ twist[:3])
    np.testing.assert_allclose(turned(there, place, back=True), twist)
    offset = Pose(0.1, 0.2, 0.3, 0.3, -0.2, 0.1)
    turn = np.eye(4)
    turn[:3, :3] = matrix[:3, :3]
    np.testing.assert_allclose(
        Pose.of(in_tool(offset, place)).matrix, np.linalg.inv(turn) @ offset.matrix @ turn
    )
