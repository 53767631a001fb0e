"""Send commands to a simulator's command port, as `aioduco sim-do` does."""

from __future__ import annotations

import anyio

from aioduco.errors import ConnectionLost

_HOST = "127.0.0.1"
#: seconds within which it must answer
_PATIENCE = 10.0


async def ask_simulator(port: int, line: str) -> str:
    """Send a command to a simulator of this computer.

    Args:
        port: command port of the simulator.
        line: the command, such as "push 0 0 50".

    Returns:
        The answer; "error: …" if the command failed.

    Raises:
        OSError: no simulator takes commands there, or it does not answer; as `ConnectionLost`, if
            the connection is lost before its answer.
    """
    with anyio.fail_after(_PATIENCE):
        async with await anyio.connect_tcp(_HOST, port) as stream:
            answer = b""
            try:
                await stream.send(f"{line}\n".encode())
                await stream.send_eof()
                while True:
                    answer += await stream.receive()
            except anyio.EndOfStream:
                return answer.decode(errors="replace").strip()
            except anyio.BrokenResourceError as error:
                raise ConnectionLost("the simulator's connection is lost") from error
