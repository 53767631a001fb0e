"""Ports for servers of a test that are told where to listen."""

from __future__ import annotations

import random
import socket
from contextlib import suppress

__all__ = ["free_port"]

#: that no system gives to a connection: what listens there can be started again
_PORTS = range(20_000, 30_000)


def free_port() -> int:
    """A TCP port of this computer that nothing listens on."""
    for port in random.sample(_PORTS, 100):
        with suppress(OSError), socket.create_server(("127.0.0.1", port)):
            return port
    raise AssertionError("no port is free")
