"""Grippers of Robotiq: 2F-85, 2F-140, Hand-E, over Modbus RTU."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, ClassVar

from aioduco.devices.grippers import robotiq_registers as registers
from aioduco.devices.grippers.gripper import GripperState
from aioduco.devices.grippers.modbus_gripper import ModbusGripper
from aioduco.errors import GripperFault, GripperNotActivated, ParameterError
from aioduco.models.rules import Integer, Integers

if TYPE_CHECKING:
    from aioduco.devices.bus import ModbusRtu
    from aioduco.devices.grippers.robotiq_registers import RobotiqStatus
    from aioduco.models.gripper_models import GripperModel


#: positions of the register with the fingers open and closed
_COUNTS = Integers(Integer(0, 0xFF, source="gPO"), length=2, source="gPO")
#: faults that an activation clears
_INACTIVE = (0x05, 0x07)
#: fault after a second without a request of the master; the next request clears it
_SILENCE = 0x09


class Robotiq(ModbusGripper):
    """A Robotiq 2F-85, 2F-140 or Hand-E.

        async with Robotiq.at_tool(robot) as gripper:
            await gripper.activate()
            await gripper.close(force=50.0)

    The tool's port must have the gripper's bit rate; the factory setting is 115200.

    Args:
        modbus: the device; its number is 9 by the factory setting.
        model: "robotiq_2f85", "robotiq_2f140", "robotiq_hand_e", or a `GripperModel`; None for
            the first.
        counts: positions that the gripper reports when it is open and when it is closed. For a 2F
            with the manufacturer's finger tips they are 3 and 230, by a support article of the
            manufacturer.
        poll: seconds between two polls of the gripper's state.
        timeout: seconds within which a movement must have ended.
        max_age: seconds without a new state after which `carrying` stops the arm.

    Raises:
        ParameterError: an argument is out of range.
    """

    usual_model: ClassVar[str] = "robotiq_2f85"
    make: ClassVar[str] = "robotiq_"
    usual_unit: ClassVar[int] = 9

    def __init__(
        self,
        modbus: ModbusRtu,
        model: str | GripperModel | None = None,
        *,
        counts: tuple[int, int] = (3, 230),
        poll: float = 0.05,
        timeout: float = 10.0,
        max_age: float = 1.0,
    ) -> None:
        super().__init__(modbus, model, poll=poll, timeout=timeout, max_age=max_age)
        opened, closed = _COUNTS("counts", counts)
        if opened >= closed:
            raise ParameterError("counts", counts, "open below closed, each 0 to 255")
        self._counts = opened, closed
        self._sent = registers.reset()

    async def status(self) -> RobotiqStatus:
        """Read the gripper's raw status."""
        read = await self._modbus.read_registers(registers.STATUS, registers.STATUS_COUNT)
        return registers.status(read)

    async def activate(self) -> None:
        """Clear faults and find the ends of the stroke, unless that is done already.

        The fingers move through the whole stroke: a held object falls.

        Raises:
            GripperFault: the gripper has a fault that this does not clear.
            GripperTimeout: the gripper did not become ready.
            ModbusError: the gripper did not answer as it should; its fingers may move.
        """
        async with self._turn():
            found = await self.status()
            if found.activation is registers.Activation.ACTIVE and not found.fault:
                return
            self._held = self._lost = False
            await self._send(registers.reset())
            await self._send(registers.activation())
            await self._until_ready(self._active)
        await self._read_state()

    async def _active(self) -> bool:
        found = await self.status()
        self._raise_fault(found)
        return found.activation is registers.Activation.ACTIVE

    async def _send(self, words: list[int]) -> None:
        await self._modbus.write_registers(registers.COMMAND, words)
        self._sent = words

    def _raise_fault(self, found: RobotiqStatus) -> None:
        if found.fault and found.fault not in (*_INACTIVE, _SILENCE):
            meaning = registers.FAULTS.get(found.fault, "not listed in its manual")
            raise GripperFault(repr(self), found.fault, meaning)

    async def _read(self) -> GripperState:
        at = time.monotonic()
        found = await self.status()
        self._raise_fault(found)
        if found.activation is not registers.Activation.ACTIVE:
            if self._going:
                raise GripperNotActivated(f"{self} is not activated any more: activate it")
            return GripperState(None, None, found.activation is registers.Activation.ACTIVATING, at)
        # Until it follows, and the echo equals this request, the state may be of the one before.
        asked = bool(self._sent[0] >> 8 & 8)
        stale = asked and not (found.going and found.requested == self._sent[1])
        moving = stale or (found.going and found.grip is registers.RobotiqGrip.MOVING)
        caught = found.grip in (
            registers.RobotiqGrip.CAUGHT_CLOSING,
            registers.RobotiqGrip.CAUGHT_OPENING,
        )
        return GripperState(self._width_of(found.position), caught and not stale, moving, at)

    def _width_of(self, count: int) -> float:
        opened, closed = self._counts
        part = (closed - count) / (closed - opened)
        return min(max(part, 0.0), 1.0) * self.model.stroke

    def _count_of(self, width: float) -> int:
        # At the ends of the stroke, send the ends of the register's range: so the fingers press,
        # and reach their stop.
        if width <= 0.0:
            return 0xFF
        if width >= self.model.stroke:
            return 0
        opened, closed = self._counts
        return round(closed - width / self.model.stroke * (closed - opened))

    async def _go(self, width: float, speed: float, force: float) -> None:
        if (await self.status()).activation is not registers.Activation.ACTIVE:
            raise GripperNotActivated(
                f"{self} is not activated: call activate(), which moves the fingers. Nothing "
                "was moved"
            )
        words = registers.request(
            self._count_of(width),
            _byte(speed, self.model.speed or (0.0, self.model.fastest)),
            _byte(force, self.model.force),
        )
        await self._send(words)

    async def _halt(self) -> None:
        found = await self.status()
        # One that is reset stands; the request would begin its activation, which moves the fingers.
        if not found.active:
            return
        if found.activation is not registers.Activation.ACTIVE:
            await self._send(registers.reset())  # only this ends an activation
            return
        _, position, rates = self._sent
        await self._send(registers.request(position & 0xFF, rates >> 8, rates & 0xFF, go=False))


def _byte(value: float, limits: tuple[float, float]) -> int:
    low, high = limits
    return round(255 * (value - low) / (high - low)) if high > low else 255
