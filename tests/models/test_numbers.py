"""Numbers of numpy count as numbers everywhere, and other values are refused by name."""

from __future__ import annotations

import dataclasses
import inspect
import math
import re
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco import (
    Joints,
    JointTrajectory,
    ParameterError,
    Pose,
    Tolerances,
    descriptions,
    kinematics,
    planning,
)
from aioduco.api.streams.arguments import per_group
from aioduco.devices.cameras.board import BoardSize
from aioduco.envelope import JointMargin, SingularityMargin, ToolForce, ToolSpeed, Zone
from aioduco.models import ranges
from aioduco.models.places import PLACES
from aioduco.models.rules import Choice
from aioduco.planning import Region
from aioduco.sim import scene
from aioduco.sim.cabinet import SystemValues
from aioduco.sim.clock import checked_speed
from aioduco.sim.controller.signal_rules import SignalRule
from aioduco.sim.view.camera import Camera
from aioduco.streaming.sampling import instants, sampled
from aioduco.streaming.shared.space import JOINT_SPACE


def settings(**given: Any) -> Any:
    return aioduco.connect("192.0.2.1", **given)._supervisor.settings


SCALARS: list[Any] = [
    *(np.float32(0.25), np.float16(0.25), np.float64(0.25), np.longdouble(0.25), np.array(0.25)),
    *(Fraction(1, 4), np.int64(1), np.uint8(1), 1),
]
#: by name, what takes one number
TAKERS: dict[str, Callable[[Any], Any]] = {
    "Sphere": lambda x: scene.Sphere(radius=x).radius,
    "Cylinder": lambda x: scene.Cylinder(radius=x, length=x).length,
    "Box": lambda x: scene.Box(size=(x, x, x)).size[0],
    "mass": lambda x: scene.Sphere(mass=x).mass,
    "ToolSpeed": lambda x: ToolSpeed(x).most,
    "ToolForce": lambda x: ToolForce(x).most,
    "JointMargin": lambda x: JointMargin(x).least,
    "SingularityMargin": lambda x: SingularityMargin(x).least,
    "speed": lambda x: ToolForce(1.0, speed=x).speed,
    "Zone": lambda x: Zone.sphere([0, 0, 1], x).size[0],
    "Pose": lambda x: Pose(x, 0, 0, 0, 0, 0).x,
    "Joints": lambda x: Joints(x, 0, 0, 0, 0, 0).j1,
    "Number": lambda x: ranges.FROM_0("x", x),
    "Camera": lambda x: Camera(distance=x).distance,
    "Region": lambda x: Region(Pose(0, 0, 0, 0, 0, 0), size=(x, x, x)).size[0],
    "Tolerances": lambda x: Tolerances(path=x).path,
    "per joint": lambda x: Tolerances(goal=(x,) * 6).goal[0],  # type: ignore[index]
    "WorkerOptions": lambda x: aioduco.WorkerOptions(timeout=x).timeout,
    "max_step": lambda x: per_group("max_step", x, 6)[0],
    "SignalRule": lambda x: SignalRule(1, 1, after=x).after,
    "call_timeout": lambda x: settings(call_timeout=x).call_timeout,
}


@for_each("name", TAKERS)
def test_every_kind_of_number_is_taken_and_kept_as_a_float(name: str) -> None:
    for value in SCALARS:
        kept = TAKERS[name](value)
        assert type(kept) is float
        assert kept == float(value)


@for_each("name", TAKERS)
def test_what_is_no_finite_number_is_refused(name: str) -> None:
    for value in (
        *(math.nan, math.inf, -math.inf, None, "1", True, np.True_, 10**400, 10**5000, 1j, [1]),
        *(Decimal(1), np.timedelta64(1, "ns"), np.timedelta64(1, "s"), np.datetime64(1, "ns")),
    ):
        with pytest.raises(ParameterError):
            TAKERS[name](value)


