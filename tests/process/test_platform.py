"""The package without features of Linux. `pytest --bare-platform` runs all tests so."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import ClassVar

import pytest
from interpreter import python

from aioduco import ParameterError, WorkerFailed
from aioduco.api.streams.servo import Servo
from aioduco.cli.monitor.observer import Key, TerminalKeys
from aioduco.devices.teleoperation import KeyboardDevice, devices
from aioduco.streaming import session
from aioduco.streaming.endpoint import StreamEndpoint

BARE = Path(__file__).parents[1] / "bare"
PROGRAM = """
import os, socket, asyncio, aioduco
from aioduco._process import platform
from aioduco.sim import Simulator

assert not platform.limits_sockets() and not platform.hands_over_by_number()

async def main():
    with Simulator.spawn() as sim:
        try:
            async with aioduco.connect(sim.host, sim.port, guard="process"):
                print("open")
        except aioduco.GuardLost as error:
            print(error)
        async with aioduco.connect(sim.host, sim.port, heartbeat=20.0) as robot:
            await robot.bring_up(timeout=60.0)
            await robot.stop()
            print("stopped")

asyncio.run(main())
"""


@pytest.mark.slow
def test_a_program_runs_on_a_bare_platform_and_the_guard_says_what_it_needs() -> None:
    environment = {**os.environ, "PYTHONPATH": str(BARE), "AIODUCO_TESTS_BARE": str(BARE)}
    done = python("-c", PROGRAM, env=environment, timeout=110)
    assert done.returncode == 0, done.stderr
    said, stopped = done.stdout.splitlines()
    assert said.startswith("a guard's process needs Linux, and this system has no packets between")
    assert stopped == "stopped"


async def test_a_stream_that_is_faster_than_the_clock_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(session, "clock_step", lambda: 0.0156)
    servo = Servo(StreamEndpoint("127.0.0.1", 1))
    with pytest.raises(WorkerFailed, match=r"steps of 15\.6 ms.*Nothing was sent"):
        async with servo.joints(v=1.0, a=1.0, rate=125.0):
            pass


def test_a_device_that_is_no_file_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(devices, "has_device_files", lambda: False)
    with (
        pytest.raises(ParameterError, match="no files of devices"),
        KeyboardDevice(0),
    ):
        pass


async def test_keys_of_a_console_that_cannot_be_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    class Console:
        """As `msvcrt`: an arrow is two characters."""

        keys: ClassVar[list[str]] = [*"\xe0Hs"]

        @classmethod
        def kbhit(cls) -> bool:
            return bool(cls.keys)

        @classmethod
        def getwch(cls) -> str:
            return cls.keys.pop(0)

    monkeypatch.setitem(sys.modules, "msvcrt", Console)
    keys = TerminalKeys(0)
    assert await keys.wait() == []
    assert await keys.wait() == [Key.STOP]
