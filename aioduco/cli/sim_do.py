"""`aioduco sim-do`: actions of a person at the machine, on a simulator of another process."""

from __future__ import annotations

import socket
from typing import Annotated

import typer

from aioduco.cli.exit_codes import fail
from aioduco.cli.output import say

_HOST = "127.0.0.1"
_ABOVE = 10_000
_PATIENCE = 10.0  # [s]


def control_port_of(port: int) -> int:
    """The command port that belongs to a simulator's port; 0 (any free port) if there is none."""
    return port + _ABOVE if 0 < port <= 65535 - _ABOVE else 0


def sim_do(
    words: Annotated[list[str] | None, typer.Argument()] = None,
    port: Annotated[int, typer.Option(min=1, max=65535)] = 7003,
    control_port: Annotated[int | None, typer.Option(min=1, max=65535)] = None,
) -> None:
    """Do something at a simulator that runs on this computer: inputs, emergency stop, pushes.

    Args:
        words: Command, such as: input 3 on. Without one: help.
        port: Port of the simulator.
        control_port: Port for commands. Default: port + 10000.
    """
    where = control_port or control_port_of(port)
    if not where:
        raise typer.BadParameter(
            f"no port for commands belongs to {port}: give the one that `aioduco sim` named when "
            "it started",
            param_hint="--control-port",
        )
    try:
        with socket.create_connection((_HOST, where), timeout=_PATIENCE) as line:
            line.sendall(" ".join(words or ["help"]).encode(errors="replace") + b"\n")
            line.shutdown(socket.SHUT_WR)
            with line.makefile("r", encoding="utf-8", errors="backslashreplace") as answer:
                said = answer.read().rstrip("\n")
    except OSError as error:
        fail(
            f"no simulator takes commands on {_HOST}:{where}: {error.strerror or error}; "
            "`aioduco sim` names its port for commands when it starts, which is --control-port",
        )
    if not said:
        fail(f"what listens on {_HOST}:{where} ended without an answer: look at the simulator")
    failed = said.startswith("error")
    say(said, error=failed)
    raise typer.Exit(1 if failed else 0)
