"""Processing of one call from its bytes to its answer: check, decode, call the handler, encode.

Sizes are compared with the bounds before anything is allocated or awaited.
"""

from __future__ import annotations

import logging
from typing import Any

from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TApplicationException
from thriftpy2.transport import TCyMemoryBuffer

from aioduco._wire import messages
from aioduco._wire.framing import Bounds
from aioduco._wire.messages import Message, MessageType
from aioduco.sim.refusal import Refusal
from aioduco.sim.server.generations import Served, Wire, wire_of

#: A call of 1000 track points with their operations takes about 200 kB.
MAX_MESSAGE = 1 << 20
#: Elements of all lists, sets and maps of one message; bounds the decoded size of a small message.
MAX_ELEMENTS = 1 << 16
#: The deepest function of the wire nests four levels.
MAX_DEPTH = 16
CALL, REPLY, EXCEPTION, ONEWAY = MessageType
_BOUNDS = Bounds(MAX_MESSAGE, MAX_ELEMENTS, MAX_DEPTH)
_CALLS = frozenset((CALL, ONEWAY))
_log = logging.getLogger(__name__)
#: Any, because thriftpy2 ships types for only half of its functions
_protocol: Any = TCyBinaryProtocol


class CallInbox(messages.Inbox):
    """Extracts whole calls from the received bytes."""

    __slots__ = ()

    def __init__(self) -> None:
        super().__init__(_CALLS, _BOUNDS)


class Processor:
    """Answers messages by the handler's methods. It has buffers, so each connection has its own.

    Args:
        handler: object whose methods answer the calls.
        wire: the functions that are served; None for those of the present generation.
    """

    __slots__ = ("_handler", "_in", "_out", "_reader", "_wire", "_writer")

    def __init__(self, handler: object, wire: Wire | None = None) -> None:
        self._handler = handler
        self._wire = wire_of("3.8") if wire is None else wire
        self._in: Any = TCyMemoryBuffer()
        self._out: Any = TCyMemoryBuffer()
        self._reader = _protocol(self._in, strict_decode=True)
        self._writer = _protocol(self._out)

    def answer(self, message: Message) -> bytes:
        """The encoded answer; empty for a one-way call.

        Every exception of the handler becomes an application error with its text. The connection
        continues, because the message was complete.
        """
        kind, result = self._result(message)
        if message.kind != CALL:
            return b""
        try:
            return self._encode(message, kind, result)
        except Exception as exc:
            _log.exception("%s: the handler's result does not fit the wire", message.name)
            error = TApplicationException(
                TApplicationException.INTERNAL_ERROR,
                f"{message.name}: the result does not fit the wire: {exc!r}",
            )
            return self._encode(message, EXCEPTION, error)

    def _result(self, message: Message) -> tuple[int, Any]:
        served = self._wire.get(message.name)
        if served is None or not hasattr(self._handler, message.name):
            return _error(
                TApplicationException.UNKNOWN_METHOD, f"unknown function {message.name!r}"
            )
        try:
            values = served.values(self._arguments(served, message.body))
        except Exception as exc:
            return _error(TApplicationException.PROTOCOL_ERROR, str(exc))
        try:
            value = getattr(self._handler, message.name)(*values)
        except Refusal as exc:
            return _error(TApplicationException.INTERNAL_ERROR, str(exc))
        except Exception as exc:
            _log.exception("%s failed in the simulated controller", message.name)
            return _error(TApplicationException.INTERNAL_ERROR, repr(exc))
        return REPLY, served.answer(value)

    def _arguments(self, served: Served, body: bytes) -> Any:
        """Decode the arguments in the layout of the generation that the fields indicate."""
        args = served.args()
        self._in.setvalue(body)
        self._reader.read_struct(args)
        for layout in served.others:
            came = layout.args()
            self._in.setvalue(body)
            self._reader.read_struct(came)
            if layout.matches(came):
                return came
        return args

    def _encode(self, message: Message, kind: int, result: Any) -> bytes:
        self._out.clean()
        self._writer.write_message_begin(message.name, kind, message.seqid)
        self._writer.write_struct(result)
        encoded: bytes = self._out.getvalue()
        return encoded


def _error(code: int, text: str) -> tuple[int, TApplicationException]:
    return EXCEPTION, TApplicationException(code, text)