def test_a_type_checker_takes_numbers_of_numpy_where_the_manual_has_numbers() -> None:
    """Time limits are this package's."""
    robot = aioduco.connect("192.0.2.1")

    async def checked_alone() -> None:
        await robot.motion.movej2([0.0] * 6, v=np.float32(0.5), a=np.float64(1.0), r=np.int64(0))

    del checked_alone
    floats = [
        f"{section}.{name}({parameter.name})"
        for section, names in PLACES.items()
        for name in names.split()
        for parameter in inspect.signature(
            getattr(getattr(robot, section) if section else robot, name)
        ).parameters.values()
        if re.search(r"\bfloat\b", str(parameter.annotation)) and parameter.name != "timeout"
    ]
    assert floats == []


#: pandas and ROS give such ones; numpy has them as whole numbers
NANO = np.timedelta64(3, "ns")
WHOLES: list[Any] = [3, np.int64(3), np.uint8(3), np.array(3)]
#: by name, what takes one whole number
WHOLE_TAKERS: dict[str, Callable[[Any], Any]] = {
    "Integer": lambda n: ranges.STANDARD_IO("num", n),
    "Choice": lambda n: Choice({3: "three"}, source="here")("n", n),
    "SignalRule": lambda n: SignalRule(n, 1).output,
    "BoardSize": lambda n: BoardSize(n, 4, square=0.02).columns,
    "pool_size": lambda n: settings(pool_size=n).pool_size,
}


@for_each("name", WHOLE_TAKERS)
def test_every_kind_of_whole_number_is_taken_and_kept_as_an_int(name: str) -> None:
    for value in WHOLES:
        kept = WHOLE_TAKERS[name](value)
        assert (type(kept), kept) == (int, 3)


@for_each("name", WHOLE_TAKERS)
def test_what_is_no_whole_number_is_refused(name: str) -> None:
    for value in (3.0, np.float64(3.0), np.array(3.0), np.array([3]), True, np.True_, None, NANO):
        with pytest.raises(ParameterError):
            WHOLE_TAKERS[name](value)


@for_each("speed", [2, np.float32(2.0), np.array(2.0), Fraction(2), math.inf])
def test_every_kind_of_number_is_a_speed_of_time(speed: Any) -> None:
    assert checked_speed(speed) == float(speed)


def test_percent_as_a_whole_number_of_numpy_does_not_warn() -> None:
    for percent in WHOLES:
        assert ranges.percent_of_speed("v", percent) == 3.0


def test_system_values_of_numpy_are_kept_as_python_has_them() -> None:
    values = SystemValues({"one": np.float32(0.5), "many": np.arange(3.0), "table": np.eye(2)})  # type: ignore[dict-item]
    assert values.get("one", float) == 0.5
    assert values.numbers("many") == [0.0, 1.0, 2.0]
    assert values.lists("table") == [[1.0, 0.0], [0.0, 1.0]]


# -- times ---------------------------------------------------------------------------------------


def test_a_time_in_nanoseconds_is_named_as_one() -> None:
    with pytest.raises(ParameterError, match="seconds, not nanoseconds"):
        aioduco.connect("192.0.2.1", call_timeout=2e9)
    with pytest.raises(ParameterError, match="seconds, not nanoseconds"):
        JointTrajectory([[0.0] * 6, [0.1] * 6], [0.0, 1e9])
    with pytest.raises(ParameterError, match="seconds, not nanoseconds"):
        next(sampled(JOINT_SPACE, [[0.0] * 6, [0.1] * 6], [0.0, 4e8], 0.002))


#: by name, what takes an array
ARRAY_TAKERS: dict[str, Callable[[Any], Any]] = {
    "times": lambda x: JointTrajectory(np.zeros((6, 6)), x),
    "positions": lambda x: JointTrajectory(np.stack([x, x]), [0.0, 1.0]),
    "sampled": lambda x: next(sampled(JOINT_SPACE, np.zeros((6, 6)), x, 0.002)),
    "rule": lambda x: ranges.JOINTS("joints", x),
    "Joints": Joints.of,
    "fkine": kinematics.arm("gcr5_910").fkine,
    "near": lambda x: kinematics.arm("gcr5_910").ikine(np.eye(4), x),
    "ikine": lambda x: kinematics.arm("gcr5_910").ikine(x, [0.0] * 6),
    "rotation": lambda x: Pose.from_rotvec(x[:3], [0.0, 0.0, 0.0]),
    "cloud": lambda x: planning.PointCloud(points=np.reshape(x, (2, 3))),
}


