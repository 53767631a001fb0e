"""A fleet of arms over several computers: one view of it, and one stop for it.

A gateway (`aioduco fleet serve fleet.toml`) supervises the arms of its computer in one process, and
offers their state and a stop over Zenoh. `FleetClient` sees and stops all of them.

`settings` is the file, `reports` what is said and how it is read, `gateway_state` what a gateway
decides: all without I/O. `link` alone speaks Zenoh, the extra `fleet`. `gateway` joins them to
robots. An arm is supervised by its gateway's own connections: what happens to Zenoh, to a router or
to another gateway changes nothing about that.
"""

from __future__ import annotations

from aioduco.fleet.client import FleetClient, FleetStop, FleetView
from aioduco.fleet.gateway import FleetGateway
from aioduco.fleet.reports import ArmStopped, GatewayReport, StopReport
from aioduco.fleet.settings import ArmSettings, FleetFileError, FleetSettings

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
