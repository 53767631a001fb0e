"""Registers of Robotiq's 2F-85, 2F-140 and Hand-E, without I/O.

Source: Robotiq, 2F-85 & 2F-140 instruction manual, section 4 (control), tables of the registers
0x03E8 to 0x03EA and 0x07D0 to 0x07D2; the Hand-E's manual has the same.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco.models.named_int import NamedInt

if TYPE_CHECKING:
    from collections.abc import Sequence

#: first register of the command (rACT to rFR) and of the status (gACT to gCU)
COMMAND, STATUS = 0x03E8, 0x07D0
STATUS_COUNT = 3

#: bits of the action request
_ACTIVATE, _GO = 0x01, 0x08

#: meanings of gFLT
FAULTS: dict[int, str] = {
    0x05: "the action is delayed: it must be activated first",
    0x07: "the activation bit must be set before the action",
    0x08: "it is too hot: let it cool down",
    0x09: "nothing was heard of the master for a second",
    0x0A: "its voltage is too low",
    0x0B: "it is being released by its automatic release",
    0x0C: "an internal fault: contact its maker",
    0x0D: "it was not activated: look whether something is in its way",
    0x0E: "its current was too high",
    0x0F: "it was released by its automatic release: activate it again",
}


class Activation(NamedInt):
    """Progress of the activation (gSTA)."""

    RESET = 0
    ACTIVATING = 1
    ACTIVE = 3


class RobotiqGrip(NamedInt):
    """How the last motion ended (gOBJ)."""

    MOVING = 0
    CAUGHT_OPENING = 1
    CAUGHT_CLOSING = 2
    REACHED = 3


class RobotiqStatus(NamedTuple):
    """The values of the three status registers.

    Attributes:
        active: gACT.
        going: gGTO: whether it follows the position request.
        activation: gSTA; None for a value that the manual does not list.
        grip: gOBJ.
        fault: gFLT, 0 for none.
        requested: gPR, echo of the position request.
        position: gPO, 0 open to 255 closed.
        current: gCU [A].
    """

    active: bool
    going: bool
    activation: Activation | None
    grip: RobotiqGrip
    fault: int
    requested: int
    position: int
    current: float


def reset() -> list[int]:
    """Return the command registers that reset the gripper and clear its faults (rACT = 0)."""
    return [0, 0, 0]


def activation() -> list[int]:
    """Return the command registers that activate the gripper (rACT = 1)."""
    return [_ACTIVATE << 8, 0, 0]


def request(position: int, speed: int, force: int, *, go: bool = True) -> list[int]:
    """Return the command registers that move the fingers.

    Args:
        position: rPR, 0 open to 255 closed.
        speed: rSP, 0 to 255.
        force: rFR, 0 to 255.
        go: rGTO; without it the fingers stop.

    Raises:
        ValueError: a number is not from 0 to 255.
    """
    if not all(0 <= value <= 0xFF for value in (position, speed, force)):
        raise ValueError(f"{position}, {speed}, {force} must be from 0 to 255 each")
    return [(_ACTIVATE | (_GO if go else 0)) << 8, position, speed << 8 | force]


def status(registers: Sequence[int]) -> RobotiqStatus:
    """Decode the three status registers from `STATUS` on."""
    first, second, third = registers
    bits = first >> 8
    state = bits >> 4 & 3
    return RobotiqStatus(
        active=bool(bits & 1),
        going=bool(bits & _GO),
        activation=Activation(state) if state in (0, 1, 3) else None,
        grip=RobotiqGrip(bits >> 6),
        # The upper half belongs to an optional controller.
        fault=second >> 8 & 0x0F,
        requested=second & 0xFF,
        position=third >> 8,
        current=(third & 0xFF) * 0.01,
    )
