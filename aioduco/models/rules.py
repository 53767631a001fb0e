"""Kinds of rules: each checks one argument and converts it to its value on the wire.

A rule is called with the parameter's name and the value. It returns the value on the wire, or
raises `ParameterError` with the allowed range and its unit. The common case (a float, a list or a
tuple of floats, an array) takes a fast path; all other values take a slower one.

Limits are public attributes of a rule (`low`, `high`, `unit`, `length`, …), so that documents and
tests can read them. A bound that the manual prints as infinite is the largest finite float: NaN and
infinities never pass.
"""

from __future__ import annotations

import math
import numbers
import os
import sys
import unicodedata
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Mapping, Sequence, Set
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from aioduco.errors import Described, ParameterError
from aioduco.models.bounds import least, most, shown
from aioduco.models.numpy_on_use import is_array, is_number, np, plain
from aioduco.models.pose import Joints, Pose

if TYPE_CHECKING:
    from numpy.typing import NDArray

Real: TypeAlias = "float | np.floating[Any] | np.integer[Any]"
Whole: TypeAlias = "int | np.integer[Any]"
VectorLike: TypeAlias = "Sequence[Real] | NDArray[np.floating[Any]] | NDArray[np.integer[Any]]"
WholesLike: TypeAlias = "Sequence[Whole] | NDArray[np.integer[Any]]"
FlagsLike: TypeAlias = "Sequence[bool] | NDArray[np.bool_]"
BytesLike: TypeAlias = "bytes | bytearray | memoryview | Sequence[Whole] | NDArray[np.integer[Any]]"

G = TypeVar("G")
T = TypeVar("T")

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
            return "a finite number in" if self.unit else "a finite number"
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


# -- lists ---------------------------------------------------------------------------------------


def ordered(name: str, value: object, expected: str) -> Sequence[Any]:
    """Return the elements of an ordered collection; mappings, sets and texts are refused."""
    if is_array(value):
        if value.ndim == 1 and value.dtype.kind not in "mM":  # times have a unit of their own
            return list(value.tolist())
    elif isinstance(value, Sequence):
        if not isinstance(value, (str, bytes, bytearray, memoryview)):
            return tuple(value)
    elif hasattr(value, "__array__"):
        return ordered(name, np.asarray(value), expected)
    raise ParameterError(name, value, f"{expected}, as a list, a tuple or a flat array")


def listed(name: str, values: Iterable[T], expected: str) -> list[T]:
    """Return the elements of an ordered iterable as a list.

    Raises:
        ParameterError: `values` is not iterable, or is a text, bytes, a mapping or a set.
    """
    if isinstance(values, (str, bytes, bytearray, Mapping, Set)):
        raise ParameterError(name, values, expected)
    try:
        return list(values)
    except TypeError as exc:
        raise ParameterError(name, values, expected) from exc


class Vector(Rule):
    """A list of numbers, each with its own bounds.

    Attributes:
        element: the rules of the elements, in order; one rule for all if any length is allowed.
        length: the number of elements; None if any is allowed.
        low: the smallest value of each element.
        high: the largest value of each element.
        unit: the unit, or the units of the parts in their order.
    """

    __slots__ = ("_highs", "_lows", "element", "high", "length", "low", "unit")

    #: class with the same number of elements, but another meaning
    _other: type[Pose | Joints] | tuple[()] = ()

    def __init__(self, *element: Number, length: int | None = None, source: str = "") -> None:
        if length is not None:
            element = element * length
        self.element: tuple[Number, ...] = element
        self.length: int | None = None if length is None and len(element) == 1 else len(element)
        self.low: tuple[float, ...] = tuple(rule.low for rule in element)
        self.high: tuple[float, ...] = tuple(rule.high for rule in element)
        self.unit: str = ", ".join(dict.fromkeys(rule.unit for rule in element if rule.unit))
        self._lows = tuple(rule._low for rule in element)
        self._highs = tuple(rule._high for rule in element)
        count = "numbers" if self.length is None else f"{self.length} numbers"
        expected = f"{count} ({self.unit})" if self.unit else count
        super().__init__(expected, source or element[0].source)

    def __call__(self, name: str, value: VectorLike) -> list[float]:
        """Check `value` and return it as a list of floats."""
        if isinstance(value, (list, tuple)):
            items: Sequence[Any] = value
        else:
            if isinstance(value, self._other):
                raise ParameterError(name, value, self.expected)
            items = ordered(name, value, self.expected)
        if self.length is None:
            rule = self.element[0]
            return [rule(f"{name}[{i}]", item) for i, item in enumerate(items)]
        if len(items) != self.length:
            raise ParameterError(name, value, self.expected)
        for item, low, high in zip(items, self._lows, self._highs, strict=True):
            if type(item) is not float or not low <= item <= high:
                break
        else:
            return list(items)
        rules = zip(self.element, items, strict=True)
        return [rule(f"{name}[{i}]", item) for i, (rule, item) in enumerate(rules)]


class PoseRule(Vector):
    """A pose: x, y, z in m, then rx, ry, rz in rad; a `Joints` is refused, although it has six.

    `farthest` is the maximum distance along an axis [m].
    """

    __slots__ = ()
    _other = Joints

    def __init__(self, *, farthest: float = FARTHEST, source: str) -> None:
        position = Number(unit="m", plausible=farthest, source=source)
        angle = Number(-2 * math.pi, 2 * math.pi, "rad", source=source)
        super().__init__(position, position, position, angle, angle, angle, source=source)
        self.expected = "a pose: x, y, z in m, then rx, ry, rz in rad"


