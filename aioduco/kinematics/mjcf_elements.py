"""Elements of MJCF, MuJoCo's format: for the simulated arm, and for its description to others."""

from __future__ import annotations

import math
from importlib import resources
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np

from aioduco.kinematics.bodies import ROTOR, Capsule
from aioduco.models.rotation import Array, quaternion_from_matrix

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


_FREQUENCY = 2 * math.pi * 25  # natural frequency of a drive that moves only its own rotor [rad/s]

_LEAST_MASS, _LEAST_INERTIA = 1e-6, 1e-9  # that MuJoCo accepts [kg, kg m²]


def numbers(values: Iterable[float]) -> str:
    """Return numbers with twelve digits; a rounding error of zero becomes zero."""
    return " ".join(f"{round(float(value), 14) + 0.0:.12g}" for value in values)


def placed(position: Iterable[float], rotation: Array) -> dict[str, str]:
    """Return the attributes for a place in the parent body; default values are left out.

    Args:
        position: x, y, z [m].
        rotation: rotation matrix. Shape (3, 3).
    """
    place = {"pos": numbers(position), "quat": numbers(quaternion_from_matrix(rotation))}
    unmoved = {"pos": "0 0 0", "quat": "1 0 0 0"}
    return {name: value for name, value in place.items() if value != unmoved[name]}


def inertial(body: ET.Element, mass: float, centre: Iterable[float], inertia: Array) -> None:
    """Add the mass of a body.

    Args:
        body: the body.
        mass: mass [kg].
        centre: centre of mass in the body's frame [m].
        inertia: about the centre, along the axes of the body's frame [kg m²]. Shape (3, 3).
    """
    diagonal = np.diag(inertia).clip(_LEAST_INERTIA)
    ET.SubElement(
        body, "inertial", pos=numbers(centre), mass=numbers([max(mass, _LEAST_MASS)]),
        fullinertia=numbers([*diagonal, *inertia[[0, 0, 1], [1, 2, 2]]]),
    )  # fmt: skip


def shape(part: Capsule) -> dict[str, str]:
    """Return the attributes of a geom: a capsule, or a sphere if its ends are the same point."""
    size = numbers([part.radius])
    if part.start == part.end:
        return {"type": "sphere", "size": size, "pos": numbers(part.start)}
    return {"type": "capsule", "size": size, "fromto": numbers([*part.start, *part.end])}


def drive(effort: float) -> tuple[float, float, float]:
    """Inertia of a drive's rotor seen through its gear [kg m²], and the drive's gains.

    The gains are for the rotor alone, the least inertia that the drive ever moves.

    Args:
        effort: largest torque of the drive [N m].

    Returns:
        The inertia, the stiffness [N m/rad], and the damping that is critical then [N m s/rad].
    """
    rotor = ROTOR * effort
    return rotor, rotor * _FREQUENCY**2, 2 * rotor * _FREQUENCY


def surround(root: ET.Element, *, size: Sequence[float], height: float = 0.0) -> None:
    """Add a sky, a light and a tiled floor.

    Args:
        root: root element of the model.
        size: half lengths of the floor [m], 0 for infinite ones, and the spacing of its grid [m].
        height: height of the floor [m].
    """
    text = resources.files("aioduco.kinematics").joinpath("surroundings.xml").read_text("utf-8")
    found = ET.fromstring("".join(line.strip() for line in text.splitlines()))
    for path, name, value in (
        # eight tiles along the floor, or in each metre of an infinite one
        *(() if all(size[:2]) else ((".//material", "texuniform", "true"),)),
        (".//geom", "size", numbers(size)),
        (".//geom", "pos", numbers((0.0, 0.0, height))),
    ):
        element = found.find(path)
        assert element is not None
        element.set(name, value)
    root.extend(found)
