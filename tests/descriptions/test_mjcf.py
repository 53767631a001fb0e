"""MJCF: MuJoCo's kinematics and inertias are ours, and the arm stands at home."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from for_each import for_each

from aioduco.descriptions import STATES, ArmDescription, mjcf, mjcf_scene, srdf
from aioduco.kinematics import arm, models
from aioduco.kinematics.bodies import ROTOR, bodies
from aioduco.kinematics.looks import COLOURS, looks, merged

from .test_urdf import GRIPPER, LEFT, RIGHT, agrees, configurations


@cache
def compiled(model: str) -> Any:
    """MuJoCo's model of an arm; the tests only read it."""
    return mujoco.MjModel.from_xml_string(mjcf(model))


@pytest.mark.parametrize("model", models())
def test_mujoco_agrees_on_frames_and_inertias(model: str) -> None:
    loaded, known = compiled(model), arm(model)
    data = mujoco.MjData(loaded)
    agrees(loaded, data, known, data.site("tool0"), data.site("attachment_site"))
    assert np.allclose(loaded.actuator_ctrlrange, loaded.jnt_range)
    assert np.allclose(loaded.actuator_forcerange[:, 1], known.effort)
    assert np.allclose(loaded.dof_armature, ROTOR * np.array(known.effort))


@pytest.mark.parametrize("model", models())
def test_it_stands_at_home_on_a_floor(model: str, tmp_path: Path) -> None:
    """The drives carry it, and neither there nor in the other configurations does it touch."""
    (tmp_path / f"{model}.xml").write_text(mjcf(model), encoding="utf-8")
    (tmp_path / "scene.xml").write_text(mjcf_scene(model, f"{model}.xml"), encoding="utf-8")
    loaded = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    data = mujoco.MjData(loaded)
    assert [loaded.key(i).name for i in range(loaded.nkey)] == list(STATES)
    for name, q in STATES.items():
        mujoco.mj_resetDataKeyframe(loaded, data, loaded.key(name).id)
        mujoco.mj_forward(loaded, data)
        assert np.allclose(data.qpos, q.array)
        assert np.array_equal(data.qpos, data.ctrl)
        assert data.ncon == 0, name
    mujoco.mj_resetDataKeyframe(loaded, data, loaded.key("home").id)
    mujoco.mj_step(loaded, data, 1000)  # 2 s
    assert not data.warning.number.any()
    assert np.abs(data.qpos - STATES["home"].array).max() < 0.02
    assert np.abs(data.qvel).max() < 1e-3


def test_configurations_beyond_limits_of_ones_own_are_left_out() -> None:
    narrow = replace(arm("gcr5_910"), lower=(-1.6,) * 6, upper=(1.6,) * 6)
    loaded = mujoco.MjModel.from_xml_string(mjcf(narrow))
    assert [loaded.key(i).name for i in range(loaded.nkey)] == ["up"]
    states = ET.fromstring(srdf(narrow)).iter("group_state")
    assert [state.get("name") for state in states] == ["up"]


@pytest.mark.slow
def test_it_follows_the_conventions_of_menagerie() -> None:
    root = ET.fromstring(mjcf("gcr5_910"))
    order = ["compiler", "option", "default", "asset", "worldbody", "contact", "actuator"]
    assert [element.tag for element in root] == [*order, "keyframe"]
    assert root.find("compiler[@angle='radian']") is not None
    loaded = compiled("gcr5_910")
    seen, touched = loaded.geom_group == 2, loaded.geom_group == 3
    assert (seen | touched).all()
    known = arm("gcr5_910")
    assert touched.sum() == sum(len(body.parts) for body in bodies(known))
    assert seen.sum() == sum(len(merged(link)) for link in looks(known))
    assert not loaded.geom_contype[seen].any()
    assert not loaded.geom_conaffinity[seen].any()
    assert loaded.geom_contype[touched].all()


@pytest.mark.slow
def test_two_arms_with_a_tool_stand_where_they_are_mounted() -> None:
    loaded = mujoco.MjModel.from_xml_string(mjcf(LEFT, RIGHT, name="cell"))
    data = mujoco.MjData(loaded)
    q = configurations(2)
    data.qpos[:] = q.ravel()
    mujoco.mj_kinematics(loaded, data)
    for described, joints, site in ((LEFT, q[0], "left_tool0"), (RIGHT, q[1], "right_tcp")):
        tree = described.tree()
        frame = tree.joints[0].matrix @ tree.frames(joints[None])[site][0]
        assert np.abs(data.site(site).xpos - frame[:3, 3]).max() < 1e-9
        assert np.abs(data.site(site).xmat.reshape(3, 3) - frame[:3, :3]).max() < 1e-9
    assert loaded.body("right_tool").mass[0] == pytest.approx(GRIPPER.mass)
    home = loaded.key("home").qpos
    assert np.allclose(home, [*STATES["home"], *STATES["home"]])


def test_an_arm_without_a_world_is_at_the_origin() -> None:
    on_floor, alone = (mjcf(ArmDescription("gcr5_910", mounting=m)) for m in ("floor", None))
    assert alone == on_floor


@pytest.mark.slow
def test_models_are_put_into_one_by_mujoco() -> None:
    cell = mujoco.MjSpec()
    cell.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for prefix in ("a/", "b/"):
        frame = cell.worldbody.add_frame(pos=[0, len(prefix), 0])
        cell.attach(mujoco.MjSpec.from_string(mjcf("gcr5_910")), prefix=prefix, frame=frame)
    assert cell.compile().nq == 12


@pytest.mark.slow
def test_meshes_of_the_user_are_shown(tmp_path: Path) -> None:
    cube = [(x, y, z) for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in cube) + "".join(f"f {f}\n" for f in faces)
    (tmp_path / "link_3.obj").write_text(text, encoding="utf-8")
    plain = compiled("gcr5_910")
    loaded = mujoco.MjModel.from_xml_string(mjcf("gcr5_910", meshes=tmp_path))
    names = [loaded.mesh(i).name for i in range(loaded.nmesh)]
    assert [name for name in names if name.startswith("link_3")] == ["link_3"]
    assert np.allclose(loaded.body_mass, plain.body_mass)
    assert (loaded.geom_group == 3).sum() == (plain.geom_group == 3).sum()


@pytest.mark.slow
@for_each("model", models())
def test_the_looks_are_in_the_frames_of_the_links(model: str) -> None:
    """MuJoCo turns each mesh to its own axes; where its points are then must be where they were."""
    loaded, known = compiled(model), arm(model)
    for number, parts in enumerate(looks(known)):
        body = loaded.body(f"link_{number}" if number else "base_link").id
        for colour, (points, _) in merged(parts).items():
            (geom,) = (
                geom
                for geom in range(loaded.ngeom)
                if loaded.geom_bodyid[geom] == body
                and (loaded.geom_group[geom] == 2)
                and loaded.mat(loaded.geom_matid[geom]).name == colour
            )
            mesh = loaded.geom_dataid[geom]
            first, count = loaded.mesh_vertadr[mesh], loaded.mesh_vertnum[mesh]
            turn = np.zeros(9)
            mujoco.mju_quat2Mat(turn, loaded.geom_quat[geom])
            found = loaded.mesh_vert[first : first + count] @ turn.reshape(3, 3).T
            found += loaded.geom_pos[geom]
            assert np.abs(found - points).max() < 1e-5
            assert loaded.mat(colour).rgba == pytest.approx([*COLOURS[colour], 1.0], abs=1e-6)
