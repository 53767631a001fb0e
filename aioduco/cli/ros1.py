"""`aioduco ros1`: the driver of an arm as a node of ROS 1."""

from __future__ import annotations

import importlib.util
import logging
from typing import Annotated, Any

import typer

from aioduco.cli.output import say

__all__ = ["ros1"]

_NEEDED = {
    "rospy": "python3-rospy",
    "actionlib": "python3-actionlib",
    "genpy": "python3-genpy",
    "trajectory_msgs": "python3-trajectory-msgs",
    "sensor_msgs": "python3-sensor-msgs",
    "tf2_msgs": "python3-tf2-msgs",
    "diagnostic_msgs": "python3-diagnostic-msgs",
    "std_srvs": "python3-std-srvs",
}


def ros1(
    remappings: Annotated[
        list[str] | None,
        typer.Argument(help="ROS arguments: `_prefix:=left_ __ns:=left joint_states:=/js` …"),
    ] = None,
    host: Annotated[str, typer.Option(help="Address of the controller; or _host:=…")] = "",
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the controller. Default: 7003.")
    ] = None,
) -> None:
    """Run the driver of one arm as a node of ROS 1, until Ctrl-C. Two arms are two nodes."""
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        debian = " ".join(_NEEDED[name] for name in missing)
        say(
            f"this needs {' and '.join(missing)} of ROS 1: source its setup.bash, or on Debian "
            f"`apt install {debian}`, and use that Python (python3 -m venv --system-site-packages)",
            error=True,
        )
        raise typer.Exit(1)
    from aioduco.errors import DucoError  # noqa: PLC0415 - for this command alone
    from aioduco.integrations.ros.ros1.message_classes import install  # noqa: PLC0415

    install()
    from aioduco.integrations.ros.ros1 import node  # noqa: PLC0415 - it imports what is installed

    given: dict[str, Any] = {"host": host} if host else {}
    if port is not None:
        given["port"] = port
    logging.getLogger("aioduco").setLevel(logging.INFO)
    try:
        node.main(remappings or [], given)
    except DucoError as error:
        say(str(error), error=True)
        raise typer.Exit(1) from None
