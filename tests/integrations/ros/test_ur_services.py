"""Services of the Universal Robots driver, on a simulated arm, without ROS."""

from __future__ import annotations

import contextlib
import math
from collections.abc import AsyncIterator, Generator, Iterator
from types import SimpleNamespace
from typing import Any

import anyio
import numpy as np
import pytest
from for_each import for_each

from aioduco import RobotState
from aioduco.errors import ConnectionLost
from aioduco.integrations.ros.arm_node import ArmNode
from aioduco.integrations.ros.arm_services import ArmServices, ServiceReply
from aioduco.integrations.ros.service_table import service_table
from aioduco.sim import Simulator
from aioduco.testing import eventually_async

from .goals import START, Client, goal, way
from .nodes import beside, running, ticks

PROGRAMS = {"wave": [["movej2", list(way(1.0, 0.2)), 1.0, 5.0], ["movej2", list(START), 1.0, 5.0]]}
TABLE = {entry.name: entry for entry in service_table()}


@pytest.fixture(scope="module")
def sim() -> Iterator[Simulator]:
    with Simulator(programs=PROGRAMS) as sim:
        yield sim


@pytest.fixture
async def node(sim: Simulator) -> AsyncIterator[ArmNode]:
    async with running(sim) as node:
        yield node


async def call(node: ArmNode, name: str, **asked: Any) -> ServiceReply:
    """What a service answers."""
    return await TABLE[name].call(node.services, SimpleNamespace(**asked))


async def done(node: ArmNode, name: str, **asked: Any) -> str:
    reply = await call(node, name, **asked)
    assert reply.success, (name, reply.message)
    return reply.message


def test_each_service_has_a_name_of_its_own() -> None:
    assert len(TABLE) == len(list(service_table()))


class Lost:
    """A robot whose connection is lost, whatever is asked for."""

    def __getattr__(self, name: str) -> Lost:
        return self

    def __call__(self, *_: object, **__: object) -> Lost:
        return self

    def __await__(self) -> Generator[Any, None, None]:
        yield from ()
        raise ConnectionLost("the connection is lost")


SIX, THREE = [0.0] * 6, [0.0] * 3
ASKED = SimpleNamespace(
    **dict.fromkeys(("text", "name"), "wave"), **dict.fromkeys(("tool", "wobj"), ""),
    **dict.fromkeys(("offset", "wrench", "damping", "speed_limits", "joints", "pose"), SIX),
    **dict.fromkeys(("v", "a", "mass", "speed_slider_fraction"), 1.0), centre=THREE, percent=50.0,
    selection=[True] * 6, number=1, value=True, current=False, fun=1, pin=0, state=1.0, frame=0,
)  # fmt: skip


@for_each("name", TABLE)
async def test_no_service_raises_without_a_connection(name: str) -> None:
    robot: Any = Lost()
    goals: Any = SimpleNamespace(
        busy=False, following=False, resume=lambda: False, stopped=lambda: None
    )
    services = ArmServices(
        robot,
        goals,
        recovered=lambda: None,
        halted=lambda: None,
        twisting=lambda: False,
        streaming=lambda: False,
    )
    reply = await TABLE[name].call(services, ASKED)
    without = {"dashboard_client/load_program"}
    assert reply.success == (name in without), reply.message
    assert reply.message


@pytest.mark.slow
async def test_power_and_brakes(node: ArmNode) -> None:
    assert await done(node, "dashboard_client/get_robot_mode") == "ENABLE"
    assert await done(node, "dashboard_client/get_safety_mode") == "RUN"
    assert await done(node, "dashboard_client/program_state") == "STOPPED"
    for name, state in (
        ("~disable", "DISABLE"),
        ("dashboard_client/power_off", "POWER_OFF"),
        ("dashboard_client/power_on", "DISABLE"),
        ("dashboard_client/brake_release", "ENABLE"),
    ):
        await done(node, name)
        assert await done(node, "dashboard_client/get_robot_mode") == state


async def test_outputs_and_speed(node: ArmNode, sim: Simulator) -> None:
    await done(node, "io_and_status_controller/set_io", fun=1, pin=2, state=1.0)
    assert sim.get_digital_output(3)
    await done(node, "io_and_status_controller/set_io", fun=1, pin=17, state=1.0)
    assert await node.robot.io.get_tool_digital_out(2)
    await done(node, "io_and_status_controller/set_io", fun=3, pin=0, state=2.5)
    await done(node, "~set_analog_output", number=2, value=8.0, current=True)
    io = await node.robot.state.getRobotIOStatus()
    assert io.analog_voltage_outputs[0] == pytest.approx(2.5)
    assert io.analog_current_outputs[1] == pytest.approx(8.0)
    for wrong in ({"fun": 2, "pin": 0, "state": 1.0}, {"fun": 1, "pin": 0, "state": 0.5}):
        assert not (await call(node, "io_and_status_controller/set_io", **wrong)).success
    slider = "io_and_status_controller/set_speed_slider"
    await done(node, slider, speed_slider_fraction=0.5)
    assert await node.robot.settings.get_global_speed() == 50
    assert node.goals.factor == 0.5
    assert not (await call(node, slider, speed_slider_fraction=1.5)).success
    await done(node, slider, speed_slider_fraction=1.0)


