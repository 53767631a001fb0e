"""The ports of the tests' servers: none is shared."""

from __future__ import annotations

import socket

import pytest
from ports import Ports


@pytest.mark.skipif(not hasattr(socket, "SO_REUSEPORT"), reason="no two sockets share a port")
def test_a_port_that_another_run_would_share_is_left_out() -> None:
    """A proxy's socket shares its port: with that of another run, each would get some calls."""
    ours, theirs = Ports(0), Ports(0)
    ours._next = theirs._next
    with socket.socket() as one, socket.socket() as other:
        for sock, ports in ((one, theirs), (other, ours)):
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            ports.bind(sock, "127.0.0.1")
        assert one.getsockname() != other.getsockname()
