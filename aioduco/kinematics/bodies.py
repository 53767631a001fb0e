"""The links as solid bodies: where they are, how thick, and what inertia that gives them.

The masses and centres of mass are the vendor's. The inertias of its URDFs are not usable (1e-5
kg m² for a link of 4.7 kg), so that each link is taken as a solid cylinder of its mass, along the
link and about its centre of mass. Frames are those of the modified Denavit-Hartenberg convention,
T_i = Rx(alpha_{i-1})·Tx(a_{i-1})·Rz(q_i + theta_i)·Tz(d_i): their z axis is the joint's.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from aioduco.kinematics.arm import Arm
    from aioduco.models.rotation import Array

__all__ = ["ROTOR", "Body", "bodies"]

_DENSITY = 1200.0  # kg/m³: castings of aluminium with drives in them; an assumption
_THINNEST = 0.025  # m

ROTOR = 0.002
"""Inertia of a drive's rotor, seen through its gear, per torque [kg m²/(N m)].

An assumption: 0.4 kg m² for a drive of 200 N m, such as a rotor of 4e-5 kg m² behind 1:100.
"""


class Body(NamedTuple):
    """A link as a solid.

    Attributes:
        position: origin of its frame in that of the link before [m]. Shape (3,).
        rotation: of its frame in that of the link before, at zero. Shape (3, 3).
        start: one end of its axis [m]. Shape (3,).
        end: the other end [m]. Shape (3,).
        radius: thickness [m].
        mass: kg.
        centre: centre of mass [m]. Shape (3,).
        inertia: about the centre of mass, in the link's frame [kg m²]. Shape (3, 3).
    """

    position: Array
    rotation: Array
    start: Array
    end: Array
    radius: float
    mass: float
    centre: Array
    inertia: Array


def bodies(arm: Arm) -> tuple[Body, ...]:
    """Give the base and the six links of an arm."""
    g = arm.geometry
    centres = np.array(arm.centres)
    # The axis of each link in its frame; the upper arm and the forearm lie beside their joints,
    # as far as their centres of mass do.
    upper, fore = centres[2, 2], centres[3, 2]
    axes = (
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.6 * g.d1)),
        ((0.0, 0.0, 0.0), (0.0, g.d2 + min(upper, 0.0), 0.0)),
        ((0.0, 0.0, upper), (g.a2, 0.0, upper)),
        ((0.0, 0.0, fore), (g.a3, 0.0, fore)),
        ((0.0, 0.0, 0.0), (0.0, -g.d5, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 0.5 * g.d6, 0.0)),
        ((0.0, 0.0, -0.5 * g.d6), (0.0, 0.0, 0.0)),
    )
    along = (0.0, 0.0, g.a2, g.a3, 0.0, 0.0)  # a_{i-1}
    twists = (0.0, *g.alpha[:5])
    found = [_body(np.zeros(3), np.eye(3), axes[0], arm.masses[0], centres[0])]
    for i in range(6):
        c, s = math.cos(twists[i]), math.sin(twists[i])
        twist = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        c, s = math.cos(g.theta[i]), math.sin(g.theta[i])
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        position = twist @ np.array([0.0, 0.0, g.d[i]]) + np.array([along[i], 0.0, 0.0])
        found.append(_body(position, twist @ turn, axes[i + 1], arm.masses[i + 1], centres[i + 1]))
    return tuple(found)


def _body(
    position: Array,
    rotation: Array,
    axis: tuple[tuple[float, ...], tuple[float, ...]],
    mass: float,
    centre: Array,
) -> Body:
    start, end = np.array(axis[0]), np.array(axis[1])
    length = float(np.linalg.norm(end - start))
    direction = (end - start) / length
    radius = max(math.sqrt(mass / (_DENSITY * math.pi * length)), _THINNEST)
    across = mass * (3 * radius**2 + length**2) / 12
    about = mass * radius**2 / 2
    inertia = across * np.eye(3) + (about - across) * np.outer(direction, direction)
    return Body(position, rotation, start, end, radius, mass, centre, inertia)
