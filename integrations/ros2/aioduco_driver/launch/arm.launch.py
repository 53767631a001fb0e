"""The driver of one arm, its description, and RViz where it is installed.

ros2 launch aioduco_driver arm.launch.py sim:=true               a simulated arm
ros2 launch aioduco_driver arm.launch.py host:=192.168.1.10      a real one: keep clear of it
"""

from __future__ import annotations

import sys

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from aioduco.descriptions import ArmDescription, urdf

ARGUMENTS = {
    "host": ("127.0.0.1", "address of the controller"),
    "port": ("7003", "its port"),
    "model": ("gcr5_910", "the arm"),
    "prefix": ("", "before the names of joints, links and controllers"),
    "name": ("duco", "of the node"),
    "sim": ("false", "whether to start a simulated arm on that port"),
    "rviz": ("true", "whether to start RViz, where it is installed"),
    "description": ("true", "whether to publish the arm's description"),
    "autostart": ("true", "whether to configure and activate the driver"),
    "parameters": ("", "file of parameters; empty: that of this package"),
}


def generate_launch_description() -> LaunchDescription:
    """Say what is to be started."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Start what was asked for."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    share = FindPackageShare("aioduco_driver")
    started: list[LaunchDescriptionEntity] = []
    if given["sim"] == "true":
        words = ["sim", "--model", given["model"], "--port", given["port"]]
        started.append(ExecuteProcess(cmd=[sys.executable, "-m", "aioduco.cli", *words]))
    started.append(
        Node(
            package="aioduco_driver",
            executable="driver",
            name=given["name"],
            parameters=[
                given["parameters"] or PathJoinSubstitution([share, "config", "arm.yaml"]),
                {
                    "host": given["host"],
                    "port": int(given["port"]),
                    "model": given["model"],
                    "prefix": given["prefix"],
                    "autostart": given["autostart"] == "true",
                },
            ],
            output="screen",
            # A controller that is not there yet, or a simulator that is still starting.
            respawn=True,
            respawn_delay=2.0,
        )
    )
    if given["description"] == "true":
        text = description(given["model"], given["prefix"])
        started.append(
            Node(
                package="robot_state_publisher",
                executable="robot_state_publisher",
                parameters=[{"robot_description": text}],
            )
        )
    if given["rviz"] == "true" and installed("rviz2"):
        view = PathJoinSubstitution([share, "rviz", "arm.rviz"])
        started.append(Node(package="rviz2", executable="rviz2", arguments=["-d", view]))
    return started


def description(model: str, prefix: str) -> str:
    """The arm's URDF."""
    return urdf(ArmDescription(model, prefix=prefix))


def installed(package: str) -> bool:
    """Whether a package of ROS is installed."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True
