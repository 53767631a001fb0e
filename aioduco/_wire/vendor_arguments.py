"""What the vendor's programs pass, as the values of the wire that it stands for.

The vendor's client takes whatever Thrift's Python library can write. So programs pass None and ''
for "the present one", objects of their own copy of the vendor's structs, bytes above 127, 1 for
True. Each of these has one meaning here; what has none is left as it is, and refused where the
arguments are encoded.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from thriftpy2.thrift import TType

from aioduco._wire import idl
from aioduco._wire.type_checks import type_of

if TYPE_CHECKING:
    from aioduco._wire.rpc import Op

__all__ = ["wire_arguments"]

_Convert: TypeAlias = Callable[[Any], Any]

#: by type of the wire the bits of its whole numbers
_BITS: Final = {TType.BYTE: 8, TType.I16: 16, TType.I32: 32, TType.I64: 64}
#: what stands for the present one if nothing is given, and the outputs of a weave: none
_MAY_BE_NOTHING: Final = frozenset({"q_near", "qnear", "tool", "wobj", "ref_pos", "op_list"})
#: position of `path_dwell`, in whose place older versions of the class have `op_list`
_PATH_DWELL: Final = 8


def wire_arguments(name: str, args: tuple[Any, ...], op: Op) -> tuple[Any, ...]:
    """The arguments of a call as the wire has them.

    Args:
        name: the function of the wire.
        args: what the program gave, in the order of the wire.
        op: what is sent for outputs that were not given.
    """
    if name == "combine_motion_config" and isinstance(args[_PATH_DWELL], (list, tuple)):
        args = (*args[:_PATH_DWELL], False, args[_PATH_DWELL])
    conversions = _conversions(name)
    parameters = idl.functions()[name].parameters
    return tuple(
        op if parameter == "op" and value is None else convert(value)
        for parameter, convert, value in zip(parameters, conversions, args, strict=True)
    )


@functools.cache
def _conversions(name: str) -> tuple[_Convert, ...]:
    """For each parameter of a function what makes a value of the wire of its argument."""
    entries = idl.functions()[name].args.thrift_spec.values()
    return tuple(
        _or_nothing(*type_of(entry))
        if entry[1] in _MAY_BE_NOTHING and not name.startswith("set_")
        else _conversion(*type_of(entry))
        for entry in entries
    )


@functools.cache
def _conversion(kind: int, shape: Any) -> _Convert:
    if kind in _BITS:
        return _whole
    if kind == TType.STRUCT:
        return functools.partial(_struct, shape)
    if kind == TType.LIST:
        element, inner = shape if isinstance(shape, tuple) else (shape, None)
        if element in (TType.BYTE, TType.I16):
            return functools.partial(_signed, _BITS[element])
        if element != TType.DOUBLE:
            return functools.partial(_list, _conversion(element, inner))
    return _same


def _or_nothing(kind: int, shape: Any) -> _Convert:
    """The conversion of a parameter for which None, '' and an empty list stand for nothing."""
    convert = _conversion(kind, shape)
    nothing: Callable[[], Any] = str if kind == TType.STRING else list

    def either(value: Any) -> Any:
        empty = value is None or (isinstance(value, (str, list, tuple)) and not value)
        return nothing() if empty else convert(value)

    return either


def _same(value: Any) -> Any:
    return value


def _whole(value: Any) -> Any:
    """True and False are the 1 and 0 that they are to the vendor's class."""
    return int(value) if isinstance(value, bool) else value


def _signed(bits: int, value: Any) -> Any:
    """Bytes and words: those without a sign as the ones with a sign that have the same bits."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return value
    half, full = 1 << (bits - 1), 1 << bits
    found = []
    for item in value:
        try:
            number = operator.index(item)
        except TypeError:
            return value
        found.append(number - full if half <= number < full else number)
    return found


def _list(convert: _Convert, value: Any) -> Any:
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return [convert(item) for item in value]
    return value


def _struct(kind: Any, value: Any) -> Any:
    """A struct of this package; of another that has its fields, such as the vendor's, a copy.

    The vendor's have None for what was not set.
    """
    entries = kind.thrift_spec.values()
    if isinstance(value, kind) or not any(hasattr(value, entry[1]) for entry in entries):
        return value
    made = kind()
    for entry in entries:
        field = getattr(value, entry[1], None)
        if field is not None:
            setattr(made, entry[1], _conversion(*type_of(entry))(field))
    return made
