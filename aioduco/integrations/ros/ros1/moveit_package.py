"""A package of MoveIt 1 as texts: its configuration, launch files, and a view. Needs no ROS.

move_group's launch file loads the planners twice: Noetic reads pipelines by their names, Melodic
reads one from its own namespace. The view has the button "next", if rviz_visual_tools is installed.
"""

from __future__ import annotations

from typing import Any

from aioduco.descriptions import ArmDescription, ArmLike, moveit
from aioduco.integrations.ros.ros1.launch_package import filled, package_files, rviz_text

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