@pytest.mark.slow
async def test_programs_popup_and_log(node: ArmNode, sim: Simulator) -> None:
    assert not (await call(node, "dashboard_client/play")).success
    await done(node, "dashboard_client/load_program", text="wave")
    assert await done(node, "dashboard_client/get_loaded_program") == "wave"
    await done(node, "dashboard_client/play")
    await eventually_async(lambda: sim.moving)
    await done(node, "dashboard_client/pause")
    assert not sim.moving
    await done(node, "dashboard_client/play")
    await eventually_async(lambda: sim.moving)
    await done(node, "dashboard_client/stop")
    assert not sim.moving
    await done(node, "dashboard_client/add_to_log", text="a note")
    await done(node, "dashboard_client/popup", text="change the part")
    assert "change the part" in str(await node.robot.state.get_last_error())


async def test_force_mode_and_zeroing(node: ArmNode, sim: Simulator) -> None:
    await done(node, "io_and_status_controller/zero_ftsensor")
    np.testing.assert_allclose(await node.robot.force.fc_get_ft(), 0.0, atol=0.5)
    assert not (await call(node, "force_mode_controller/stop_force_mode")).success
    out = np.linalg.inv(np.array(sim.arm.fkine(sim.joints)))
    await done(
        node,
        "force_mode_controller/start_force_mode",
        selection=[False, False, True, False, False, False],
        wrench=[0.0, 0.0, 50.0, 0.0, 0.0, 0.0],
        damping=[0.0] * 6,
        speed_limits=[0.0] * 6,
        frame=0,
    )
    assert await node.robot.force.fc_mode_is_active()
    # the arm pushes along the tool's z axis, as UR's does by this wrench
    await eventually_async(lambda: (out @ np.array(sim.arm.fkine(sim.joints)))[2, 3] > 0.01)
    await done(node, "force_mode_controller/stop_force_mode")
    assert not await node.robot.force.fc_mode_is_active()
    # as by a driver that died, and was started again by its launch file
    await node.robot.force.fc_start()
    await done(node, "force_mode_controller/stop_force_mode")
    assert not await node.robot.force.fc_mode_is_active()


@pytest.mark.slow
async def test_freedrive_lasts_as_long_as_it_is_asked_for(node: ArmNode) -> None:
    node.freedrive.take(True)
    await eventually_async(lambda: node.freedrive.following)
    await eventually_async(lambda: not node.freedrive.following)  # nobody asks for it any more
    assert (await node.robot.state.get_robot_state()).robot is RobotState.ENABLE
    assert (await node.services.movej(START, 3.0, 20.0)).success


@pytest.mark.slow
@pytest.mark.parametrize("again", ["recover", "asked anew"])
async def test_after_a_stop_freedrive_is_to_be_asked_for_anew(node: ArmNode, again: str) -> None:
    async def ask() -> None:
        async for _ in ticks(50.0):
            node.freedrive.take(True)

    async with beside(ask()):
        await eventually_async(lambda: node.freedrive.following)
        assert (await node.services.stop()).success
        await eventually_async(lambda: not node.freedrive.following)
        assert (await node.services.movej(START, 3.0, 20.0)).success  # it does not begin again
        assert not node.freedrive.following
        if again == "recover":
            assert (await node.services.recover()).success
        else:
            node.freedrive.take(False)
        await eventually_async(lambda: node.freedrive.following)
    await eventually_async(lambda: not node.freedrive.following)


@pytest.mark.slow
async def test_twists_move_the_tool_while_they_arrive(node: ArmNode, sim: Simulator) -> None:
    assert not node.twists.take([0.0, 0.0, float("nan"), 0.0, 0.0, 0.0])
    assert not node.twists.take([0.0] * 6, "camera")
    before = await node.robot.state.get_tcp_pose()

    @contextlib.asynccontextmanager
    async def sent(up: float, frame: str) -> AsyncIterator[None]:
        async def lead() -> None:
            async for _ in ticks(50.0):
                node.twists.take([0.0, 0.0, up, 0.0, 0.0, 0.0], frame)

        async with beside(lead()):
            yield

    async with sent(0.05, "base_link"):
        await eventually_async(lambda: np.abs(np.array(sim.joints) - START).max() > 0.03)
        none = (0.0,) * 6
        reply = await node.services.start_force_mode((True,) * 6, none, none, none, 0)
        assert (reply.success, reply.message.endswith("nothing was sent")) == (False, True)
        assert not await node.robot.force.fc_mode_is_active()
    # one that is too fast brings the arm to rest, and the next one is followed
    seen: list[Any] = [sim.time, np.array(sim.joints)]

    def stands() -> bool:
        if np.abs(np.array(sim.joints) - seen[1]).max() > 1e-4:
            seen[:] = sim.time, np.array(sim.joints)
        return bool(sim.time - seen[0] > 0.3)

    async with sent(-50.0, "base_link"):
        await eventually_async(stands)
    async with sent(0.05, "base_link"):
        await eventually_async(lambda: not stands())
    # what is refused does not let the arm go on with the twist before it
    async with sent(0.05, "camera"), sent(float("nan"), "base_link"):
        await eventually_async(lambda: not node.twists.following and not sim.moving)
    after = await node.robot.state.get_tcp_pose()
    assert after.z - before.z > 0.005
    assert abs(after.x - before.x) + abs(after.y - before.y) < 0.005


