"""Interprets the keys of a terminal: the key that is held moves the arm. No device, no clock.

A terminal does not report the release of a key. It repeats a key that is held, first after a delay
of up to 0.66 s and then some 25 times a second (defaults of X11's `xset r rate`). So a key counts
as held for `first` seconds, and from its first repetition on for only `repeating` seconds.
"""

from __future__ import annotations

from typing import Final

from aioduco.devices.teleoperation.reading import HELD, STANDING, Axes, Reading

_DIRECTIONS: Final = (("w", "s"), ("a", "d"), ("r", "f"), ("j", "l"), ("i", "k"), ("u", "o"))

#: the axes of each key
KEYS: dict[str, Axes] = {}
for _axis, _keys in enumerate(_DIRECTIONS):
    for _key, _sign in zip(_keys, (1.0, -1.0), strict=True):
        _x, _y, _z, _u, _v, _w = (_sign * (_each == _axis) for _each in range(6))
        KEYS[_key] = (_x, _y, _z, _u, _v, _w)

_DONE: Final = ("q", "\x04")
_REPEATS_WITHIN: Final = 0.15  # s between two repetitions of a key that is held


class Keyboard:
    """Converts the keys of a terminal to readings.

    Args:
        first: seconds for which a key counts as held after it came once, up to 60.
        repeating: seconds for which a repeated key counts as held, up to 60.

    Raises:
        ParameterError: a time is out of range.
    """

    def __init__(self, *, first: float = 0.4, repeating: float = 0.15) -> None:
        self._first = HELD("first", first)
        self._repeating = HELD("repeating", repeating)
        self._key = ""
        self._at = 0.0
        self._until = 0.0
        self._done = False
        self._escape = False

    def feed(self, data: bytes, now: float) -> None:
        """Take bytes of the terminal; no bytes mean that the terminal is gone.

        Args:
            data: the bytes.
            now: time at which they arrived [s].
        """
        if not data:
            self._done = True
        for key in data.decode(errors="replace").lower():
            if self._escape:
                # The letters of an arrow or a function key do not move the arm.
                self._escape = not (key.isalpha() or key == "~") or key == "o"
            elif key == "\x1b":
                self._escape, self._key = True, ""
            else:
                self._press(key, now)

    def _press(self, key: str, now: float) -> None:
        if key in _DONE:
            self._done = True
        repeated = key == self._key and now - self._at <= _REPEATS_WITHIN
        self._key, self._at = key, now
        self._until = now + (self._repeating if repeated else self._first)

    def reading(self, now: float) -> Reading:
        """The state of the keys at a time [s]."""
        held = self._key in KEYS and now < self._until
        axes = KEYS[self._key] if held else STANDING
        return Reading(axes, held, self._done)
