"""Servers of Apache's library in C++, as a controller may have one, called by the package."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from aioduco._wire.lane import WireLane
from aioduco.errors import ControllerError

#: the first test waits for a compiler
pytestmark = [pytest.mark.interop, pytest.mark.timeout(900)]


@pytest.fixture(params=["simple", "threaded", "pool"])
def start(request: pytest.FixtureRequest, driver: Path) -> Iterator[int]:
    """The port of a server in a process of its own."""
    with subprocess.Popen(
        [driver, "serve", request.param], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        try:
            yield int(process.stdout.readline())
        finally:
            process.kill()


async def test_several_questions_in_one_piece_are_answered_in_their_order(start: int) -> None:
    """Each answer says how many calls came before it."""
    names = ("get_robot_state", "getRobotStatus", "get_ext_torque", "get_tcp_force")
    lane = WireLane("test", "127.0.0.1", start)
    await lane.open()
    try:
        for calls in range(0, 2000, 5):
            states, status, refused, force = await lane.ask(*((name, ()) for name in names))
            assert states.get()[3] == calls % 100
            assert status.get().jointActualPosition == [(calls + 1) % 100] * 6
            with pytest.raises(ControllerError, match="not here"):
                refused.get()
            assert force.get() == [(calls + 3) % 100] * 6
            assert await lane.rpc.get_tcp_force() == [(calls + 4) % 100] * 6
        assert lane.statistics().opened == 1
    finally:
        await lane.aclose()
