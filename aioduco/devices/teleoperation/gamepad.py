"""Interprets a gamepad's events of Linux's joystick interface. No device and no clock are used.

An event is `struct js_event` of include/uapi/linux/joystick.h: time [ms] as u32, value as s16, type
and number as u8 each; type 1 is a button, 2 an axis, and 0x80 marks the state when it was opened.
Axes and buttons have the numbers of the kernel's driver xpad (drivers/input/joystick/xpad.c).

A stick that is held still sends no events, so missing events mean nothing here: a shoulder button
is the dead-man switch. A button that was down when the device was opened, or is stuck, counts only
after it was released.
"""

from __future__ import annotations

import struct
from typing import Final

from aioduco.devices.teleoperation.reading import STANDING, WIDTH, Axes, Reading, deadband

EVENT: Final = struct.Struct("=IhBB")
_BUTTON, _AXIS, _INITIAL = 0x01, 0x02, 0x80
_FULL: Final = 32767
#: by number of a stick's axis: axis of the reading, and sign. Sticks give minus forward and left.
_STICKS: Final = {1: (0, -1), 0: (1, -1), 4: (2, -1), 6: (3, 1), 7: (4, -1), 3: (5, -1)}
_DEAD_MEN: Final = (4, 5)  # LB, RB
_DONE: Final = 7  # Start


class Gamepad:
    """Converts a joystick's events to readings.

    Args:
        width: share of a stick's travel within which it counts as at rest.
        dead_men: numbers of the buttons, one of which must be held.

    Raises:
        ParameterError: the width is out of range.
    """

    def __init__(self, *, width: float = 0.1, dead_men: tuple[int, ...] = _DEAD_MEN) -> None:
        self._width = WIDTH("width", width)
        self._dead_men = dead_men
        self._rest = b""
        self._axes = list(STANDING)
        self._down: set[int] = set()
        self._gone = False

    def feed(self, data: bytes, now: float) -> None:  # noqa: ARG002 - other devices need the time
        """Take bytes of the device; no bytes mean that the device is gone.

        Args:
            data: events, or parts of them.
            now: time at which they arrived [s].
        """
        self._gone = self._gone or not data
        self._rest += data
        while len(self._rest) >= EVENT.size:
            _, value, kind, number = EVENT.unpack_from(self._rest)
            self._rest = self._rest[EVENT.size :]
            if kind & ~_INITIAL == _AXIS and number in _STICKS:
                axis, sign = _STICKS[number]
                self._axes[axis] = sign * deadband(value / _FULL, self._width)
            elif kind & ~_INITIAL == _BUTTON and not value:
                self._down.discard(number)
            elif kind == _BUTTON:
                self._down.add(number)

    def reading(self, now: float) -> Reading:  # noqa: ARG002 - other devices need the time
        """The state of sticks and buttons at a time [s]."""
        held = not self._gone and any(number in self._down for number in self._dead_men)
        x, y, z, rx, ry, rz = self._axes
        axes: Axes = (x, y, z, rx, ry, rz)
        pressed = frozenset(self._down.difference(self._dead_men))
        return Reading(axes if held else STANDING, held, self._gone or _DONE in pressed, pressed)
