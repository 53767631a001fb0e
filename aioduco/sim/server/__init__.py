"""The simulated controller's network side: unframed strict binary Thrift over TCP.

It has its own accept loop instead of thriftpy2's server, which shares its port silently
(SO_REUSEPORT), drops clients that idle for three seconds and never joins its threads.

Guarantees:
- each connection has one thread, which reads, calls the handler and answers, in order;
- every answer is sent by one system call, without Nagle's delay;
- bytes that are not a message close their connection, and only that one;
- `close` returns when every thread has ended and every socket is closed.

This package may import `refusal` of the simulator, and Thrift.
"""

from __future__ import annotations

from aioduco.sim.server.rpc_server import Server

__all__ = ["Server"]
