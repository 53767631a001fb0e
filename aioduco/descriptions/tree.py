"""An arm in the form that ROS uses: links connected by joints, with names, shapes and inertias."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.errors import ParameterError
from aioduco.kinematics.bodies import Capsule, bodies, cylinder_inertia, flange_on_link6
from aioduco.kinematics.catalogue import arm_given
from aioduco.kinematics.looks import Look, looks
from aioduco.kinematics.mounting import MountingLike, base_in_world
from aioduco.models import ranges
from aioduco.models.pose import Joints, Pose, PoseLike
from aioduco.models.rotation import Array, transform
from aioduco.models.rules import FARTHEST, Number, Vector, VectorLike, stored

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from aioduco.kinematics.arm import Arm


WORLD = "world"
"""The link that arms are mounted in."""

STATES: Mapping[str, Joints] = {
    "home": Joints.deg(30, -15, 105, 0, -90, 0),
    "up": Joints(0, 0, 0, 0, 0, 0),
    "ahead": Joints.deg(0, -15, 105, 0, -90, 0),
}
"""Configurations by name: `home` and `ahead` have the flange down, `up` is straight up."""

WORD = re.compile(r"[A-Za-z]\w*", re.ASCII)
"""What names of models and prefixes consist of."""

_THREE = Vector(Number(source="this package"), length=3, source="this package")
_PLACE = Vector(Number(unit="m", plausible=FARTHEST, source="this package"), length=3)
_RADIUS = Number(0.0, unit="m", open_low=True, plausible=FARTHEST, source="this package")
_DENSITY = 2700.0  # density of aluminium, for tools of unknown size [kg/m³]


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolDescription:
    """A tool that is rigidly fixed to the flange (工具).

    Attributes:
        mass: mass [kg].
        centre: centre of mass in the frame of the flange [m].
        tcp: tip of the tool (工具中心点) in the frame of the flange [m, rad].
        parts: its shape: capsules in the frame of the flange, for display and collisions.
        inertia: three moments of inertia about the centre of mass, along the axes of the flange
            [kg m²]. By default those of a cylinder of the size of the first part, or without parts,
            those of a ball of aluminium.
    """

    mass: float = 0.0
    centre: Sequence[float] = (0.0, 0.0, 0.0)
    tcp: PoseLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    parts: Sequence[Capsule] = ()
    inertia: Sequence[float] | None = None

    def __post_init__(self) -> None:
        stored(self, mass=ranges.FROM_0)
        # Stored as tuples: what becomes of the caller's own lists has no effect.
        object.__setattr__(self, "tcp", tuple(ranges.POSE("tcp", self.tcp)))
        object.__setattr__(self, "centre", tuple(_PLACE("centre", self.centre)))
        if self.inertia is not None:
            inertia = tuple(_THREE("inertia", self.inertia))
            low, middle, high = sorted(inertia)
            if not 0.0 < low <= high <= low + middle:
                raise ParameterError(
                    "inertia", self.inertia, "three numbers above 0, none above the others' sum"
                )
            object.__setattr__(self, "inertia", inertia)
        if not isinstance(self.parts, (list, tuple)):
            raise ParameterError("parts", self.parts, "a list of Capsules")
        parts = []
        for number, part in enumerate(self.parts):
            if not isinstance(part, Capsule):
                raise ParameterError(f"parts[{number}]", part, "a Capsule")
            start, end = (_point(name, getattr(part, name)) for name in ("start", "end"))
            radius = _RADIUS("radius", part.radius)
            parts.append(part._replace(start=start, end=end, radius=radius))
        object.__setattr__(self, "parts", tuple(parts))

    def inertias(self) -> Array:
        """Return the inertia about the centre of mass, in the flange's frame. Shape (3, 3)."""
        if self.inertia is not None:
            return np.diag(np.asarray(self.inertia, dtype=np.float64))
        if self.parts:
            return cylinder_inertia(self.mass, self.parts[0])
        radius = (0.75 * self.mass / (math.pi * _DENSITY)) ** (1 / 3)
        return np.diag((0.4 * self.mass * radius**2,) * 3)


