"""Descriptions read by other makers' libraries: Pinocchio with Coal, and yourdfpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from aioduco.descriptions import STATES, ArmDescription, mjcf, srdf, urdf
from aioduco.kinematics import arm, models
from aioduco.kinematics.bodies import bodies

from .test_collisions import disabled
from .test_urdf import GRIPPER, LEFT, RIGHT, configurations

if TYPE_CHECKING:
    from pathlib import Path

    pinocchio: Any  # its bindings are compiled, without types
else:
    pinocchio = pytest.importorskip("pinocchio", reason="needs pip install 'aioduco[interop]'")

pytestmark = [pytest.mark.interop, pytest.mark.timeout(900)]


def flange(model: Any, data: Any, q: Any, frame: str = "tool0") -> Any:
    pinocchio.framesForwardKinematics(model, data, q)
    return data.oMf[model.getFrameId(frame)].homogeneous


@pytest.mark.parametrize("model", models())
@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_pinocchio_agrees_on_frames_inertias_and_limits(
    model: str, kind: str, tmp_path: Path
) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(urdf(model) if kind == "urdf" else mjcf(model), encoding="utf-8")
    build = pinocchio.buildModelFromUrdf if kind == "urdf" else pinocchio.buildModelFromMJCF
    loaded = build(str(file))
    known, data, joints = arm(model), loaded.createData(), configurations(100)
    for q, expected in zip(joints, known.fkine(joints), strict=True):
        assert np.abs(flange(loaded, data, q) - expected).max() < 1e-9
    for inertia, solid in zip(list(loaded.inertias)[1:], bodies(known)[1:], strict=True):
        assert abs(inertia.mass - solid.mass) < 1e-6
        assert np.abs(inertia.lever - solid.centre).max() < 1e-6
        assert np.abs(inertia.inertia - solid.inertia).max() < 1e-6
    assert np.allclose(loaded.lowerPositionLimit, known.lower, atol=1e-9)
    assert np.allclose(loaded.upperPositionLimit, known.upper, atol=1e-9)
    if kind == "urdf":
        assert np.allclose(loaded.upperEffortLimit, known.effort)
        assert np.allclose(loaded.upperVelocityLimit, known.velocity)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:`Scene.dump:DeprecationWarning")  # yourdfpy's own
@pytest.mark.parametrize("model", models()[::4])
def test_yourdfpy_agrees_on_frames(model: str, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(model), encoding="utf-8")
    yourdfpy = pytest.importorskip("yourdfpy", reason="needs pip install 'aioduco[interop]'")
    loaded = yourdfpy.URDF.load(str(tmp_path / "arm.urdf"), build_collision_scene_graph=True)
    assert loaded.actuated_joint_names == [f"joint_{i}" for i in range(1, 7)]
    assert loaded.validate()
    joints = configurations(20)
    for q, expected in zip(joints, arm(model).fkine(joints), strict=True):
        loaded.update_cfg(q)
        assert np.abs(loaded.get_transform("tool0", "base_link") - expected).max() < 1e-9


def test_pinocchio_loads_two_arms_with_a_tool() -> None:
    loaded = pinocchio.buildModelFromXML(urdf(LEFT, RIGHT, name="cell"))
    assert list(loaded.names)[1:] == [
        f"{side}_joint_{i}" for side in ("left", "right") for i in range(1, 7)
    ]
    last = list(loaded.inertias)[12]
    wrist = bodies(arm("gcr3_618"))[6]
    assert last.mass == pytest.approx(wrist.mass + GRIPPER.mass)
    centre = (wrist.mass * wrist.centre + GRIPPER.mass * np.array(GRIPPER.centre)) / last.mass
    assert np.abs(last.lever - centre).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize(
    "described",
    [ArmDescription(model) for model in models()]
    + [ArmDescription("gcr5_910", prefix="left_", tool=GRIPPER)],
    ids=lambda described: described.prefix + described.arm.name,
)
def test_coal_finds_no_collision_of_disabled_pairs(
    described: ArmDescription, thorough: bool, tmp_path: Path
) -> None:
    """On the URDF's cylinders and spheres, and none of what collides is disabled."""
    file = tmp_path / "arm.urdf"
    file.write_text(urdf(described), encoding="utf-8")
    semantic = tmp_path / "arm.srdf"
    semantic.write_text(srdf(described), encoding="utf-8")
    model = pinocchio.buildModelFromUrdf(str(file))
    solids = pinocchio.buildGeomFromUrdf(model, str(file), pinocchio.COLLISION)
    solids.addAllCollisionPairs()
    every = len(solids.collisionPairs)
    links = [model.frames[solid.parentFrame].name for solid in solids.geometryObjects]
    reasons = disabled(srdf(described))
    number = 400 if thorough else 200
    hits = dict.fromkeys(reasons, 0)
    data, placed = model.createData(), solids.createData()
    kept = [
        i
        for i, pair in enumerate(solids.collisionPairs)
        if frozenset((links[pair.first], links[pair.second])) in reasons
    ]
    for q in configurations(number, seed=5):
        pinocchio.updateGeometryPlacements(model, data, solids, placed, q)
        hit = set()
        for i in kept:
            pair = solids.collisionPairs[i]
            names = frozenset((links[pair.first], links[pair.second]))
            if names not in hit and pinocchio.computeCollision(solids, placed, i):
                hit.add(names)
        for names in hit:
            hits[names] += 1
    for names, reason in reasons.items():
        if reason != "Adjacent":
            assert hits[names] == (0 if reason == "Never" else number), (names, reason)
    # What Pinocchio leaves of the pairs by the SRDF is free in its configurations.
    pinocchio.removeCollisionPairs(model, solids, str(semantic))
    assert len(solids.collisionPairs) < every
    pinocchio.loadReferenceConfigurations(model, str(semantic))
    assert {entry.key() for entry in model.referenceConfigurations} >= set(STATES)
    placed = solids.createData()
    for name, q in STATES.items():
        found = model.referenceConfigurations[name]
        assert np.allclose(found, q.array)
        assert not pinocchio.computeCollisions(model, data, solids, placed, found, True), name
