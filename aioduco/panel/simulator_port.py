"""Asks a simulated controller's port for commands, as `aioduco sim-do` does."""

from __future__ import annotations

import anyio

__all__ = ["ask_simulator"]

_HOST = "127.0.0.1"
#: seconds in which it answers
_PATIENCE = 10.0


async def ask_simulator(port: int, line: str) -> str:
    """Have a simulator of this computer do something.

    Args:
        port: its port for commands.
        line: such as "push 0 0 50".

    Returns:
        What it says; "error: …" if it was not done.

    Raises:
        OSError: no simulator takes commands there, or it does not answer.
    """
    with anyio.fail_after(_PATIENCE):
        async with await anyio.connect_tcp(_HOST, port) as stream:
            await stream.send(f"{line}\n".encode())
            await stream.send_eof()
            answer = b""
            try:
                while True:
                    answer += await stream.receive()
            except anyio.EndOfStream:
                return answer.decode(errors="replace").strip()
