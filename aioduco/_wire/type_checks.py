"""Check whether a value fits its type on the wire, before it is encoded.

thriftpy2 encodes nearly every value: it truncates 1.7 to 1, sends 300 as a byte of 44, "False" as
true, a NaN unchanged, and leaves out fields that are None or missing, which the controller reads as
zero. The sections check their arguments by their own ranges. This second check applies to every
call of the wire. A value that passes arrives unchanged: an int is accepted as a double, 0 and 1 as
a bool, and a bool only as a bool.
"""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Callable, Sequence
from numbers import Real
from typing import Any, Final, TypeAlias

from aioduco._wire.framing import TType

#: function that returns if the value fits, and else raises `TypeMismatch`
Check: TypeAlias = Callable[[Any], None]


class TypeMismatch(Exception):
    """A value does not fit its type.

    Attributes:
        path: place of the value in the argument, in Python's notation; empty for the argument
            itself.
        value: the value.
        expected: description of values that fit.
    """

    def __init__(self, value: object, expected: str) -> None:
        self.path = ""
        self.value = value
        self.expected = expected


#: number of bits of each whole-number type of the wire
BITS: Final = {TType.BYTE: 8, TType.I16: 16, TType.I32: 32, TType.I64: 64}


def check_of(kind: int, shape: Any = None) -> Check:
    """Return the check of one type.

    Args:
        kind: thriftpy2's number of the type.
        shape: thriftpy2's details of the type: a struct's class, a container's element type.
    """
    if kind in BITS:
        return _whole(BITS[kind])
    if kind == TType.LIST:
        element, inner = shape if isinstance(shape, tuple) else (shape, None)
        return _doubles if element == TType.DOUBLE else _list(check_of(element, inner))
    if kind == TType.STRUCT:
        return _struct(shape)
    return {TType.BOOL: _flag, TType.DOUBLE: _double, TType.STRING: _text}[kind]


def _whole(bits: int) -> Check:
    low, high = -(1 << (bits - 1)), (1 << (bits - 1)) - 1
    expected = f"a whole number from {low} to {high}: i{bits} on the wire"

    def check(value: Any) -> None:
        if type(value) is int and low <= value <= high:
            return
        if isinstance(value, bool):
            raise TypeMismatch(value, expected)
        try:
            number = operator.index(value)
        except TypeError:
            raise TypeMismatch(value, expected) from None
        if not low <= number <= high:
            raise TypeMismatch(value, expected)

    return check


def _double(value: Any) -> None:
    if type(value) is float and math.isfinite(value):
        return
    number = _without_dimensions(value)
    try:
        fits = not isinstance(number, bool) and isinstance(number, Real) and math.isfinite(number)
    except OverflowError:  # a whole number too large for a double
        fits = False
    if not fits:
        raise TypeMismatch(value, "a finite number: double on the wire")


def _without_dimensions(value: Any) -> Any:
    """The number of an array without dimensions; any other value as it is."""
    return value.item() if _is_numpy(value, "ndarray") and value.ndim == 0 else value


def _flag(value: Any) -> None:
    if value is True or value is False or _is_numpy(value, "bool_"):
        return
    try:
        fits = operator.index(value) in (0, 1)
    except TypeError:
        fits = False
    if not fits:
        raise TypeMismatch(value, "True or False: bool on the wire")


def _is_numpy(value: object, name: str) -> bool:
    """Whether a value is of this numpy type. numpy is not loaded for it: a worker needs none."""
    kind = getattr(sys.modules.get("numpy"), name, None)
    return kind is not None and isinstance(value, kind)


def _text(value: Any) -> None:
    if not isinstance(value, str):
        raise TypeMismatch(value, "a text: string on the wire")


def _list(element: Check) -> Check:
    def check(value: Any) -> None:
        if not isinstance(value, (list, tuple)):
            _ordered(value)
        index = 0
        try:
            for index, item in enumerate(value):  # noqa: B007  # read when an element raises
                element(item)
        except TypeMismatch as exc:
            exc.path = f"[{index}]{exc.path}"
            raise

    return check


def _ordered(value: Any) -> None:
    fits = value.ndim > 0 if _is_numpy(value, "ndarray") else isinstance(value, Sequence)
    if not fits or isinstance(value, (str, bytes, bytearray, memoryview)):
        raise TypeMismatch(value, "a list")


_any_doubles: Final = _list(_double)


def _doubles(value: Any) -> None:
    if type(value) is list:  # fast path for most arguments
        for item in value:
            if type(item) is not float or not math.isfinite(item):
                break
        else:
            return
    _any_doubles(value)


def _struct(kind: Any) -> Check:
    entries = kind.thrift_spec.values()
    names: tuple[str, ...] = tuple(entry[1] for entry in entries)
    checks = tuple(check_of(*type_of(entry)) for entry in entries)
    values_of = operator.attrgetter(*names)
    # a struct without lists is compared as a whole: most fields have their default values
    flat = all(entry[0] not in (TType.LIST, TType.STRUCT) for entry in entries)
    zeros = values_of(kind()) if flat else None

    def check(value: Any) -> None:
        if not isinstance(value, kind):
            raise TypeMismatch(value, f"of this package's type {kind.__name__}")
        values = values_of(value)
        if flat and values == zeros:
            return
        name = ""
        try:
            for name, each, item in zip(names, checks, values, strict=True):  # noqa: B007  # read when a field raises
                each(item)
        except TypeMismatch as exc:
            exc.path = f".{name}{exc.path}"
            raise

    return check


def type_of(entry: tuple[Any, ...]) -> tuple[int, Any]:
    """Return type and shape of a field, from thriftpy2's spec of it."""
    return entry[0], entry[2] if len(entry) > 3 else None
