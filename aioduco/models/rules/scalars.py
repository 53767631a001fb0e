"""Rules for single values: numbers, choices, flags, texts, times."""

from __future__ import annotations

import math
import numbers
import os
import sys
import unicodedata
from collections.abc import Awaitable, Callable, Coroutine, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from aioduco.errors import Described, ParameterError
from aioduco.models.bounds import least, most, shown
from aioduco.models.numpy_on_use import is_number, plain

if TYPE_CHECKING:
    import numpy as np

Real: TypeAlias = "float | np.floating[Any] | np.integer[Any]"
Whole: TypeAlias = "int | np.integer[Any]"

_MAX = sys.float_info.max
_WHOLE: Any = numbers.Integral
#: distance from base to flange of the longest arms, gcr10_2000 and gcr16_2000, stretched out [m]
LONGEST_ARM = 2.51
#: maximum distance of a pose from the origin of its frame [m]: eight times the longest arm, since
#: a work object may be beside the arm, and the arm may be on an external axis
FARTHEST = 20.0


#: the longest time that is plausible, 11 days: 1 ms in nanoseconds is as much [s]
LONGEST = 1e6


def stored(settings: object, **rules: Callable[[str, Any], object]) -> None:
    """Check fields of a frozen dataclass, and store the plain values that the rules return.

    Args:
        settings: the object.
        rules: the rule of each field, by its name.

    Raises:
        ParameterError: a field is not what its rule wants.
    """
    for name, rule in rules.items():
        object.__setattr__(settings, name, rule(name, getattr(settings, name)))


def condition_holds(name: str, answer: object) -> bool:
    """Whether a condition holds, by what the program's function for it returned.

    A coroutine is refused: it would count as true, whatever it would have come to.

    Args:
        name: the name of the parameter that is the function.
        answer: what the function returned.

    Raises:
        ParameterError: it must be awaited.
    """
    if isinstance(answer, Awaitable):
        if isinstance(answer, Coroutine):
            answer.close()
        returns = Described("a function whose result must be awaited")
        raise ParameterError(name, returns, "a function that returns at once whether it holds")
    return bool(answer)


class Rule:
    """Base class of all rules.

    Attributes:
        source: source of the limits: the section of manual 3.8, or another document.
        expected: description of the allowed values, with the unit, for errors.
    """

    __slots__ = ("expected", "source")

    def __init__(self, expected: str, source: str) -> None:
        self.expected: str = expected
        self.source: str = source

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.expected} [{self.source}]>"


class Number(Rule):
    """A finite number within bounds.

    Attributes:
        low: the smallest value, -inf if there is none.
        high: the largest value, inf if there is none.
        open_low: whether `low` itself is excluded.
        plausible: the largest magnitude that is plausible for these arms, inf if it is unknown.
        unit: unit of the value, "" if it has none.
    """

    __slots__ = ("_high", "_low", "high", "low", "open_low", "plausible", "unit")

    def __init__(
        self,
        low: float = -math.inf,
        high: float = math.inf,
        unit: str = "",
        *,
        open_low: bool = False,
        plausible: float = math.inf,
        source: str,
    ) -> None:
        self.plausible: float = plausible
        self.low: float = low
        self.high: float = high
        self.open_low: bool = open_low
        self.unit: str = unit
        self._low = math.nextafter(low, math.inf) if open_low else max(low, -_MAX, -plausible)
        self._high = min(high, _MAX, plausible)
        super().__init__(f"{self._words()} {unit}".rstrip(), source)

    def _words(self) -> str:
        above, below = self.low > -math.inf, self.high < math.inf
        if not above and not below:
            return "a finite number"
        if not above:
            return f"a number of at most {shown(self.high)}"
        if self.open_low:
            more = f"a number above {shown(self.low, low=True)}"
            return f"{more}, up to {shown(self.high)}" if below else more
        if not below:
            return f"a number of at least {shown(self.low, low=True)}"
        return f"a number from {shown(self.low, low=True)} to {shown(self.high)}"

    def __call__(self, name: str, value: Real) -> float:
        """Check `value` and return it as a float."""
        if type(value) is float and self._low <= value <= self._high:
            return value
        return self._other(name, value)

    def _other(self, name: str, value: object) -> float:
        number: Any = plain(value)
        if not is_number(number):
            raise ParameterError(name, value, self.expected)
        if self._low <= number <= self._high:
            return float(number)
        if least(self.low) <= number < self.low and not self.open_low:
            return self.low
        if self.high < number <= most(self.high):
            return self.high
        hint = ""
        if self.low <= number <= self.high and self.plausible < abs(number) < math.inf:
            hint = f", and within what these arms reach, {shown(self.plausible)} m (millimetres?)"
        if self.unit == "rad" and 2 * math.pi < abs(number) < 2000:
            hint = " (radians, not degrees)"
        if self.unit == "s" and number >= LONGEST:
            hint = " (seconds, not nanoseconds)"
        raise ParameterError(name, value, self.expected + hint)


def is_whole(value: object) -> bool:
    """Whether it is a whole number, also one of numpy; True and False are none."""
    return is_number(value) and isinstance(plain(value), _WHOLE)