class JointsRule(Vector):
    """Six joint positions in rad; a `Pose` is refused, although it has six numbers."""

    __slots__ = ()
    _other = Pose

    def __init__(self, *, source: str) -> None:
        super().__init__(Number(-2 * math.pi, 2 * math.pi, "rad", source=source), length=6)
        self.expected = "six joint positions in rad"


class OrCurrent(Rule):
    """A vector; None or an empty list means the controller's present value.

    Attributes:
        rule: the rule for a vector.
        length: the number of elements of a vector.
    """

    __slots__ = ("length", "rule")

    def __init__(self, rule: Vector) -> None:
        self.rule: Vector = rule
        self.length: int | None = rule.length
        super().__init__(
            f"{rule.expected}, or None for the controller's present value", rule.source
        )

    def __call__(self, name: str, value: VectorLike | None) -> list[float]:
        """Check `value` and return it as a list of floats, empty for the present value."""
        if value is None or (isinstance(value, (list, tuple)) and not value):
            return []
        if is_array(value) and value.shape == (0,):
            return []
        return self.rule(name, value)


class Points(Rule):
    """A list of vectors.

    Attributes:
        element: the rule of each vector.
        low: the minimum number of vectors.
        high: the maximum number of vectors.
    """

    __slots__ = ("element", "high", "low")

    def __init__(self, element: Vector, low: int, high: int, *, source: str) -> None:
        self.element: Vector = element
        self.low: int = low
        self.high: int = high
        super().__init__(f"{low} to {high} points, each {element.expected}", source)

    def __call__(
        self, name: str, value: Iterable[VectorLike] | NDArray[np.floating[Any]]
    ) -> list[list[float]]:
        """Check `value` and return it as a list of lists of floats."""
        element = self.element
        points = self.listed(name, value)
        return [element(f"{name}[{i}]", point) for i, point in enumerate(points)]

    def listed(
        self, name: str, value: Iterable[VectorLike] | NDArray[np.floating[Any]]
    ) -> list[Any]:
        """Check the number of points, and return them unchanged."""
        points = listed(name, value.tolist() if is_array(value) else value, self.expected)
        if not self.low <= len(points) <= self.high:
            raise ParameterError(name, Described(f"{len(points)} points"), self.expected)
        return points


class Items(Rule, Generic[G, T]):
    """A list of values of one kind.

    Attributes:
        element: the rule of each element.
        length: the number of elements; None if any is allowed.
    """

    __slots__ = ("element", "length")

    def __init__(self, element: Any, *, length: int | None = None, source: str) -> None:
        self.element: Any = element
        self.length: int | None = length
        count = "a list" if length is None else f"a list of {length}"
        super().__init__(f"{count}, each {element.expected}", source)

    def __call__(self, name: str, value: G) -> list[T]:
        """Check `value` and return it as a list of plain values."""
        items = ordered(name, value, self.expected)
        if self.length is not None and len(items) != self.length:
            raise ParameterError(name, value, self.expected)
        element = self.element
        return [element(f"{name}[{i}]", item) for i, item in enumerate(items)]


class Integers(Items[WholesLike, int]):
    """A list of whole numbers, each by an `Integer` or a `Choice`."""


class Flags(Items[FlagsLike, bool]):
    """A list of True and False."""


class Texts(Rule):
    """A list of texts. One text alone is refused: its letters would be taken for the texts.

    Attributes:
        element: the rule of each text.
    """

    __slots__ = ("element",)

    def __init__(self, element: Text, *, source: str) -> None:
        self.element: Text = element
        super().__init__("a list of texts", source)

    def __call__(self, name: str, value: Sequence[str]) -> tuple[str, ...]:
        """Check `value` and return it as a tuple of texts."""
        items = ordered(name, value, self.expected)
        return tuple(self.element(f"{name}[{i}]", item) for i, item in enumerate(items))


class Signed(Rule):
    """Bytes or words, sent as the signed numbers that have the same bits.

    255 and -1 are the same byte: the manual's types are signed, but its examples and the documents
    of most devices use unsigned numbers.

    Attributes:
        bits: number of bits of each element.
        low: the smallest value of each element, as a signed number.
        high: the largest value of each element, as an unsigned number.
        min_length: the minimum number of elements.
    """

    __slots__ = ("_bytes", "_element", "bits", "high", "low", "min_length")

    def __init__(self, bits: int, words: str, *, min_length: int = 1, source: str) -> None:
        self.bits: int = bits
        self.low: int = -(1 << (bits - 1))
        self.high: int = (1 << bits) - 1
        self.min_length: int = min_length
        self._bytes = bits == 8
        self._element = Integer(self.low, self.high, source=source)
        amount = f"at least {min_length}" if min_length else "any number of"
        super().__init__(f"{words}, {amount}, each {self._element.expected}", source)

    def __call__(self, name: str, value: BytesLike) -> list[int]:
        """Check `value` and return it as a list of signed ints."""
        if self._bytes and isinstance(value, (bytes, bytearray, memoryview)):
            items: Sequence[Any] = bytes(value)
        else:
            items = ordered(name, value, self.expected)
        if len(items) < self.min_length:
            raise ParameterError(name, value, self.expected)
        half, whole = 1 << (self.bits - 1), 1 << self.bits
        element = self._element
        numbers = (element(f"{name}[{i}]", item) for i, item in enumerate(items))
        return [number - whole if number >= half else number for number in numbers]
