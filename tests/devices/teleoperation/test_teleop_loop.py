"""An arm that is moved by keys, on the simulated controller, and recorded."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco.devices.teleoperation import KeyboardDevice, Reading, TeleopScale, teleoperate
from aioduco.devices.teleoperation.keyboard import Keyboard
from aioduco.errors import ParameterError
from aioduco.models.ranges import FINE_SPEED, JOINT_SPEED
from aioduco.recording import read
from aioduco.sim import Simulator
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.shared.words import Reason
from aioduco.testing import eventually_async


@pytest.fixture
def pipe() -> Iterator[tuple[int, int]]:
    reader, writer = os.pipe()
    yield reader, writer
    for end in (reader, writer):
        os.close(end)


#: on a busy machine answers take long, and neither time is what is tested here
WAITING: Any = {"hold": 30.0, "options": WorkerOptions(timeout=30.0)}


@asynccontextmanager
async def ready() -> AsyncIterator[tuple[Simulator, aioduco.Robot]]:
    """A simulated arm, and a robot that a busy machine does not disturb."""
    with Simulator() as sim:
        async with aioduco.connect(
            sim.host,
            sim.port,
            heartbeat=30.0,
            loop_stall_limit=30.0,
            call_timeout=30.0,
            lag_limit=None,
            clock=sim.clock,
        ) as robot:
            await robot.bring_up()
            yield sim, robot


class Standing:
    """Whether the arm has not moved for a while of its own time; a speed of zero is sent on."""

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._since, self._joints = sim.time, np.array(sim.joints)

    def __call__(self) -> bool:
        time, joints = self._sim.time, np.array(self._sim.joints)
        if np.abs(joints - self._joints).max() > 1e-4:
            self._since, self._joints = time, joints
        return time - self._since > 0.6


def place(sim: Simulator) -> np.ndarray:
    return np.array(sim.arm.fkine(sim.joints)[:3, 3])


@pytest.mark.slow
@pytest.mark.linux("devices that are files")
async def test_a_held_key_leads_the_tool_and_a_silent_device_leaves_it_standing(
    pipe: tuple[int, int], tmp_path: Path
) -> None:
    reader, writer = pipe
    async with ready() as (sim, robot):
        before, start = place(sim), np.array(sim.joints)
        device = KeyboardDevice(reader, Keyboard(first=0.5, repeating=0.5))
        async with robot.record(tmp_path / "run.mcap"), anyio.create_task_group() as tasks:
            with device:

                async def lead() -> None:
                    report = await teleoperate(robot, device, TeleopScale(speed=0.1), **WAITING)
                    assert report.held >= 1
                    assert report.seconds > 0.05

                tasks.start_soon(lead)

                def risen() -> bool:
                    # As a terminal repeats a key that is held.
                    os.write(writer, b"r")
                    return bool(place(sim)[2] - before[2] > 0.01)

                await eventually_async(risen, 60.0)
                # Then nothing more comes: it comes to rest by itself.
                await eventually_async(Standing(sim), 60.0)
                os.write(writer, b"q")
        way = place(sim) - before
        np.testing.assert_allclose(way / np.linalg.norm(way), [0, 0, 1], atol=0.1)
        led = np.array(sim.joints)
        seen = read(tmp_path / "run.mcap").arrays("/joint_states")["position"]
        np.testing.assert_allclose(seen[0], start, atol=2e-3)
        np.testing.assert_allclose(seen[-1], led, atol=2e-3)


@pytest.mark.linux("devices that are files")
async def test_joints_are_turned_and_a_wrong_scale_is_refused(pipe: tuple[int, int]) -> None:
    reader, writer = pipe
    async with ready() as (sim, robot):
        before = np.array(sim.joints)
        seen: list[Reading] = []

        def look(reading: Reading) -> None:
            if not seen:
                os.write(writer, b"u")  # the sixth axis
            seen.append(reading)
            if abs(np.array(sim.joints)[5] - before[5]) > 0.01:
                os.write(writer, b"q")

        with KeyboardDevice(reader, Keyboard(first=30.0)) as device:
            await teleoperate(robot, device, joints=True, on_reading=look, **WAITING)
        assert seen[-1].done
        moved = np.array(sim.joints) - before
        assert moved[5] > 0.01
        assert np.abs(moved[:5]).max() < 2e-3
        with pytest.raises(ParameterError, match="TeleopScale"):
            await teleoperate(robot, device, 0.5)  # type: ignore[arg-type]  # what is refused


class Held:
    """A device whose dead-man switch is held until its person ends it."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self.first: float | None = None
        self.last = 0.0

    def read(self, now: float) -> Reading:
        self.first = now if self.first is None else self.first
        self.last = now
        return Reading(held=True, done=now - self.first >= self._seconds)


@pytest.mark.slow
async def test_a_hold_that_lasts_until_the_end_counts() -> None:
    async with ready() as (_, robot):
        device = Held(0.1)
        report = await teleoperate(robot, device, **WAITING)
    assert report.held == 1
    assert device.first is not None
    assert report.seconds == device.last - device.first


@pytest.mark.slow
async def test_the_fastest_speeds_are_ones_that_a_stream_takes() -> None:
    fastest = TeleopScale(speed=FINE_SPEED.high, turn_speed=JOINT_SPEED.high)
    async with ready() as (_, robot):
        report = await teleoperate(robot, Held(0.0), fastest, **WAITING)
    assert report.stream.reason is Reason.CLOSED


class Wrong:
    """A device of somebody's own that gives no reading."""

    def __init__(self, given: Any) -> None:
        self._given = given

    def read(self, now: float) -> Reading:
        found: Reading = self._given
        return found


@pytest.mark.slow
async def test_what_is_no_reading_ends_the_stream() -> None:
    async with ready() as (_, robot):
        for given in (None, (1.0, 0.0, 0.0), Reading((1.0,) * 5, held=True), Reading(None)):  # type: ignore[arg-type]  # what is refused
            with pytest.raises(ParameterError, match="a Reading with six axes"):
                await teleoperate(robot, Wrong(given), **WAITING)
        assert not await robot.state.robotmoving()


class Once(Wrong):
    """One reading, and then the end."""

    def read(self, now: float) -> Reading:
        found, self._given = super().read(now), Reading(done=True)
        return found


@for_each("held", ["released", "0", float("nan"), None, 1])
async def test_a_dead_mans_switch_is_held_or_not_and_nothing_else_moves_the_arm(held: Any) -> None:
    async with ready() as (_, robot):
        with pytest.raises(ParameterError, match="the reading's held"):
            await teleoperate(robot, Once(Reading((0.0, 1.0, 0, 0, 0, 0), held=held)), **WAITING)


async def test_the_flags_of_numpy_are_flags() -> None:
    async with ready() as (_, robot):
        given = Reading(held=np.True_, done=np.True_)  # type: ignore[arg-type]  # as a model gives them
        assert (await teleoperate(robot, Wrong(given), **WAITING)).held == 1
