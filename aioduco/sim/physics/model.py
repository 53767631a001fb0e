"""The MuJoCo model: an arm made of its lengths and masses, without meshes; its tool and scene."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

from aioduco.errors import SceneError
from aioduco.kinematics.bodies import Body, bodies, flange_on_link6
from aioduco.kinematics.looks import COLOURS, looks, merged
from aioduco.kinematics.mjcf_elements import drive, inertial, numbers, placed, shape, surround
from aioduco.models.pose import Pose

if TYPE_CHECKING:
    from aioduco.kinematics import Arm

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


SERVOS = 5
"""Group of the servos, which lose their power together; a scene's drives are in others."""

_HIDDEN = 3  # group of geoms that are not drawn
# MuJoCo's friction yields a little under load: these are its stiffest parameters.
_FIRM = "0.9999 0.9999 0.001 0.5 2"
_GAP = 0.01  # between the base and what it stands on, so that a link may come close to it [m]
# Housings that overlap in every configuration, besides those of neighbours.
_NESTED = (("base", "link1"), ("base", "link2"), ("link4", "link6"))
_TUBE, _JOINT = "0.9 0.91 0.92 1", "0.16 0.36 0.62 1"  # colours


def mjcf(arm: Arm, timestep: float, mounting: Pose | None = None, *, pedestal: bool = False) -> str:
    """Give the model as MJCF.

    Joints are named joint1 to joint6, their servos likewise. The flange is a site of that name,
    on a body without mass of its own that a force-torque sensor joins to link 6; its frame is
    that of `Arm.fkine`.

    Args:
        arm: the arm.
        timestep: time step of the simulation [s].
        mounting: pose of the base in the world, whose z axis is up; None for on the floor.
        pedestal: whether a base that is off the floor stands on a column instead of a plate.
    """
    root = ET.Element("mujoco", model=arm.name)
    ET.SubElement(root, "compiler", angle="radian", autolimits="true")
    option = ET.SubElement(
        root, "option", timestep=f"{timestep:.9g}", integrator="implicitfast", cone="elliptic"
    )
    ET.SubElement(option, "flag", eulerdamp="disable")
    surround(root, size=(3.0, 3.0, 0.1), height=-_GAP)
    world = root.find("worldbody")
    assert world is not None
    links = bodies(arm)
    place = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0) if mounting is None else mounting
    where = placed(place[:3], place.matrix[:3, :3])
    parent = ET.SubElement(world, "body", {"name": "base", **where})
    if pedestal:
        wide, high = 1.5 * links[0].parts[0].radius, 0.5 * place[2]
        ET.SubElement(
            parent, "geom", name="pedestal", type="box", size=numbers((wide, wide, high)),
            pos=numbers((0.0, 0.0, -_GAP - high)), rgba="0.6 0.63 0.66 1",
        )  # fmt: skip
    elif any(place):
        # A base off the floor stands on a plate. The arm cannot pass through it either.
        half = 0.3 * arm.reach
        ET.SubElement(
            parent, "geom", name="plate", type="box", size=numbers((half, half, 0.01)),
            pos="0 0 -0.02", rgba="0.6 0.63 0.66 1",
        )  # fmt: skip
    _solid(parent, links[0], "base")
    actuator = ET.Element("actuator")
    for i, link in enumerate(links[1:], start=1):
        where = placed(link.position, link.rotation)
        parent = ET.SubElement(parent, "body", {"name": f"link{i}", **where})
        effort = arm.effort[i - 1]
        rotor, stiffness, damping = drive(effort)
        ET.SubElement(
            parent, "joint", name=f"joint{i}", type="hinge", axis="0 0 1",
            range=numbers((arm.lower[i - 1], arm.upper[i - 1])), armature=numbers([rotor]),
            solreffriction=f"{2 * timestep:.9g} 1", solimpfriction=_FIRM,
        )  # fmt: skip
        _solid(parent, link, f"link{i}")
        # MuJoCo integrates the damping implicitly.
        ET.SubElement(
            actuator, "position", name=f"servo{i}", joint=f"joint{i}", kp=numbers([stiffness]),
            kv=numbers([damping]), forcerange=numbers((-effort, effort)),
            group=str(SERVOS),
        )  # fmt: skip
    on = flange_on_link6(arm)
    held = placed(on[:3, 3], on[:3, :3])
    flange = ET.SubElement(parent, "body", {"name": "flange", **held})
    # The sensor measures what touches this geom; the link behind it is set back a little.
    thick, wide = 0.002, links[6].parts[0].radius
    ET.SubElement(
        flange, "geom", name="flange_0", type="cylinder", size=numbers((wide, thick)),
        pos=numbers((0.0, 0.0, -thick)), rgba=_TUBE, contype="2", conaffinity="3", mass="0",
    )  # fmt: skip
    # Not at its origin: older versions of MuJoCo would then keep loads at the origin, too.
    ET.SubElement(
        flange, "inertial", pos="0.001 0.001 0.001", mass="1e-6", diaginertia="1e-9 1e-9 1e-9"
    )
    ET.SubElement(flange, "site", name="flange", size="0.004", rgba="0.9 0.3 0.1 1")
    contact = ET.SubElement(root, "contact")
    for one, other in _NESTED:
        ET.SubElement(contact, "exclude", body1=one, body2=other)
    root.append(actuator)
    sensor = ET.SubElement(root, "sensor")
    ET.SubElement(sensor, "force", name="force", site="flange")
    ET.SubElement(sensor, "torque", name="torque", site="flange")
    return ET.tostring(root, encoding="unicode")


