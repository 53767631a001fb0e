"""Electronics of grippers: Modbus slaves with the makers' registers, or digital signals.

They drive and read `Fingers`, which the physics implement. The register maps are written here
independently of those of the drivers, so that both cannot have the same mistake.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from aioduco.sim.cabinet.modbus import RtuSlave

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.models.gripper_models import GripperModel
    from aioduco.sim.cabinet.signals import Signals
    from aioduco.sim.cycle import GripperReading


class Fingers(Protocol):
    """The fingers as their electronics drive them; usable from any thread."""

    @property
    def gripper(self) -> GripperModel:
        """Model of the gripper."""
        ...

    @property
    def reading(self) -> GripperReading:
        """State of the fingers."""
        ...

    def command(self, targets: Iterable[float], speed: float, force: float) -> int:
        """Order openings [m], one after another; none to stop. Return the number of the order."""
        ...


class RobotiqSlave(RtuSlave):
    """The registers of a Robotiq gripper (2F-85 and 2F-140 instruction manual, section 4).

    Args:
        fingers: the fingers that it drives.
    """

    #: position counts when open and when closed, from a support article of the maker
    OPEN, CLOSED = 3, 230

    def __init__(self, fingers: Fingers) -> None:
        super().__init__(9, registers=dict.fromkeys((*range(1000, 1003), *range(2000, 2003)), 0))
        self.input_registers: dict[int, int] = self.registers  # both functions read these
        self._fingers = fingers
        self._order = self._activation = 0
        self._fault = 0

    def receive(self, data: bytes) -> bytes | None:
        """Answer a frame, with the present status."""
        self._refresh()
        return super().receive(data)

    def write_registers(self, address: int, values: list[int]) -> None:
        """Write registers and carry out the command."""
        if address < 1000 or address + len(values) > 1003:
            raise KeyError(address)  # the status is read-only
        before = [self.registers[1000 + i] for i in range(3)]
        super().write_registers(address, values)
        after = [self.registers[1000 + i] for i in range(3)]
        was, now = before[0] >> 8, after[0] >> 8
        model = self._fingers.gripper
        if not now & 1:
            self._fault = 7 if now & 8 else 0
            if was & 1:
                self._fingers.command((), 0.0, 0.0)
        elif not was & 1:
            middle = 0.5 * sum(model.force)
            ends = (model.stroke, 0.0, model.stroke)
            self._activation = self._order = self._fingers.command(ends, model.fastest, middle)
            self._fault = 0
        elif not self._active:
            self._fault = 5 if now & 8 else 0
        elif not now & 8:
            if was & 8:
                self._order = self._fingers.command((), 0.0, 0.0)
        elif before != after:
            self._go(after[1] & 0xFF, after[2] >> 8, after[2] & 0xFF)

    def _go(self, position: int, speed: int, force: int) -> None:
        model = self._fingers.gripper
        part = (self.CLOSED - position) / (self.CLOSED - self.OPEN)
        low, high = model.speed or (model.fastest, model.fastest)
        self._order = self._fingers.command(
            (part * model.stroke,),
            low + speed / 255 * (high - low),
            model.force[0] + force / 255 * (model.force[1] - model.force[0]),
        )

    @property
    def _active(self) -> bool:
        reading = self._fingers.reading
        over = reading.number > self._activation or (
            reading.number == self._activation and not reading.moving
        )
        return bool(self.registers[1000] >> 8 & 1) and over

    def _refresh(self) -> None:
        reading, model = self._fingers.reading, self._fingers.gripper
        bits = self.registers[1000] >> 8
        moving = reading.moving or reading.number != self._order
        if not bits & 1:
            state, grip = 0, 0
        elif not self._active:
            state, grip = 1, 0
        else:
            state = 3
            grip = 0 if moving else {1: 2, -1: 1, 0: 3}[reading.caught]
        closed = 1.0 - reading.opening / model.stroke
        count = round(self.OPEN + closed * (self.CLOSED - self.OPEN))
        self.registers[2000] = (grip << 6 | state << 4 | bits & 8 | bits & 1) << 8
        self.registers[2001] = self._fault << 8 | (self.registers[1001] & 0xFF)
        self.registers[2002] = min(max(count, 0), 255) << 8 | (0x10 if moving else 0)


class DhSlave(RtuSlave):
    """The basic control registers of a DH gripper (AG-95 and PGE short manuals, section 2.3).

    Args:
        fingers: the fingers that it drives.
    """

    def __init__(self, fingers: Fingers) -> None:
        self._settable = fingers.gripper.speed is not None
        names = [0x0100, 0x0101, 0x0103, *([0x0104] if self._settable else [])]
        # 0x0205, the error, is not in the short manuals: a program for a PGEA-50-26 reads it
        zero = dict.fromkeys((*names, 0x0200, 0x0201, 0x0202, 0x0205), 0)
        super().__init__(1, registers=zero | {0x0101: 100, 0x0103: 1000})
        if self._settable:
            self.registers[0x0104] = 100
        self.input_registers: dict[int, int] = self.registers
        self._fingers = fingers
        self._order = self._initialization = 0

    def receive(self, data: bytes) -> bytes | None:
        """Answer a frame, with the present state."""
        self._refresh()
        return super().receive(data)

    def write_registers(self, address: int, values: list[int]) -> None:
        """Write a setting, or move to a position.

        Raises:
            KeyError: A register cannot be written.
            ValueError: A value is out of range.
        """
        limits = {0x0100: (1, 0xA5), 0x0101: (20, 100), 0x0103: (0, 1000), 0x0104: (1, 100)}
        for i, value in enumerate(values):
            low, high = limits[address + i]
            if not low <= value <= high:
                raise ValueError(f"{value} is not from {low} to {high}")
        super().write_registers(address, values)
        written = range(address, address + len(values))
        model = self._fingers.gripper
        if 0x0100 in written:
            whole = self.registers[0x0100] == 0xA5
            ends = (0.0, model.stroke) if whole else (model.stroke,)
            self._order = self._fingers.command(ends, model.fastest, model.force[0])
            self._initialization = self._order
        elif 0x0103 in written and self._initialized == 1:
            force = (self.registers[0x0101] - 20) / 80
            speed = self.registers[0x0104] / 100 if self._settable else 1.0
            self._order = self._fingers.command(
                (self.registers[0x0103] / 1000 * model.stroke,),
                speed * model.fastest,
                model.force[0] + force * (model.force[1] - model.force[0]),
            )

    @property
    def _initialized(self) -> int:
        reading = self._fingers.reading
        if not self._initialization:
            return 0
        over = reading.number > self._initialization or not reading.moving
        return 1 if reading.number >= self._initialization and over else 2

    def _refresh(self) -> None:
        reading = self._fingers.reading
        self.registers[0x0200] = self._initialized
        if reading.number != self._order:
            grip = 0
        elif reading.lost:
            grip = 3
        elif reading.moving:
            grip = 0
        else:
            grip = 2 if reading.caught else 1
        self.registers[0x0201] = grip
        part = reading.opening / self._fingers.gripper.stroke
        self.registers[0x0202] = min(max(round(1000 * part), 0), 1000)


class ValveGripper:
    """A gripper or a suction cup on general signals of the cabinet.

    Fingers close while output 1 is on. Input 1 is on if they hold something, input 2 if they are
    open, input 3 if they are closed on nothing. A cup sucks while output 1 is on, and blows off
    while output 2 is on; input 1 is its vacuum.

    Args:
        fingers: the fingers that it drives.
    """

    CLOSE, BLOW_OFF = 1, 2
    HOLDS, OPENED, SHUT = 1, 2, 3

    def __init__(self, fingers: Fingers) -> None:
        self._fingers = fingers
        self._given: tuple[bool, bool] | None = None
        self._order = 0

    def tick(self, time: float, signals: Signals) -> dict[int, bool]:
        """Run one cycle of the controller, at a time [s]; give the states of its inputs."""
        model = self._fingers.gripper
        closing = signals.standard_out.level(self.CLOSE, time)
        blowing = not model.stroke and signals.standard_out.level(self.BLOW_OFF, time)
        if (closing, blowing) != self._given:
            # The gripper starts open: that needs no order.
            if self._given is not None or closing or blowing:
                goal = 0.0 if closing else (model.stroke or 1.0)
                speed = model.fastest if model.stroke else float(blowing)
                self._order = self._fingers.command((goal,), speed, model.force[1])
            self._given = closing, blowing
        reading = self._fingers.reading
        rests = reading.number == self._order and not reading.moving
        holds = closing and reading.caught == 1 and reading.number == self._order
        states = {self.HOLDS: holds}
        if model.stroke:
            states[self.OPENED] = rests and reading.opening > model.stroke - 1e-3
            states[self.SHUT] = rests and reading.opening < 1e-3
        return states


def slave_of(fingers: Fingers) -> RtuSlave | None:
    """Make the Modbus slave of a gripper; None for one that outputs of the cabinet drive."""
    maker, _, _ = fingers.gripper.name.partition("_")
    if maker == "robotiq":
        return RobotiqSlave(fingers)
    return DhSlave(fingers) if maker == "dh" else None
