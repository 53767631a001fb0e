"""Registers of DH's grippers of the series AG, PGE and PGI, without I/O.

Source: DH-Robotics, AG-95 short manual (Modbus-RTU) and PGE series short manual, section 2.3,
tables of basic control registers. The AG-95 has no register for the speed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco.models.named_int import NamedInt

if TYPE_CHECKING:
    from collections.abc import Sequence

INITIALIZE, FORCE, POSITION, SPEED = 0x0100, 0x0101, 0x0103, 0x0104
#: first of three registers: state of the initialization, state of the grip, position
STATE = 0x0200
STATE_COUNT = 3
#: position with the fingers open; 0 with the fingers closed
OPEN = 1000
#: how far beyond an end of the stroke a position may be; an assumption
_BEYOND = 100


class Initialization(NamedInt):
    """Whether the ends of the stroke are known."""

    NONE = 0
    DONE = 1
    UNDER_WAY = 2


class DhGrip(NamedInt):
    """How the last motion ended."""

    MOVING = 0
    REACHED = 1
    CAUGHT = 2
    DROPPED = 3


class DhState(NamedTuple):
    """The values of the three state registers.

    Attributes:
        initialization: whether the gripper is ready.
        grip: how the last motion ended.
        position: 0 closed to 1000 open.
    """

    initialization: Initialization
    grip: DhGrip
    position: int


def state(registers: Sequence[int]) -> DhState:
    """Decode the three state registers from `STATE` on.

    A position a little beyond an end of the stroke, also below zero, is that end.

    Raises:
        ValueError: a register has a value that the manual does not list.
    """
    ready, grip, position = registers
    signed = position - 0x10000 if position & 0x8000 else position
    if not -_BEYOND <= signed <= OPEN + _BEYOND:
        raise ValueError(f"{signed} is no position: they are from 0 to {OPEN}")
    return DhState(Initialization(ready), DhGrip(grip), min(max(signed, 0), OPEN))
