"""URDF: links with inertias and shapes, joints with limits.

URDF has no capsule, so each capsule becomes a cylinder with a sphere at both ends, as usual. It
has no meshes in its text either: without files of meshes, each surface becomes a cylinder.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np

from aioduco.descriptions.tree import WORLD, ArmTree, JointDescription, LinkDescription
from aioduco.descriptions.xml_text import bounds, numbers, pretty, rgba
from aioduco.kinematics.bodies import Capsule
from aioduco.kinematics.looks import COLOURS
from aioduco.models.rotation import Array, rpy_from_matrix

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence


def urdf_text(name: str, trees: Sequence[ArmTree], meshes: Mapping[str, Mapping[str, str]]) -> str:
    """Return the URDF of some arms in one world.

    Args:
        name: name of the robot.
        trees: the arms.
        meshes: by link, the URIs of meshes to show, by the name of their colour; "" for meshes
            with colours of their own.
    """
    robot = ET.Element("robot", name=name)
    for colour, value in COLOURS.items():
        material = ET.SubElement(robot, "material", name=f"duco_{colour}")
        ET.SubElement(material, "color", rgba=rgba(value))
    if any(joint.parent == WORLD for tree in trees for joint in tree.joints):
        ET.SubElement(robot, "link", name=WORLD)
    carried = {joint.child for tree in trees for joint in tree.joints}
    for tree in trees:
        for link in tree.links:
            _link(
                robot,
                link,
                meshes.get(link.name, {}),
                flat=link is tree.links[0],
                carried=link.name in carried,
            )
        for joint in tree.joints:
            _joint(robot, joint)
    return pretty(
        robot,
        "Shapes are made from lengths, capsules for collisions. Masses are the vendor's, inertias "
        "those of solid cylinders.",
    )


def _inertial(link: LinkDescription) -> ET.Element:
    inertial = ET.Element("inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(link.centre), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=numbers([link.mass]))
    ET.SubElement(
        inertial,
        "inertia",
        {
            f"i{a}{b}": numbers([link.inertia["xyz".index(a), "xyz".index(b)]])
            for a, b in ("xx", "xy", "xz", "yy", "yz", "zz")
        },
    )
    return inertial


def _link(
    robot: ET.Element,
    link: LinkDescription,
    meshes: Mapping[str, str],
    *,
    flat: bool,
    carried: bool,
) -> None:
    element = ET.SubElement(robot, "link", name=link.name)
    # A massless frame is said to be one: PyBullet gives a link without inertia 1 kg. KDL takes no
    # inertia of the root.
    if link.mass > 0.0 or carried:
        element.append(_inertial(link))
    for colour, uri in meshes.items():
        visual = _solid(element, "visual", np.zeros(3), np.zeros(3), "mesh", {"filename": uri})
        _paint(visual, colour)
    if not meshes:
        for look in link.looks:
            cylinder = Capsule(tuple(look.start), tuple(look.end), look.radius)
            kind, size, xyz, rpy = next(_shapes(cylinder, flat=True))
            _paint(_solid(element, "visual", xyz, rpy, kind, size), look.colour)
    for number, part in enumerate(link.parts):
        # The base must not touch the surface on which it stands.
        for kind, size, xyz, rpy in _shapes(part, flat=flat and number == 0):
            if not meshes and not link.looks:
                _paint(_solid(element, "visual", xyz, rpy, kind, size), "body")
            _solid(element, "collision", xyz, rpy, kind, size)


def _solid(
    link: ET.Element, purpose: str, xyz: Array, rpy: Array, kind: str, size: dict[str, str]
) -> ET.Element:
    solid = ET.SubElement(link, purpose)
    ET.SubElement(solid, "origin", xyz=numbers(xyz), rpy=numbers(rpy))
    ET.SubElement(ET.SubElement(solid, "geometry"), kind, size)
    return solid


def _paint(visual: ET.Element, colour: str) -> None:
    if colour:
        ET.SubElement(visual, "material", name=f"duco_{colour}")


def _shapes(part: Capsule, *, flat: bool) -> Iterator[tuple[str, dict[str, str], Array, Array]]:
    """Yield a capsule's URDF shapes: kind, sizes, position, angles; no start sphere if `flat`."""
    start, end = np.array(part.start), np.array(part.end)
    along = end - start
    length = float(np.linalg.norm(along))
    size = {"radius": numbers([part.radius])}
    if length > 0.0:
        x, y, z = along / length
        # Rotates the z axis about y, then about z.
        rpy = np.array([0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)])
        yield "cylinder", {**size, "length": numbers([length])}, (start + end) / 2, rpy
        yield "sphere", size, end, np.zeros(3)
    if not flat:
        yield "sphere", size, start, np.zeros(3)


def _joint(robot: ET.Element, joint: JointDescription) -> None:
    limits = joint.limits
    element = ET.SubElement(
        robot, "joint", name=joint.name, type="fixed" if limits is None else "revolute"
    )
    ET.SubElement(
        element,
        "origin",
        xyz=numbers(joint.position),
        rpy=numbers(rpy_from_matrix(np.asarray(joint.rotation))),
    )
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    if limits is not None:
        ET.SubElement(element, "axis", xyz="0 0 1")
        lower, upper = bounds(limits.lower, limits.upper)
        effort, velocity = (bounds(0.0, each)[1] for each in (limits.effort, limits.velocity))
        ET.SubElement(element, "limit", lower=lower, upper=upper, effort=effort, velocity=velocity)
