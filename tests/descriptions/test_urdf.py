"""URDFs: what urdfdom and MuJoCo make of them, prefixes, mountings, tools and meshes."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from for_each import for_each

from aioduco import Joints, ParameterError, Pose
from aioduco.descriptions import ArmDescription, Capsule, ToolDescription, mjcf, srdf, urdf
from aioduco.descriptions.texts import ArmLike
from aioduco.kinematics import Arm, DhCorrections, arm, models
from aioduco.kinematics.bodies import bodies
from aioduco.sim import Simulator

GRIPPER = ToolDescription(
    mass=0.9,
    centre=(0.0, 0.01, 0.06),
    tcp=Pose(0.01, 0.0, 0.18, 0.1, 0.2, 0.3),
    parts=[Capsule((0, 0, 0.035), (0, 0, 0.095), 0.04), Capsule((0, 0, 0.15), (0, 0, 0.15), 0.02)],
)
LEFT = ArmDescription("gcr5_910", prefix="left_", mounting=(0, 0.5, 0.2, 0.1, 0.2, 0.3))
RIGHT = ArmDescription("gcr3_618", prefix="right_", mounting="wall", tool=GRIPPER)


def configurations(number: int, seed: int = 3) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.random.default_rng(seed).uniform(-2 * np.pi, 2 * np.pi, (number, 6))


def read_by_mujoco(text: str) -> Any:
    """MuJoCo's model of a URDF, with each of its links as a body."""
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.fusestatic = False
    return spec.compile()


def agrees(loaded: Any, data: Any, known: Arm, *flanges: Any) -> None:
    """MuJoCo has an arm's flanges where they are, and its inertias and limits as they are."""
    joints = configurations(20)
    for q, flange in zip(joints, known.fkine(joints), strict=True):
        data.qpos[:] = q
        mujoco.mj_kinematics(loaded, data)
        for each in flanges:
            assert np.abs(each.xpos - flange[:3, 3]).max() < 1e-9
            assert np.abs(each.xmat.reshape(3, 3) - flange[:3, :3]).max() < 1e-9
    for i, solid in enumerate(bodies(known)[1:], start=1):
        body = loaded.body(f"link_{i}")
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        inertia = turn.reshape(3, 3) @ np.diag(body.inertia) @ turn.reshape(3, 3).T
        assert body.mass[0] == pytest.approx(solid.mass, abs=1e-9)
        assert np.abs(body.ipos - solid.centre).max() < 1e-9
        assert np.abs(inertia - solid.inertia).max() < 1e-6
    assert np.allclose(loaded.jnt_range, np.array([known.lower, known.upper]).T, atol=1e-9)


