"""Arguments of `Simulator` on their way to another process."""

from __future__ import annotations

import pickle
from typing import TYPE_CHECKING, Any

from aioduco.errors import Described, ParameterError

if TYPE_CHECKING:
    from collections.abc import Mapping

_SENDABLE = (
    "what another process can have: numbers, texts, lists and values of this package; programs as "
    "lists of calls or in a folder. A Simulator in this process, without spawn, takes functions"
)


def packed(options: Mapping[str, Any]) -> dict[str, bytes]:
    """Pickle arguments of `Simulator` one by one.

    Raises:
        ParameterError: one of them cannot be sent to another process.
    """
    data = {}
    for name, value in options.items():
        try:
            data[name] = pickle.dumps(value)
        except Exception as error:
            raise ParameterError(name, value, _SENDABLE) from error
    return data


def unpacked(data: Mapping[str, bytes]) -> dict[str, Any]:
    """Undo `packed`.

    Raises:
        ParameterError: one of them is of a class, or a function, that this process cannot import.
    """
    options = {}
    for name, value in data.items():
        try:
            options[name] = pickle.loads(value)
        except (AttributeError, ImportError) as error:
            own = Described(f"something that only your program has ({error})")
            raise ParameterError(name, own, _SENDABLE) from error
    return options
