"""MJCF by the conventions of MuJoCo Menagerie: default classes, visual and collision geoms, home.

Visual geoms are in group 2, collision geoms in group 3, and the keyframe `home` comes first.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np

from aioduco.descriptions.collisions import disabled_pairs
from aioduco.descriptions.tree import STATES, WORLD, ArmTree, JointDescription, LinkDescription
from aioduco.descriptions.xml_text import bounds, pretty, rgba
from aioduco.kinematics.looks import COLOURS, Look, merged
from aioduco.kinematics.mjcf_elements import drive, inertial, numbers, placed, shape, surround

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from aioduco.models.rotation import Array


#: frames that become sites; `attachment_site` is the name of the tool's place in Menagerie's arms
_SITES = {"tool0": ("tool0", "attachment_site"), "tcp": ("tcp",)}


def mjcf_text(name: str, trees: Sequence[ArmTree], meshes: Mapping[str, Path]) -> str:
    """Return the MJCF of some arms in one world.

    Args:
        name: name of the model.
        trees: the arms.
        meshes: by link, the file of a mesh to show instead of the link's own surfaces.
    """
    root = ET.Element("mujoco", model=name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    ET.SubElement(root, "option", integrator="implicitfast")
    classes = ET.SubElement(root, "default")
    asset = ET.SubElement(root, "asset")
    world = ET.SubElement(root, "worldbody")
    contact = ET.SubElement(root, "contact")
    actuator = ET.SubElement(root, "actuator")
    for tree in trees:
        _classes(classes, tree)
        for colour, value in COLOURS.items():
            ET.SubElement(asset, "material", name=tree.arm.prefix + colour, rgba=rgba(value))
        for link in tree.links:
            for colour, (points, faces) in merged(_drawn(link, meshes)).items():
                ET.SubElement(
                    asset, "mesh", name=f"{link.name}_{colour}",
                    vertex=" ".join(f"{value:.6g}" for value in points.ravel().round(5)),
                    face=" ".join(map(str, faces.ravel())),
                )  # fmt: skip
        _bodies(world, tree, meshes)
        for pair in disabled_pairs(tree):
            if pair.reason != "Never":
                ET.SubElement(contact, "exclude", body1=pair.link1, body2=pair.link2)
        for joint, limits in tree.turning:
            named = _drive_class(tree, limits.effort)
            ET.SubElement(actuator, "position", {"class": named}, name=joint.name, joint=joint.name)
    for path in sorted(set(meshes.values())):
        ET.SubElement(asset, "mesh", name=path.stem, file=str(path))
    keys = ET.SubElement(root, "keyframe")
    for state, q in STATES.items():
        if not all(state in tree.states for tree in trees):
            continue
        values = numbers(tuple(q) * len(trees))
        ET.SubElement(keys, "key", name=state, qpos=values, ctrl=values)
    return pretty(
        root,
        "Shapes are turned and lofted from lengths; capsules collide. Masses are the vendor's; "
        "inertias are those of solid cylinders; rotors and gains are assumptions.",
    )


def mjcf_scene(name: str, file: str) -> str:
    """Return a scene with a floor, light and sky around a model.

    Args:
        name: name of the model.
        file: file of the model, in the same folder.
    """
    root = ET.Element("mujoco", model=f"{name} scene")
    ET.SubElement(root, "include", file=file)
    surround(root, size=(0.0, 0.0, 0.05))
    return pretty(root, "The model on a floor.")


def _drive_class(tree: ArmTree, effort: float) -> str:
    return f"{tree.arm.prefix}drive_{numbers([effort])}"


def _classes(root: ET.Element, tree: ArmTree) -> None:
    """Add the default classes of an arm, named after it, so that models can be combined."""
    prefix, arm = tree.arm.prefix, tree.arm.arm
    top = ET.SubElement(root, "default", {"class": prefix + arm.name})
    ET.SubElement(top, "joint", axis="0 0 1")
    # Critical damping for the upright arm.
    ET.SubElement(top, "position", inheritrange="1", dampratio="1")
    visual = ET.SubElement(top, "default", {"class": prefix + "visual"})
    ET.SubElement(
        visual, "geom", type="capsule", contype="0", conaffinity="0", group="2", mass="0",
        material=prefix + "body",
    )  # fmt: skip
    collision = ET.SubElement(top, "default", {"class": prefix + "collision"})
    ET.SubElement(collision, "geom", type="capsule", group="3", mass="0")
    site = ET.SubElement(top, "default", {"class": prefix + "frame"})
    ET.SubElement(site, "site", group="4", size="0.005", rgba="0.9 0.3 0.1 1")
    for effort in sorted({limits.effort for _, limits in tree.turning}):
        size = ET.SubElement(top, "default", {"class": _drive_class(tree, effort)})
        rotor, stiffness, _ = drive(effort)
        ET.SubElement(size, "joint", armature=numbers([rotor]))
        ET.SubElement(
            size, "position", kp=numbers([stiffness]),
            forcerange=numbers([-effort, effort]),
        )  # fmt: skip


def _bodies(world: ET.Element, tree: ArmTree, meshes: Mapping[str, Path]) -> None:
    """Add the links as bodies, from the world on, and the frames as sites."""
    prefix, links = tree.arm.prefix, {link.name: link for link in tree.links}
    base = tree.links[0]
    #: for each link, the body that it is or belongs to, and its frame in that body
    made = {WORLD: (world, np.eye(4))}
    if tree.arm.mounting is None:
        made[base.name] = _body(world, np.eye(4), base, None, tree, meshes), np.eye(4)
    for joint in tree.joints:
        link = links[joint.child]
        parent, before = made[joint.parent]
        place = before @ joint.matrix
        if link.parts or link.mass:
            made[link.name] = _body(parent, place, link, joint, tree, meshes), np.eye(4)
            continue
        made[link.name] = parent, place
        for site in _SITES.get(link.name.removeprefix(prefix), ()):
            named = {"class": prefix + "frame", "name": prefix + site}
            ET.SubElement(parent, "site", {**named, **placed(place[:3, 3], place[:3, :3])})


def _body(
    parent: ET.Element,
    place: Array,
    link: LinkDescription,
    joint: JointDescription | None,
    tree: ArmTree,
    meshes: Mapping[str, Path],
) -> ET.Element:
    prefix = tree.arm.prefix
    body = ET.SubElement(parent, "body", {"name": link.name, **placed(place[:3, 3], place[:3, :3])})
    if link is tree.links[0]:
        body.set("childclass", prefix + tree.arm.arm.name)
    if link.mass > 0.0:
        inertial(body, link.mass, link.centre, link.inertia)
    if joint is not None and joint.limits is not None:
        named = _drive_class(tree, joint.limits.effort)
        ET.SubElement(
            body,
            "joint",
            {"class": named},
            name=joint.name,
            range=" ".join(bounds(*joint.limits[:2])),
        )
    if link.name in meshes:
        mesh = {"type": "mesh", "mesh": meshes[link.name].stem}
        ET.SubElement(body, "geom", {"class": prefix + "visual", **mesh})
    for colour in merged(_drawn(link, meshes)):
        mesh = {"type": "mesh", "mesh": f"{link.name}_{colour}", "material": prefix + colour}
        ET.SubElement(body, "geom", {"class": prefix + "visual", **mesh})
    for part in link.parts:
        geom = shape(part)
        if link.name not in meshes and not link.looks:
            ET.SubElement(body, "geom", {"class": prefix + "visual", **geom})
        ET.SubElement(body, "geom", {"class": prefix + "collision", **geom})
    return body


def _drawn(link: LinkDescription, meshes: Mapping[str, Path]) -> tuple[Look, ...]:
    """Return a link's own surfaces, if no other mesh is shown."""
    return () if link.name in meshes else link.looks