@pytest.mark.slow
async def test_a_twist_is_followed_along_no_axes_but_its_own(sim: Simulator) -> None:
    """Also one that comes while the stream of another frame opens."""
    up = [0.0, 0.0, 0.05, 0.0, 0.0, 0.0]  # along z; the tool's points down
    async with running(sim, command_timeout=10.0) as node:
        before = await node.robot.state.get_tcp_pose()
        assert node.twists.take(up)
        await anyio.wait_all_tasks_blocked()  # its stream opens
        node.twists.take(up, "tool0")
        await eventually_async(lambda: node.twists.following)
        await eventually_async(lambda: not node.twists.following)
        after = await node.robot.state.get_tcp_pose()
        assert after.almost_equal(before, position=1e-3, rotation=1e-2)


@pytest.mark.slow
async def test_the_axes_of_tool0_are_those_of_the_flange_however_the_tool_is_turned() -> None:
    with Simulator() as sim:
        async with running(sim) as node:
            offset = (0.0, 0.0, 0.1, math.pi / 2, 0.0, 0.0)
            assert (await node.services.set_tool("turned", offset, 1.0, (0.0, 0.0, 0.05))).success
            before = np.array(sim.arm.fkine(sim.joints))

            def moved() -> Any:
                node.twists.take([0.0, 0.0, 0.05, 0.0, 0.0, 0.0], "tool0")
                return np.array(sim.arm.fkine(sim.joints))[:3, 3] - before[:3, 3]

            await eventually_async(lambda: np.linalg.norm(moved()) > 0.01)
            way = moved()
            np.testing.assert_allclose(way / np.linalg.norm(way), before[:3, 2], atol=0.1)
            # another tool would turn the axes under way
            assert not (await node.services.set_tool("", (0.0,) * 6, 0.0, (0.0,) * 3)).success


@pytest.mark.slow
@pytest.mark.parametrize("how", ["pause", "speed"])
async def test_a_goal_survives_a_pause_and_another_speed(
    node: ArmNode, sim: Simulator, how: str
) -> None:
    client = Client(goal(count=50, duration=2.0, goal_time_tolerance=60.0))
    node.goals.submit(client)
    await eventually_async(lambda: client.seen and client.seen[-1].time > 0.5)
    if how == "pause":
        assert (await node.services.pause()).success
        assert not sim.moving
        assert not client.done
        assert (await node.services.resume()).success
    else:
        assert (await node.services.set_speed(50)).success
    await eventually_async(lambda: client.done)
    assert client.told == ["accepted", "succeeded"], client.text
    np.testing.assert_allclose(sim.joints, way(1.0), atol=0.011)
    assert (await node.services.set_speed(100)).success


@pytest.mark.slow
async def test_a_pause_holds_the_goal_that_comes_in_place_of_the_running_one(
    node: ArmNode, sim: Simulator
) -> None:
    """It was answered by a failure, and the arm went on with the newer goal."""
    older = Client(goal(count=50, duration=60.0))
    node.goals.submit(older)
    await eventually_async(lambda: older.seen and older.seen[-1].time > 0.3)
    back = goal().points[0]._replace(time=2.0, positions=START)
    newer = Client(goal(points=[back], goal_time_tolerance=60.0))
    node.goals.submit(newer)
    assert (await node.services.pause()).success
    place, paused = sim.joints, sim.time
    await eventually_async(lambda: sim.time > paused + 1.0)
    assert sim.joints.almost_equal(place, 1e-3)
    assert older.told == ["accepted", "cancelled"]
    assert (await node.services.resume()).success
    await eventually_async(lambda: newer.done)
    assert newer.told == ["accepted", "succeeded"], newer.text


@pytest.mark.slow
@pytest.mark.parametrize("how", ["stop", "recover", "emergency stop"])
async def test_a_paused_goal_ends_by_a_stop(node: ArmNode, sim: Simulator, how: str) -> None:
    """After an emergency stop and `recover`, a resume let the arm go on with it."""
    client = Client(goal(count=50, duration=60.0))  # a busy machine pauses it late
    node.goals.submit(client)
    await eventually_async(lambda: client.seen and client.seen[-1].time > 0.3)
    assert (await node.services.pause()).success
    if how == "emergency stop":
        sim.emergency_stop()
    else:
        assert (await getattr(node.services, how)()).success
    await eventually_async(lambda: client.done)
    sim.release_emergency_stop()
    assert client.told == ["accepted", "aborted"]
    assert ("cannot move" if how == "emergency stop" else "paused") in client.text
    assert not (await node.services.resume()).success
