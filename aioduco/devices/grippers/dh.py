"""Grippers of DH: AG-95, PGE, over Modbus RTU."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, ClassVar

from aioduco.devices.grippers import dh_registers as registers
from aioduco.devices.grippers.gripper import GripperState
from aioduco.devices.grippers.modbus_gripper import ModbusGripper
from aioduco.errors import GripperError, GripperNotActivated, ModbusGarbled

if TYPE_CHECKING:
    from aioduco.devices.grippers.dh_registers import DhState


#: seconds after which a state belongs to this motion, even if the gripper was not seen moving
_SETTLED = 0.3
#: ranges of the registers for force and speed, in hundredths of the largest value
_FORCES, _SPEEDS = (20, 100), (1, 100)


class DhGripper(ModbusGripper):
    """A gripper of DH's series AG or PGE.

        async with DhGripper.at_tool(robot, "dh_ag95") as gripper:
            await gripper.activate()
            await gripper.close(force=60.0)

    The tool's port must have the gripper's bit rate; the factory setting is 115200. The gripper
    takes forces in hundredths, 20 to 100: the driver maps the least and the largest force of the
    model to these two.

    Args:
        modbus: the device; its number is 1 by the factory setting.
        model: "dh_ag95", "dh_pge", or a `GripperModel`; None for the first.
        poll: seconds between two polls of the gripper's state.
        timeout: seconds within which a movement must have ended.
        max_age: seconds without a new state after which `carrying` stops the arm.

    Raises:
        ParameterError: an argument is out of range.
    """

    usual_model: ClassVar[str] = "dh_ag95"
    make: ClassVar[str] = "dh_"
    usual_unit: ClassVar[int] = 1

    _seen_moving = True
    _sent_at = 0.0
    #: the position that was sent last
    _target = 0

    async def status(self) -> DhState:
        """Read the gripper's raw state.

        Raises:
            ModbusGarbled: the state has a value that the gripper's manual does not list.
        """
        read = await self._modbus.read_registers(registers.STATE, registers.STATE_COUNT)
        try:
            return registers.state(read)
        except ValueError as error:
            raise ModbusGarbled(f"the state of {self} is none: {error}") from error

    async def activate(self) -> None:
        """Find the ends of the stroke, unless they are known already.

        The fingers move through the whole stroke: a held object falls.

        Raises:
            GripperTimeout: the gripper did not become ready.
        """
        async with self._turn():
            if await self._initialized():
                return
            self._held = self._lost = False
            await self._modbus.write_register(registers.INITIALIZE, 1)
            await self._until_ready(self._initialized)
        await self._read_state()

    async def _initialized(self) -> bool:
        return (await self.status()).initialization is registers.Initialization.DONE

    async def _read(self) -> GripperState:
        at = time.monotonic()
        found = await self.status()
        if found.initialization is not registers.Initialization.DONE:
            if self._going:
                raise GripperNotActivated(f"{self} is not initialized any more: activate it")
            under_way = found.initialization is registers.Initialization.UNDER_WAY
            return GripperState(None, None, under_way, at)
        moving = found.grip is registers.DhGrip.MOVING
        # At first the gripper may still report the previous motion.
        self._seen_moving |= moving or at > self._sent_at + _SETTLED
        stale = not self._seen_moving
        caught = found.grip is registers.DhGrip.CAUGHT
        width = found.position / registers.OPEN * self.model.stroke
        return GripperState(width, caught and not stale, moving or stale, at)

    async def _go(self, width: float, speed: float, force: float) -> None:
        if not await self._initialized():
            raise GripperNotActivated(
                f"{self} is not initialized: call activate(), which moves the fingers. Nothing "
                "was moved"
            )
        write = self._modbus.write_register
        await write(registers.FORCE, _hundredths(force, self.model.force, _FORCES))
        if self.model.speed is not None:
            await write(registers.SPEED, _hundredths(speed, self.model.speed, _SPEEDS))
        await self._send(round(width / self.model.stroke * registers.OPEN))

    async def _send(self, position: int) -> None:
        self._seen_moving, self._sent_at, self._target = False, time.monotonic(), position
        try:
            await self._modbus.write_register(registers.POSITION, position)
        finally:  # on a slow bus the gripper has it only now
            self._sent_at = time.monotonic()

    async def _halt(self) -> None:
        found = await self.status()
        if found.initialization is registers.Initialization.NONE:
            return  # its position is not known
        if found.initialization is registers.Initialization.UNDER_WAY:
            raise GripperError(f"{self} is being activated, which cannot be halted: it moves on")
        # There is no register that stops the gripper: its present position becomes the target.
        # A gripper that has not begun to open still tells of the object that it holds.
        opens = not self._seen_moving and self._target > found.position
        if opens or found.grip is not registers.DhGrip.CAUGHT:
            await self._send(found.position)


def _hundredths(value: float, limits: tuple[float, float], register: tuple[int, int]) -> int:
    low, high = limits
    part = (value - low) / (high - low) if high > low else 1.0  # else it cannot be set
    return round(register[0] + part * (register[1] - register[0]))
