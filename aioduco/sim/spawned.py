"""A simulator for the program that started this process, until that program's channel closes."""

from __future__ import annotations

import contextlib
import os
import selectors
import signal
import socket
import sys
from typing import TYPE_CHECKING, Any

from aioduco._process.linked_process import ValueChannel
from aioduco.sim.process import unpacked
from aioduco.sim.simulator import Simulator

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


#: how long one thread of a simulator's own process may keep another from running [s]
SWITCH_INTERVAL = 0.0005


def serve(
    options: Mapping[str, Any],
    announce: Callable[[dict[str, Any]], object],
    owner_channel: ValueChannel,
    answer: Callable[[Simulator], bool],
) -> None:
    """Run a simulator until its channel closes, SIGTERM or SIGINT comes, or a client shuts it down.

    Args:
        options: arguments of `Simulator`.
        announce: called with the simulator's addresses, in types that JSON has.
        owner_channel: channel of the program that uses the simulator; when it closes, the
            simulator ends.
        answer: reads a request from the channel and replies; returns whether the simulator
            continues.
    """
    # Only the simulator uses this process. With a short interval a command does not wait long for a
    # thread that computes, such as one that plans a motion.
    sys.setswitchinterval(SWITCH_INTERVAL)
    ours, others = socket.socketpair()
    ours.setblocking(False)
    others.setblocking(False)
    # The handlers do nothing: each signal arrives as a byte on the socket, at any moment.
    signal.set_wakeup_fd(others.fileno(), warn_on_full_buffer=False)
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: None)
    with Simulator(**options, on_shutdown=lambda: others.send(b"x")) as sim:
        ports = {
            "port": sim.port,
            "status_port": sim.status_port,
            "force_port": sim.force_port,
        }
        announce({"host": sim.host, **ports, "pid": os.getpid()})
        with selectors.DefaultSelector() as selector:
            selector.register(owner_channel, selectors.EVENT_READ)
            selector.register(ours, selectors.EVENT_READ)
            while True:
                ready = {key.fileobj for key, _ in selector.select()}
                if ours in ready or not answer(sim):
                    break
    ours.close()
    others.close()


def main(arguments: list[str]) -> int:
    """Serve the program that started this process by `Simulator.spawn`."""
    channel = ValueChannel.of(arguments)

    def answer(sim: Simulator) -> bool:
        """Reply with all positions, whatever the request is."""
        try:
            channel.receive()
            channel.send(sim.positions)
        except (EOFError, OSError):
            return False
        return True

    announced = False

    def announce(addresses: dict[str, Any]) -> None:
        nonlocal announced
        announced = True
        channel.send(addresses)

    with contextlib.suppress(EOFError, ConnectionError):  # the program has ended meanwhile
        try:
            serve(unpacked(channel.receive()), announce, channel, answer)
        except (ValueError, OSError) as error:  # of an argument of the simulator
            if announced:
                raise
            channel.send(error)
    return 0
