"""Two arms in one world: a driver for each, and one description of both.

ros2 launch aioduco_driver two_arms.launch.py sim:=true
ros2 launch aioduco_driver two_arms.launch.py left_host:=192.168.1.10 right_host:=192.168.1.11
"""

from __future__ import annotations

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from aioduco.descriptions import ArmDescription, urdf

ARGUMENTS = {
    "model": ("gcr5_910", "the arms"),
    "left_host": ("127.0.0.1", "address of the left controller"),
    "right_host": ("127.0.0.1", "address of the right controller"),
    "left_port": ("7003", "its port"),
    "right_port": ("", "its port; empty: 7003, or 7103 if simulated"),
    "distance": ("0.8", "between the bases [m]"),
    "sim": ("false", "whether to start simulated arms"),
}


def generate_launch_description() -> LaunchDescription:
    """Say what is to be started."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Start a driver for each arm, and the description of both."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    given["right_port"] = given["right_port"] or ("7103" if given["sim"] == "true" else "7003")
    one = PathJoinSubstitution([FindPackageShare("aioduco_driver"), "launch", "arm.launch.py"])
    started: list[LaunchDescriptionEntity] = [
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(one),
            launch_arguments={
                "host": given[f"{side}_host"],
                "port": given[f"{side}_port"],
                "model": given["model"],
                "prefix": f"{side}_",
                "name": f"{side}_driver",
                "sim": given["sim"],
                "rviz": "true" if side == "left" else "false",
                "description": "false",
            }.items(),
        )
        for side in ("left", "right")
    ]
    text = description(given["model"], float(given["distance"]))
    started.append(
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            parameters=[{"robot_description": text}],
        )
    )
    return started


def description(model: str, distance: float) -> str:
    """The URDF of both arms, side by side."""
    sides = {"left_": distance / 2, "right_": -distance / 2}
    return urdf(
        *(
            ArmDescription(model, prefix=prefix, mounting=(0, y, 0, 0, 0, 0))
            for prefix, y in sides.items()
        ),
        name="two_arms",
    )
