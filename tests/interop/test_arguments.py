"""What each function sends, read by the official implementation of Thrift; what it is answered."""

from __future__ import annotations

import importlib
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from api.cases import Case, blocking_cases, cases
from api.nowhere import robot_on
from api.test_calls import same
from for_each import for_each

import aioduco
from aioduco._wire import codec, idl
from aioduco.supervision.command import MotionCommand

from .clients import names, plain
from .conftest import Generated

pytestmark = [pytest.mark.interop, pytest.mark.slow]


def theirs(value: Any, generated: Generated) -> Any:
    """A value with its structs as the other library's."""
    if isinstance(value, list):
        return [theirs(one, generated) for one in value]
    if hasattr(value, "thrift_spec"):
        kind = getattr(generated.structs, type(value).__name__)
        return kind(**{name: theirs(getattr(value, name), generated) for name in names(value)})
    return value


def protocol(data: bytes = b"") -> Any:
    """The official implementation's strict binary protocol on a buffer."""
    transport = importlib.import_module("thrift.transport.TTransport")
    binary = importlib.import_module("thrift.protocol.TBinaryProtocol")
    buffer = transport.TMemoryBuffer(data) if data else transport.TMemoryBuffer()
    return binary.TBinaryProtocol(buffer)


def sent_and_answered(case: Case, generated: Generated) -> Callable[..., Awaitable[Any]]:
    """A controller in a function: bytes go in and come out by the official implementation."""

    async def exchange(name: str, args: tuple[Any, ...]) -> Any:
        function = idl.functions()[name]
        assert arrived(name, codec.encode(function, args), generated) == plain(args)
        if name == case.name:
            assert args == case.wire
        nothing: Any = [] if name == "get_last_error" else False
        answer = case.answer if name == case.name else case.also.get(name, nothing)
        return answered(name, answer, generated)

    return exchange


def arrived(name: str, encoded: bytes, generated: Generated) -> list[Any]:
    """The arguments that the official implementation reads."""
    read = getattr(generated.client, f"{name}_args")()
    read.read(protocol(encoded))
    assert names(read) == list(idl.functions()[name].parameters)
    return [plain(getattr(read, field)) for field in names(read)]


def answered(name: str, answer: Any, generated: Generated) -> Any:
    """An answer that the official implementation writes, as it is read here."""
    function = idl.functions()[name]
    out = protocol()
    out.writeMessageBegin(name, 2, 7)
    result = getattr(generated.client, f"{name}_result")
    given = {} if function.void else {"success": theirs(answer, generated)}
    result(**given).write(out)
    out.writeMessageEnd()
    data = out.trans.getvalue()
    reader = codec.ReplyReader(function, 7)
    assert reader.whole(data)
    return reader.value(data)


@for_each(
    "case",
    # restart also waits for the controller, over a connection: tests/api tries it with one
    [case for case in cases() if case.section and case.name != "restart"],
)
async def test_a_function_of_a_section(case: Case, generated: Generated) -> None:
    """From our arguments to the official reader, from the official writer to our result."""
    exchange = sent_and_answered(case, generated)
    made = case.method(robot_on(exchange))(**case.args)
    if isinstance(made, MotionCommand):
        made.mark_used()
        assert made.command.args == case.wire
        await exchange(case.name, made.command.args)
        return
    result = await made
    if isinstance(case.result, type):
        assert type(result) is case.result
    else:
        same(result, case.result)


@for_each("case", blocking_cases())
async def test_a_blocking_call(case: Case, generated: Generated) -> None:
    """It is the call of the motion with `block` true, and its answer is a state."""
    state = await case.method(robot_on(sent_and_answered(case, generated)))(**case.args)
    assert state is aioduco.TaskState.FINISHED


@for_each("name", sorted(idl.functions()))
def test_the_bytes_of_every_function(name: str, generated: Generated) -> None:
    """All of the wire, what the supervision calls included."""
    known = {case.name: (case.wire, case.answer) for case in cases()}
    args, answer = {"rpc_heartbeat": ((500,), None), **known}[name]
    encoded = codec.encode(idl.functions()[name], args)
    assert arrived(name, encoded, generated) == plain(args)
    assert answered(name, answer, generated) == (None if idl.functions()[name].void else answer)