@for_each("name", ARRAY_TAKERS)
def test_an_array_of_other_things_than_numbers_is_refused(name: str) -> None:
    take = ARRAY_TAKERS[name]
    nano = np.arange(6) * np.timedelta64(1, "ns")
    for value in (
        *(
            nano,
            nano.astype("m8[s]"),
            np.arange(6) * 1j,
            np.array(list("012345")),
            np.ones(6, bool),
        ),
        np.array([None, 1, 2, 3, 4, 5], dtype=object),
    ):
        with pytest.raises(ParameterError):
            take(value)


@for_each("name", ["times", "positions", "fkine", "rotation"])
def test_an_array_of_any_kind_of_number_is_taken(name: str) -> None:
    for kind in (np.float32, np.int64, np.uint8, object):
        ARRAY_TAKERS[name](np.arange(6).astype(kind))
    ARRAY_TAKERS[name](np.ma.masked_array(np.arange(6.0), mask=[False] * 6))


def test_what_is_masked_is_missing() -> None:
    masked = np.ma.masked_array(np.zeros((2, 6)), mask=np.eye(2, 6, dtype=bool))
    with pytest.raises(ParameterError, match="finite"):
        JointTrajectory(masked, [0.0, 1.0])
    with pytest.raises(ParameterError, match="j1"):
        Joints(*masked[0])
    with pytest.raises(ParameterError, match="joints"):
        ranges.JOINTS("joints", [*masked[0]])


@for_each("jump", [math.nan, -1.0, "1", True])
def test_a_largest_jump_that_is_no_angle_is_refused(jump: Any) -> None:
    arm = kinematics.arm("gcr5_910")
    home = Joints.deg(30, -15, 105, 0, -90, 0)
    with pytest.raises(ParameterError, match="max_jump"):
        arm.ikine(arm.fkine(home), home, max_jump=jump)


@for_each("length", [math.nan, "x", None, True, 425.0])
def test_a_length_of_an_arm_that_is_no_number_is_refused(length: Any) -> None:
    with pytest.raises(ParameterError, match="a2"):
        kinematics.arm("gcr5_910", a2=length)


def test_set_points_fit_into_memory() -> None:
    assert instants(0.01, 0.002).tolist() == pytest.approx([0.0, 0.002, 0.004, 0.006, 0.008, 0.01])
    with pytest.raises(ParameterError, match=r"at most 20000 s long at 500 Hz"):
        instants(20001.0, 0.002)


def test_the_ends_of_ranges_in_docstrings_are_within_them() -> None:
    files = Path(aioduco.__file__).parent.rglob("*.py")
    texts = " ".join(file.read_text(encoding="utf-8") for file in files)
    found = set(re.findall(r"(0\.000175) to (\d+\.\d+)", texts))
    assert len(found) == 2  # speed and acceleration of a joint, which end at multiples of π
    for low, high in found:
        rule = ranges.JOINT_SPEED if float(high) < 10.0 else ranges.TRACK_JOINT_ACCELERATION
        assert rule("v", float(low)) < rule("v", float(high))


# -- rotations and texts -------------------------------------------------------------------------


def test_a_rotation_with_six_decimals_is_one() -> None:
    random = np.random.default_rng(0)
    for _ in range(100):
        pose = Pose(0.4, 0.1, 0.3, *random.uniform(-3.1, 3.1, 3))
        for matrix in (np.round(pose.matrix, 6), pose.matrix.astype(np.float32)):
            assert Pose.from_matrix(matrix).distance(pose)[1] < 2e-6
        near = pose.matrix
        near[:3, :3] *= 1.0 + 1e-5
        with pytest.raises(ParameterError, match="orthonormal"):
            Pose.from_matrix(near)


@pytest.mark.parametrize("value", [1e-5, 1e-7, 123456.0, 1e16, 1.5e22, 2.0, 0.1])
def test_yaml_reads_every_limit_as_a_number(value: float) -> None:
    arm = dataclasses.replace(kinematics.arm("gcr5_910"), velocity=(value,) * 6)
    limits = yaml.safe_load(descriptions.moveit(arm)["joint_limits.yaml"])["joint_limits"]
    assert all(joint["max_velocity"] == value for joint in limits.values())
