"""A jog moves in the direction of its sign, whichever numbers the controller uses for it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from client.bench import HOME

import aioduco
from aioduco import Jog, JogDirections, ParameterError
from aioduco.errors import NotSent
from aioduco.testing import DropReply, FaultProxy
from api.desk import Desk

UP, DOWN = Jog.joint(1, 1, 50, step=0.05), Jog.joint(1, -1, 50, step=0.05)
WAYS: dict[str, Callable[[aioduco.Robot, Jog], Any]] = {
    "awaited": lambda robot, jog: robot.motion.move_jog(jog),
    "blocking": lambda robot, jog: robot.blocking.move_jog(jog),
}


@pytest.fixture(params=list(WAYS))
def way(request: pytest.FixtureRequest, desk: Desk) -> str:
    desk.moves("move_jog")
    desk.blocks("move_jog")
    desk.motion_time = 0.02
    name: str = request.param
    return name


@pytest.mark.parametrize(("version", "numbers"), [("V3.8.0", [1, -1]), ("V4.3.0", [0, 1])])
async def test_the_version_decides(desk: Desk, way: str, version: str, numbers: list[int]) -> None:
    desk.answer("get_robot_version", version)
    async with aioduco.connect(desk.host, desk.port) as robot:
        for jog in (UP, DOWN):
            await WAYS[way](robot, jog)
    assert [call.args[0].jog_direction for call in desk.received("move_jog")] == numbers


@pytest.mark.parametrize(("version", "refused"), [("V3.8.1", False), ("V4.3.0", True)])
async def test_a_controller_that_gets_other_software_meanwhile(
    desk: Desk, proxy: FaultProxy, way: str, version: str, refused: bool
) -> None:
    """The robot stays open, and its jogs would go the wrong way."""
    async with aioduco.connect(proxy.host, proxy.port) as robot:
        await WAYS[way](robot, UP)
        desk.answer("get_robot_version", version)
        proxy.cut()
        if refused:
            for _ in range(2):
                with pytest.raises(aioduco.RobotStateError, match=r"V3\.8\.0 .* is V4\.3\.0 now"):
                    await WAYS[way](robot, UP)
        else:
            await WAYS[way](robot, UP)
            assert robot.version.controller.text == version
    assert len(desk.received("move_jog")) == 1 + (not refused)


async def test_a_motion_says_if_the_version_cannot_be_read_again(
    desk: Desk, proxy: FaultProxy
) -> None:
    async with aioduco.connect(proxy.host, proxy.port, call_timeout=0.2) as robot:
        proxy.cut()
        proxy.on("get_robot_version", DropReply(), times=None)
        with pytest.raises(NotSent, match=r"^movej2 was not sent: get_robot_version"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        proxy.clear()
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
    assert len(desk.received("movej2")) == 1


@pytest.mark.parametrize("version", ["", "V4.0.1"])
async def test_a_version_that_does_not_tell(desk: Desk, way: str, version: str) -> None:
    desk.answer("get_robot_version", version)
    async with aioduco.connect(desk.host, desk.port) as robot:
        with pytest.raises(ParameterError, match=r"directions=JogDirections\.MANUAL_3_8"):
            await WAYS[way](robot, UP)
        assert not desk.received("move_jog")
        await robot.motion.move_jog(UP, directions=JogDirections.MANUAL_4_3)
    assert [call.args[0].jog_direction for call in desk.received("move_jog")] == [0]


async def test_external_axes_of_a_newer_controller(desk: Desk) -> None:
    """Manual 4.3 contradicts itself about them."""
    desk.answer("get_robot_version", "V4.3.0")
    async with aioduco.connect(desk.host, desk.port) as robot:
        axes = robot.external_axes
        with pytest.raises(ParameterError, match="external axes"):
            axes.move_jog_eaxis("rail", 1, 5)
        for directions in JogDirections:
            await axes.move_jog_eaxis("rail", 1, 5, time=0.01, directions=directions)
    assert [call.args[1] for call in desk.received("move_jog_eaxis")] == [1, 0]