@dataclass(frozen=True, slots=True)
class ArmDescription:
    """An arm with the names of its parts, its mounting and its tool.

    Attributes:
        model: the model, such as "gcr5_910", or an `Arm` with your own numbers.
        prefix: prefix of every name of a link, joint, group and controller; arms in one file need
            different ones.
        mounting: "floor", "wall", "ceiling", or the pose of the base in the world [m, rad]: a fixed
            joint from the link "world" to the base. None for a base without a world, which you
            join to a link of your own.
        tool: tool at the flange; None for no tool.

    Raises:
        ParameterError: there is no such model or mounting; the prefix is not a word; the tool is
            no `ToolDescription`.
    """

    model: str | Arm
    prefix: str = ""
    mounting: MountingLike | None = "floor"
    tool: ToolDescription | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.prefix, str) or (self.prefix and not WORD.fullmatch(self.prefix)):
            raise ParameterError("prefix", self.prefix, "letters, digits and _, a letter first")
        if self.mounting is not None and not isinstance(self.mounting, str):
            object.__setattr__(self, "mounting", tuple(ranges.POSE("mounting", self.mounting)))
        if not isinstance(self.tool, (ToolDescription, type(None))):
            raise ParameterError("tool", self.tool, "a ToolDescription, or None for no tool")
        self.tree()

    @property
    def arm(self) -> Arm:
        """The arm with its numbers."""
        return arm_given("model", self.model)

    def tree(self) -> ArmTree:
        """Return the links and joints."""
        arm, tool, name = self.arm, self.tool, self.prefix.__add__
        solids = bodies(arm)
        chain = [name("base_link"), *(name(f"link_{i}") for i in range(1, 7))]
        links = [
            LinkDescription(link, body.parts, body.mass, body.centre, body.inertia, shown)
            for link, body, shown in zip(chain, solids, looks(arm), strict=True)
        ]
        joints = []
        if self.mounting is not None:
            place = base_in_world(self.mounting, arm).matrix
            joints.append(_fixed(name("world-base_link"), WORLD, chain[0], place))
        limits = zip(arm.lower, arm.upper, arm.velocity, arm.effort, arm.acceleration, strict=True)
        for i, limit in enumerate(limits, start=1):
            joints.append(
                JointDescription(
                    name(f"joint_{i}"),
                    chain[i - 1],
                    chain[i],
                    solids[i].position,
                    solids[i].rotation,
                    JointLimits(*limit),
                )
            )
        added = [
            ("base_link", LinkDescription(name("base")), np.eye(4)),
            ("link_6", LinkDescription(name("flange")), flange_on_link6(arm) @ _REP_199),
            ("flange", LinkDescription(name("tool0")), _REP_199.T),
        ]
        if tool is not None:
            centre = np.asarray(tool.centre, dtype=np.float64)
            body = LinkDescription(
                name("tool"), tuple(tool.parts), tool.mass, centre, tool.inertias()
            )
            added.append(("tool0", body, np.eye(4)))
            added.append(("tool0", LinkDescription(name("tcp")), Pose.of(tool.tcp).matrix))
        for parent, link, pose in added:
            called = f"{parent}-{link.name.removeprefix(self.prefix)}"
            links.append(link)
            joints.append(_fixed(name(called), name(parent), link.name, pose))
        return ArmTree(self, tuple(links), tuple(joints))


def _point(name: str, value: VectorLike) -> tuple[float, float, float]:
    x, y, z = _PLACE(name, value)
    return x, y, z


def _fixed(name: str, parent: str, child: str, pose: Array) -> JointDescription:
    return JointDescription(name, parent, child, pose[:3, 3], pose[:3, :3])


