"""The mounting of the arm, the things around it, and its tool.

Boxes, tables and springs are values that can be written as MJCF without MuJoCo; any other MJCF can
be used instead. In a scene, positions are in the world's frame: the floor is at z = -0.01, and an
arm on the floor has its base at the origin. In a tool, positions are in the frame of the flange.
"""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar, TypeAlias
from xml.etree import ElementTree as ET

from aioduco.errors import ParameterError, SceneError
from aioduco.kinematics.mjcf_elements import numbers, placed
from aioduco.kinematics.mounting import MountingLike, base_in_world
from aioduco.models.pose import Pose, PoseLike
from aioduco.models.ranges import OWN_NAME_OR_NONE, POSE
from aioduco.models.rules import Number, Vector, ordered, stored

if TYPE_CHECKING:
    from aioduco.kinematics import Arm


__all__ = [
    "Box",
    "Cylinder",
    "MountingLike",
    "Pad",
    "Rod",
    "SceneLike",
    "Sphere",
    "Table",
    "Thing",
    "mjcf_of",
    "mounting_of",
]

Colour = tuple[float, float, float]
_WOOD, _STEEL, _RUBBER = (0.72, 0.6, 0.45), (0.6, 0.63, 0.66), (0.2, 0.2, 0.2)
# Contact parameters of surfaces; of two surfaces in contact, the one with the higher priority
# determines them. As stiff as a step of 1 ms allows, without bouncing:
_LOOSE = {"solref": "0.004 1", "solimp": "0.99 0.999 0.0005", "priority": "1"}
# A thing that slides on it under load must not lose contact. MuJoCo subtracts friction times speed
# times the contact's damping from the force between sliding things. So the damping is low, and the
# surface bounces a bit:
_FIXED = {"solref": "0.05 0.2", "solimp": "0.5 0.5 0.001", "priority": "2"}
# The spring must give way, not the surface.
_SPRUNG = {**_LOOSE, "priority": "3"}
_PERIOD = 0.004  # period of a sprung plate over 2π: a step of 1 ms still resolves it [s]
_FLOOR = -0.01  # [m]
_LOWEST_PEDESTAL = 0.05  # [m]
_PEDESTAL = Number(0.0, 20.0, "m", source="this package")
_MASS = Number(0.0, unit="kg", source="this package")
_SIZE = Number(0.0, unit="m", open_low=True, source="this package")
#: the fields above 0 that are no lengths
_OTHERS = {
    "stiffness": Number(0.0, unit="N/m", open_low=True, source="this package"),
    "damping": Number(0.0, open_low=True, source="this package"),
}
_COLOUR = Vector(Number(0.0, 1.0, source="this package"), length=3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing(ABC):
    """An object.

    Attributes:
        at: position of its centre: x, y, z [m], or a pose of six numbers [m, rad].
        mass: mass [kg]. In a scene, an object of mass zero never moves, and any other falls and can
            be pushed; in a tool it is the mass that the arm carries.
        colour: red, green, blue, 0 to 1.
        name: name in the physics; names in a scene must differ.
    """

    at: PoseLike = (0.0, 0.0, 0.0)
    mass: float = 0.0
    colour: Colour = _STEEL
    name: str = ""

    _anchored: ClassVar[bool] = False
    #: names of the fields that must be above 0; one that is None by default may be
    _sizes: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        _pose(self.at)
        object.__setattr__(self, "at", tuple(map(float, self.at)))  # not the caller's own list
        stored(self, mass=_MASS)
        OWN_NAME_OR_NONE("name", self.name)
        object.__setattr__(self, "colour", tuple(_COLOUR("colour", self.colour)))
        defaults = {field.name: field.default for field in fields(self)}
        for name in self._sizes:
            default = defaults[name]
            if getattr(self, name) is default is None:
                continue
            if isinstance(default, tuple):
                rule = Vector(_SIZE, length=len(default))
                object.__setattr__(self, name, tuple(rule(name, getattr(self, name))))
            else:
                stored(self, **{name: _OTHERS.get(name, _SIZE)})

    @abstractmethod
    def _shapes(self, body: ET.Element) -> None:
        """Add the geometry to the body."""

    def mjcf(self, *, free: bool) -> ET.Element:
        """Give the object as an MJCF body.

        Args:
            free: whether an object with a mass may move on its own, as in a scene; a tool is one
                rigid piece.
        """
        pose = _pose(self.at)
        body = ET.Element("body", placed(pose[:3], pose.matrix[:3, :3]))
        if self.name:
            body.set("name", self.name)
        if free and self.mass > 0.0 and not self._anchored:
            ET.SubElement(body, "freejoint")
        self._shapes(body)
        return body

    def assets(self) -> list[ET.Element]:
        """The elements of MJCF for the object outside of the world."""
        return []

    def _geom(self, body: ET.Element, kind: str, size: Iterable[float], **more: str) -> None:
        look = {"rgba": numbers((*self.colour, 1.0)), "mass": numbers((self.mass,))}
        shape = {"type": kind, "size": numbers(size)}
        surface = _LOOSE if self.mass > 0.0 else _FIXED
        ET.SubElement(body, "geom", {**surface, **look, **shape, **more})

    def _plate(
        self, body: ET.Element, size: tuple[float, float, float], surface: dict[str, str]
    ) -> None:
        """Add a box whose top is at the origin of the body."""
        half = tuple(0.5 * length for length in size)
        self._geom(body, "box", half, pos=numbers((0, 0, -half[2])), mass="0", **surface)


@dataclass(frozen=True, slots=True, kw_only=True)
class Box(Thing):
    """A box.

    Attributes:
        size: full lengths along x, y, z [m].
    """

    size: tuple[float, float, float] = (0.1, 0.1, 0.1)

    _sizes: ClassVar[tuple[str, ...]] = ("size",)

    def _shapes(self, body: ET.Element) -> None:
        self._geom(body, "box", (0.5 * length for length in self.size))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sphere(Thing):
    """A sphere.

    Attributes:
        radius: radius [m].
    """

    radius: float = 0.05

    _sizes: ClassVar[tuple[str, ...]] = ("radius",)

    def _shapes(self, body: ET.Element) -> None:
        self._geom(body, "sphere", (self.radius,))


@dataclass(frozen=True, slots=True, kw_only=True)
class Cylinder(Thing):
    """A cylinder along its z axis.

    Attributes:
        radius: radius [m].
        length: length [m].
    """

    radius: float = 0.05
    length: float = 0.1

    _sizes: ClassVar[tuple[str, ...]] = ("radius", "length")

    def _shapes(self, body: ET.Element) -> None:
        self._geom(body, "cylinder", (self.radius, 0.5 * self.length))


@dataclass(frozen=True, slots=True, kw_only=True)
class Rod(Thing):
    """A rod along its z axis, from a flat end at `at` to a round tip; as a tool, a probe.

    The tip is `length` away from `at`: `Rod(length=0.12)` as a tool has it at (0, 0, 0.12).

    Attributes:
        length: distance from `at` to the tip [m].
        radius: radius of the rod and its tip [m].
    """

    length: float = 0.1
    radius: float = 0.015

    _sizes: ClassVar[tuple[str, ...]] = ("length", "radius")

    def _shapes(self, body: ET.Element) -> None:
        straight = max(self.length - self.radius, 1e-4)
        # The upper end of the cylinder is inside the sphere, so the rod has a round tip.
        self._geom(
            body, "cylinder", (self.radius, 0.5 * straight), pos=numbers((0, 0, 0.5 * straight))
        )
        self._geom(
            body, "sphere", (self.radius,), pos=numbers((0, 0, self.length - self.radius)), mass="0"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Pad(Thing):
    """A plate on a spring, which gives way along its z axis only.

    A force F presses it down by F / stiffness. Its own weight does not load the spring: without a
    force, its top is at `at`.

    Attributes:
        at: centre of its top.
        size: lengths along x and y, thickness [m].
        stiffness: stiffness of the spring [N/m].
        damping: damping ratio of the plate on its spring, 1 for no vibration.
        travel: largest distance by which it can be pressed [m]; there it meets a hard stop.
    """

    size: tuple[float, float, float] = (0.1, 0.1, 0.02)
    stiffness: float = 10_000.0
    damping: float = 1.0
    travel: float = 0.03
    colour: Colour = _RUBBER

    _anchored: ClassVar[bool] = True
    _sizes: ClassVar[tuple[str, ...]] = ("size", "stiffness", "damping", "travel")

    def _shapes(self, body: ET.Element) -> None:
        plate = _sprung(body, self.stiffness, self.damping, self.travel, self.name)
        self._plate(plate, self.size, _SPRUNG)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table(Thing):
    """A table on four legs, with a hard or a sprung top.

    Attributes:
        at: centre of its top.
        size: lengths along x and y [m].
        stiffness: stiffness of the top along z [N/m]; None for a hard top.
        damping: damping ratio of a sprung top, 1 for no vibration.
        height: distance from the feet of the legs to the top [m]; None for legs down to the floor.
    """

    size: tuple[float, float] = (0.6, 0.4)
    stiffness: float | None = None
    damping: float = 1.0
    height: float | None = None
    colour: Colour = _WOOD

    _anchored: ClassVar[bool] = True
    _sizes: ClassVar[tuple[str, ...]] = ("size", "damping", "stiffness", "height")

    def _shapes(self, body: ET.Element) -> None:
        top = body
        if self.stiffness is not None:
            top = _sprung(body, self.stiffness, self.damping, 0.05, self.name)
        self._plate(top, (*self.size, 0.02), _FIXED if top is body else _SPRUNG)
        self._legs(body, self.at[2] - _FLOOR if self.height is None else self.height)

    def _legs(self, body: ET.Element, height: float) -> None:
        # A sprung top needs room below it for its travel.
        above, thick = (0.02 if self.stiffness is None else 0.08), 0.02
        half = 0.5 * (height - above)
        if half <= 0.0:
            return
        for x in (-1.0, 1.0):
            for y in (-1.0, 1.0):
                leg = (x * (0.5 * self.size[0] - thick), y * (0.5 * self.size[1] - thick))
                self._geom(
                    body, "cylinder", (thick, half), pos=numbers((*leg, -above - half)), mass="0"
                )


def _sprung(
    body: ET.Element, stiffness: float, damping: float, travel: float, name: str
) -> ET.Element:
    plate = ET.SubElement(body, "body", gravcomp="1")
    # Light enough not to act as a load, heavy enough for the time step.
    mass = max(0.1, stiffness * _PERIOD**2)
    joint = ET.SubElement(
        plate, "joint", type="slide", axis="0 0 1", limited="true", range=numbers((-travel, 0.0)),
        stiffness=numbers((stiffness,)), margin="0",
        damping=numbers((2.0 * damping * math.sqrt(stiffness * mass),)),
    )  # fmt: skip
    if name:
        plate.set("name", f"{name}/plate")
        joint.set("name", f"{name}/spring")
    ET.SubElement(
        plate,
        "inertial",
        pos="0 0 0",
        mass=numbers((mass,)),
        diaginertia=numbers((0.01 * mass,) * 3),
    )
    return plate


def _pose(at: PoseLike) -> Pose:
    expected = "three numbers [m], or a pose of six [m, rad]"
    given = ordered("at", at, expected)
    if len(given) not in (3, 6):
        raise ParameterError("at", at, expected)
    return Pose(*POSE("at", [*given, 0.0, 0.0, 0.0][:6]))


SceneLike: TypeAlias = str | os.PathLike[str] | Sequence[Thing]
"""Path of an MJCF file, MJCF as text, or things."""


def mjcf_of(scene: SceneLike, *, free: bool = True) -> str:
    """Give a scene as one text: MJCF, or the absolute path of an MJCF file.

    Args:
        scene: a path, MJCF text (a string that begins with "<"), or things.
        free: whether things with a mass may move on their own; not so in a tool.

    Raises:
        SceneError: The scene is none of these.
    """
    # a byte order mark, as of a file of Windows that the program has read, is no text
    if isinstance(scene, str) and (text := scene.lstrip("\ufeff \t\r\n")).startswith("<"):
        return text
    if isinstance(scene, str | os.PathLike):
        return os.path.abspath(scene)  # noqa: PTH100 - a path that need not exist here
    try:
        things = iter(scene)
    except TypeError:
        wrong = f"{scene!r} is no scene: give things, or one file, or MJCF as text"
        raise SceneError(wrong) from None
    root = ET.Element("mujoco")
    world = ET.SubElement(root, "worldbody")
    for thing in things:
        if not isinstance(thing, Thing):
            raise SceneError(f"{thing!r} is no thing: give things, or one file, or MJCF as text")
        if assets := thing.assets():
            ET.SubElement(root, "asset").extend(assets)
        world.append(thing.mjcf(free=free))
    return ET.tostring(root, encoding="unicode")


def mounting_of(mounting: MountingLike, arm: Arm, pedestal: float = 0.0) -> Pose:
    """Give the pose of an arm's base in the world, where the z axis is up and the floor at z = 0.

    Args:
        mounting: as for `base_in_world`.
        arm: the arm.
        pedestal: height of a column under an arm on the floor [m].

    Raises:
        SceneError: The mounting is neither a name nor a pose, the pedestal is out of range, or an
            arm that is not on the floor has a pedestal.
    """
    try:
        height = _PEDESTAL("pedestal", pedestal)
    except ParameterError as exc:
        raise SceneError(str(exc)) from None
    if height:
        if not isinstance(mounting, str) or mounting != "floor":
            raise SceneError("a pedestal is for an arm on the floor: give the height by mounting")
        if height < _LOWEST_PEDESTAL:
            raise SceneError(f"pedestal is {height}, but must be 0 or from {_LOWEST_PEDESTAL} m")
        return Pose(0.0, 0.0, height, 0.0, 0.0, 0.0)
    try:
        return base_in_world(mounting, arm)
    except ParameterError as exc:
        if isinstance(mounting, str):
            raise SceneError(f"no mounting is called {mounting!r}: {exc.expected}") from None
        raise SceneError(f"mounting is {mounting!r}, but must be {exc.expected}") from None
