"""A package of ROS 1 as texts: launch file, RViz's configuration, URDF. No I/O; needs no ROS."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from aioduco.descriptions import ArmDescription, urdf

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.descriptions import ArmLike

__all__ = ["CMAKE", "PACKAGE", "launch_package", "rviz_text"]

_PORT = 7003  # port of a controller
PACKAGE = """\
<?xml version="1.0"?>
<package format="2">
  <name>{package}</name>
  <version>1.0.0</version>
  <description>{description}</description>
  <maintainer email="nobody@example.com">written by aioduco export ros1</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>catkin</buildtool_depend>
{needed}
</package>
"""
CMAKE = """\
cmake_minimum_required(VERSION 3.0.2)
project({package})
find_package(catkin REQUIRED)
catkin_package()
"""
_DRIVER = """\
#!/bin/sh
exec {command} ros1 "$@"
"""
_SIMULATOR = """\
#!/bin/sh
# roslaunch adds remappings, which the simulator does not know.
for each do
  shift
  case $each in
    *:=*) ;;
    *) set -- "$@" "$each" ;;
  esac
done
exec {command} sim "$@"
"""


def launch_package(*arms: ArmLike, name: str, command: str, **meshes: Any) -> dict[str, str]:
    """Make the files of a package called `<name>_bringup`, by their paths.

    Args:
        arms: models, or descriptions of arms in one world.
        name: name of the robot in its URDF.
        command: path of `aioduco`, in the environment that also has rospy.
        meshes: `meshes` and `mesh_uri`, as of `aioduco.descriptions.urdf`.
    """
    described = [arm if isinstance(arm, ArmDescription) else ArmDescription(arm) for arm in arms]
    package = f"{name}_bringup"
    files = {
        "package.xml": PACKAGE.format(
            package=package,
            description=f"Starts the driver of {name}, its description, and RViz.",
            needed="  <exec_depend>robot_state_publisher</exec_depend>",
        ),
        "CMakeLists.txt": CMAKE.format(package=package),
        "launch/arm.launch": _launch(described, name, package),
        "rviz/arm.rviz": rviz_text(described),
        f"urdf/{name}.urdf": urdf(*arms, name=name, **meshes),
        "scripts/driver": _DRIVER.format(command=shlex.quote(command)),
        "scripts/simulator": _SIMULATOR.format(command=shlex.quote(command)),
    }
    return {f"{package}/{path}": text for path, text in files.items()}


def _root(arms: Sequence[ArmDescription]) -> str:
    """The fixed frame of the display."""
    return "world" if arms[0].mounting is not None else arms[0].prefix + "base_link"


def _launch(arms: Sequence[ArmDescription], name: str, package: str) -> str:
    """The launch file: one driver for each arm, and a simulator for each that has no address."""
    root = ET.Element("launch")
    for arm in arms:
        ET.SubElement(
            root,
            "arg",
            name=f"{arm.prefix}robot_ip",
            default="",
            doc="address of the controller; without one a simulated arm is started",
        )
    for arg, default, doc in (
        ("through", "auto", "how set-points are sent: realtime, servoj, auto"),
        ("guard", "", "process: a process that stops the arm when its driver dies"),
        ("rviz", "true", "whether to start RViz; where it is not installed, roslaunch says so"),
        ("simulator_port", str(_PORT), "of the first simulated arm; each other has the next"),
        ("respawn_delay", "3", "seconds until a driver that ended is started again"),
    ):
        ET.SubElement(root, "arg", name=arg, default=default, doc=doc)
    ET.SubElement(
        root, "param", name="robot_description", textfile=f"$(dirname)/../urdf/{name}.urdf"
    )
    for number, arm in enumerate(arms):
        _add_arm(root, arm, package, f"arg('simulator_port') + {number}")
    ET.SubElement(
        root,
        "node",
        name="robot_state_publisher",
        pkg="robot_state_publisher",
        type="robot_state_publisher",
    )
    ET.SubElement(
        root,
        "node",
        {"if": "$(arg rviz)"},
        name="rviz",
        pkg="rviz",
        type="rviz",
        args="-d $(dirname)/../rviz/arm.rviz",
    )
    ET.indent(root)
    return f'<?xml version="1.0"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _add_arm(root: ET.Element, arm: ArmDescription, package: str, port: str) -> None:
    model = arm.arm.name
    given = f"{arm.prefix}robot_ip"
    ET.SubElement(
        root,
        "node",
        {"if": f"$(eval arg('{given}') == '')"},
        name=f"{arm.prefix}simulator",
        pkg=package,
        type="simulator",
        args=f"$(eval '--model {model} --port ' + str({port}))",
        required="true",
    )
    node = ET.SubElement(
        root,
        "node",
        name=f"{arm.prefix}duco",
        pkg=package,
        type="driver",
        output="screen",
        # A controller, or its simulator, may start later than the driver.
        respawn="true",
        respawn_delay="$(arg respawn_delay)",
    )
    address = {"name": "host", "value": f"$(eval arg('{given}') or '127.0.0.1')"}
    ET.SubElement(node, "param", address)
    # All controllers have the same port; simulators on one computer have different ports.
    chosen = f"$(eval {_PORT} if arg('{given}') else {port})"
    ET.SubElement(node, "param", name="port", type="int", value=chosen)
    ET.SubElement(node, "param", name="model", value=model)
    ET.SubElement(node, "param", name="prefix", type="str", value=arm.prefix)
    ET.SubElement(node, "param", name="through", value="$(arg through)")
    ET.SubElement(node, "param", name="guard", type="str", value="$(arg guard)")


def rviz_text(arms: Sequence[ArmDescription], displays: str = "", panels: str = "") -> str:
    """RViz: the arms, the frames, and a grid.

    Args:
        arms: the arms, in one world.
        displays: further displays.
        panels: further panels.
    """
    return f"""\
Panels:
  - Class: rviz/Displays
    Name: Displays
  - Class: rviz/Views
    Name: Views
{panels}Visualization Manager:
  Class: ""
  Displays:
    - Class: rviz/Grid
      Name: Grid
      Enabled: true
      Cell Size: 0.1
      Plane Cell Count: 20
    - Class: rviz/RobotModel
      Name: Arm
      Enabled: true
      Robot Description: robot_description
      Visual Enabled: true
      Collision Enabled: false
    - Class: rviz/TF
      Name: Frames
      Enabled: false
      Show Names: true
      Marker Scale: 0.3
{displays}  Enabled: true
  Global Options:
    Background Color: 48; 48; 48
    Fixed Frame: {_root(arms)}
    Frame Rate: 30
  Name: root
  Tools:
    - Class: rviz/Interact
    - Class: rviz/MoveCamera
    - Class: rviz/FocusCamera
  Value: true
  Views:
    Current:
      Class: rviz/Orbit
      Name: Current View
      Distance: 2.5
      Focal Point:
        X: 0
        Y: 0
        Z: 0.4
      Pitch: 0.4
      Yaw: 0.8
      Target Frame: <Fixed Frame>
Window Geometry:
  Width: 1200
  Height: 800
"""
