"""Suction cups: an output for the vacuum, an input for its sensor, an output for the blow-off."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import anyio

from aioduco._process import trial
from aioduco.devices.grippers.digital import OutputGripper, of
from aioduco.devices.grippers.gripper import GripperState
from aioduco.errors import ParameterError
from aioduco.models import ranges

if TYPE_CHECKING:
    from aioduco.models.gripper_models import GripperModel
    from aioduco.robot import Robot


class VacuumGripper(OutputGripper):
    """A suction cup. `close` switches the suction on, `open` releases the part; it has no width.

        async with VacuumGripper(robot, suction=1, vacuum=1, blow_off=2) as cup:
            if not (await cup.close()).holding:
                ...

    Args:
        robot: the robot.
        suction: output for the vacuum: a number, 1 to 16, or "tool 1" or "tool 2".
        vacuum: input that is on while there is a vacuum; None without this sensor.
        blow_off: output that blows air into the cup; None without a blow-off.
        build_up: seconds within which the vacuum must have built up.
        blow_time: seconds for which air is blown; without a blow-off, seconds until the part has
            fallen off.
        model: "vacuum", or a `GripperModel`.
        poll: seconds between two polls of the gripper's state.
        timeout: seconds within which the sensor must report that the part is gone.
        max_age: seconds without a new sample of the inputs after which `carrying` stops the arm.

    Raises:
        ParameterError: an argument is out of range.
    """

    def __init__(
        self,
        robot: Robot,
        suction: int | str,
        *,
        vacuum: int | str | None = None,
        blow_off: int | str | None = None,
        build_up: float = 1.0,
        blow_time: float = 0.2,
        model: str | GripperModel = "vacuum",
        poll: float = 0.02,
        timeout: float = 5.0,
        max_age: float = 1.0,
    ) -> None:
        signals = {"suction": suction, "vacuum": vacuum, "blow_off": blow_off}
        super().__init__(robot, model, signals, poll=poll, timeout=timeout, max_age=max_age)
        self._suction, self._sensor, self._blow_off = suction, vacuum, blow_off
        self._build_up = ranges.TIMEOUT("build_up", build_up)
        self._blow_time = ranges.TIMEOUT("blow_time", blow_time)
        self._sucking: bool | None = None

    async def close(
        self, *, speed: float | None = None, force: float | None = None
    ) -> GripperState:
        """Switch the suction on, and return when there is a vacuum, or none within `build_up`."""
        return await self._switch(sucking=True, speed=speed, force=force)

    async def open(self, *, speed: float | None = None, force: float | None = None) -> GripperState:
        """Release the part, and blow it off if there is a blow-off."""
        return await self._switch(sucking=False, speed=speed, force=force)

    async def move(
        self, width: float, *, speed: float | None = None, force: float | None = None
    ) -> GripperState:
        """Refuse: a suction cup has no fingers to move.

        Raises:
            ParameterError: always; nothing was sent.
        """
        del speed, force
        raise ParameterError("width", width, "none: a cup has no width, only open() and close()")

    async def _switch(
        self, *, sucking: bool, speed: float | None, force: float | None
    ) -> GripperState:
        for name, value in (("speed", speed), ("force", force)):
            if value is not None:
                self._cannot(name, value)
        async with self._turn():
            return await self._carry_out(float(not sucking), 0.0, 0.0)

    async def _go(self, width: float, speed: float, force: float) -> None:
        del speed, force
        sucking = width == 0.0
        self._sucking = None  # not known if a command fails or is cancelled, and may be carried out
        if sucking and self._blow_off is not None:
            await self._set(self._blow_off, value=False)
        await self._set(self._suction, sucking)
        self._sucking, self._sent_at = sucking, time.monotonic()
        if not sucking and self._blow_off is not None:
            try:
                await self._set(self._blow_off, value=True)
                await anyio.sleep_until(anyio.current_time() + self._blow_time)
            finally:
                with anyio.CancelScope(shield=True):
                    await self._set(self._blow_off, value=False)

    async def _read(self) -> GripperState:
        io = await self._inputs()
        at = trial.wall(io.received_at)
        vacuum = None if self._sensor is None else of(io, self._sensor)
        fresh = at > self._sent_at
        if self._sucking is None:
            return GripperState(None, vacuum, False, at)
        if self._sucking:
            over = at >= self._sent_at + self._build_up
            return GripperState(None, vacuum, not (over or (fresh and vacuum is True)), at)
        if vacuum is None:
            return GripperState(None, False, at < self._sent_at + self._blow_time, at)
        return GripperState(None, False, not fresh or vacuum, at)

    async def _halt(self) -> None:
        """Leave the suction as it is, so that a held object stays held."""
