"""The links as solid bodies: their places, shapes and inertias.

The masses and centres of mass are the vendor's. The inertias of its URDFs are not usable (1e-5
kg m² for a link of 4.7 kg). So each link is modelled as a solid cylinder of its mass, along the
link and about its centre of mass. Frames are those of the modified Denavit-Hartenberg convention,
T_i = Rx(alpha_{i-1})·Tx(a_{i-1})·Rz(q_i + theta_i)·Tz(d_i): their z axis is the joint's.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from aioduco.models.rotation import transform

if TYPE_CHECKING:
    from aioduco.kinematics.arm import Arm
    from aioduco.models.rotation import Array


ROTOR = 0.002
"""Inertia of a drive's rotor, seen through its gear, per torque [kg m²/(N m)].

An assumption: 0.4 kg m² for a drive of 200 N m, such as a rotor of 4e-5 kg m² behind 1:100.
"""

_Point: TypeAlias = tuple[float, float, float]


class Capsule(NamedTuple):
    """A part of a link: a cylinder with round ends, in the link's frame.

    Attributes:
        start: one end of its axis [m].
        end: the other end [m].
        radius: radius [m].
        joint: whether it is the housing of a joint, and not a tube between joints.
    """

    start: _Point
    end: _Point
    radius: float
    joint: bool = False


class Body(NamedTuple):
    """A link as a solid.

    Attributes:
        position: origin of its frame in that of the link before [m]. Shape (3,).
        rotation: rotation of its frame in that of the link before, at joint angle zero. Shape
            (3, 3).
        parts: capsules of its shape; the first one determines the inertia.
        mass: mass [kg].
        centre: centre of mass [m]. Shape (3,).
        inertia: inertia about the centre of mass, in the link's frame [kg m²]. Shape (3, 3).
    """

    position: Array
    rotation: Array
    parts: tuple[Capsule, ...]
    mass: float
    centre: Array
    inertia: Array


def bodies(arm: Arm) -> tuple[Body, ...]:
    """Return the base and the six links of an arm."""
    g = arm.geometry
    along = (0.0, *g.a[:5])  # a_{i-1}
    twists = (0.0, *g.alpha[:5])  # alpha_{i-1}
    positions, rotations = [np.zeros(3)], [np.eye(3)]
    for i in range(6):
        twist = _turn(twists[i], 0)
        positions.append(twist @ np.array([0.0, 0.0, g.d[i]]) + np.array([along[i], 0.0, 0.0]))
        rotations.append(twist @ _turn(g.theta[i], 2))
    return tuple(
        Body(
            positions[i],
            rotations[i],
            parts,
            arm.masses[i],
            np.array(arm.centres[i]),
            cylinder_inertia(arm.masses[i], parts[0]),
        )
        for i, parts in enumerate(_parts(arm))
    )


def flange_on_link6(arm: Arm) -> Array:
    """Return the flange in the frame of link 6, which it is but for an arm's corrections.

    Returns:
        A homogeneous matrix. Shape (4, 4).
    """
    geometry = arm.geometry
    return transform(_turn(geometry.alpha[5], 0), np.array([geometry.a[5], 0.0, 0.0]))


def _parts(arm: Arm) -> tuple[tuple[Capsule, ...], ...]:
    g = arm.geometry
    # Upper arm and forearm lie beside their joints, at the offset of their centres of mass.
    upper, fore = arm.centres[2][2], arm.centres[3][2]
    # The sizes of the wrist's housings follow from its lengths, and those of the other housings
    # from the wrist's: approximately as in photographs of the arms.
    wrist, tube, shoulder = 0.42 * g.d5, 0.5 * g.d5, 0.7 * g.d5
    # It extends into the base, with a clearance of 5 mm to the mounting surface.
    neck = min(0.4 * g.d1, g.d1 - 0.97 * shoulder - 0.005)
    origin = (0.0, 0.0, 0.0)
    return (
        (Capsule(origin, (0.0, 0.0, 0.5 * g.d1), shoulder, joint=True),),
        (
            Capsule(origin, (0.0, max(g.d2 + upper - shoulder, 0.0), 0.0), shoulder, joint=True),
            Capsule((0.0, 0.0, -neck), origin, 0.97 * shoulder),
        ),
        (
            Capsule((0.0, 0.0, upper), (g.a2, 0.0, upper), tube),
            Capsule(
                (0.0, 0.0, upper - tube), (0.0, 0.0, upper + 0.2 * tube), 1.2 * tube, joint=True
            ),
            Capsule((g.a2, 0.0, upper), (g.a2, 0.0, upper - tube), 1.1 * tube),
        ),
        (
            Capsule((0.0, 0.0, fore), (g.a3, 0.0, fore), 0.85 * tube),
            Capsule((0.0, 0.0, fore), (0.0, 0.0, fore + tube), tube, joint=True),
        ),
        (
            Capsule(origin, (0.0, -g.d5, 0.0), wrist),
            Capsule((0.0, 0.0, 0.7 * fore), origin, wrist, joint=True),
        ),
        (
            Capsule(origin, (0.0, g.d6 - wrist, 0.0), wrist),
            Capsule((0.0, 0.0, -0.5 * wrist), (0.0, 0.0, 0.5 * wrist), 1.02 * wrist, joint=True),
        ),
        (Capsule((0.0, 0.0, -0.65 * wrist), (0.0, 0.0, -0.55 * wrist), 0.5 * wrist, joint=True),),
    )


def _turn(angle: float, axis: int) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def cylinder_inertia(mass: float, part: Capsule) -> Array:
    """Return the inertia of a solid cylinder with a capsule's length and radius, about its centre.

    Args:
        mass: mass [kg].
        part: the capsule.

    Returns:
        The inertia, in the capsule's frame [kg m²]. Shape (3, 3).
    """
    axis = np.array(part.end) - np.array(part.start)
    length = float(np.linalg.norm(axis))
    axis = axis / length if length else np.array([0.0, 0.0, 1.0])
    length += 2 * part.radius
    across = mass * (3 * part.radius**2 + length**2) / 12
    about = mass * part.radius**2 / 2
    inertia: Array = across * np.eye(3) + (about - across) * np.outer(axis, axis)
    return inertia
