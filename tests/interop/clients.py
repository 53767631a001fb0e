"""Two clients behind one interface: each calls any function, and answers in plain values."""

from __future__ import annotations

import importlib
import json
import math
import subprocess
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol, Self

_STRUCT, _MAP, _LIST, _STRING = 12, 13, 15, 11
#: the module of each service
MODULES = {name: f"clients.{name}" for name in ("Short", "Older", "Oldest", "First")} | {
    "RPCRobot": "duco.RPCRobot"
}


@dataclass(frozen=True)
class Refused:
    """An application error, with its text."""

    text: str


@dataclass(frozen=True)
class Lost:
    """The connection ended instead of an answer."""

    text: str


class Client(Protocol):
    """Calls functions by name."""

    def call(self, service: str, name: str, args: dict[str, Any]) -> Any:
        """The answer; structs are dictionaries. What is not in `args` is left out, or zero."""

    def close(self) -> None:
        """End it."""


def module(service: str) -> ModuleType:
    """What the compiler wrote for a service."""
    return importlib.import_module(MODULES[service])


def made(spec: Any, value: Any) -> Any:
    """A value of the table as the generated code wants it: dictionaries become structs."""
    kind, extra = spec
    if kind == _LIST:
        return [made((extra[0], extra[1]), one) for one in value]
    if kind == _STRUCT:
        cls = extra[0]
        fields = {field[2]: (field[1], field[3]) for field in cls.thrift_spec if field}
        return cls(**{name: made(fields[name], one) for name, one in value.items()})
    return value


def struct(cls: Any, values: dict[str, Any]) -> Any:
    """A generated struct of arguments."""
    return made((_STRUCT, [cls]), values)


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


class PythonClient:
    """The generated Python client, buffered: Nagle's algorithm is not what is tried here."""

    def __init__(self, host: str, port: int) -> None:
        self._address = (host, port)
        self._transport: Any = None
        self._protocol: Any = None

    def call(self, service: str, name: str, args: dict[str, Any]) -> Any:
        thrift = importlib.import_module("thrift.Thrift")
        code = module(service)
        sent = struct(getattr(code, f"{name}_args"), args)
        fields = names(sent)
        try:
            self._open()
            method = getattr(code.Client(self._protocol), name)
            return plain(method(*(getattr(sent, field) for field in fields)))
        except thrift.TApplicationException as exc:
            return Refused(str(exc.message))
        except (thrift.TException, OSError) as exc:
            self.close()
            return Lost(repr(exc))

    def _open(self) -> None:
        if self._transport is not None:
            return
        thrift_socket = importlib.import_module("thrift.transport.TSocket")
        transports = importlib.import_module("thrift.transport.TTransport")
        binary = importlib.import_module("thrift.protocol.TBinaryProtocol")
        sock = thrift_socket.TSocket(*self._address)
        sock.setTimeout(20_000)
        self._transport = transports.TBufferedTransport(sock)
        self._transport.open()
        self._protocol = binary.TBinaryProtocol(self._transport)

    def close(self) -> None:
        if self._transport is not None:
            self._transport.close()
            self._transport = None


class CppClient:
    """The program of the generated C++ clients, spoken to in lines."""

    def __init__(self, program: Path, host: str, port: int) -> None:
        self._process = subprocess.Popen(
            [str(program), host, str(port)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )

    def call(self, service: str, name: str, args: dict[str, Any]) -> Any:
        code = module(service)
        sent = struct(getattr(code, f"{name}_args"), args)
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None
        assert stdout is not None
        stdin.write(f"{service} {name} {_json(sent)}\n")
        stdin.flush()
        line = stdout.readline()
        if not line:
            raise RuntimeError(f"the C++ client ended at {name}({args})")
        answer = json.loads(line)
        if "refused" in answer:
            return Refused(answer["refused"])
        if "lost" in answer:
            return Lost(answer["lost"])
        result = getattr(code, f"{name}_result")()
        text = line.partition(": ")[2].rstrip()[:-1]
        result.read(_reader(text))
        return plain(getattr(result, "success", None))

    def close(self) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        self._process.wait(10)
        self._process.stdout.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _json(sent: Any) -> str:
    """A generated struct in Thrift's JSON, and NaN as the C++ side reads it."""
    transports = importlib.import_module("thrift.transport.TTransport")
    protocol = importlib.import_module("thrift.protocol.TJSONProtocol")

    class Writer(protocol.TJSONProtocol):  # type: ignore[name-defined, misc]  # loaded above
        def writeDouble(self, number: float) -> None:  # the library's name
            if math.isfinite(number):
                super().writeDouble(number)
            elif math.isnan(number):
                self.writeJSONString("NaN")
            else:
                self.writeJSONString("Infinity" if number > 0 else "-Infinity")

    buffer = transports.TMemoryBuffer()
    sent.write(Writer(buffer))
    text: str = buffer.getvalue().decode()
    return text


def _reader(text: str) -> Any:
    transports = importlib.import_module("thrift.transport.TTransport")
    protocol = importlib.import_module("thrift.protocol.TJSONProtocol")
    return protocol.TJSONProtocol(transports.TMemoryBuffer(text.encode()))
