"""Grippers on digital outputs: one or two valves, with or without sensors."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._process import trial
from aioduco.devices.grippers.gripper import GripperState, PolledGripper, awaited
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.gripper_models import GripperModel, gripper_model

if TYPE_CHECKING:
    from aioduco.models.state import IOStatus
    from aioduco.robot import Robot


_TOOL = "tool"


class OutputGripper(PolledGripper):
    """A gripper with outputs for its commands and inputs for its state, from the state feed.

    A signal is a number from 1 to 16 for the cabinet, or "tool 1" or "tool 2". `signals` are a
    gripper's by the names of its arguments; None for one that it does not have.
    """

    _HALTED = "its outputs stay as they are, and it may still move"

    def __init__(
        self,
        robot: Robot,
        model: str | GripperModel,
        signals: dict[str, int | str | None],
        *,
        poll: float,
        timeout: float,
        max_age: float,
    ) -> None:
        known = gripper_model(model) if isinstance(model, str) else model
        super().__init__(known, poll=poll, timeout=timeout, max_age=max_age)
        for name, value in signals.items():
            if value is not None:
                signal(name, value)
        self._robot = awaited(robot)
        self._sent_at = 0.0

    async def _set(self, output: int | str, value: bool) -> None:
        tool, num = signal("output", output)
        if tool:
            await self._robot.io.set_tool_digital_out(num, value)
        else:
            await self._robot.io.set_standard_digital_out(num, value)

    async def _inputs(self) -> IOStatus:
        return (await self._robot.feed.latest(max_age=self._timeout)).io


class DigitalGripper(OutputGripper):
    """A gripper that is closed by an output, such as a pneumatic one.

        async with DigitalGripper(robot, close=1, holds=1, opened=2) as gripper:
            if not (await gripper.close()).holding:
                ...

    Args:
        robot: the robot.
        close: output that closes it: a number, 1 to 16, or "tool 1" or "tool 2".
        open: output that opens it; None if it opens when `close` is off.
        holds: input that is on while it holds something; None without this sensor.
        shut: input that is on while it is fully closed, holding nothing; None without this sensor.
        opened: input that is on while it is open; None without this sensor.
        travel_time: maximum seconds that it takes to open or to close.
        model: "parallel", or a `GripperModel`.
        poll: seconds between two polls of the gripper's state.
        timeout: seconds within which the input `opened` must switch on.
        max_age: seconds without a new sample of the inputs after which `carrying` stops the arm.

    Raises:
        ParameterError: an argument is out of range.
    """

    def __init__(
        self,
        robot: Robot,
        close: int | str,
        *,
        open: int | str | None = None,  # noqa: A002 - what it does
        holds: int | str | None = None,
        shut: int | str | None = None,
        opened: int | str | None = None,
        travel_time: float = 0.5,
        model: str | GripperModel = "parallel",
        poll: float = 0.02,
        timeout: float = 5.0,
        max_age: float = 1.0,
    ) -> None:
        signals = {"close": close, "open": open, "holds": holds, "shut": shut, "opened": opened}
        super().__init__(robot, model, signals, poll=poll, timeout=timeout, max_age=max_age)
        self._outputs = close, open
        self._holds, self._shut, self._opened = holds, shut, opened
        self._travel_time = ranges.TIMEOUT("travel_time", travel_time)
        self._closed: bool | None = None

    async def _read(self) -> GripperState:
        io = await self._inputs()
        at = trial.wall(io.received_at)
        on = {name: of(io, name) for name in (self._holds, self._shut, self._opened) if name}
        # Samples come at intervals: one that is older than the output's change says nothing.
        fresh = at > self._sent_at
        waited = at >= self._sent_at + self._travel_time
        holding = self._holding(on, waited=waited)
        if self._closed is None:
            moving = False
        elif self._closed:
            # Only a held object ends the motion earlier: the fingers may pass the sensor for shut.
            moving = not (waited or (fresh and self._holds is not None and on[self._holds]))
        else:
            moving = not (fresh and on[self._opened] if self._opened else waited)
        return GripperState(self._width_now(on, holding, moving=moving), holding, moving, at)

    def _holding(self, on: dict[int | str, bool], *, waited: bool) -> bool | None:
        if self._closed is False:
            return False
        if self._holds:
            return on[self._holds]
        if self._shut and self._closed:
            return waited and not on[self._shut]
        return None

    def _width_now(
        self, on: dict[int | str, bool], holding: bool | None, *, moving: bool
    ) -> float | None:
        if self._opened and on[self._opened]:
            return self.model.stroke
        if self._shut and on[self._shut]:
            return 0.0
        if self._closed is None or moving or (self._closed and holding is not False):
            return None
        return 0.0 if self._closed else self.model.stroke

    async def _go(self, width: float, speed: float, force: float) -> None:
        del speed, force
        if width not in (0.0, self.model.stroke):
            raise ParameterError(
                "width", width, f"0 or {self.model.stroke:g} m: it has no positions between"
            )
        closing = width == 0.0
        close, opening = self._outputs
        # The output that goes off comes first: a valve with two coils must not have both on.
        steps = [(close, closing)] if opening is None else sorted(
            [(close, closing), (opening, not closing)], key=lambda step: step[1]
        )  # fmt: skip
        self._closed = None  # not known if a command fails or is cancelled, and may be carried out
        for output, value in steps:
            await self._set(output, value)
        self._closed, self._sent_at = closing, time.monotonic()

    async def _halt(self) -> None:
        """Do nothing: a valve has no middle position, and a held object must stay held."""


def signal(name: str, value: int | str) -> tuple[bool, int]:
    """Return whether a signal belongs to the tool, and its number.

    Raises:
        ParameterError: it is not a signal.
    """
    if isinstance(value, str):
        kind, _, number = value.strip().rpartition(" ")
        if kind.strip() != _TOOL or not number.isdecimal():
            raise ParameterError(name, value, '1 to 16, or "tool 1" or "tool 2"')
        return True, ranges.TOOL_IO(name, int(number))
    return False, ranges.STANDARD_IO(name, value)


def of(io: IOStatus, name: int | str) -> bool:
    """Return an input of a sample."""
    tool, num = signal("input", name)
    return io.tool_input(num) if tool else io.input(num)
