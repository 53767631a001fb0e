"""Rules for lists: vectors, poses, points, flags, bytes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence, Set
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from aioduco.errors import Described, ParameterError
from aioduco.models.numpy_on_use import is_array, np
from aioduco.models.pose import Joints, Pose
from aioduco.models.rules.scalars import FARTHEST, Integer, Number, Real, Rule, Text, Whole

if TYPE_CHECKING:
    from numpy.typing import NDArray


VectorLike: TypeAlias = "Sequence[Real] | NDArray[np.floating[Any]] | NDArray[np.integer[Any]]"
WholesLike: TypeAlias = "Sequence[Whole] | NDArray[np.integer[Any]]"
FlagsLike: TypeAlias = "Sequence[bool] | NDArray[np.bool_]"
BytesLike: TypeAlias = "bytes | bytearray | memoryview | Sequence[Whole] | NDArray[np.integer[Any]]"

G = TypeVar("G")
T = TypeVar("T")


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
    """A pose: x, y, z in m, then rx, ry, rz in rad; a `Joints` is refused, although it has six."""

    __slots__ = ()
    _other = Joints

    def __init__(self, *, source: str) -> None:
        position = Number(unit="m", plausible=FARTHEST, source=source)
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
