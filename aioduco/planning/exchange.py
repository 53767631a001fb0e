"""Values through the pipes between a planner and its process."""

from __future__ import annotations

import pickle
import struct
from typing import IO, TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["WorkerScene", "receive", "send"]

_HEAD = struct.Struct("<Q")


class WorkerScene(NamedTuple):
    """The scene of the problems that follow.

    Attributes:
        model: of MuJoCo.
        positions: of what is loose in it.
    """

    model: Any
    positions: NDArray[np.float64]


def send(stream: IO[bytes], value: object) -> None:
    """Write a value to a pipe."""
    data = pickle.dumps(value)
    stream.write(_HEAD.pack(len(data)) + data)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read a value from a pipe of a process that we started, or that started us.

    Raises:
        EOFError: the pipe was closed.
    """
    head = stream.read(_HEAD.size)
    if len(head) < _HEAD.size:
        raise EOFError
    return pickle.loads(stream.read(_HEAD.unpack(head)[0]))
