"""MoveIt's files name what the URDF has, with the types that ROS takes."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as ET

import pytest
import yaml

from aioduco import ParameterError
from aioduco.descriptions import STATES, ArmDescription, moveit
from aioduco.integrations.ros.arm_node import NodeSettings
from aioduco.kinematics import arm, models

from .test_urdf import LEFT, RIGHT

JOINTS = [f"joint_{i}" for i in range(1, 7)]


def read(files: dict[str, str]) -> dict[str, Any]:
    return {
        name: yaml.safe_load(text) if name.endswith(".yaml") else ET.fromstring(text)
        for name, text in files.items()
    }


@pytest.mark.parametrize("model", models())
def test_files_name_the_same_joints_links_and_groups(model: str) -> None:
    files = read(moveit(model))
    urdf, srdf = files[f"{model}.urdf"], files[f"{model}.srdf"]
    # MoveIt compares them.
    assert urdf.get("name") == srdf.get("name") == model
    links = {link.get("name") for link in urdf.findall("link")}
    turning = [joint.get("name") for joint in urdf.findall("joint") if joint.get("type") != "fixed"]
    assert turning == JOINTS
    assert list(files["joint_limits.yaml"]["joint_limits"]) == JOINTS
    controllers = files["moveit_controllers.yaml"]["moveit_simple_controller_manager"]
    (controller,) = controllers["controller_names"]
    assert controllers[controller]["joints"] == JOINTS
    assert controllers[controller]["type"] == "FollowJointTrajectory"
    for state in srdf.findall("group_state"):
        assert [joint.get("name") for joint in state] == JOINTS
        found = [float(joint.get("value")) for joint in state]
        assert arm(model).within_limits(found)
        assert found == pytest.approx(list(STATES[state.get("name")]), abs=1e-11)
    groups = {group.get("name") for group in srdf.findall("group")}
    assert groups == {"manipulator", "end_effector"}
    assert set(files["kinematics.yaml"]) == {"manipulator"}
    planning = files["ompl_planning.yaml"]
    assert set(planning["manipulator"]["planner_configs"]) == set(planning["planner_configs"])
    assert planning["manipulator"]["projection_evaluator"] == "joints(joint_1,joint_2)"
    named = {link.get("name") for link in srdf.findall("group/link")}
    for chain in srdf.findall("group/chain"):
        named |= {chain.get("base_link"), chain.get("tip_link")}
    for pair in srdf.findall("disable_collisions"):
        named |= {pair.get("link1"), pair.get("link2")}
    (effector,) = srdf.findall("end_effector")
    assert {effector.get("group"), effector.get("parent_group")} == groups
    assert named | {effector.get("parent_link")} <= links


@pytest.mark.parametrize("model", models())
def test_limits_are_those_of_arm_and_driver_and_no_whole_numbers(model: str) -> None:
    """ROS 2 refuses a whole number where a limit belongs."""
    limits = yaml.safe_load(moveit(model)["joint_limits.yaml"])["joint_limits"]
    known, driver = arm(model), NodeSettings(host="-", model=model).profile
    for i, joint in enumerate(limits.values()):
        assert joint["max_acceleration"] == driver.acceleration
        assert joint["max_velocity"] == known.velocity[i]
        assert (joint["min_position"], joint["max_position"]) == (known.lower[i], known.upper[i])
        for name, value in joint.items():
            assert type(value) is (bool if name.startswith("has_") else float), name


@pytest.mark.slow
def test_two_arms_have_groups_and_controllers_of_their_own() -> None:
    files = read(moveit(LEFT, RIGHT, name="cell"))
    joints = [side + joint for side in ("left_", "right_") for joint in JOINTS]
    assert list(files["joint_limits.yaml"]["joint_limits"]) == joints
    assert set(files["kinematics.yaml"]) == {"left_manipulator", "right_manipulator"}
    controllers = files["moveit_controllers.yaml"]["moveit_simple_controller_manager"]
    assert [
        j for name in controllers["controller_names"] for j in controllers[name]["joints"]
    ] == joints
    chains = files["cell.srdf"].findall("group/chain")
    assert [chain.get("tip_link") for chain in chains] == ["left_tool0", "right_tcp"]
    (effector,) = files["cell.srdf"].findall("group[@name='right_end_effector']")
    assert [link.get("name") for link in effector] == ["right_tool0", "right_tool", "right_tcp"]


def test_pipelines_are_named_as_the_release_of_ros_has_them() -> None:
    humble = yaml.safe_load(moveit("gcr5_910", distro="humble")["ompl_planning.yaml"])
    jazzy = yaml.safe_load(moveit("gcr5_910")["ompl_planning.yaml"])
    assert humble["planning_plugin"] == jazzy["planning_plugins"][0] == "ompl_interface/OMPLPlanner"
    assert isinstance(humble["request_adapters"], str)
    assert isinstance(jazzy["request_adapters"], list)
    with pytest.raises(ParameterError, match='"noetic", "humble" or "jazzy"'):
        moveit("gcr5_910", distro="kinetic")  # type: ignore[arg-type]  # what is tested


def test_files_of_moveit_1_with_names_of_another_package() -> None:
    files = read(moveit("gcr5_910", distro="noetic", group="duco_gcr5", tip="link_6"))
    controllers = files["moveit_controllers.yaml"]["controller_list"]
    assert [each["name"] for each in controllers] == ["joint_trajectory_controller"]
    assert controllers[0]["joints"] == [f"joint_{number}" for number in range(1, 7)]
    planning = files["ompl_planning.yaml"]
    assert "AddTimeParameterization" in planning["request_adapters"]
    assert "RRTConnect" in planning["duco_gcr5"]["planner_configs"]
    assert list(files["kinematics.yaml"]) == ["duco_gcr5"]
    chain = files["gcr5_910.srdf"].find("group[@name='duco_gcr5']/chain")
    assert chain.get("tip_link") == "link_6"
    for tip in list[Any](["link_9", 9, ["link_6"]]):
        with pytest.raises(ParameterError, match="link_6"):
            moveit("gcr5_910", tip=tip)
    with pytest.raises(ParameterError, match="group"):
        moveit("gcr5_910", group="a b")


@pytest.mark.parametrize(("prefix", "group"), [("", "on"), ("", "Null"), ("y", "es"), ("n", "o")])
def test_a_group_is_called_as_it_is_even_if_yaml_takes_the_word_for_something_else(
    prefix: str, group: str
) -> None:
    texts = moveit(ArmDescription("gcr5_910", prefix=prefix), group=group)
    assert list(yaml.safe_load(texts["kinematics.yaml"])) == [prefix + group]
    assert prefix + group in yaml.safe_load(texts["ompl_planning.yaml"])
