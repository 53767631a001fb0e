"""Further imports of the vendor's programs: the enums of its client, and Thrift's errors."""

from __future__ import annotations

import sys
from typing import Any, Final

from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    ControllerError,
    DucoError,
    NotSent,
)

__all__ = ["ENUMS", "as_thrift"]

#: the enums of section 1.2 in the spelling of the vendor's client: values by name of the enum
_VALUES: Final[dict[str, dict[str, int]]] = {
    "StateRobot": {
        "SR_Start": 0,
        "SR_Initialize": 1,
        "SR_Logout": 2,
        "SR_Login": 3,
        "SR_PowerOff": 4,
        "SR_Disable": 5,
        "SR_Enable": 6,
        "SR_Update": 7,
    },
    "StateProgram": {
        "SP_Stopped": 0,
        "SP_Stopping": 1,
        "SP_Running": 2,
        "SP_Paused": 3,
        "SP_Pausing": 4,
        "SP_TaskRuning": 5,
    },
    "OperationMode": {"kManual": 0, "kAuto": 1, "kRemote": 2},
    "TaskState": {
        "ST_Idle": 0,
        "ST_Running": 1,
        "ST_Paused": 2,
        "ST_Stopped": 3,
        "ST_Finished": 4,
        "ST_Interrupt": 5,
        "ST_Error": 6,
        "ST_Illegal": 7,
        "ST_ParameterMismatch": 8,
    },
    "SafetyState": {
        "SS_INIT": 0,
        "SS_WAIT": 2,
        "SS_CONFIG": 3,
        "SS_POWER_OFF": 4,
        "SS_RUN": 5,
        "SS_RECOVERY": 6,
        "SS_STOP2": 7,
        "SS_STOP1": 8,
        "SS_STOP0": 9,
        "SS_MODEL": 10,
        "SS_REDUCE": 12,
        "SS_BOOT": 13,
        "SS_FAIL": 14,
        "SS_UPDATE": 99,
    },
}


def _enum(name: str, values: dict[str, int]) -> Any:
    """Make a class of whole numbers with Thrift's two tables, as its compiler does for Python."""
    names = {number: each for each, number in values.items()}
    tables = {"_VALUES_TO_NAMES": names, "_NAMES_TO_VALUES": values}
    return type(name, (), {"__module__": "aioduco.compat", **values, **tables})


ENUMS: Final = {name: _enum(name, values) for name, values in _VALUES.items()}

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
