"""`aioduco ros1` and `aioduco ros2`: the driver of an arm as a node of ROS."""

from __future__ import annotations

import importlib.util
import logging
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from aioduco.cli.exit_codes import ended_by_errors, fail

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence


#: Python packages that the node of ROS 1 needs; Debian's that have them are named like them
_ROS1 = (
    *("rospy", "actionlib", "genpy", "trajectory_msgs", "sensor_msgs", "tf2_msgs"),
    *("diagnostic_msgs", "std_srvs"),
)
#: Python packages that the node of ROS 2 needs; `ros-base` has all but the last line
_ROS2 = (
    *("rclpy", "lifecycle_msgs", "rcl_interfaces", "builtin_interfaces", "sensor_msgs"),
    *("geometry_msgs", "trajectory_msgs", "std_srvs"),
    *("std_msgs", "diagnostic_msgs", "tf2_msgs", "control_msgs", "aioduco_msgs"),
)

Port: TypeAlias = Annotated[
    int | None, typer.Option(min=1, max=65535, help="Port of the controller. Default: 7003.")
]


def ros1(
    remappings: Annotated[list[str] | None, typer.Argument()] = None,
    host: str = "",
    port: Port = None,
) -> None:
    """Run the driver of one arm as a node of ROS 1, until Ctrl-C. Two arms are two nodes.

    Exit codes: 0 it was ended, by Ctrl-C, too, as launch files expect; 1 no ROS, no master, or no
    controller; 2 wrong options, arguments or parameters. The arm stands then.

    Args:
        remappings: ROS arguments: `_prefix:=left_ __ns:=left joint_states:=/js` …
        host: Address of the controller; or _host:=…
    """
    if missing := _missing(_ROS1):
        fail(
            f"this needs {' and '.join(missing)} of ROS 1: source its setup.bash, or on Debian "
            f"`apt install {' '.join(map(_of_debian, missing))}`, and use that Python "
            "(python3 -m venv --system-site-packages)"
        )
    from aioduco.integrations.ros.ros1.message_classes import install  # noqa: PLC0415 - as below

    install()
    from aioduco.integrations.ros.ros1 import node  # noqa: PLC0415 - it imports what is installed

    _run(node.main, remappings or [], host, port)


def ros2(
    context: typer.Context,
    host: str = "",
    port: Port = None,
) -> None:
    """Run the driver of one arm as a node of ROS 2, until Ctrl-C. Two arms are two nodes.

    ROS's own arguments follow: --ros-args -p prefix:=left_ -r __node:=left_driver …

    Exit codes: 0 it was ended, by Ctrl-C, too, as launch files expect; 1 no ROS, or no controller;
    2 wrong options, arguments or parameters. The arm stands then.

    Args:
        host: Address of the controller; or -p host:=…
    """
    if missing := _missing(_ROS2):
        fail(
            f"this needs {' and '.join(missing)} of ROS 2: source its setup.bash, and that of a "
            "workspace with the packages in integrations/ros2/ built by colcon, and use that "
            "Python (python3 -m venv --system-site-packages)"
        )
    from aioduco.integrations.ros.ros2 import driver_process  # noqa: PLC0415 - it imports what is installed

    _run(driver_process.main, context.args, host, port)


def _missing(packages: Iterable[str]) -> list[str]:
    return [name for name in packages if importlib.util.find_spec(name) is None]


def _of_debian(package: str) -> str:
    return f"python3-{package.replace('_', '-')}"


def _run(
    main: Callable[[Sequence[str], dict[str, Any]], None],
    arguments: Sequence[str],
    host: str,
    port: int | None,
) -> None:
    """Run a node until it ends; its parameters are the options that were given."""
    given: dict[str, Any] = {"host": host} if host else {}
    if port is not None:
        given["port"] = port
    logging.getLogger("aioduco").setLevel(logging.INFO)
    with ended_by_errors():
        main(arguments, given)
