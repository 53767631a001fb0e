"""A fleet of arms over several computers: one view of it, and one stop for it.

A gateway (`aioduco fleet serve fleet.toml`) supervises the arms of its computer in one process, and
offers their state and a stop over Zenoh. `FleetClient` observes and stops all of them.

`settings` holds the file's settings, `reports` the messages and their decoding, `gateway_state` the
decisions of a gateway: all without I/O. Only `link` uses Zenoh, the extra `fleet`. `gateway`
connects them to robots. A gateway supervises its arms over its own connections: failures of Zenoh,
of a router or of another gateway do not affect the supervision.
"""

from __future__ import annotations

from aioduco.integrations.fleet.client import FleetClient, FleetStop, FleetView
from aioduco.integrations.fleet.gateway import FleetGateway
from aioduco.integrations.fleet.reports import ArmStopped, GatewayReport, StopReport
from aioduco.integrations.fleet.settings import ArmSettings, FleetFileError, FleetSettings

__all__ = [
    "ArmSettings",
    "ArmStopped",
    "FleetClient",
    "FleetFileError",
    "FleetGateway",
    "FleetSettings",
    "FleetStop",
    "FleetView",
    "GatewayReport",
    "StopReport",
]
