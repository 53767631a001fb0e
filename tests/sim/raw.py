"""A client below the SDK: one socket, calls encoded by thriftpy2, nothing else."""

from __future__ import annotations

import socket
from typing import Any, Self

from thriftpy2.protocol import TCyBinaryProtocol
from thriftpy2.thrift import TApplicationException
from thriftpy2.transport import TCyBufferedTransport, TCyMemoryBuffer, TSocket

from aioduco._wire import idl

#: thriftpy2 ships types of half of its functions
_protocol: Any = TCyBinaryProtocol
_socket: Any = TSocket


def encode(name: str, seqid: int, /, *args: Any, **fields: Any) -> bytes:
    """A call; fields that are not given are left out."""
    out = TCyMemoryBuffer()
    writer = _protocol(out)
    writer.write_message_begin(name, 1, seqid)
    function = idl.functions().get(name)
    writer.write_struct(function.args(*args, **fields) if function else _Nothing())
    encoded: bytes = out.getvalue()
    return encoded


class RawClient:
    """Calls functions, or sends any bytes."""

    def __init__(self, port: int, timeout: float = 20.0) -> None:
        self.sock = socket.create_connection(("127.0.0.1", port), timeout=timeout)
        self.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        wrapped = _socket()
        wrapped.set_handle(self.sock)
        self._reader = _protocol(TCyBufferedTransport(wrapped))
        self._seqid = 0

    def encode(self, name: str, /, *args: Any, **fields: Any) -> bytes:
        """A call; fields that are not given are left out."""
        self._seqid += 1
        return encode(name, self._seqid, *args, **fields)

    def call(self, name: str, /, *args: Any, **fields: Any) -> Any:
        """Call, and wait for the answer."""
        self.sock.sendall(self.encode(name, *args, **fields))
        return self.answer(name)

    def answer(self, name: str) -> Any:
        """The next answer, which must be that of this call."""
        found, kind, seqid = self._reader.read_message_begin()
        if kind == 3:
            error: Exception = TApplicationException()
            self._reader.read_struct(error)
            raise error
        assert (found, kind) == (name, 2)
        assert 0 < seqid <= self._seqid
        result = idl.functions()[name].result()
        self._reader.read_struct(result)
        return getattr(result, "success", None)

    def ended(self) -> bool:
        """Whether the other side closes without a word; waits for it."""
        try:
            return self.sock.recv(1) == b""
        except ConnectionResetError:
            return True

    def close(self) -> None:
        self.sock.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()


class _Nothing:
    thrift_spec: dict[int, Any] = {}  # noqa: RUF012 - what thriftpy2 looks for
