"""A server whose handlers do nothing, so that what is measured beside it is the client.

It speaks the wire on one port and echoes bytes on another, prints both as a line of JSON, and
ends when its standard input does.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import sys
import threading
from typing import TYPE_CHECKING, Any, NoReturn

import thriftpy2
from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TProcessor
from thriftpy2.transport import TCyBufferedTransport, TSocket

from aioduco._wire import idl

if TYPE_CHECKING:
    from collections.abc import Callable

_socket: Any = TSocket


class Handlers:
    """Answers of the right type and a usual size."""

    def __init__(self, structs: Any) -> None:
        self._status = structs.RobotStatus(
            **{
                entry[1]: [0.1] * 7 for entry in list(structs.RobotStatus.thrift_spec.values())[:15]
            },
            slaveReady=[True] * 6,
            collision=False,
            collisionAxis=0,
            emcStopSignal=False,
            robotState=6,
            robotError=0,
        )

    def get_noneblock_taskstate(self, *_: object) -> int:
        return 1

    def servoj(self, *_: object) -> int:
        return 0

    def getRobotStatus(self) -> Any:  # noqa: N802  # the name on the wire
        return self._status


def answer_calls(sock: socket.socket, service: Any, handlers: Handlers) -> None:
    transport = TCyBufferedTransport(_socket(sock=sock))
    protocol: Any = TCyBinaryProtocol
    stream = protocol(transport)
    processor = TProcessor(service, handlers)
    while True:
        processor.process(stream, stream)


def answer_echoes(sock: socket.socket) -> None:
    """Read the sizes of request and reply once; then send a reply for each request."""
    request, reply = struct.unpack("!II", receive(sock, 8))
    data = bytes(reply)
    while True:
        receive(sock, request)
        sock.sendall(data)


def receive(sock: socket.socket, size: int) -> bytes:
    data = sock.recv(size)
    while len(data) < size:
        chunk = sock.recv(size - len(data))
        if not chunk:
            raise EOFError
        data += chunk
    return data


def listen(answer: Callable[[socket.socket], None]) -> int:
    """Serve each connection on a thread of its own; the port."""
    listener = socket.create_server(("127.0.0.1", 0), backlog=64)

    def serve(sock: socket.socket) -> None:
        # a client that goes away ends its connection, however it shows
        with contextlib.suppress(Exception), sock:
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            answer(sock)

    def accept() -> None:
        while True:
            sock, _ = listener.accept()
            threading.Thread(target=serve, args=(sock,), daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    return int(listener.getsockname()[1])


def serve(ports: dict[str, int]) -> NoReturn:
    """Say where this process serves, until its standard input ends."""
    print(json.dumps(ports), flush=True)
    sys.stdin.read()
    # threads that wait for bytes need no farewell
    os._exit(0)


def main() -> None:
    module = thriftpy2.load(str(idl.path()), module_name="rpc_server_thrift")
    handlers = Handlers(module)
    ports = {
        "thrift": listen(lambda sock: answer_calls(sock, module.RPCRobot, handlers)),
        "echo": listen(answer_echoes),
    }
    serve(ports)


if __name__ == "__main__":
    main()
