"""Controllers of older generations: thriftpy2's own server, on an IDL cut down to what they had."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

import thriftpy2
from thriftpy2.protocol import TBinaryProtocol
from thriftpy2.thrift import TProcessor
from thriftpy2.transport import TBufferedTransport, TSocket

from aioduco.sim.server import generations

DATA = Path(__file__).parents[1] / "data"
WIRE: dict[str, Any] = json.loads((DATA / "wire.json").read_text("utf-8"))
OLDER: dict[str, Any] = json.loads(
    Path(generations.__file__).with_name("older_wires.json").read_text("utf-8")
)["versions"]
#: those of which a generated client is known
NAMES = ("older", "oldest")

#: thriftpy2 ships types of half of its functions
_library: Any = thriftpy2
_protocol: Any = TBinaryProtocol
_processor: Any = TProcessor
_buffered: Any = TBufferedTransport
_socket: Any = TSocket


class Field(NamedTuple):
    """A field of a struct, or a parameter."""

    id: int
    type: str
    name: str


class Layout(NamedTuple):
    """What one generation speaks."""

    structs: dict[str, list[Field]]
    parameters: dict[str, list[Field]]
    returns: dict[str, str]

    def idl(self) -> str:
        """As the text of an IDL."""
        lines = []
        for struct, fields in self.structs.items():
            inner = "".join(f"  {each.id}: {each.type} {each.name}\n" for each in fields)
            lines.append(f"struct {struct} {{\n{inner}}}\n")
        lines.append("service RPCRobot {\n")
        for name, fields in self.parameters.items():
            inner = ", ".join(f"{each.id}: {each.type} {each.name}" for each in fields)
            lines.append(f"  {self.returns[name]} {name}({inner})\n")
        return "".join(lines).replace("i8", "byte") + "}\n"


@cache
def layout(generation: str) -> Layout:
    """What a generation speaks: the present wire, without what it lacks, with its own fields."""
    older = OLDER[generation]
    structs = WIRE["structs"] | older["structs"]
    methods = {
        name: one | {"args": older["methods"].get(name, one["args"])}
        for name, one in WIRE["methods"].items()
        if name not in older["lacks"]
    }
    return Layout(
        # what a struct is made of comes before it
        {name: [Field(*each) for each in structs[name]] for name in _in_order(structs)},
        {name: [Field(*each) for each in one["args"]] for name, one in methods.items()},
        {name: one["returns"] for name, one in methods.items()},
    )


def _in_order(structs: dict[str, Any]) -> list[str]:
    return sorted(structs, key=lambda name: sum(each[1] in structs for each in structs[name]))


class OlderController:
    """A server of one generation that answers what it is told to."""

    def __init__(self, generation: str, folder: Path) -> None:
        path = folder / f"{generation}.thrift"
        path.write_text(layout(generation).idl(), encoding="utf-8")
        module = _library.load(str(path), module_name=f"{generation}_controller_thrift")
        self.layout = layout(generation)
        self.answers: dict[str, Any] = {
            "get_robot_state": [6, 0, 5, 1],
            "get_robot_version": "V2.6.1",
            "getRobotIOStatus": module.IOStatus(),
            "rpc_heartbeat": None,
            "robotmoving": False,
        }
        self.received: list[tuple[str, tuple[Any, ...]]] = []
        self.structs: Any = module
        self._processor = _processor(module.RPCRobot, self)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.host, self.port = "127.0.0.1", self._listener.getsockname()[1]
        self._open: list[socket.socket] = []
        self._threads: list[threading.Thread] = []

    def __getattr__(self, name: str) -> Callable[..., Any]:
        if name not in self.layout.parameters:
            raise AttributeError(name)

        def serve(*args: Any) -> Any:
            self.received.append((name, args))
            answer = self.answers[name]
            return answer(*args) if callable(answer) else answer

        return serve

    def __enter__(self) -> Self:
        self._start(self._accept)
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._threads[0].join(5.0)
        for each in self._open:
            each.close()
        for thread in self._threads:
            thread.join(5.0)

    def _start(self, run: Callable[..., None], *args: Any) -> None:
        thread = threading.Thread(target=run, args=args, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            self._open.append(client)
            self._start(self._serve, client)

    def _serve(self, client: socket.socket) -> None:
        link = _socket()
        link.set_handle(client)
        protocol = _protocol(_buffered(link))
        with client:
            try:
                while True:
                    self._processor.process(protocol, protocol)
            except Exception:  # the client is gone, in whatever way
                return
