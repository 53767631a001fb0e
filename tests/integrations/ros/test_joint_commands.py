"""Joint commands on a simulated arm, without ROS."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import AsyncIterator, Callable, Iterator
from functools import partial
from typing import Any

import anyio
import numpy as np
import pytest
from for_each import for_each

from aioduco import Robot
from aioduco.errors import ParameterError
from aioduco.integrations.ros.arm_node import ArmNode, NodeSettings
from aioduco.integrations.ros.joint_commands import JointCommands, check_command
from aioduco.integrations.ros.node_parameters import parameter_defaults, settings_of
from aioduco.integrations.ros.streamed_commands import StreamedCommands
from aioduco.integrations.ros.trajectory_goals import GoalRefused
from aioduco.integrations.ros.twist_commands import TwistCommands
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

from .goals import NAMES, PROFILE, START, Client, goal, way
from .nodes import Sink, beside, connected, running, ticks


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator() as sim:
        yield sim


@contextlib.asynccontextmanager
async def commanding(node: ArmNode, place: tuple[float, ...]) -> AsyncIterator[None]:
    """As a client that goes on saying the same."""

    async def run() -> None:
        async for _ in ticks(50.0):
            node.commands.take(NAMES, place)

    async with beside(run()):
        yield


async def lead(node: ArmNode, sim: Simulator, place: tuple[float, ...]) -> None:
    """Command a place until the arm is there."""
    async with commanding(node, place):
        await eventually_async(lambda: np.allclose(sim.joints, place, atol=2e-3))


@pytest.mark.slow
async def test_commands_lead_the_arm_and_their_end_frees_it(sim: Simulator) -> None:
    async with running(sim) as node:
        # One far away, such as the zeros of a controller that is not active yet, moves nothing.
        assert node.commands.take(NAMES, (0.0,) * 6)
        await eventually_async(lambda: not node.commands._waiting)
        np.testing.assert_allclose(sim.joints, START, atol=2e-3)
        for step in range(1, 6):
            await lead(node, sim, tuple(q + 0.03 * step for q in START))
        # A jump is left out, on the way or at a start.
        for _ in range(5):
            node.commands.take(NAMES, tuple(q + 1.0 for q in START))
        await eventually_async(lambda: not node.commands.following)
        np.testing.assert_allclose(sim.joints, np.array(START) + 0.15, atol=3e-3)
        client = Client(goal(points=[goal().points[0]._replace(time=1.0)]))
        node.goals.submit(client)
        await eventually_async(lambda: client.done)
        assert client.told == ["accepted", "succeeded"], client.text


@pytest.mark.slow
async def test_commands_that_are_left_out_keep_the_arm_where_it_is(sim: Simulator) -> None:
    """Some seconds of them ended the stream, and none after them was followed."""
    async with running(sim) as node:
        await lead(node, sim, way(0.2, 0.1))
        begin = sim.time
        async with commanding(node, way(1.0, 0.5)):
            await eventually_async(lambda: sim.time > begin + 4.0)
        np.testing.assert_allclose(sim.joints, way(0.2, 0.1), atol=3e-3)
        await lead(node, sim, way(0.4, 0.1))


@pytest.mark.slow
async def test_a_stop_is_not_undone_by_commands_that_go_on(sim: Simulator) -> None:
    async with running(sim, command_timeout=10.0) as node:
        await lead(node, sim, way(0.2, 0.1))
        assert (await node.services.stop()).success
        await eventually_async(lambda: not node.commands.following)
        await eventually_async(lambda: not node.commands.take(NAMES, way(0.2, 0.1)))
        assert (await node.services.recover()).success
        await lead(node, sim, way(0.4, 0.1))


@pytest.mark.slow
@pytest.mark.parametrize("how", ["stop", "pause"])
async def test_a_stop_is_not_undone_by_what_is_followed_only_later(
    sim: Simulator, how: str
) -> None:
    async with running(sim, command_timeout=10.0) as node:
        # the arm follows neither at first: one is too far away, the other is no motion
        assert node.commands.take(NAMES, (0.0,) * 6)
        assert node.twists.take([0.0] * 6)
        assert (await getattr(node.services, how)()).success
        assert not node.commands.take(NAMES, START)
        assert not node.twists.take([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
        assert (await node.services.recover()).success
        await lead(node, sim, way(0.4, 0.1))


@pytest.mark.slow
async def test_a_driver_that_serves_again_does_not_go_on_with_commands(sim: Simulator) -> None:
    """As after its transitions deactivate and activate; of a freedrive as of the others."""
    async with connected(sim, command_timeout=10.0) as node:
        async with beside(node.run(Sink())):
            await lead(node, sim, way(0.2, 0.1))
        async with beside(node.run(Sink())):
            assert not node.commands.take(NAMES, way(0.2, 0.1))
            assert not node.twists.take([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])
            node.freedrive.take(True)
            assert not node.freedrive._wanted()
            assert (await node.services.recover()).success
            await lead(node, sim, way(0.4, 0.1))


@pytest.mark.slow
async def test_a_pause_of_a_goal_is_not_undone_by_commands_that_go_on(sim: Simulator) -> None:
    up = [0.0, 0.0, 0.05, 0.0, 0.0, 0.0]
    async with running(sim, command_timeout=10.0) as node:
        client = Client(goal(count=50, duration=6.0, far=0.8))
        node.goals.submit(client)
        await eventually_async(lambda: client.seen)
        assert not node.twists.take(up)  # the goal has the arm
        assert (await node.services.pause()).success
        node.goals.cancel(client)
        await eventually_async(lambda: client.done)
        assert not node.twists.take(up)


@pytest.mark.slow
@pytest.mark.parametrize("how", ["bring_up", "recover"])
async def test_a_stop_while_the_arm_is_brought_up_is_not_undone(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    async with running(sim, command_timeout=10.0) as node:
        ready = getattr(Robot, how)

        async def stopped_meanwhile(robot: Robot) -> object:
            assert (await node.services.stop()).success
            return await ready(robot)

        assert node.twists.take([0.0] * 6)
        monkeypatch.setattr(Robot, how, stopped_meanwhile)
        assert (await getattr(node.services, how)()).success
        assert not node.twists.take([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])


@pytest.mark.slow
async def test_a_driver_that_stood_still_takes_that_for_no_end_of_the_commands() -> None:
    """They have gone on meanwhile, and wait to be read."""
    robot: Any = None
    given: dict[str, Any] = {"busy": lambda: False, "options": None, "timeout": 0.5}
    joints = JointCommands(robot, PROFILE, rate=100.0, hold=False, reach=0.1, **given)
    twists = TwistCommands(robot, base="base", tips=(), flange="tool0", **given)
    taken: list[tuple[StreamedCommands, Callable[[], bool]]] = [
        (joints, lambda: joints.take(NAMES, START)),
        (twists, lambda: twists.take((0.0,) * 6)),
    ]
    for commands, take in taken:
        async with beside(commands.watch()):
            assert not take(), "it goes on from before the driver started"
            await eventually_async(partial(getattr, commands, "_ceased"))
            assert take()
            stand_still()
            await anyio.wait_all_tasks_blocked()
            commands.ignore()
            assert not take()
            stand_still()
            await anyio.wait_all_tasks_blocked()
            assert not take()
            await eventually_async(partial(getattr, commands, "_ceased"))
            commands.ignore()
            assert take()


def stand_still() -> None:
    """As a driver that computes, or whose computer is busy."""
    time.sleep(0.7)


@pytest.mark.slow
async def test_commands_may_move_at_once(sim: Simulator) -> None:
    async with running(sim) as node:
        farthest = 0.0
        begin = anyio.current_time()
        with anyio.fail_after(90.0):
            async for _ in ticks(50.0):
                phase = (anyio.current_time() - begin) % 6.0
                lead = START[0] + 0.3 * min(phase, 6.0 - phase)
                node.commands.take(NAMES, (lead, *START[1:]))
                farthest = max(farthest, sim.joints[0] - START[0])
                if farthest > 0.5:
                    break


@pytest.mark.slow
async def test_commands_may_hold_the_arm(sim: Simulator) -> None:
    async with running(sim, hold_commands=True) as node:
        await eventually_async(lambda: node.commands.following)
        client = Client(goal())
        node.goals.submit(client)
        await eventually_async(lambda: client.done)
        assert "succeeded" not in client.told
        await lead(node, sim, way(0.2, 0.1))
        await eventually_async(lambda: node.commands.following)


@for_each(
    "names, positions",
    [
        (NAMES[:5], START[:5]),
        (NAMES, START[:5]),
        ((*NAMES[:5], NAMES[0]), START),
        (NAMES, (math.nan, *START[1:])),
        (NAMES, (7.0, *START[1:])),
        ((), ()),
    ],
)
def test_wrong_commands(names: tuple[str, ...], positions: tuple[float, ...]) -> None:
    with pytest.raises(GoalRefused):
        check_command(names, positions, PROFILE)


def test_commands_of_two_arms_at_once() -> None:
    both = (*reversed(NAMES), "gripper")
    assert check_command(both, (*reversed(START), 0.5), PROFILE) == START


def test_parameters() -> None:
    assert settings_of({**parameter_defaults(), "host": "a"}) == NodeSettings(host="a")
    assert settings_of({"robot_ip": "b", "host": ""}).host == "b"
    assert settings_of({"robot_ip": "b", "host": "a"}).host == "a"
    found = settings_of({"robot_ip": "b", "rate": 100, "path_tolerance": 0.3})
    assert (found.host, found.rate, found.rules.path) == ("b", 100.0, 0.3)
    for wrong in ({}, {"host": "a", "rate": "fast"}, {"host": "a", "hurst": 1}):
        with pytest.raises(ParameterError):
            settings_of(wrong)
    with pytest.raises(ParameterError):
        NodeSettings(host="a", command_timeout=0.0)
    with pytest.raises(ParameterError, match=r"^path_tolerance is -1"):
        settings_of({"host": "a", "path_tolerance": -1.0})


@for_each("wrong", ["left arm", "1_", "_", "l\n", "é"])
def test_a_prefix_is_the_beginning_of_a_name_in_ros(wrong: str) -> None:
    assert NodeSettings(host="a", prefix="cell/left_").prefix == "cell/left_"
    with pytest.raises(ParameterError, match=r"^prefix is"):
        NodeSettings(host="a", prefix=wrong)


@for_each("given", [{"hold_commands": True}, {"command_rate": 50.0}, {"command_timeout": 1.0}])
def test_a_driver_without_joint_commands_has_no_parameters_for_them(given: dict[str, Any]) -> None:
    assert settings_of({"host": "a", "rate": 50}, joint_commands=False).rate == 50.0
    with pytest.raises(ParameterError, match=r"must be one of host, .*, robot_ip") as refused:
        settings_of({"host": "a", **given}, joint_commands=False)
    assert not [each for each in given if each in str(refused.value).split("must be")[1]]