def _solid(parent: ET.Element, link: Body, name: str) -> None:
    inertial(parent, link.mass, link.centre, link.inertia)
    # By these bits they touch each other and the world, whose geoms have MuJoCo's default, 1 and 1.
    for i, part in enumerate(link.parts):
        ET.SubElement(
            parent, "geom", shape(part), name=f"{name}_{i}",
            rgba=_JOINT if part.joint else _TUBE, contype="2", conaffinity="3", mass="0",
        )  # fmt: skip


def assemble(arm: str, scene: str | None, tool: str | None) -> Any:
    """Build MuJoCo's specification of an arm with its tool and its scene, to be `compiled`.

    The arm comes first, so that its joints, drives and sensors have the first indices. Names of a
    scene get the prefix "scene/", those of a tool "tool/". Options of both have no effect: those of
    the arm apply, since its drives are made for its time step. A plane of the scene with the name
    "floor" replaces the arm's.

    Args:
        arm: the arm as MJCF, with a body "flange" and a geom "floor".
        scene: MJCF, or the path of a file of it; placed in the world.
        tool: likewise, rigidly placed at the flange.

    Raises:
        SceneError: MuJoCo rejects the scene or the tool; the message says why.
    """
    spec = mujoco.MjSpec.from_string(arm)
    if tool is not None:
        body = spec.body("flange").add_body(name="tool")
        spec.attach(part("tool", tool, spec), prefix="tool/", frame=body.add_frame())
    if scene is not None:
        around = part("scene", scene, spec)
        if around.geom("floor") is not None:
            spec.delete(spec.geom("floor"))
        spec.attach(around, prefix="scene/", frame=spec.worldbody.add_frame())
    return spec


def dressed(spec: Any, arm: Arm) -> Any:
    """Compile a specification for pictures: the arm shows its looks, not the bodies that collide.

    Only what is drawn differs: positions and bodies are those of the model that moves, which has no
    meshes, since it is compiled more often than it is drawn.

    Args:
        spec: specification, as `assemble` gives it; it is not changed.
        arm: its arm.
    """
    shown = spec.copy()
    for number, parts in enumerate(looks(arm)):
        name = f"link{number}" if number else "base"
        body = shown.body(name)
        for geom in body.geoms:
            if geom.name.startswith(f"{name}_"):
                geom.group = _HIDDEN
        for colour, (points, faces) in merged(parts).items():
            mesh = f"{name}_{colour}"
            shown.add_mesh(name=mesh, uservert=points.ravel(), userface=faces.ravel())
            body.add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, rgba=(*COLOURS[colour], 1.0),
                contype=0, conaffinity=0, mass=0.0,
            )  # fmt: skip
    shown.geom("flange_0").group = _HIDDEN
    return compiled(shown)


def compiled(spec: Any) -> Any:
    """Compile a specification.

    Raises:
        SceneError: MuJoCo rejects it; the message says why.
    """
    try:
        return spec.compile()
    except ValueError as exc:
        raise SceneError(f"scene and tool make no model: {exc}") from exc


def part(name: str, text: str, spec: Any) -> Any:
    """Read MJCF that is to be attached to a specification, with the options of that specification.

    Args:
        name: name of the part, for error messages.
        text: MJCF, or the path of a file of it.
        spec: specification that it will be attached to.

    Raises:
        SceneError: MuJoCo rejects it; the message says why.
    """
    inline = text.lstrip().startswith("<")
    if not inline and not os.path.isfile(text):  # noqa: PTH113 - a path given as text
        raise SceneError(f"the {name}'s file {text} does not exist")
    try:
        found = (mujoco.MjSpec.from_string if inline else mujoco.MjSpec.from_file)(text)
    except ValueError as exc:
        raise SceneError(f"the {name} is no MJCF: {exc}") from exc
    for option in dir(spec.option):
        if not option.startswith("_"):
            setattr(found.option, option, getattr(spec.option, option))
    return found
