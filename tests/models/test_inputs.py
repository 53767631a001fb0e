"""Values that are no number, list or file are refused by the name of their parameter."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco import Joints, ParameterError, Pose, SceneError, TaughtPoints, kinematics
from aioduco.compat import DucoCobot
from aioduco.descriptions import ArmDescription, ToolDescription, moveit
from aioduco.devices.cameras import BoardSize, SimulatedCamera, calibrate_hand_eye
from aioduco.devices.grippers import Robotiq
from aioduco.envelope import Zone
from aioduco.integrations.panel import Panel
from aioduco.models import ranges
from aioduco.models.op import event
from aioduco.planning import MotionLimits, PointCloud
from aioduco.recording import read
from aioduco.recording.playback import WaypointFile
from aioduco.recording.tap import Tap
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, mounting_of

ARM = kinematics.arm("gcr5_910")
HUGE = 10**400
#: arrays, texts and the like where one number is meant
NO_NUMBERS: list[Any] = [
    *(math.nan, -1.0, HUGE, "1", "", True, [1.0], {}, np.array([1.0, 2.0]), np.array(["a"])),
    *(1j, object(), b"1"),
]
NO_LISTS: list[Any] = [3, math.nan, HUGE, "tool", b"tool", {}, object(), [[1.0]], ["a"] * 3]
NO_FILES: list[Any] = [3, math.nan, True, "", b"run.mcap", [], "a\0b", "\ud800", ".", "/", object()]


def ranges_of(rule: str) -> Callable[[Any], object]:
    return lambda x: getattr(ranges, rule)("name", x)


class _NoArm:
    def field_of_view(self, _: str) -> float:
        return 1.0


NUMBERS: dict[str, Callable[[Any], object]] = {
    "speed": lambda x: Simulator(speed=x),
    "pedestal": lambda x: mounting_of("floor", ARM, x),
    "square": lambda x: BoardSize(5, 4, x),
    "width": lambda x: SimulatedCamera(_NoArm(), "eye", width=x),  # type: ignore[arg-type]
    "height": lambda x: SimulatedCamera(_NoArm(), "eye", height=x),  # type: ignore[arg-type]
    "timeout": lambda x: DucoCobot("192.0.2.1", timeout=x),
    "v": lambda x: MotionLimits.of(ARM, v=x, a=1.0, jerk=None),
    "a": lambda x: MotionLimits.of(ARM, v=1.0, a=x, jerk=None),
    "jerk": lambda x: MotionLimits.of(ARM, v=1.0, a=1.0, jerk=x),
}
LISTS: dict[str, Callable[[Any], object]] = {
    "at": lambda x: Box(at=x),
    "bodies": lambda x: Zone.sphere((0, 0, 1), 0.1, bodies=x),
    "points": lambda x: PointCloud(points=x),
    "flanges": lambda x: calibrate_hand_eye(x, [Pose(0, 0, 0, 0, 0, 0)] * 5),
    "centre": lambda x: ToolDescription(centre=x),
    "inertia": lambda x: ToolDescription(inertia=x),
    "prefix": lambda x: ArmDescription("gcr5_910", prefix=x if not isinstance(x, str) else "3"),
    "group": lambda x: moveit(ARM, group=x if not isinstance(x, str) else "3"),
    "counts": lambda x: Robotiq.at_tool(aioduco.connect("192.0.2.1")).__class__(
        _modbus(), counts=x
    ),
}
#: what listens, by the name of its address; an empty one would be every address of the computer
LISTENERS: dict[str, Callable[[Any], object]] = {
    "bind": lambda x: Panel("192.0.2.1", bind=x),
    "host": lambda x: Simulator(host=x),
    "host of a publication": lambda x: aioduco.connect("192.0.2.1").publish(host=x),
    "listen": lambda x: Tap("192.0.2.1", listen=(x, 0)),
}
#: what names something, on the controller or for the program
NAMES: dict[str, Callable[[Any], object]] = {
    "tool": ranges_of("NAME"),
    "frame": ranges_of("FRAME"),
    "program": ranges_of("LONG_NAME"),
    "project": ranges_of("PATH"),
    "event": event,
    "taught point": lambda x: TaughtPoints({x: Joints(0, 0, 0, 0, 0, 0)}),
    "waypoint": lambda x: WaypointFile.new(arm="GCR5 910").add(x, [0.0] * 6),
    "limit": lambda x: Zone.sphere((0, 0, 1), 0.1, name=x),
    "thing": lambda x: Box(name=x),
    "undertaking": lambda x: aioduco.connect("192.0.2.1").permit(x),
}
FILES: dict[str, Callable[[Any], object]] = {
    "record": lambda x: aioduco.connect("192.0.2.1", record=x),
    "path": read,
}


@for_each("kind", NAMES)
def test_a_name_is_on_one_line(kind: str) -> None:
    for name in ("a\nb", "a\0", "\x1b[2J", "a\u2028b", "\u202e", 3, None, b"a"):
        with pytest.raises(ParameterError):
            NAMES[kind](name)


def test_a_name_may_have_spaces_of_any_width() -> None:
    assert ranges.NAME("name", "抓手\u3000 1\u00a0") == "抓手\u3000 1\u00a0"


def _modbus() -> Any:
    return Robotiq.at_tool(aioduco.connect("192.0.2.1"))._modbus


@for_each("name", NUMBERS)
def test_what_is_no_number_is_refused_by_name(name: str) -> None:
    for value in NO_NUMBERS:
        with pytest.raises((ParameterError, SceneError), match=name):
            NUMBERS[name](value)


@for_each("name", LISTS)
def test_what_is_no_list_is_refused_by_name(name: str) -> None:
    for value in NO_LISTS:
        with pytest.raises(ParameterError, match=name):
            LISTS[name](value)


@for_each("name", LISTENERS)
def test_an_empty_address_to_listen_on_is_refused(name: str) -> None:
    for value in ("", None, 3, "x" * 300):
        with pytest.raises(ParameterError, match=name.partition(" ")[0]):
            LISTENERS[name](value)


@for_each("name", FILES)
def test_what_is_no_file_is_refused_by_name(name: str) -> None:
    for value in NO_FILES:
        with pytest.raises(ParameterError, match=name):
            FILES[name](value)


@for_each("points", ["points.toml", 3, ["a"], [("a",)]])
def test_what_are_no_points_by_name_is_refused(points: Any) -> None:
    with pytest.raises(ParameterError, match="points"):
        TaughtPoints(points)


def test_a_message_shows_the_beginning_of_a_long_value() -> None:
    with pytest.raises(ParameterError, match=r"… \(200002 characters\)") as caught:
        kinematics.arm("x" * 200_000)
    assert len(str(caught.value)) < 1500


@for_each(
    "six",
    [
        {f"joint_{number}": 0.0 for number in range(1, 7)},
        {0.0, 0.1, 0.2, 0.3, 0.4, 0.5},
        "0 0 0 0 0 0",
        (0.0 for _ in range(6)),
        np.zeros((1, 6)),
    ],
)
def test_six_numbers_that_are_no_list_are_refused_as_no_list(six: Any) -> None:
    for made in (ranges.JOINTS, ranges.POSE):
        with pytest.raises(ParameterError, match=r"must be .*, as a list, a tuple or a flat array"):
            made("joints", six)
    if not isinstance(six, np.ndarray | str):  # the message has its shape; a text is a sequence
        with pytest.raises(ParameterError, match=r"must be .*, as a list, a tuple or an array"):
            Joints.of(six)
