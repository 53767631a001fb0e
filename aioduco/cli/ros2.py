"""`aioduco ros2`: the driver of an arm as a node of ROS 2."""

from __future__ import annotations

import importlib.util
import logging
from typing import Annotated, Any

import typer

from aioduco.cli.output import say

__all__ = ["ros2"]

#: Python packages that the node needs; `ros-base` has all but the last two
_NEEDED = (
    *(
        "rclpy",
        "lifecycle_msgs",
        "rcl_interfaces",
        "builtin_interfaces",
        "sensor_msgs",
        "geometry_msgs",
        "trajectory_msgs",
        "std_srvs",
    ),
    *("std_msgs", "diagnostic_msgs", "tf2_msgs", "control_msgs", "aioduco_msgs"),
)


def ros2(
    context: typer.Context,
    host: Annotated[str, typer.Option(help="Address of the controller; or -p host:=…")] = "",
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="Port of the controller. Default: 7003.")
    ] = None,
) -> None:
    """Run the driver of one arm as a node of ROS 2, until Ctrl-C. Two arms are two nodes.

    ROS's own arguments follow: --ros-args -p prefix:=left_ -r __node:=left_driver …
    """
    missing = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        say(
            f"this needs {' and '.join(missing)} of ROS 2: source its setup.bash, and that of a "
            "workspace with the packages in integrations/ros2/ built by colcon, and use that "
            "Python (python3 -m venv --system-site-packages)",
            error=True,
        )
        raise typer.Exit(1)
    from aioduco.errors import DucoError  # noqa: PLC0415 - for this command alone
    from aioduco.integrations.ros.ros2 import driver_process  # noqa: PLC0415 - it imports what is installed

    given: dict[str, Any] = {"host": host} if host else {}
    if port is not None:
        given["port"] = port
    logging.getLogger("aioduco").setLevel(logging.INFO)
    try:
        driver_process.main(context.args, given)
    except DucoError as error:
        say(str(error), error=True)
        raise typer.Exit(1) from None
