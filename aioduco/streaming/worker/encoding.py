"""Calls whose constant parts are encoded once, so that a set-point costs one `struct.pack`.

Encoding a servoj with thriftpy2 takes as long as the rest of a worker's work for a set-point. Here
thriftpy2 encodes each call once, with numbers in the place of the set-point that occur nowhere
else; the bytes before and after them are kept.
"""

from __future__ import annotations

import struct
import time
from typing import TYPE_CHECKING, Any

from aioduco._wire import codec, idl

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.connection import Connection


_MARKS = tuple(-1.2345678901e-217 * (axis + 1) for axis in range(6))
_MARK = struct.pack("!6d", *_MARKS)
_SIX = struct.Struct("!6d").pack
_LIST_HEAD = 3 + 1 + 4  # field type and id, type of the elements, their number


class Point:
    """A call that carries one set-point.

    Args:
        connection: connection for the calls, used only on its owner's thread.
        name: the function of the wire.
        args: makes the arguments from the six numbers of a set-point.
        timeout: time-out of each call [s].
        permit: called last before the set-point is sent; it raises if that is not allowed.
    """

    def __init__(
        self,
        connection: Connection,
        name: str,
        args: Callable[[list[float]], tuple[Any, ...]],
        timeout: float,
        permit: Callable[[], object] | None = None,
    ) -> None:
        self._connection = connection
        self._permit = permit
        self._timeout = timeout
        self._function = idl.functions()[name]
        self._head, self._tail = _around(codec.encode(self._function, args(list(_MARKS))))
        self._pack = struct.Struct(f"!{len(self._head)}s6d{len(self._tail)}s").pack

    def encode(self, values: Sequence[float]) -> bytes:
        """The arguments with a set-point, as `codec.encode` would encode them."""
        return self._pack(self._head, *values, self._tail)

    def send(self, values: Sequence[float], meanwhile: Callable[[], object] | None = None) -> int:
        """Send a set-point and return the controller's answer.

        Args:
            values: the set-point.
            meanwhile: function to call while the controller answers.
        """
        arguments = self._pack(self._head, *values, self._tail)
        deadline = time.monotonic() + self._timeout
        answer: int = self._connection.exchange(
            self._function, arguments, deadline, meanwhile, permit=self._permit
        )
        return answer


class Batch:
    """A call whose first argument is a list of set-points.

    Args:
        connection: connection for the calls, used only on its owner's thread.
        name: the function of the wire.
        element: makes an element of the list from the six numbers of a set-point.
        timeout: time-out of each call [s].
        permit: called last before set-points are sent; it raises if that is not allowed.
    """

    def __init__(
        self,
        connection: Connection,
        name: str,
        element: Callable[[list[float]], Any],
        timeout: float,
        permit: Callable[[], object] | None = None,
    ) -> None:
        self._connection = connection
        self._permit = permit
        self._timeout = timeout
        self._function = idl.functions()[name]
        self._kind, encoded, self._rest = _parts(self._function, element)
        #: the bytes before and after the six numbers in an element of the list
        self.head: bytes
        self.tail: bytes
        self.head, self.tail = _around(encoded)

    def element(self, values: Sequence[float], tail: bytes = b"") -> bytes:
        """One set-point as an encoded element of the list, optionally with another tail."""
        return self.head + _SIX(*values) + (tail or self.tail)

    def encode(self, elements: Sequence[bytes]) -> bytes:
        """The arguments with these set-points, as `codec.encode` would encode them."""
        return b"".join((self._kind, struct.pack("!i", len(elements)), *elements, self._rest))

    def send(self, elements: Sequence[bytes]) -> int:
        """Send set-points and return the controller's answer."""
        deadline = time.monotonic() + self._timeout
        answer: int = self._connection.exchange(
            self._function, self.encode(elements), deadline, permit=self._permit
        )
        return answer


def element_tail(name: str, element: Callable[[list[float]], Any]) -> bytes:
    """The bytes after the six numbers of an element, for `Batch.element`."""
    return _around(_parts(idl.functions()[name], element)[1])[1]


def _parts(
    function: idl.Function, element: Callable[[list[float]], Any]
) -> tuple[bytes, bytes, bytes]:
    """The parts of a call with one element in its list: before the count, the element, the rest.

    Behind the list the call has `block`, which is true: the answer says that the points were taken.
    """
    encoded = codec.encode(function, ([element(list(_MARKS))], True))
    # With an empty list, the bytes after the list's head are the rest of the call.
    rest = codec.encode(function, ([], True))[_LIST_HEAD:]
    return encoded[: _LIST_HEAD - 4], encoded[_LIST_HEAD : len(encoded) - len(rest)], rest


def _around(encoded: bytes) -> tuple[bytes, bytes]:
    """The bytes before and after the set-point."""
    head, found, tail = encoded.partition(_MARK)
    if not found or _MARK in tail:
        raise ValueError("the set-point must occur exactly once in the call")
    return head, tail
