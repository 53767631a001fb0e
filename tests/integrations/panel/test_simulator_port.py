"""Commands of the panel to a simulator that dies before it answers."""

from __future__ import annotations

import socket
import struct
import threading

import pytest

from aioduco.integrations.panel.simulator_port import ask_simulator


async def test_a_simulator_that_dies_before_it_answers_is_an_error_of_the_system() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def reset() -> None:
            connection, _ = server.accept()
            with connection:
                connection.recv(64)
                connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))

        thread = threading.Thread(target=reset)
        thread.start()
        with pytest.raises(ConnectionError, match="the simulator's connection is lost"):
            await ask_simulator(server.getsockname()[1], "state")
        thread.join()
