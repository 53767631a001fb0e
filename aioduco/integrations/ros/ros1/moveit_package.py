"""A package of MoveIt 1 as texts: its configuration, launch files, and a view. Needs no ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from aioduco.descriptions import ArmDescription, moveit
from aioduco.integrations.ros.ros1.launch_package import CMAKE, PACKAGE, rviz_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.descriptions import ArmLike

__all__ = ["moveit_package"]

_CONFIG = "$(dirname)/../config/"
_NEEDED = (
    *("moveit_ros_move_group", "moveit_planners_ompl", "moveit_kinematics"),
    *("moveit_simple_controller_manager", "moveit_ros_visualization"),
)
_PLANNING = """\
    - Class: moveit_rviz_plugin/MotionPlanning
      Name: MotionPlanning
      Enabled: true
      Move Group Namespace: ""
      Robot Description: robot_description
      Planning Scene Topic: move_group/monitored_planning_scene
      Planned Path:
        Trajectory Topic: move_group/display_planned_path
      Planning Request:
        Planning Group: {group}
        Query Goal State: true
"""
#: the button "next", if rviz_visual_tools is installed
_NEXT = """\
  - Class: rviz_visual_tools/RvizVisualToolsGui
    Name: RvizVisualToolsGui
"""


def moveit_package(
    *arms: ArmLike, name: str, group: str, tip: str, **meshes: Any
) -> dict[str, str]:
    """Make the files of a package called `<name>_moveit_config`, by their paths.

    It needs the package `<name>_bringup` of `launch_package`, which starts the driver.

    Args:
        arms: models, or descriptions of arms in one world.
        name: name of the robot in its URDF.
        group: name of the group of an arm's joints, after its prefix.
        tip: link at which the group ends, after the prefix; empty: the tool's tip or the flange.
        meshes: `meshes` and `mesh_uri`, as of `aioduco.descriptions.urdf`.

    Raises:
        ParameterError: as for `aioduco.descriptions.moveit`.
    """
    described = [arm if isinstance(arm, ArmDescription) else ArmDescription(arm) for arm in arms]
    package = f"{name}_moveit_config"
    config = moveit(*arms, name=name, distro="noetic", group=group, tip=tip, **meshes)
    packages = (*_NEEDED, f"{name}_bringup")
    needed = "\n".join(f"  <exec_depend>{each}</exec_depend>" for each in packages)
    display = _PLANNING.format(group=described[0].prefix + group)
    files = {
        "package.xml": PACKAGE.format(
            package=package, description=f"Plans motions of {name} by MoveIt.", needed=needed
        ),
        "CMakeLists.txt": CMAKE.format(package=package),
        "launch/moveit_planning_execution.launch": _execution(described, name),
        "launch/planning_context.launch": _context(name),
        "launch/move_group.launch": _move_group(),
        "launch/moveit_rviz.launch": _rviz(),
        "rviz/moveit.rviz": rviz_text(described, display, _NEXT),
        **{f"config/{path}": text for path, text in config.items()},
    }
    return {f"{package}/{path}": text for path, text in files.items()}


def _text(root: ET.Element) -> str:
    ET.indent(root)
    return f'<?xml version="1.0"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _execution(arms: Sequence[ArmDescription], name: str) -> str:
    """All of it: the driver or a simulated arm, move_group, and RViz."""
    root = ET.Element("launch")
    address = "controller; without one an arm is simulated"
    given = [
        *((f"{arm.prefix}robot_ip", "", address) for arm in arms),
        ("through", "auto", "how set-points are sent: realtime, servoj, auto"),
        ("guard", "", "process: a process that stops the arm when its driver dies"),
        ("simulator_port", "7003", "of the first simulated arm"),
    ]
    for arg, default, doc in (*given, ("rviz", "true", "whether to start RViz")):
        ET.SubElement(root, "arg", name=arg, default=default, doc=doc)
    driver = ET.SubElement(root, "include", file=f"$(find {name}_bringup)/launch/arm.launch")
    for arg, _, _ in given:
        ET.SubElement(driver, "arg", name=arg, value=f"$(arg {arg})")
    ET.SubElement(driver, "arg", name="rviz", value="false")
    ET.SubElement(root, "include", file="$(dirname)/move_group.launch")
    ET.SubElement(root, "include", {"if": "$(arg rviz)"}, file="$(dirname)/moveit_rviz.launch")
    return _text(root)


def _context(name: str) -> str:
    """What move_group and RViz know of the robot; the URDF comes with the driver."""
    root = ET.Element("launch")
    doc = "whether to load the URDF; the driver's launch file does"
    ET.SubElement(root, "arg", name="load_robot_description", default="false", doc=doc)
    ET.SubElement(
        root,
        "param",
        {"if": "$(arg load_robot_description)"},
        name="robot_description",
        textfile=f"{_CONFIG}{name}.urdf",
    )
    ET.SubElement(
        root, "param", name="robot_description_semantic", textfile=f"{_CONFIG}{name}.srdf"
    )
    for space, file in (("planning", "joint_limits"), ("kinematics", "kinematics")):
        group = ET.SubElement(root, "group", ns=f"robot_description_{space}")
        ET.SubElement(group, "rosparam", command="load", file=f"{_CONFIG}{file}.yaml")
    return _text(root)


def _move_group() -> str:
    """move_group with OMPL and the driver's action."""
    root = ET.Element("launch")
    ET.SubElement(root, "include", file="$(dirname)/planning_context.launch")
    node = ET.SubElement(
        root,
        "node",
        name="move_group",
        pkg="moveit_ros_move_group",
        type="move_group",
        output="screen",
        respawn="false",
    )
    for name in ("allow_trajectory_execution", "moveit_manage_controllers"):
        ET.SubElement(node, "param", name=name, type="bool", value="true")
    for name in (
        *("publish_planning_scene", "publish_geometry_updates"),
        *("publish_state_updates", "publish_transforms_updates"),
    ):
        full = f"planning_scene_monitor/{name}"
        ET.SubElement(node, "param", name=full, type="bool", value="true")
    # Noetic's move_group reads pipelines by their names, Melodic's reads one from its namespace.
    ET.SubElement(node, "param", name="default_planning_pipeline", value="ompl")
    planning = {"command": "load", "file": f"{_CONFIG}ompl_planning.yaml"}
    ET.SubElement(node, "rosparam", planning)
    ET.SubElement(node, "rosparam", planning, ns="planning_pipelines/ompl")
    ET.SubElement(node, "rosparam", command="load", file=f"{_CONFIG}moveit_controllers.yaml")
    return _text(root)


def _rviz() -> str:
    """RViz with the display of motion planning."""
    root = ET.Element("launch")
    node = ET.SubElement(
        root,
        "node",
        name="moveit_rviz",
        pkg="rviz",
        type="rviz",
        args="-d $(dirname)/../rviz/moveit.rviz",
    )
    kinematics = f"{_CONFIG}kinematics.yaml"
    ET.SubElement(node, "rosparam", command="load", file=kinematics)
    return _text(root)