def check_urdf(text: str, folder: Path) -> str:
    """What Debian's check_urdf says; it has to accept the text."""
    if shutil.which("check_urdf") is None:
        pytest.skip("check_urdf is not installed: apt install liburdfdom-tools")
    file = folder / "arm.urdf"
    file.write_text(text, encoding="utf-8")
    done = subprocess.run(
        ["check_urdf", str(file)], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr == ""
    return done.stdout


@pytest.mark.parametrize("model", models())
def test_urdfdom_accepts_it(model: str, tmp_path: Path) -> None:
    said = check_urdf(urdf(model), tmp_path)
    assert f"robot name is: {model}" in said
    assert "root Link: world" in said
    links = {link.get("name") for link in ET.fromstring(urdf(model)).findall("link")}
    assert {*re.findall(r"child\(\d+\):\s+(\S+)", said), "world"} == links


@pytest.mark.slow
@pytest.mark.parametrize(
    "arms",
    [
        pytest.param((LEFT, RIGHT), id="two"),
        pytest.param((ArmDescription("gcr5_910", mounting=None, tool=GRIPPER),), id="no-world"),
    ],
)
def test_urdfdom_accepts_arms_with_prefixes_and_tools(
    arms: tuple[ArmLike, ...], tmp_path: Path
) -> None:
    said = check_urdf(urdf(*arms, name="cell"), tmp_path)
    assert "robot name is: cell" in said


@for_each("model", models())
def test_mujoco_agrees_on_frames_inertias_and_limits(model: str) -> None:
    loaded, known = read_by_mujoco(urdf(model)), arm(model)
    data = mujoco.MjData(loaded)
    agrees(loaded, data, known, data.body("tool0"))


def test_a_calibrated_arm_has_its_flange_where_its_kinematics_have_it() -> None:
    nominal = arm("gcr5_910")
    columns = np.random.default_rng(1).normal(0.0, 3e-3, (4, 6)).tolist()
    corrections = DhCorrections(*map(tuple, columns))
    known = replace(nominal, geometry=nominal.geometry._replace(corrections=corrections))
    loaded = read_by_mujoco(urdf(known))
    data = mujoco.MjData(loaded)
    agrees(loaded, data, known, data.body("tool0"))


def test_limits_are_those_of_the_arm() -> None:
    known = replace(arm("gcr5_910"), lower=(-3.0,) * 6, upper=(3, 2, 1, 3, 3, 3))
    limits = ET.fromstring(urdf(known)).findall("joint/limit")
    found = [[float(limit.attrib[name]) for limit in limits] for name in limits[0].attrib]
    expected = [known.lower, known.upper, known.effort, known.velocity]
    assert np.allclose(found, expected)


def test_the_flange_points_its_x_axis_away_from_the_arm() -> None:
    """As REP 199 has it; tool0 has the axes of the controller."""
    loaded = read_by_mujoco(urdf("gcr5_910"))
    data = mujoco.MjData(loaded)
    mujoco.mj_kinematics(loaded, data)
    flange, tool0 = (data.body(name).xmat.reshape(3, 3) for name in ("flange", "tool0"))
    assert np.allclose(flange[:, 0], tool0[:, 2])
    assert np.array_equal(data.body("base").xpos, data.body("base_link").xpos)


def test_two_arms_stand_where_they_are_mounted() -> None:
    loaded = read_by_mujoco(urdf(LEFT, RIGHT))
    data = mujoco.MjData(loaded)
    q = configurations(2)
    data.qpos[:] = q.ravel()
    mujoco.mj_kinematics(loaded, data)
    with Simulator("gcr3_618", mounting="wall") as sim:
        wall = sim.mounting
    places = Pose(0, 0.5, 0.2, 0.1, 0.2, 0.3), wall
    tips = data.body("left_tool0"), data.body("right_tcp")
    ends = np.eye(4), Pose.of(GRIPPER.tcp).matrix
    for place, described, joints, end, tip in zip(
        places, (LEFT, RIGHT), q, ends, tips, strict=True
    ):
        expected = place.matrix @ described.arm.fkine(joints) @ end
        assert np.abs(tip.xpos - expected[:3, 3]).max() < 1e-9
        assert np.abs(tip.xmat.reshape(3, 3) - expected[:3, :3]).max() < 1e-9


@for_each("mounting", ["floor", None])
def test_a_frame_is_said_to_have_no_mass_for_readers_that_assume_one(mounting: Any) -> None:
    """PyBullet gives 1 kg to a link without inertia; KDL takes none of the root."""
    robot = ET.fromstring(urdf(ArmDescription("gcr5_910", mounting=mounting)))
    carried = {each.attrib["link"] for each in robot.iter("child")}
    told = {
        link.attrib["name"]: float(mass.attrib["value"])
        for link in robot.iter("link")
        if (mass := link.find("inertial/mass")) is not None
    }
    assert set(told) == carried
    assert told["flange"] == told["tool0"] == 0.0
    assert sum(told.values()) == pytest.approx(sum(arm("gcr5_910").masses))


def test_a_tool_has_its_mass_where_it_is() -> None:
    loaded = read_by_mujoco(urdf(ArmDescription("gcr5_910", tool=GRIPPER)))
    tool = loaded.body("tool")
    assert tool.mass[0] == pytest.approx(0.9)
    assert np.allclose(tool.ipos, GRIPPER.centre)
    # A cylinder of 140 mm and a radius of 40 mm.
    across, about = 0.9 * (3 * 0.04**2 + 0.14**2) / 12, 0.9 * 0.04**2 / 2
    assert sorted(tool.inertia) == pytest.approx(sorted([across, across, about]))


@for_each(
    "tool, inertia",
    [
        (ToolDescription(mass=1.0, inertia=(1e-3, 2e-3, 2.5e-3)), (2.5e-3, 2e-3, 1e-3)),
        # A ball of 1 kg of aluminium has a radius of 44.6 mm.
        (ToolDescription(mass=1.0), (0.4 * 0.04455**2,) * 3),
    ],
)
def test_inertia_of_a_tool_without_a_shape(
    tool: ToolDescription, inertia: tuple[float, ...]
) -> None:
    loaded = read_by_mujoco(urdf(ArmDescription("gcr5_910", tool=tool)))
    assert loaded.body("tool").inertia == pytest.approx(inertia, rel=1e-3)


def test_the_base_does_not_reach_below_what_it_stands_on(tmp_path: Path) -> None:
    base = next(link for link in ET.fromstring(urdf("gcr5_910")) if link.get("name") == "base_link")
    for solid in base.findall("collision"):
        height = float(solid.findall("origin")[0].attrib["xyz"].split()[2])
        (shape,) = solid.findall("geometry/*")
        below = float(shape.get("length", 0)) / 2 or float(shape.attrib["radius"])
        assert height - below >= -0.01 if shape.tag == "sphere" else height >= below


def test_meshes_of_the_user_are_shown(tmp_path: Path) -> None:
    for name in ("base_link.stl", "Link_1.STL", "link_1.dae", "left_link_2.obj", "other.stl"):
        (tmp_path / name).touch()
    left = ArmDescription("gcr5_910", prefix="left_")
    root = ET.fromstring(urdf(left, meshes=tmp_path, mesh_uri="package://mine/meshes/"))
    shown = {
        link.attrib["name"]: mesh.attrib["filename"]
        for link in root.findall("link")
        if (mesh := link.find("visual/geometry/mesh")) is not None
    }
    assert shown == {
        "left_base_link": "package://mine/meshes/base_link.stl",
        "left_link_1": "package://mine/meshes/link_1.dae",
        "left_link_2": "package://mine/meshes/left_link_2.obj",
    }
    assert (tmp_path / "link_1.dae").as_uri() in urdf("gcr5_910", meshes=tmp_path)
    assert root.find("link[@name='left_link_1']/collision/geometry/mesh") is None


def test_what_is_wrong_is_said(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="one of gcr3_618"):
        urdf("ur5e")
    with pytest.raises(ParameterError, match='"floor", "wall", "ceiling" or a pose'):
        ArmDescription("gcr5_910", mounting="roof")  # type: ignore[arg-type]  # what is tested
    with pytest.raises(ParameterError, match="prefix"):
        ArmDescription("gcr5_910", prefix="my arm/")
    with pytest.raises(ParameterError, match="tool is 'x', but must be a ToolDescription"):
        ArmDescription("gcr5_910", tool="x")  # type: ignore[arg-type]  # what is tested
    with pytest.raises(ParameterError, match="a different one for each arm"):
        srdf("gcr5_910", "gcr3_618")
    with pytest.raises(ParameterError, match="at least one arm"):
        urdf()
    with pytest.raises(ParameterError, match="a word"):
        urdf("gcr5_910", name="my cell")
    with pytest.raises(ParameterError, match="a folder with base_link"):
        urdf("gcr5_910", meshes=tmp_path)
    for option, texts in product(("meshes", "mesh_uri"), list[Any]([5, b"meshes", ["meshes"]])):
        with pytest.raises(ParameterError, match=f"^{option} is "):
            urdf("gcr5_910", **{option: texts})
    wrong: dict[str, Any] = {
        "mass": -1.0,
        "centre": (0, 0),
        "tcp": (0, 0, 0.1),
        "inertia": (1, 1, 3),
    }
    for name, value in wrong.items():
        with pytest.raises(ParameterError) as caught:
            ToolDescription(**{name: value})
        assert caught.value.parameter in {name, "pose"}
    with pytest.raises(ParameterError, match="inertia"):
        ToolDescription(inertia=(1, 1))
    with pytest.raises(ParameterError, match="radius"):
        ToolDescription(parts=[Capsule((0, 0, 0), (0, 0, 1), 0.0)])
    with pytest.raises(ParameterError, match="end"):
        ToolDescription(parts=[Capsule((0, 0, 0), (0, 1), 0.1)])  # type: ignore[arg-type]
    for parts in list[Any]([None, "hand", {}, [1.0]]):
        with pytest.raises(ParameterError, match="parts"):
            ToolDescription(parts=parts)


@for_each("kind", [list, np.array])
def test_a_description_keeps_its_numbers_whatever_becomes_of_the_callers(kind: Any) -> None:
    centre, end, tcp, place = (kind([0.0, 0.0, 0.1, 0.0, 0.0, 0.0][:n]) for n in (3, 3, 6, 6))
    parts = [Capsule(kind([0.0, 0.0, 0.0]), end, 0.02)]
    tool = ToolDescription(mass=1.0, centre=centre, tcp=tcp, parts=parts)
    arm = ArmDescription("gcr5_910", mounting=place, tool=tool)
    before = urdf(arm), mjcf(arm)
    for given in (centre, end, tcp, place):
        given[2] = np.nan
    parts.clear()
    assert (urdf(arm), mjcf(arm)) == before
    assert len({arm, arm}) == 1


@for_each("given", [{"centre": (0, 0, 90)}, {"parts": [Capsule((0, 0, 0), (0, 0, 90), 0.04)]}])
def test_a_tool_in_millimetres_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(ParameterError, match=r"\(millimetres\?\)"):
        ToolDescription(mass=1.0, **given)


def test_home_is_that_of_the_examples() -> None:
    from aioduco.descriptions import STATES  # noqa: PLC0415

    assert STATES["home"] == Joints.deg(30, -15, 105, 0, -90, 0)
