"""SRDF: the groups of joints, named configurations, and pairs of links that need no check."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from aioduco.descriptions.collisions import LinkPair, disabled_pairs
from aioduco.descriptions.xml_text import numbers, pretty

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.descriptions.tree import ArmTree


GROUP = "manipulator"
"""The group of an arm's joints, after its prefix."""

END_EFFECTOR = "end_effector"
"""The group of what the flange carries, after the prefix."""


def srdf_text(
    name: str, trees: Sequence[ArmTree], *, group_name: str = GROUP, tip: str = ""
) -> str:
    """Return the SRDF of some arms in one world.

    Args:
        name: name of the robot, as in its URDF.
        trees: the arms.
        group_name: name of the group of an arm's joints, after its prefix.
        tip: link at which the group ends, after the prefix; empty: the tool's tip or the flange.
    """
    robot = ET.Element("robot", name=name)
    for tree in trees:
        prefix = tree.arm.prefix
        group = ET.SubElement(robot, "group", name=prefix + group_name)
        end = prefix + tip if tip else tree.tip
        ET.SubElement(group, "chain", base_link=tree.links[0].name, tip_link=end)
        effector = ET.SubElement(robot, "group", name=prefix + END_EFFECTOR)
        for link in _carried(tree):
            ET.SubElement(effector, "link", name=link)
        for state, q in tree.states.items():
            element = ET.SubElement(robot, "group_state", name=state, group=prefix + group_name)
            for (joint, _), angle in zip(tree.turning, q, strict=True):
                ET.SubElement(element, "joint", name=joint.name, value=numbers([angle]))
        ET.SubElement(
            robot,
            "end_effector",
            name=prefix + END_EFFECTOR,
            parent_link=prefix + "flange",
            group=prefix + END_EFFECTOR,
            parent_group=prefix + group_name,
        )
    pairs = [pair for tree in trees for pair in disabled_pairs(tree)]
    # Bases in one world do not move.
    bases = [tree.links[0].name for tree in trees]
    pairs += [LinkPair(one, other, "Adjacent") for one, other in combinations(bases, 2)]
    for pair in pairs:
        ET.SubElement(robot, "disable_collisions", pair._asdict())
    return pretty(robot, "Collisions are disabled by random sampling of the shapes in the URDF.")


def _carried(tree: ArmTree) -> list[str]:
    prefix = tree.arm.prefix
    names = ("tool0",) if tree.arm.tool is None else ("tool0", "tool", "tcp")
    return [prefix + name for name in names]
