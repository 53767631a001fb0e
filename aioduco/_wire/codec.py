"""Encode calls and decode replies: Thrift's strict binary protocol, without I/O.

Arguments of fixed width and results of numbers are packed and read by formats of `struct`. All else
is left to thriftpy2, which is loaded when the first value needs it (`aioduco._wire.thrift`).
"""

from __future__ import annotations

import dataclasses
import os
import struct
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from aioduco._wire.framing import Malformed, StructScanner, TType
from aioduco._wire.newer import SCHEMES
from aioduco._wire.type_checks import TypeMismatch
from aioduco.errors import ControllerError, ParameterError, UnknownFunction

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from types import ModuleType

    from aioduco._wire.idl import Function

_CALL: Final = b"\x80\x01\x00\x01"
_REPLY: Final = b"\x80\x01\x00\x02"
_EXCEPTION: Final = b"\x80\x01\x00\x03"

#: a struct without fields
_NOTHING: Final = b"\0"

#: an application error: its text and its type
_ERROR_SPEC: Final = {1: (TType.STRING, "message", False), 2: (TType.I32, "type", False)}
_UNKNOWN_METHOD: Final = 1
_MISSING_RESULT: Final = 5

_sequence = struct.Struct("!i").pack

#: largest sequence id; the next one is 1 again
LAST_SEQUENCE: Final = 0x7FFFFFFF


def encode(function: Function, args: tuple[Any, ...]) -> bytes:
    """Encode the arguments of a call.

    A motion with external axes whose schemes are in lists is encoded as manual 4.3 has it.

    Args:
        function: the function of the wire.
        args: one value per parameter.

    Returns:
        The argument struct, as in the message.

    Raises:
        ParameterError: a value does not fit the type of its parameter.
        TypeError: the number of arguments is wrong.
    """
    parameters = function.parameters
    if not args and not parameters:
        return _NOTHING
    if len(args) != len(parameters):
        raise TypeError(
            f"{function.name} takes {len(parameters)} arguments ({', '.join(parameters)}), "
            f"not {len(args)}"
        )
    if function.listed is not None and isinstance(args[SCHEMES[function.name] - 1], list):
        function = function.listed
    parameter = ""
    try:
        for check, parameter, value in zip(function.checks, parameters, args, strict=True):  # noqa: B007  # read when a check raises
            check(value)
    except TypeMismatch as exc:
        raise ParameterError(f"{parameter}{exc.path}", exc.value, exc.expected) from None
    if function.packed is not None:
        return function.packed(args)
    thrift = _thrift()
    try:
        encoded: bytes = thrift.write_struct(function.args(*args))
    except thrift.TDecodeException as exc:
        raise ParameterError(
            exc.field, exc.value, f"a value of the wire's type {exc.type_repr}"
        ) from exc
    return encoded


def _thrift() -> ModuleType:
    """The part that stands on thriftpy2."""
    from aioduco._wire import thrift  # noqa: PLC0415 - most calls need none of it

    return thrift


def message(function: Function, sequence: int, arguments: bytes) -> bytes:
    """Make the whole message of a call from its encoded arguments."""
    return _CALL + function.head + _sequence(sequence) + arguments


def decode_arguments(function: Function, body: bytes) -> dict[str, Any]:
    """Decode the arguments of a call, for a program between a client and a controller.

    Args:
        function: the function of the wire.
        body: the argument struct of the message, which must be complete.

    Returns:
        The received values by parameter; a parameter that was not sent is left out.
    """
    args = function.args()
    _thrift().read_struct(body, args)
    if function.listed is not None and args.scheme_name is None:
        args = function.listed.args()
        _thrift().read_struct(body, args)
    came = ((name, getattr(args, name)) for name in function.parameters)
    return {name: _text(value) for name, value in came if value is not None}


