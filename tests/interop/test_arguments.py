"""What each function sends, read by the official implementation of Thrift; what it is answered."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

import pytest
from api.cases import Case, cases

from aioduco._wire import codec, idl

if TYPE_CHECKING:
    from .conftest import Generated

pytestmark = pytest.mark.interop


def names(struct: Any) -> list[str]:
    """The fields of a struct, whichever of the two libraries made it."""
    spec = type(struct).thrift_spec
    if isinstance(spec, dict):
        return [field[1] for field in spec.values()]
    return [field[2] for field in spec if field]


def plain(value: Any) -> Any:
    """A value with its structs as dictionaries."""
    if isinstance(value, (list, tuple)):
        return [plain(one) for one in value]
    if hasattr(value, "thrift_spec"):
        return {name: plain(getattr(value, name)) for name in names(value)}
    return value


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


@pytest.mark.parametrize("case", cases(), ids=str)
def test_arguments(case: Case, generated: Generated) -> None:
    function = idl.functions()[case.name]
    read = getattr(generated.client, f"{case.name}_args")()
    read.read(protocol(codec.encode(function, case.wire)))
    assert names(read) == list(function.parameters)
    assert [plain(getattr(read, name)) for name in names(read)] == [plain(v) for v in case.wire]


@pytest.mark.parametrize("case", cases(), ids=str)
def test_answers(case: Case, generated: Generated) -> None:
    function = idl.functions()[case.name]
    out = protocol()
    out.writeMessageBegin(case.name, 2, 7)
    answer = None if function.void else theirs(case.answer, generated)
    result = getattr(generated.client, f"{case.name}_result")
    (result() if function.void else result(success=answer)).write(out)
    out.writeMessageEnd()
    data = out.trans.getvalue()
    reader = codec.ReplyReader(function, 7)
    assert reader.whole(data)
    assert reader.value(data) == (None if function.void else case.answer)
