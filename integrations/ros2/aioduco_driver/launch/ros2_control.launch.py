"""The driver of one arm under ros2_control, through topics of commands and states.

ros2 launch aioduco_driver ros2_control.launch.py host:=192.168.1.10

It needs ros2_control, ros2_controllers, and joint_state_topic_hardware_interface or, by its former
name, topic_based_ros2_control. The driver holds the arm for joint commands all the time and has no
action of its own: goals are for the controller's.
"""

from __future__ import annotations

from xml.etree import ElementTree

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from aioduco.descriptions import urdf

ARGUMENTS = {
    "host": ("127.0.0.1", "address of the controller"),
    "port": ("7003", "its port"),
    "model": ("gcr5_910", "the arm"),
}
#: the plug-in by its package; the newer first
PLUGINS = {
    "joint_state_topic_hardware_interface": "JointStateTopicSystem",
    "topic_based_ros2_control": "TopicBasedSystem",
}
STATES, COMMANDS = "/arm_joint_states", "/joint_commands"


def generate_launch_description() -> LaunchDescription:
    """Say what is to be started."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def start(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Start driver, controller manager and controllers."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    package = next((each for each in PLUGINS if installed(each)), next(iter(PLUGINS)))
    plugin = f"{package}/{PLUGINS[package]}"
    robot = {"robot_description": description(given["model"], plugin)}
    controllers = PathJoinSubstitution(
        [FindPackageShare("aioduco_driver"), "config", "ros2_control.yaml"]
    )
    return [
        Node(
            package="aioduco_driver",
            executable="driver",
            name="duco",
            parameters=[{**given, "port": int(given["port"]), "hold_commands": True}],
            remappings=[("joint_states", STATES)],  # the broadcaster publishes joint_states
            output="screen",
        ),
        Node(
            package="robot_state_publisher",
            executable="robot_state_publisher",
            parameters=[robot],
        ),
        Node(
            package="controller_manager",
            executable="ros2_control_node",
            parameters=[robot, controllers],
            remappings=[("~/robot_description", "/robot_description")],
            output="screen",
        ),
        *(
            Node(package="controller_manager", executable="spawner", arguments=[name])
            for name in ("joint_state_broadcaster", "joint_trajectory_controller")
        ),
    ]


def installed(package: str) -> bool:
    """Whether a package of ROS is installed."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True


def description(model: str, plugin: str) -> str:
    """The arm's URDF with its hardware for ros2_control."""
    robot = ElementTree.fromstring(urdf(model))
    names = [each.get("name", "") for each in robot.iter("joint") if each.get("type") == "revolute"]
    system = ElementTree.SubElement(robot, "ros2_control", name="duco", type="system")
    hardware = ElementTree.SubElement(system, "hardware")
    ElementTree.SubElement(hardware, "plugin").text = plugin
    for name, value in (("joint_commands_topic", COMMANDS), ("joint_states_topic", STATES)):
        ElementTree.SubElement(hardware, "param", name=name).text = value
    for name in names:
        joint = ElementTree.SubElement(system, "joint", name=name)
        ElementTree.SubElement(joint, "command_interface", name="position")
        for kind in ("position", "velocity"):
            ElementTree.SubElement(joint, "state_interface", name=kind)
    return ElementTree.tostring(robot, encoding="unicode")
