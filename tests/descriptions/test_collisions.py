"""Pairs of links whose collisions are disabled, against MuJoCo's collisions."""

from __future__ import annotations

from collections import Counter
from itertools import combinations
from typing import Any
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest

from aioduco.descriptions import ArmDescription, mjcf, srdf
from aioduco.descriptions.collisions import pair_distances
from aioduco.kinematics import models

from .test_urdf import GRIPPER, configurations

pytestmark = pytest.mark.timeout(900)  # thousands of configurations of each arm, on a busy machine


def disabled(text: str) -> dict[frozenset[str], str]:
    """The pairs of an SRDF with their reasons."""
    pairs = ET.fromstring(text).findall("disable_collisions")
    found = {frozenset((p.attrib["link1"], p.attrib["link2"])): p.attrib["reason"] for p in pairs}
    assert len(found) == len(pairs)
    return found


def unfiltered(arm: ArmDescription | str) -> Any:
    """MuJoCo's model of an arm in which every two links may touch, neighbours included."""
    spec = mujoco.MjSpec.from_string(mjcf(arm))
    for exclude in list(spec.excludes):
        spec.delete(exclude)
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    return spec.compile()


def collisions(
    model: Any, joints: np.ndarray[Any, np.dtype[np.float64]]
) -> Counter[frozenset[str]]:
    """In how many of the configurations each pair of links touches."""
    data, found = mujoco.MjData(model), Counter[frozenset[str]]()
    link = [model.body(body).name for body in model.geom_bodyid]
    for q in joints:
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        found.update({frozenset((link[a], link[b])) for a, b in data.contact.geom.tolist()})
    return found


@pytest.mark.slow
@pytest.mark.parametrize("model", models())
def test_disabled_are_those_that_never_or_always_touch(model: str) -> None:
    number = 10_000
    found = collisions(unfiltered(model), configurations(number, seed=11))
    reasons = disabled(srdf(model))
    assert sum(reason == "Adjacent" for reason in reasons.values()) == 6
    others = {pair for pair, reason in reasons.items() if reason != "Adjacent"}
    assert others == {frozenset(("base_link", "link_2")), frozenset(("link_4", "link_6"))}
    for pair, reason in reasons.items():
        # Neighbours overlap at their joint.
        assert found[pair] == (0 if reason == "Never" else number), (pair, reason)
    # And of the others each was seen to touch, so that none is checked in vain.
    links = ["base_link", *(f"link_{i}" for i in range(1, 7))]
    pairs = {frozenset((one, other)) for one in links for other in links if one != other}
    assert all(0 < found[pair] < number for pair in pairs - set(reasons))


@pytest.mark.slow
@pytest.mark.parametrize("model", ["gcr5_910", "gcr3_618"])
def test_a_tool_is_kept_from_the_links_that_it_reaches(model: str) -> None:
    number = 10_000
    arm = ArmDescription(model, prefix="left_", tool=GRIPPER)
    found = collisions(unfiltered(arm), configurations(number, seed=12))
    reasons = disabled(srdf(arm))
    assert reasons[frozenset(("left_link_6", "left_tool"))] == "Adjacent"
    touching = {
        link for pair, count in found.items() if "left_tool" in pair for link in pair if count
    }
    assert {"left_base_link", "left_link_1", "left_link_2"} <= touching
    for pair, reason in reasons.items() - {(frozenset(("left_link_6", "left_tool")), "Adjacent")}:
        assert found[pair] == (0 if reason == "Never" else number), (pair, reason)


def test_distances_are_those_of_mujoco(thorough: bool) -> None:
    arm = ArmDescription("gcr5_910", tool=GRIPPER)
    joints = configurations(300 if thorough else 20)
    model = mujoco.MjModel.from_xml_string(mjcf(arm))
    data = mujoco.MjData(model)
    links = [link.name for link in arm.tree().links if link.parts]
    geoms = [
        np.flatnonzero((model.geom_group == 3) & (model.geom_bodyid == model.body(n).id))
        for n in links
    ]
    ours = pair_distances(arm.tree(), joints, combinations(range(len(links)), 2))
    for n, q in enumerate(joints):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        for (i, j), distances in ours.items():
            theirs = min(
                mujoco.mj_geomDistance(model, data, int(a), int(b), 10.0, None)
                for a in geoms[i]
                for b in geoms[j]
            )
            if theirs > 0:
                assert distances[n] == pytest.approx(theirs, abs=1e-6)
            else:
                assert distances[n] < 1e-9


def test_arms_in_one_world_are_kept_from_each_other() -> None:
    left, right = (
        ArmDescription("gcr5_910", prefix=p, mounting=(0, y, 0, 0, 0, 0))
        for p, y in (("left_", 0), ("right_", 1))
    )
    across = {
        pair: reason
        for pair, reason in disabled(srdf(left, right)).items()
        if len({link.partition("_")[0] for link in pair}) == 2
    }
    # The bases do not move.
    assert across == {frozenset(("left_base_link", "right_base_link")): "Adjacent"}
