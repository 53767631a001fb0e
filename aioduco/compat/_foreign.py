"""Further imports of the vendor's programs: the enums of its client, and Thrift's errors."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any, Final

from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    ControllerError,
    DucoError,
    NotSent,
)


def _enum(name: str, values: dict[str, int]) -> Any:
    """Make a class of whole numbers with Thrift's two tables, as its compiler does for Python."""
    names = {number: each for each, number in values.items()}
    tables = {"_VALUES_TO_NAMES": names, "_NAMES_TO_VALUES": values}
    return type(name, (), {"__module__": "aioduco.compat", **values, **tables})


#: the enums of section 1.2 in the spelling of the vendor's client
_ENUMS: Final = Path(__file__).with_name("vendor_enums.json")
ENUMS: Final = {
    name: _enum(name, values) for name, values in json.loads(_ENUMS.read_text("utf-8")).items()
}

#: values of `type` of Thrift's TTransportException
_NOT_OPEN: Final = 1
_TIMED_OUT: Final = 3
_END_OF_FILE: Final = 4


def _reduced(error: DucoError) -> tuple[object, ...]:
    """For pickle, which finds classes by name: as the error of this package alone."""
    restore, (kind, *content) = DucoError.__reduce__(error)
    return restore, (kind.__mro__[1], *content)


def as_thrift(error: DucoError, connected: bool = True) -> DucoError:
    """Make an error an instance of Thrift's error too, if the program has loaded Thrift's library.

    Args:
        error: the error of this package.
        connected: whether there was a connection.

    Returns:
        The same error; its class may have become one that inherits from both. Pickled, it is the
        package's error again, with Thrift's attributes.
    """
    if isinstance(error, ControllerError):
        place, name, code = "thrift.Thrift", "TApplicationException", error.code
    elif isinstance(error, (ConnectionLost, ConnectError)):
        place, name = "thrift.transport.TTransport", "TTransportException"
        late = isinstance(error, (CallTimeout, NotSent))
        code = (_TIMED_OUT if late else _END_OF_FILE) if connected else _NOT_OPEN
    else:
        return error
    foreign = tuple(
        getattr(module, name)
        for path, module in tuple(sys.modules.items())
        if (path == place or path.endswith(f".{place}")) and hasattr(module, name)
    )
    if foreign:
        ours, message = type(error), str(error)
        both: Any = type(
            ours.__name__,
            (ours, *dict.fromkeys(foreign)),
            {"__module__": ours.__module__, "__reduce__": _reduced},
        )
        error.__class__ = both
        error.__dict__.update(message=message, type=code)
    return error
