"""Packages of ROS 1 as texts: of the driver, and of MoveIt 1. Needs no ROS.

The texts are in the folder `package`, with @ before what is filled in. The driver is started again
when it ends: a controller, or its simulator, may start later. All controllers have the same port;
simulators on one computer have different ones.

move_group's launch file loads the planners twice: Noetic reads pipelines by their names, Melodic
reads one from its own namespace. The view has the button "next", if rviz_visual_tools is installed.
"""

from __future__ import annotations

import shlex
from importlib import resources
from string import Template
from typing import TYPE_CHECKING, Any

from aioduco.descriptions import ArmDescription, ArmLike, moveit, urdf

if TYPE_CHECKING:
    from collections.abc import Sequence


class _Text(Template):
    delimiter = "@"


def filled(file: str, /, **values: object) -> str:
    """A text of the folder `package`, filled in.

    Args:
        file: name of its file.
        values: what is filled in, by the words after @.
    """
    folder = resources.files("aioduco.integrations.ros.ros1") / "package"
    return _Text((folder / file).read_text("utf-8")).substitute(values)


def package_files(package: str, description: str, needed: Sequence[str]) -> dict[str, str]:
    """The files that every package has.

    Args:
        package: its name.
        description: what it does.
        needed: packages that it needs.
    """
    lines = "\n".join(f"  <exec_depend>{each}</exec_depend>" for each in needed)
    return {
        "package.xml": filled(
            "package.xml", package=package, description=description, needed=lines
        ),
        "CMakeLists.txt": filled("CMakeLists.txt", package=package),
    }


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
    nodes = "".join(
        filled("arm_nodes.launch", package=package, prefix=arm.prefix, model=arm.arm.name, number=n)
        for n, arm in enumerate(described)
    )
    arguments = "".join(filled("arm_argument.launch", prefix=arm.prefix) for arm in described)
    own = shlex.quote(command)
    files = {
        **package_files(
            package,
            f"Starts the driver of {name}, its description, and RViz.",
            ["robot_state_publisher"],
        ),
        "launch/arm.launch": filled("arm.launch", name=name, arguments=arguments, nodes=nodes),
        "rviz/arm.rviz": rviz_text(described),
        f"urdf/{name}.urdf": urdf(*arms, name=name, **meshes),
        "scripts/driver": filled("driver", command=own),
        "scripts/simulator": filled("simulator", command=own),
    }
    return {f"{package}/{path}": text for path, text in files.items()}


def _root(arms: Sequence[ArmDescription]) -> str:
    """The fixed frame of the display."""
    return "world" if arms[0].mounting is not None else arms[0].prefix + "base_link"


def rviz_text(arms: Sequence[ArmDescription], displays: str = "", panels: str = "") -> str:
    """RViz: the arms, the frames, and a grid.

    Args:
        arms: the arms, in one world.
        displays: further displays.
        panels: further panels.
    """
    return filled("arm.rviz", root=_root(arms), displays=displays, panels=panels)


_NEEDED = (
    *("moveit_ros_move_group", "moveit_planners_ompl", "moveit_kinematics"),
    *("moveit_simple_controller_manager", "moveit_ros_visualization"),
)


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
    arguments, passed = (
        "".join(filled(file, prefix=arm.prefix) for arm in described)
        for file in ("moveit_argument.launch", "passed_argument.launch")
    )
    display = filled("motion_planning.rviz", group=described[0].prefix + group)
    files = {
        **package_files(
            package, f"Plans motions of {name} by MoveIt.", [*_NEEDED, f"{name}_bringup"]
        ),
        "launch/moveit_planning_execution.launch": filled(
            "moveit_planning_execution.launch", name=name, arguments=arguments, passed=passed
        ),
        "launch/planning_context.launch": filled("planning_context.launch", name=name),
        "launch/move_group.launch": filled("move_group.launch"),
        "launch/moveit_rviz.launch": filled("moveit_rviz.launch"),
        "rviz/moveit.rviz": rviz_text(described, display, filled("next_button.rviz")),
        **{f"config/{path}": text for path, text in config.items()},
    }
    return {f"{package}/{path}": text for path, text in files.items()}