#: the flange of REP 199, whose x axis points away from the arm, in the frame of `Arm.fkine`
_REP_199 = np.array(
    [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


class LinkDescription(NamedTuple):
    """A link; a link without shape and mass is a frame.

    Attributes:
        name: name, with the prefix.
        parts: capsules that collide, in its frame.
        mass: mass [kg].
        centre: centre of mass in its frame [m]. Shape (3,).
        inertia: inertia about the centre of mass, along its frame's axes [kg m²]. Shape (3, 3).
        looks: surfaces that are drawn, in its frame; empty to draw the capsules.
    """

    name: str
    parts: tuple[Capsule, ...] = ()
    mass: float = 0.0
    centre: Array = np.zeros(3)
    inertia: Array = np.zeros((3, 3))
    looks: tuple[Look, ...] = ()


class JointLimits(NamedTuple):
    """Limits of a joint.

    Attributes:
        lower: lower limit of the angle [rad].
        upper: upper limit of the angle [rad].
        velocity: maximum speed [rad/s].
        effort: maximum torque [N m].
        acceleration: maximum acceleration [rad/s²].
    """

    lower: float
    upper: float
    velocity: float
    effort: float
    acceleration: float


class JointDescription(NamedTuple):
    """A joint; a revolute joint turns about the z axis of the link that it moves.

    Attributes:
        name: name, with the prefix.
        parent: the link that carries it.
        child: the link that it moves.
        position: origin of the child's frame in the parent's [m]. Shape (3,).
        rotation: rotation of the child's frame in the parent's, at joint angle zero. Shape (3, 3).
        limits: limits; None for a fixed joint.
    """

    name: str
    parent: str
    child: str
    position: Array
    rotation: Array
    limits: JointLimits | None = None

    @property
    def matrix(self) -> Array:
        """The child's frame in the parent's, at joint angle zero. Shape (4, 4)."""
        return transform(self.rotation, self.position)


class ArmTree(NamedTuple):
    """The links and joints of an arm, each joint after the one that carries it.

    Attributes:
        arm: the described arm.
        links: the links: first the base, then the chain, then frames and the tool.
        joints: the joints: first the one from the world to the base, if there is a world.
    """

    arm: ArmDescription
    links: tuple[LinkDescription, ...]
    joints: tuple[JointDescription, ...]

    @property
    def turning(self) -> tuple[tuple[JointDescription, JointLimits], ...]:
        """The six revolute joints, and their limits."""
        return tuple((joint, joint.limits) for joint in self.joints if joint.limits is not None)

    @property
    def states(self) -> dict[str, Joints]:
        """Those of `STATES` that are within the arm's limits."""
        return {name: q for name, q in STATES.items() if self.arm.arm.within_limits(q)}

    @property
    def tip(self) -> str:
        """The link whose poses are planned: the tool's tip, or `tool0` without a tool."""
        return self.arm.prefix + ("tool0" if self.arm.tool is None else "tcp")

    def frames(self, q: Array) -> dict[str, Array]:
        """Return the frames of the links in the base frame, by name.

        Args:
            q: joint angles [rad]. Shape (n, 6).

        Returns:
            Homogeneous matrices. Shape (n, 4, 4) each.
        """
        base = self.links[0].name
        found = {base: np.broadcast_to(np.eye(4), (len(q), 4, 4))}
        angles = iter(np.moveaxis(q, -1, 0))
        for joint in self.joints:
            if joint.child == base:
                continue
            frame = found[joint.parent] @ joint.matrix
            if joint.limits is not None:
                angle = next(angles)
                turn = np.zeros((len(q), 4, 4))
                turn[:, 0, 0] = turn[:, 1, 1] = np.cos(angle)
                turn[:, 1, 0] = np.sin(angle)
                turn[:, 0, 1] = -turn[:, 1, 0]
                turn[:, 2, 2] = turn[:, 3, 3] = 1.0
                frame = frame @ turn
            found[joint.child] = frame
        return found
