"""The vendor's class over a client by the Apache Thrift compiler: what is left out is not sent."""

from __future__ import annotations

import importlib
import inspect
from functools import partial
from types import ModuleType
from typing import Any


class Generated:
    """One connection, with a method for each function; one call at a time.

    Args:
        client: the module that the compiler wrote for the service.
        ip: address of the controller.
        port: its TCP port.
    """

    def __init__(self, client: ModuleType, ip: str, port: int) -> None:
        sockets = importlib.import_module("thrift.transport.TSocket")
        transports = importlib.import_module("thrift.transport.TTransport")
        binary = importlib.import_module("thrift.protocol.TBinaryProtocol")
        self._transport = transports.TBufferedTransport(sockets.TSocket(ip, port))
        self._client = client.Client(binary.TBinaryProtocol(self._transport))

    def open(self) -> int:
        """Connect."""
        self._transport.open()
        return 0

    def close(self) -> int:
        """Close the connection."""
        self._transport.close()
        return 0

    def __getattr__(self, name: str) -> Any:
        return partial(_call, getattr(self._client, name))


def _call(function: Any, *args: Any) -> Any:
    """Call a generated function; without the arguments that the program leaves out."""
    parameters = len(inspect.signature(function).parameters)
    return function(*args, *[None] * (parameters - len(args)))
