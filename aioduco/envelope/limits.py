"""The limits of an envelope as values, and how they are passed to another process.

Plain Python without numpy, because the worker loads it: arrays and poses are taken as sequences.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, get_args

from aioduco.errors import Described, ParameterError
from aioduco.models.pose import Joints
from aioduco.models.ranges import FINITE, OWN_NAME_OR_NONE, POSE
from aioduco.models.rules import FARTHEST, Number, VectorLike, ordered
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm

Action: TypeAlias = Literal["refuse", "slow", "stop"]
Body: TypeAlias = Literal["tool", "elbow", "flange"]

#: the points of the arm to which zones apply: the tool's tip, the axis of joint 3, the flange
BODIES: tuple[str, ...] = get_args(Body)
_MOST = 100  # largest number of limits in one envelope
#: number of lengths of each shape of a zone; of a plane, those of its normal
_SIZES = {"box": 3, "sphere": 1, "plane": 3}
#: highest limit of the tool's speed; no arm is nearly as fast, so such a number is none of m/s
_FASTEST = 20.0


#: by which a unit vector or a rotation matrix may differ from one
_EXACT = 1e-6
#: margin that is printed as none
_AT = 0.5e-4


class Crossing(NamedTuple):
    """A point of the arm, a limit, and the margin between them.

    Attributes:
        limit: name of the limit.
        body: "tool", "elbow" or "flange"; such as "joint 3" for a joint; "arm" for a singularity.
        place: position of the body in the base frame [m]; NaN if it is not known.
        margin: distance within the limit; negative beyond it; NaN if it is not known.
        unit: unit of the margin; empty for a singularity, which has none.
        action: action of the limit.
    """

    limit: str
    body: str
    place: tuple[float, float, float]
    margin: float
    unit: str
    action: str

    def __str__(self) -> str:
        where = ", ".join(f"{each:.3f}" for each in self.place)
        there = f" at ({where}) m" if self.place[0] == self.place[0] else ""
        # what is beyond a zone with this action is too fast, and not at a forbidden place
        slow = " (there the tool must be slow)" if (self.action, self.unit) == ("slow", "m") else ""
        margin = f"has a margin of {self.margin:+.4f} {self.unit}".rstrip()
        if abs(self.margin) < _AT:
            margin = "is at the limit"
        elif math.isnan(self.margin):
            margin = "has a value that the controller does not report"
        return f"{self.limit!r}{slow}: {self.body}{there} {margin}"


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvelopeLimit:
    """The base class of all limits of an envelope.

    Attributes:
        action: action for a motion that would cross the limit. "refuse": the motion is not sent.
            "stop": the motion is not sent, and the arm is stopped. "slow": the motion is allowed,
            with the tool no faster than `speed`.
        speed: largest speed of the tool beyond the limit, with the action "slow", up to 20 [m/s].
        name: name for errors and events; empty: a name that describes the limit.
    """

    action: Action = "refuse"
    speed: float = 0.1
    name: str = ""

    def __post_init__(self) -> None:
        one_of("action", self.action, get_args(Action))
        object.__setattr__(self, "speed", _positive("speed", self.speed, "m/s", _FASTEST))
        OWN_NAME_OR_NONE("name", self.name)
        if len(self.name) > 64:
            raise ParameterError("name", self.name, "a text of up to 64 characters")

    @property
    def title(self) -> str:
        """The limit's name, or its description if it has none."""
        return self.name or self._what()

    def _what(self) -> str:
        return type(self).__name__


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone(EnvelopeLimit):
    """A zone (安全区域) to keep points of the arm in, or out of. Made by `box`, `sphere`, `plane`.

    Attributes:
        shape: "box", "sphere" or "plane".
        keep: "in" or "out".
        at: centre of a box or sphere, or a point of a plane, in the base frame [m].
        size: the three lengths of a box, the radius of a sphere [m], the unit normal of a plane.
        turn: orientation of a box: its rotation matrix by rows. Shape (9,).
        bodies: the points of the arm to which it applies.
    """

    shape: Literal["box", "sphere", "plane"]
    keep: Literal["in", "out"]
    at: tuple[float, ...]
    size: tuple[float, ...]
    turn: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    bodies: tuple[Body, ...] = ("tool", "elbow", "flange")

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        one_of("shape", self.shape, _SIZES)
        one_of("keep", self.keep, ("in", "out"))
        # also after dataclasses.replace: a zone with NaN would hold nothing
        object.__setattr__(self, "at", _place("at", self.at, 3))
        if self.shape == "plane":
            size = _unit("size", self.size)
            if self.keep != "in":
                wanted = '"in": the side to which its normal points; turn the normal for the other'
                raise ParameterError("keep", self.keep, wanted)
        else:
            size = _numbers("size", self.size, _SIZES[self.shape])
            for each in size:
                _positive("size", each, "m")
        object.__setattr__(self, "size", size)
        object.__setattr__(self, "turn", _rows("turn", self.turn))
        object.__setattr__(self, "bodies", _bodies(self.bodies))

    def _what(self) -> str:
        return f"{self.shape} to keep {self.keep}"

    @classmethod
    def box(
        cls,
        at: VectorLike,
        size: VectorLike,
        *,
        keep: Literal["in", "out"] = "out",
        bodies: Sequence[Body] = ("tool", "elbow", "flange"),
        action: Action = "refuse",
        speed: float = 0.1,
        name: str = "",
    ) -> Zone:
        """Make a box.

        Args:
            at: centre x, y, z [m], or pose of six numbers [m, rad], in the base frame.
            size: lengths along the axes of the box [m]. Shape (3,).
            keep: whether to keep the bodies "in" it or "out" of it.
            bodies: the points of the arm to which it applies: "tool", "elbow", "flange".
            action: "refuse", "slow" or "stop".
            speed: largest speed of the tool beyond it, with "slow" [m/s].
            name: name for errors and events.

        Raises:
            ParameterError: an argument has a wrong type or value.
        """
        numbers = _place("at", at, 3, 6)
        turn = _rotation(*(POSE("at", numbers)[3:] if len(numbers) == 6 else (0.0, 0.0, 0.0)))
        return cls(
            shape="box", keep=keep, at=numbers[:3], size=_numbers("size", size, 3), turn=turn,
            bodies=_bodies(bodies), action=action, speed=speed, name=name,
        )  # fmt: skip

    @classmethod
    def sphere(
        cls,
        at: VectorLike,
        radius: float,
        *,
        keep: Literal["in", "out"] = "out",
        bodies: Sequence[Body] = ("tool", "elbow", "flange"),
        action: Action = "refuse",
        speed: float = 0.1,
        name: str = "",
    ) -> Zone:
        """Make a sphere.

        Args:
            at: centre x, y, z in the base frame [m].
            radius: radius [m].
            keep: whether to keep the bodies "in" it or "out" of it.
            bodies: the points of the arm to which it applies: "tool", "elbow", "flange".
            action: "refuse", "slow" or "stop".
            speed: largest speed of the tool beyond it, with "slow" [m/s].
            name: name for errors and events.

        Raises:
            ParameterError: an argument has a wrong type or value.
        """
        size = (_positive("radius", radius, "m"),)
        return cls(
            shape="sphere", keep=keep, at=_place("at", at, 3), size=size,
            bodies=_bodies(bodies), action=action, speed=speed, name=name,
        )  # fmt: skip

    @classmethod
    def plane(
        cls,
        point: VectorLike,
        normal: VectorLike,
        *,
        bodies: Sequence[Body] = ("tool", "elbow", "flange"),
        action: Action = "refuse",
        speed: float = 0.1,
        name: str = "",
    ) -> Zone:
        """Make a plane, and keep the bodies on the side to which its normal points.

        Args:
            point: a point of the plane in the base frame [m]. Shape (3,).
            normal: normal of the plane, of any length above 0. Shape (3,).
            bodies: the points of the arm to which it applies: "tool", "elbow", "flange".
            action: "refuse", "slow" or "stop".
            speed: largest speed of the tool beyond it, with "slow" [m/s].
            name: name for errors and events.

        Raises:
            ParameterError: an argument has a wrong type or value.
        """
        return cls(
            shape="plane", keep="in", at=_place("point", point, 3), size=_unit("normal", normal),
            bodies=_bodies(bodies), action=action, speed=speed, name=name,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class ToolSpeed(EnvelopeLimit):
    """The largest speed of the tool's tip.

    Attributes:
        most: the speed, up to 20 [m/s]. With the action "slow", a faster motion is sent at a
            lower speed if its path is known; another, such as a spline, is stopped when it is
            faster.
    """

    most: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        object.__setattr__(self, "most", _positive("most", self.most, "m/s", _FASTEST))

    def _what(self) -> str:
        return "tool speed"


@dataclass(frozen=True, slots=True)
class JointMargin(EnvelopeLimit):
    """The least distance of each joint from its limits.

    Attributes:
        least: the distance [rad].
    """

    least: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        object.__setattr__(self, "least", _positive("least", self.least, "rad"))

    def _what(self) -> str:
        return "margin to joint limits"


@dataclass(frozen=True, slots=True)
class SingularityMargin(EnvelopeLimit):
    """The least distance from the singularities of shoulder, elbow and wrist.

    Attributes:
        least: the distance, as `aioduco.kinematics.Singularity` gives it, above 0 to 1.
    """

    least: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        object.__setattr__(self, "least", _positive("least", self.least, "", 1.0))

    def _what(self) -> str:
        return "margin to singularities"


@dataclass(frozen=True, slots=True)
class ToolForce(EnvelopeLimit):
    """The largest force on the tool. Only the state shows it, so a crossing always stops the arm.

    A force that the controller does not report, as if its sensor failed, stops a moving arm, too.

    Attributes:
        most: the force [N].
    """

    most: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        object.__setattr__(self, "most", _positive("most", self.most, "N"))

    def _what(self) -> str:
        return "force on the tool"


class Envelope:
    """The operating envelope (工作包络) of an arm: the limits within which a program keeps it.

    Set it as `robot.envelope`. It is not a safety function: it replaces neither the controller's
    safety zones nor a fence.

    Args:
        arm: the arm, or the name of its model, such as "gcr5_910".
        limits: zones, speeds, margins and forces, up to 100. The tool's tip is that of the
            controller's tool in use, or of the tool that a motion names.

    Raises:
        ParameterError: an argument has a wrong type or value.
    """

    __slots__ = ("arm", "limits")

    def __init__(self, arm: Arm | str, *limits: EnvelopeLimit) -> None:
        # Imported here: it imports numpy, which the worker of a stream does not load.
        from aioduco.kinematics.catalogue import arm_given  # noqa: PLC0415

        self.arm: Arm = arm_given("arm", arm)
        if len(limits) > _MOST:
            raise ParameterError("limits", Described(f"{len(limits)} limits"), f"up to {_MOST}")
        for number, limit in enumerate(limits):
            if not isinstance(limit, EnvelopeLimit):
                raise ParameterError(f"limits[{number}]", limit, "a limit, such as a Zone")
        self.limits: tuple[EnvelopeLimit, ...] = limits

    def __repr__(self) -> str:
        names = ", ".join(map(repr, self.titles))
        return f"<Envelope of {self.arm.name}: {names}>"

    @property
    def titles(self) -> tuple[str, ...]:
        """The name or description of each limit; numbered if several are equal."""
        found: list[str] = []
        for limit in self.limits:
            title, number = limit.title, 1
            while title in found:
                number += 1
                title = f"{limit.title} {number}"
            found.append(title)
        return tuple(found)

    def packed(self, tool: VectorLike) -> dict[str, Any]:
        """The data for `EnvelopeChecker`: lists, numbers and texts, which JSON can represent.

        Args:
            tool: the tool's tip in the frame of the flange [m, rad]. Shape (6,).
        """
        rows: list[list[Any]] = []
        for title, limit in zip(self.titles, self.limits, strict=True):
            row: list[Any] = [title, limit.action, limit.speed]
            match limit:
                case Zone():
                    row += [limit.shape, limit.keep == "in"]
                    row += [[BODIES.index(body) for body in limit.bodies]]
                    row += [list(limit.at), list(limit.size), list(limit.turn)]
                case ToolSpeed():
                    row += ["speed", limit.most]
                case JointMargin() | SingularityMargin():
                    row += ["joints" if isinstance(limit, JointMargin) else "singular", limit.least]
                case _:
                    continue  # only the state shows forces
            rows.append(row)
        x, y, z, *angles = map(float, tool)
        geometry = self.arm.geometry
        own = geometry.corrections
        return {
            "geometry": list(geometry.lengths),
            "corrections": None if own is None else [list(column) for column in own],
            "lower": list(self.arm.lower),
            "upper": list(self.arm.upper),
            "tool": [*_rotation(*angles), x, y, z],
            "limits": rows,
        }


def _bodies(given: Any) -> tuple[Body, ...]:
    if not isinstance(given, (list, tuple)) or not given:
        raise ParameterError("bodies", given, f"a list with some of {', '.join(BODIES)}")
    for body in given:
        one_of("bodies", body, BODIES)
    return tuple(given)


def _numbers(name: str, values: Any, *counts: int) -> tuple[float, ...]:
    wanted = f"{' or '.join(map(str, counts))} finite numbers"
    given = ordered(name, values, wanted)
    if len(given) not in counts or isinstance(values, Joints):
        raise ParameterError(name, values, wanted)
    return tuple(FINITE(name, each) for each in given)


def _unit(name: str, values: Any) -> tuple[float, ...]:
    """A direction as a unit vector: a longer one would stretch all distances."""
    along = _numbers(name, values, 3)
    length = math.hypot(*along)
    if not length > 0.0:
        raise ParameterError(name, values, "three numbers that are not all 0")
    same = abs(length - 1.0) < _EXACT  # else it would change by rounding, each time it is copied
    return along if same else tuple(each / length for each in along)


def _rows(name: str, values: Any) -> tuple[float, ...]:
    """A rotation matrix by rows: any other matrix would stretch all distances."""
    numbers = _numbers(name, values, 9)
    rows = numbers[:3], numbers[3:6], numbers[6:]
    for i, j in combinations_with_replacement(range(3), 2):
        if abs(sum(a * b for a, b in zip(rows[i], rows[j], strict=True)) - (i == j)) > _EXACT:
            raise ParameterError(name, values, "the nine numbers of a rotation matrix, by rows")
    return numbers


def _place(name: str, values: Any, *counts: int) -> tuple[float, ...]:
    """Numbers of which the first three are a place in the base frame [m]."""
    numbers = _numbers(name, values, *counts)
    for number in numbers[:3]:
        Number(unit="m", plausible=FARTHEST, source="this package")(name, number)
    return numbers


def _positive(name: str, value: Any, unit: str, most: float = math.inf) -> float:
    plausible = FARTHEST if unit == "m" else math.inf
    rule = Number(0.0, most, unit, open_low=True, plausible=plausible, source="this package")
    return rule(name, value)


def _rotation(rx: float, ry: float, rz: float) -> tuple[float, ...]:
    """The matrix Rz·Ry·Rx by rows. Shape (9,)."""
    cx, sx, cy, sy = math.cos(rx), math.sin(rx), math.cos(ry), math.sin(ry)
    cz, sz = math.cos(rz), math.sin(rz)
    return (
        *(cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx),
        *(sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx),
        *(-sy, cy * sx, cy * cx),
    )