class Integer(Rule):
    """A whole number within bounds.

    Attributes:
        low: the smallest value.
        high: the largest value.
        unit: unit of the value, "" if it has none.
    """

    __slots__ = ("high", "low", "unit")

    def __init__(self, low: int, high: int, unit: str = "", *, source: str) -> None:
        self.low: int = low
        self.high: int = high
        self.unit: str = unit
        super().__init__(f"a whole number from {low} to {high} {unit}".rstrip(), source)

    def __call__(self, name: str, value: Whole) -> int:
        """Check `value` and return it as an int."""
        if type(value) is int and self.low <= value <= self.high:
            return value
        number: Any = plain(value)
        if not is_whole(number) or not self.low <= number <= self.high:
            raise ParameterError(name, value, self.expected)
        return int(number)


class Choice(Rule):
    """One of a few whole numbers; a member of an IntEnum counts as its number.

    Attributes:
        choices: meaning of each number.
    """

    __slots__ = ("choices",)

    def __init__(self, choices: Mapping[int, str], *, source: str) -> None:
        self.choices: dict[int, str] = dict(choices)
        super().__init__(" or ".join(f"{key} ({words})" for key, words in choices.items()), source)

    def __call__(self, name: str, value: Whole) -> int:
        """Check `value` and return it as an int."""
        number = plain(value)
        if isinstance(number, bool) or not isinstance(number, int) or number not in self.choices:
            raise ParameterError(name, value, self.expected)
        return int(number)


class Flag(Rule):
    """True or False; numbers are refused, so that swapped arguments are detected."""

    __slots__ = ()

    def __init__(self, *, source: str) -> None:
        super().__init__("True or False", source)

    def __call__(self, name: str, value: bool | np.bool_) -> bool:
        """Check `value` and return it as a bool."""
        if value is True or value is False:
            return value
        flag = plain(value)
        if not isinstance(flag, bool):
            raise ParameterError(name, value, self.expected)
        return flag


class Text(Rule):
    """A string with a limited number of bytes in UTF-8.

    Attributes:
        min_bytes: the minimum number of bytes.
        max_bytes: the maximum number of bytes, None if there is no limit.
        one_line: whether it has no control characters, line ends among them: as of names.
    """

    __slots__ = ("max_bytes", "min_bytes", "one_line")

    def __init__(
        self,
        *,
        min_bytes: int = 0,
        max_bytes: int | None = None,
        one_line: bool = False,
        source: str,
    ) -> None:
        self.min_bytes: int = min_bytes
        self.max_bytes: int | None = max_bytes
        self.one_line: bool = one_line
        size = f" of at most {max_bytes} bytes in UTF-8" if max_bytes else ""
        parts = ("not empty",) * bool(min_bytes)
        parts += ("on one line, without control characters",) * one_line
        super().__init__(", ".join((f"a string{size}", *parts)), source)

    def __call__(self, name: str, value: str) -> str:
        """Check `value` and return it."""
        if not isinstance(value, str):
            raise ParameterError(name, value, self.expected)
        try:
            size = len(value.encode())
        except UnicodeEncodeError as exc:  # a lone surrogate cannot be encoded
            raise ParameterError(name, value, self.expected) from exc
        if size < self.min_bytes or (self.max_bytes is not None and size > self.max_bytes):
            raise ParameterError(name, value, self.expected)
        if self.one_line and not _is_line(value):
            raise ParameterError(name, value, self.expected)
        return str(value)


def _is_line(text: str) -> bool:
    """Whether a text has no control characters; spaces of all widths are none."""
    return text.isprintable() or all(
        each.isprintable() or unicodedata.category(each) == "Zs" for each in text
    )


class FileName(Rule):
    """The name of a file, as a text or a path.

    Attributes:
        folder: whether it is that of a folder, which may be "." or "/".
    """

    __slots__ = ("folder",)

    def __init__(self, *, folder: bool = False, source: str) -> None:
        self.folder: bool = folder
        super().__init__(f"the name of a {'folder' if folder else 'file'}", source)

    def __call__(self, name: str, value: str | os.PathLike[str]) -> Path:
        """Check `value` and return it as a path."""
        try:
            text = os.fspath(value)
            if (
                isinstance(text, str)
                and b"\0" not in os.fsencode(text)
                and (Path(text).name or (self.folder and text))
            ):
                return Path(text)
        except (TypeError, UnicodeEncodeError):  # no path; half of a surrogate pair
            pass
        raise ParameterError(name, value, self.expected)


class Duration(Rule):
    """A time in seconds, sent in whole milliseconds.

    Attributes:
        low: the shortest time, in seconds.
        high: the longest time, in seconds.
        unit: "s".
    """

    __slots__ = ("_number", "high", "low", "unit")

    def __init__(self, low: float = 0.0, high: float = 2147483.647, *, source: str) -> None:
        self._number = Number(low, high, "s", source=source)
        self.low: float = low
        self.high: float = high
        self.unit: str = "s"
        super().__init__(self._number.expected, source)

    def __call__(self, name: str, value: Real) -> int:
        """Check `value` and return it in milliseconds."""
        return round(self._number(name, value) * 1000)


class OrForever(Rule):
    """A time in seconds, or None for no limit, which is -1 on the wire.

    Attributes:
        rule: the rule of a time that is not None.
    """

    __slots__ = ("rule",)

    def __init__(self, rule: Duration) -> None:
        self.rule: Duration = rule
        super().__init__(f"{rule.expected}, or None for no end", rule.source)

    def __call__(self, name: str, value: Real | None) -> int:
        """Check `value` and return it in milliseconds, -1 for None."""
        if value is None:
            return -1
        try:
            return self.rule(name, value)
        except ParameterError as exc:
            raise ParameterError(name, value, self.expected) from exc