class ReplyReader:
    """Checks that bytes are the reply to one call, and decodes them.

    The reply must have the function's name and the sequence id of the call. thriftpy2 checks
    neither, so after a time-out its next call returns the answer to the previous call.
    """

    __slots__ = ("_function", "_head", "_read", "_result", "_scanner", "_start", "failed", "length")

    def __init__(self, function: Function, sequence: int) -> None:
        self._function = function
        self._result = function.result
        self._head = _REPLY + function.head + _sequence(sequence)
        self._scanner: StructScanner | None = None
        self._start = len(self._head)
        #: the function that reads a reply of a known layout
        self._read: Callable[[bytes | bytearray, int], Any] | None = None
        #: number of bytes of the reply, once it is complete
        self.length = 0
        #: whether the controller answered with an application error
        self.failed = False

    def whole(self, data: bytes | bytearray) -> bool:
        """Whether these bytes, from the start of the message on, contain the whole reply.

        Other bytes may follow it.

        Raises:
            Malformed: the bytes are not a reply to this call.
        """
        if self._scanner is None:
            if self._is_known(data):
                return True
            self._scanner = self._header(data)
        if self._scanner is None:
            return False
        try:
            whole = self._scanner.whole(data)
        except Malformed:
            other = self._function.other
            if self.failed or other is None or self._result is other:
                raise
            self._result = other
            self._scanner = StructScanner(other.thrift_spec, self._start, strict=True)
            whole = self._scanner.whole(data)
        self.length = self._scanner.position
        return whole

    @property
    def known(self) -> bool:
        """Whether the whole reply has a layout received before: decoding it cannot fail."""
        return self._read is not None

    def _is_known(self, data: bytes | bytearray) -> bool:
        """Whether this begins with a whole reply to this call, of a layout received before."""
        if not data.startswith(self._head):
            return False
        found = self._function.layouts.find(data[self._start :])
        if found is None:
            return False
        self._read, self.length = found[0], self._start + found[1]
        return True

    def _header(self, data: bytes | bytearray) -> StructScanner | None:
        if data.startswith(self._head):
            strict = self._function.other is not None
            return StructScanner(self._function.result.thrift_spec, self._start, strict=strict)
        kind = bytes(data[:4])
        if not (_REPLY.startswith(kind) or _EXCEPTION.startswith(kind)):
            raise Malformed(
                f"the bytes {bytes(data[:32])!r} begin no reply of Thrift's strict binary protocol"
            )
        # compare as many bytes as have arrived: do not wait for the rest of a wrong reply
        if not self._head[4:-4].startswith(bytes(data[4 : self._start - 4])):
            raise Malformed(f"a reply to another function: {bytes(data[8:48])!r}")
        if len(data) < self._start:
            return None
        if not data.startswith(self._head[-4:], self._start - 4):
            raise Malformed("a reply to another call, with another sequence id")
        self.failed = True
        return StructScanner(_ERROR_SPEC, self._start)

    def value(self, data: bytes | bytearray) -> Any:
        """Decode the whole reply.

        Raises:
            ControllerError: the controller answered with an application error.
            UnknownFunction: the controller does not have the function.
        """
        if self._read is not None:
            return self._read(data, self._start)
        function = self._function
        body = bytes(data[self._start : self.length])
        if self.failed:
            raise _application_error(function, body)
        if function.void:
            return None
        results = (self._result, function.newer or self._result)
        if (read := function.layouts.store(body, *results)) is not None:
            return read(body, 0)
        result = self._result()
        if function.newer is not None:
            extended = function.newer()
            _thrift().read_struct(body, extended)
            if _extended(extended.success):
                result = extended
        if result.success is None:
            _thrift().read_struct(body, result)
        if result.success is None:
            raise ControllerError(
                function.name, "the controller answered without a result", _MISSING_RESULT
            )
        return _text(result.success) if function.texts else result.success


def _extended(value: Any) -> bool:
    """Whether a struct, or the first of a list, has a field that only newer controllers send."""
    one = (value[0] if value else None) if isinstance(value, list) else value
    if one is None:
        return False
    present: Any = type(one).__mro__[2]  # behind the classes of `idl` and of `newer`
    added = set(one.__match_args__) - set(present.__match_args__)
    return any(getattr(one, name) is not None for name in added)


def _application_error(function: Function, body: bytes) -> ControllerError:
    thrift = _thrift()
    error = thrift.TApplicationException()
    thrift.read_struct(body, error)
    text = _text(error.message) if error.message else str(error)
    kind = UnknownFunction if error.type == _UNKNOWN_METHOD else ControllerError
    return kind(function.name, text, error.type)


