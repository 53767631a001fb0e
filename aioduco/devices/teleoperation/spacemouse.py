"""Interprets the HID reports of a SpaceMouse. This module uses no device and no clock.

Report 1 has three s16, little-endian: x to the right, y towards the person, z down, each about
-350 to 350; newer models send the three turns after them. Report 2 has the turns about these axes
in the older models. Report 3 has the buttons, one bit each. The public projects PySpaceMouse (its
list of devices) and spacenavd read the reports in the same way.

A SpaceMouse sends a report every 8 to 16 ms while its cap is deflected, and zeros when it is
released. So if no report comes, the device does not work any more, and the arm must stop. The cap
itself is the dead-man switch; with `button` a button must be held as well.
"""

from __future__ import annotations

import struct
from typing import Final

from aioduco.devices.teleoperation.reading import HELD, STANDING, WIDTH, Axes, Reading, deadband

_FULL: Final = 350.0
_THREE: Final = struct.Struct("<3h")
_TRANSLATION, _ROTATION, _BUTTONS = 1, 2, 3


class SpaceMouse:
    """Converts a SpaceMouse's reports to readings.

    Args:
        width: share of the cap's travel within which it counts as at rest.
        button: number of the button that must be held, from 0; None: no button.
        quiet: seconds without a report after which a deflected cap counts as released, up to 60.

    Raises:
        ParameterError: a number is out of range.
    """

    def __init__(
        self, *, width: float = 0.08, button: int | None = None, quiet: float = 0.2
    ) -> None:
        self._width = WIDTH("width", width)
        self._button = button
        self._quiet = HELD("quiet", quiet)
        self._along = self._about = (0.0, 0.0, 0.0)
        self._down: frozenset[int] = frozenset()
        self._at = float("-inf")
        self._gone = False

    def feed(self, data: bytes, now: float) -> None:
        """Take one report of the device; an empty report means that the device is gone.

        Args:
            data: the report, which begins with its number.
            now: time at which it arrived [s].
        """
        if not data:
            self._gone = True
            return
        number, body = data[0], data[1:]
        if number == _TRANSLATION and len(body) >= _THREE.size:
            self._along, self._at = self._three(body), now
            if len(body) >= 2 * _THREE.size:
                self._about = self._three(body[_THREE.size :])
        elif number == _ROTATION and len(body) >= _THREE.size:
            self._about, self._at = self._three(body), now
        elif number == _BUTTONS and body:
            bits = int.from_bytes(body[:4], "little")
            self._down = frozenset(bit for bit in range(32) if bits >> bit & 1)

    def _three(self, body: bytes) -> tuple[float, float, float]:
        """A vector in the person's axes: x forward, y to the left, z up."""
        right, back, down = _THREE.unpack_from(body)
        x, y, z = (deadband(value / _FULL, self._width) for value in (-back, -right, -down))
        return x, y, z

    def reading(self, now: float) -> Reading:
        """The state of cap and buttons at a time [s]."""
        x, y, z = self._along
        rx, ry, rz = self._about
        axes: Axes = (x, y, z, rx, ry, rz)
        held = not self._gone and now - self._at <= self._quiet and any(axes)
        if self._button is not None:
            held = held and self._button in self._down
        return Reading(axes if held else STANDING, held, self._gone, self._down)
