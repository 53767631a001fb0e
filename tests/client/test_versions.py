"""The controller's version is read while connecting, and named when a function is missing."""

from __future__ import annotations

import pytest

import aioduco
import aioduco.sync
from aioduco.testing import Cut, FaultProxy, Place
from client.bench import Bench


async def test_the_version_is_known_from_connecting_on(bench: Bench) -> None:
    bench.answer("get_robot_version", "V3.4.1")
    robot = aioduco.connect(bench.host, bench.port)
    assert not robot.version.controller.known
    async with robot:
        assert robot.version.controller.text == "V3.4.1"
        assert robot.version.controller.at_least(3, 4)
        assert len(bench.received("get_robot_version")) == 1


async def test_a_controller_that_does_not_tell_its_version(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port) as robot:
        assert not robot.version.controller.known
        assert not robot.version.controller.at_least(0)


def test_the_same_in_a_plain_script(bench: Bench) -> None:
    bench.answer("get_robot_version", "V2.6.1")
    with aioduco.sync.connect(bench.host, bench.port) as robot:
        assert robot.version.controller.numbers == (2, 6, 1)


async def test_a_controller_that_goes_silent_over_it_is_none(
    bench: Bench, proxy: FaultProxy
) -> None:
    proxy.on("get_robot_version", Cut(Place.IN_REPLY))
    with pytest.raises(aioduco.ConnectError):
        await aioduco.connect(proxy.host, proxy.port).open()