class ReadResult(NamedTuple):
    """The answer to a call.

    Attributes:
        reply: the result, or the bytes from which `read` decodes it; None if there is an error.
        error: the error with which the controller answered; None if there is a result.
        at: time of `time.monotonic()` at which the answer had arrived.
        read: decodes a reply of a batch, when its value is used. If those of a hundred robots came
            at once, all their lists would exist at once, and Python would search them for garbage.
    """

    reply: Any
    error: ControllerError | None
    at: float
    read: Callable[[bytes | bytearray], Any] | None = None

    @property
    def value(self) -> Any:
        """The result; None if there is an error."""
        return self.reply if self.read is None else self.read(self.reply)

    def get(self) -> Any:
        """Return the result.

        Raises:
            ControllerError: the controller answered with an error.
        """
        if self.error is not None:
            raise self.error
        return self.value


class Exchange:
    """The calls of one connection and their answers: bytes that are sent, and bytes that come.

    The first sequence id is random: a stray or forged answer with a low number would fit on most
    connections. It is the system's, so that the seeded generator of the program is not changed.

    Args:
        clock: function that returns the time [s].
    """

    __slots__ = ("_answers", "_clock", "_data", "_last", "_readers", "end")

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._last = int.from_bytes(os.urandom(4)) % LAST_SEQUENCE
        #: of the replies that have not come yet
        self._readers: list[ReplyReader] = []
        self._answers: list[ReadResult] = []
        self._data: bytes | bytearray = b""
        #: number of bytes of the replies that have come
        self.end = 0

    def begin(
        self, function: Function, arguments: bytes, further: Sequence[tuple[Function, bytes]] = ()
    ) -> bytes:
        """Begin a call, or several in one batch, and return what is to be sent.

        Args:
            function: the function of the wire.
            arguments: its encoded arguments.
            further: functions that are called after it, with their encoded arguments.
        """
        self._answers, self._data, self.end = [], b"", 0
        self._readers, whole = [], b""
        for each, encoded in ((function, arguments), *further):
            self._last = self._last % LAST_SEQUENCE + 1
            self._readers.append(ReplyReader(each, self._last))
            whole += message(each, self._last, encoded)
        return whole

    def forget(self) -> None:
        """Expect no more replies."""
        self._readers = []

    @property
    def expects(self) -> bool:
        """Whether a reply is still to come."""
        return bool(self._readers)

    def receive(self, data: bytes) -> bool:
        """Take bytes that have come; return whether all replies are whole.

        Raises:
            Malformed: the bytes are not the replies to these calls.
        """
        # most answers arrive in one piece; the others are collected without copies
        if not self._data:
            self._data = data
        else:
            self._data = bytearray(self._data) if isinstance(self._data, bytes) else self._data
            self._data += data
        while self._readers:
            rest = self._data[self.end :] if self.end else self._data
            reader = self._readers[0]
            if not rest or not reader.whole(rest):
                return False
            value, error, read = None, None, None
            try:
                if reader.known and len(self._answers) + len(self._readers) > 1:
                    value, read = rest, reader.value
                else:
                    value = reader.value(rest)
            except ControllerError as exc:
                # without the traceback: it refers to this frame, which makes a reference cycle
                error = exc.with_traceback(None)
            self._answers.append(ReadResult(value, error, self._clock(), read))
            self.end += reader.length
            del self._readers[0]
        return True

    @property
    def surplus(self) -> bool:
        """Whether bytes came behind the replies: they belong to no call."""
        return len(self._data) > self.end

    def take(self) -> ReadResult:
        """Return the answer to the call; of a batch, the value is the list of its answers.

        It is not kept: the traceback of an error that is raised has the frames of its callers, and
        so a robot that its program drops then would never be freed.
        """
        answers, self._answers = self._answers, []
        first, *further = answers
        return ReadResult(answers, None, first.at) if further else first


def _text(value: Any) -> Any:
    """Make text readable that is not UTF-8 (thriftpy2 returns it as bytes), at any depth."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "backslashreplace")
    if isinstance(value, list):
        return [_text(item) for item in value]
    if isinstance(value, dict):
        return {_text(key): _text(item) for key, item in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            setattr(value, field.name, _text(getattr(value, field.name)))
    return value
