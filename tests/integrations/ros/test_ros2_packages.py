"""The packages of ROS 2, without ROS: their files agree with the driver and with one another."""

from __future__ import annotations

import ast
import re
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import MagicMock
from xml.etree import ElementTree

import pytest
import yaml
from for_each import for_each

import aioduco
from aioduco.cli.ros import _ROS2
from aioduco.integrations.ros.node_parameters import parameter_defaults
from aioduco.integrations.ros.ros1.message_classes import MESSAGES, SERVICES

ROOT = Path(__file__).parents[3]
PACKAGES = ROOT / "integrations" / "ros2"
CHOSEN = {"host": "127.0.0.1", "port": "7003", "model": "gcr5_910"}
SHELL = Path(aioduco.__file__).parent / "integrations" / "ros" / "ros2"


def fields(text: str) -> list[str]:
    """The lines of a definition that say something."""
    lines = (line.partition("#")[0].strip() for line in text.splitlines())
    return [re.sub(r"^Header ", "std_msgs/Header ", line) for line in lines if line]


def test_messages_are_those_of_ros_1() -> None:
    ours = {**MESSAGES, **SERVICES}
    found = {
        path.stem: fields(path.read_text())
        for path in (PACKAGES / "aioduco_msgs").rglob("*.*")
        if path.suffix in (".msg", ".srv")
    }
    wanted = {
        name.partition("/")[2]: fields(text)
        for name, text in ours.items()
        if name.startswith("aioduco_msgs/")
    }
    assert found == wanted
    built = (PACKAGES / "aioduco_msgs" / "CMakeLists.txt").read_text()
    assert set(re.findall(r"(?:msg|srv)/(\w+)\.", built)) == found.keys()


def test_parameters_are_listed_with_their_defaults() -> None:
    path = PACKAGES / "aioduco_driver" / "config" / "arm.yaml"
    listed = yaml.safe_load(path.read_text())["/**"]["ros__parameters"]
    assert (listed.pop("autostart"), listed.pop("watch_clients")) == (True, True)
    defaults = parameter_defaults()
    assert defaults.pop("joint_names") == ()  # an empty list has no kind in ROS
    assert listed == defaults
    page = (ROOT / "docs" / "ros2.md").read_text() + (ROOT / "docs" / "ros.md").read_text()
    assert [name for name in defaults if f"`{name}`" not in page] == []


def test_packages_name_what_the_driver_imports() -> None:
    imported = {
        name.partition(".")[0]
        for folder in (SHELL.parent, SHELL)
        for path in folder.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, (ast.Import, ast.ImportFrom))
        for name in ([node.module or ""] if isinstance(node, ast.ImportFrom) else [""])
    }
    messages = {name for name in imported if name.endswith(("_msgs", "_srvs", "rclpy"))}
    named = {
        each.text for each in ElementTree.parse(PACKAGES / "aioduco_driver" / "package.xml").iter()
    }
    assert messages
    assert messages <= named
    assert messages <= {*_ROS2}


def test_no_message_waits_for_the_log_of_ros() -> None:
    """It may block: all go by the bounded queue and the thread of `BackgroundLogger`."""
    texts = {path.name: path.read_text() for path in SHELL.parent.rglob("*.py")}
    assert [name for name, text in texts.items() if "getLogger(__name__)" in text] == []


@for_each("package", ["aioduco_driver", "aioduco_msgs"])
def test_each_package_has_its_name(package: str) -> None:
    root = ElementTree.parse(PACKAGES / package / "package.xml").getroot()
    assert root.findtext("name") == package
    assert root.findtext("license") == "Apache-2.0"


@pytest.mark.parametrize(
    ("installed", "plugin"),
    [
        (set(), "joint_state_topic_hardware_interface/JointStateTopicSystem"),
        ({"topic_based_ros2_control"}, "topic_based_ros2_control/TopicBasedSystem"),
        (
            {"topic_based_ros2_control", "joint_state_topic_hardware_interface"},
            "joint_state_topic_hardware_interface/JointStateTopicSystem",
        ),
    ],
)
def test_ros2_control_has_the_plugin_that_is_installed(
    installed: set[str], plugin: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("launch", "launch_ros", "ament_index_python"):
        for part in ("", ".actions", ".packages", ".substitutions"):
            monkeypatch.setitem(sys.modules, name + part, MagicMock())
    code = runpy.run_path(str(PACKAGES / "aioduco_driver" / "launch" / "ros2_control.launch.py"))
    monkeypatch.setitem(code["start"].__globals__, "installed", installed.__contains__)
    nodes: list[dict[str, Any]] = []
    monkeypatch.setitem(code["start"].__globals__, "Node", lambda **given: nodes.append(given))
    argument = MagicMock(side_effect=lambda name: SimpleNamespace(perform=lambda _: CHOSEN[name]))
    monkeypatch.setitem(code["start"].__globals__, "LaunchConfiguration", argument)
    code["start"](None)
    described = {
        each["robot_description"]
        for node in nodes
        for each in node.get("parameters", [])
        if isinstance(each, dict) and "robot_description" in each
    }
    assert [ElementTree.fromstring(text).findtext(".//plugin") for text in described] == [plugin]
