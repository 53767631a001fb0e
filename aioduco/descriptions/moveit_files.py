"""MoveIt's configuration: URDF, SRDF, and files of parameters."""

from __future__ import annotations

import json
import math
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from aioduco.descriptions.srdf_text import srdf_text
from aioduco.descriptions.urdf_text import urdf_text

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from aioduco.descriptions.tree import ArmTree


RosDistro: TypeAlias = Literal["noetic", "humble", "jazzy"]
"""Release of ROS: noetic has MoveIt 1, and Melodic takes its files, too; the others name the steps
of a planning pipeline differently."""

_SEGMENT = 0.005  # fraction of the joint space's extent that is checked as one point

#: acceleration of plans at most [rad/s²]: the ROS drivers' default, with which they follow goals.
#: They would round the corners of a plan with more of it, by more than their path tolerance
_ACCELERATION = 10.0

#: words that YAML 1.1 takes for truth values, and for nothing
_NO_TEXTS = frozenset({"y", "yes", "n", "no", "true", "false", "on", "off", "null"})


def moveit_files(
    name: str,
    trees: Sequence[ArmTree],
    meshes: Mapping[str, Mapping[str, str]],
    distro: RosDistro,
    *,
    group: str,
    tip: str,
) -> dict[str, str]:
    """Return the texts of the files by their names.

    Args:
        name: name of the robot, as in URDF and SRDF.
        trees: the arms.
        meshes: URIs of meshes, as for the URDF.
        distro: release of ROS.
        group: name of the group of an arm's joints, after its prefix.
        tip: link at which the group ends, after the prefix; empty: the tool's tip or the flange.
    """
    controllers = _controllers(trees)
    if distro == "noetic":
        listed = controllers["moveit_simple_controller_manager"]
        names = listed["controller_names"]
        manager = {"controller_list": [{"name": each, **listed[each]} for each in names]}
        controllers = {
            "moveit_controller_manager": controllers["moveit_controller_manager"],
            "trajectory_execution": controllers["trajectory_execution"],
            **manager,
        }
    return {
        f"{name}.urdf": urdf_text(name, trees, meshes),
        f"{name}.srdf": srdf_text(name, trees, group_name=group, tip=tip),
        "kinematics.yaml": _yaml(
            {tree.arm.prefix + group: _fixed()["kinematics"] for tree in trees}
        ),
        "joint_limits.yaml": _yaml(_joint_limits(trees)),
        "ompl_planning.yaml": _yaml(_planning(trees, distro, group)),
        "moveit_controllers.yaml": _yaml(controllers),
    }


def _joint_limits(trees: Sequence[ArmTree]) -> dict[str, Any]:
    return {
        "default_velocity_scaling_factor": 0.1,
        "default_acceleration_scaling_factor": 0.1,
        "joint_limits": {
            joint.name: {
                "has_position_limits": True,
                "min_position": float(limits.lower),
                "max_position": float(limits.upper),
                "has_velocity_limits": True,
                "max_velocity": float(limits.velocity),
                "has_acceleration_limits": True,
                "max_acceleration": float(least),
                "has_jerk_limits": False,
            }
            for tree in trees
            for least in [min(_ACCELERATION, *(limit.acceleration for _, limit in tree.turning))]
            for joint, limits in tree.turning
        },
    }


@cache
def _fixed() -> dict[str, Any]:
    """What is the same for every arm: solver, planners, the pipeline of each release, limits."""
    text = resources.files("aioduco.descriptions").joinpath("moveit.json").read_text("utf-8")
    return dict(json.loads(text))


def _planning(trees: Sequence[ArmTree], distro: RosDistro, group: str) -> dict[str, Any]:
    planners = _fixed()["planners"]
    pipeline = {**_fixed()["pipelines"][distro], "planner_configs": planners}
    for tree in trees:
        first, second = (joint.name for joint, _ in tree.turning[:2])
        pipeline[tree.arm.prefix + group] = {
            "default_planner_config": "RRTConnect",
            "planner_configs": list(planners),
            "projection_evaluator": f"joints({first},{second})",
            "longest_valid_segment_fraction": _SEGMENT,
        }
    return pipeline


def _controllers(trees: Sequence[ArmTree]) -> dict[str, Any]:
    names = [tree.arm.prefix + "joint_trajectory_controller" for tree in trees]
    controllers = {
        name: {
            "action_ns": "follow_joint_trajectory",
            "type": "FollowJointTrajectory",
            "default": True,
            "joints": [joint.name for joint, _ in tree.turning],
        }
        for name, tree in zip(names, trees, strict=True)
    }
    return {
        "moveit_controller_manager": (
            "moveit_simple_controller_manager/MoveItSimpleControllerManager"
        ),
        "moveit_simple_controller_manager": {"controller_names": names, **controllers},
        # the driver ends goals that are late, and the global speed stretches them
        "trajectory_execution": _fixed()["trajectory_execution"],
    }


def _yaml(values: Mapping[str, Any], indent: str = "") -> str:
    """Write nested mappings, lists of words, and scalars. ROS distinguishes 1.0 from 1."""
    lines = []
    for name, value in values.items():
        key = _scalar(name)
        if isinstance(value, dict):
            lines.append(f"{indent}{key}:\n{_yaml(value, indent + '  ')}")
        elif isinstance(value, list):
            items = "".join(f"{indent}  - {_item(item, indent + '    ')}\n" for item in value)
            lines.append(f"{indent}{key}:\n{items}")
        else:
            lines.append(f"{indent}{key}: {_scalar(value)}\n")
    return "".join(lines)


def _item(value: Any, indent: str) -> str:
    """Write an element of a list: a word, or a mapping."""
    return _yaml(value, indent).strip() if isinstance(value, dict) else _scalar(value)


def _scalar(value: Any) -> str:
    """Write a scalar of YAML 1.1, in which a number has a point before its exponent."""
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, float):
        # a group may be called "on", which is true without quotes
        return f'"{value}"' if str(value).lower() in _NO_TEXTS else str(value)
    if not math.isfinite(value):
        return f"{value}".replace("inf", ".inf").replace("nan", ".nan")
    text = repr(float(value))
    return text if "." in text else text.replace("e", ".0e")
