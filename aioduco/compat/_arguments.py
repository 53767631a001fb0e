"""Convert the arguments of the vendor's programs to values of the wire.

The vendor's client accepts every value that Thrift's Python library can write. So programs pass
None and '' for "the present one", objects of their own copy of the vendor's structs, bytes above
127, and 1 for True. Each of these has one meaning here. A value without a meaning stays unchanged,
and is refused when the arguments are encoded.
"""

from __future__ import annotations

import functools
import numbers
import operator
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from aioduco._wire import idl, newer
from aioduco._wire.framing import TType
from aioduco._wire.type_checks import BITS, type_of
from aioduco.errors import ParameterError

if TYPE_CHECKING:
    from aioduco._wire.rpc import Op


_Convert: TypeAlias = Callable[[Any], Any]

#: parameters that may be empty: for most it means the present one, for a weave's outputs none
_MAY_BE_NOTHING: Final = frozenset({"q_near", "qnear", "tool", "wobj", "ref_pos", "op_list"})
#: position of `path_dwell`; older versions of the class have `op_list` in its place
_PATH_DWELL: Final = 8


def wire_arguments(name: str, args: tuple[Any, ...], op: Op) -> tuple[Any, ...]:
    """Convert the arguments of a call to values of the wire.

    Args:
        name: the function of the wire.
        args: the program's arguments, in the order of the wire.
        op: value that is sent if the program gave no outputs.
    """
    if name == "combine_motion_config" and isinstance(args[_PATH_DWELL], (list, tuple)):
        args = (*args[:_PATH_DWELL], False, args[_PATH_DWELL])
    function = idl.functions()[name]
    if function.listed is not None:  # programs for the newer class name several schemes, in lists
        scheme = args[newer.SCHEMES[name] - 1]
        function = function.listed if isinstance(scheme, (list, tuple)) else function
    conversions = _conversions(function)
    return tuple(
        op if parameter == "op" and value is None else convert(value)
        for parameter, convert, value in zip(function.parameters, conversions, args, strict=True)
    )


@functools.cache
def _conversions(function: idl.Function) -> tuple[_Convert, ...]:
    """For each parameter of a function, the conversion of its argument to a value of the wire."""
    return tuple(
        _or_nothing(*type_of(entry))
        if entry[1] in _MAY_BE_NOTHING and not function.name.startswith("set_")
        else _conversion(*type_of(entry))
        for entry in function.args.thrift_spec.values()
    )


@functools.cache
def _conversion(kind: int, shape: Any) -> _Convert:
    if kind in BITS:
        return _whole
    if kind == TType.STRUCT:
        return functools.partial(_struct, shape)
    if kind == TType.LIST:
        element, inner = shape if isinstance(shape, tuple) else (shape, None)
        if element in (TType.BYTE, TType.I16):
            return functools.partial(_signed, BITS[element])
        if element != TType.DOUBLE:
            return functools.partial(_list, _conversion(element, inner))
    return _same


def _or_nothing(kind: int, shape: Any) -> _Convert:
    """Return the conversion of a parameter for which None, '' and an empty list mean nothing."""
    convert = _conversion(kind, shape)
    nothing: Callable[[], Any] = str if kind == TType.STRING else list

    def either(value: Any) -> Any:
        empty = value is None or (isinstance(value, (str, list, tuple)) and not value)
        return nothing() if empty else convert(value)

    return either


def _same(value: Any) -> Any:
    return value


def _whole(value: Any) -> Any:
    """Convert True and False to 1 and 0, as the vendor's class does, and 3.0 to 3.

    The manual prints the id of a CAN message as a double.
    """
    exact = isinstance(value, bool) or (isinstance(value, float) and value.is_integer())
    return int(value) if exact else value


def _signed(bits: int, value: Any) -> Any:
    """Convert unsigned bytes or words to the signed ones with the same bits."""
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


def no_fixed_radius(arc_rad: object) -> None:
    """Check that movec's `arc_rad`, of manual 4.3, asks for nothing.

    Raises:
        ParameterError: it is another value than 0, which cannot be sent.
    """
    if not isinstance(arc_rad, numbers.Real) or arc_rad != 0:
        raise ParameterError("arc_rad", arc_rad, "0: where the wire has it is not known")


def _list(convert: _Convert, value: Any) -> Any:
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return [convert(item) for item in value]
    return value


def _struct(kind: Any, value: Any) -> Any:
    """Copy a foreign struct with the same fields, such as the vendor's, into one of this package.

    Fields that were not set are None in the vendor's structs.
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
