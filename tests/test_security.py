"""All servers listen on loopback unless told otherwise."""

from __future__ import annotations

import inspect

from for_each import for_each

import aioduco
from aioduco.cli.panel import panel
from aioduco.cli.sim import sim
from aioduco.cli.tap import tap
from aioduco.cli.view import view
from aioduco.integrations.fleet import FleetSettings
from aioduco.integrations.panel import Panel
from aioduco.recording.tap import Tap
from aioduco.sim import Simulator
from aioduco.sim.server.line_server import LineServer
from aioduco.sim.server.rpc_server import Server
from aioduco.sim.server.status_server import StatusServer
from aioduco.sync import Robot as SyncRobot


@for_each(
    "listener, parameter",
    [
        (Simulator, "host"),
        (Server, "host"),
        (StatusServer, "host"),
        (Tap, "listen"),
        (aioduco.Robot.publish, "host"),
        (SyncRobot.publish, "host"),
        (FleetSettings, "listen"),
        (sim, "host"),
        (tap, "listen"),
        (view, "bind"),
        (panel, "bind"),
        (Panel, "bind"),
    ],
)
def test_the_default_is_loopback(listener: object, parameter: str) -> None:
    assert callable(listener)
    default = inspect.signature(listener).parameters[parameter].default
    assert "127.0.0.1" in str(default)


def test_commands_of_a_simulator_are_taken_on_loopback_whatever_it_listens_on() -> None:
    server = LineServer(lambda line: line, 0)
    try:
        assert server._listener.server_address[0] == "127.0.0.1"
    finally:
        server.close()
