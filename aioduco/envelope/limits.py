"""The limits of an envelope as values: what they are, and how they pass the process border.

Plain Python without numpy, for the worker's sake: arrays and poses are taken as sequences.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, get_args

from aioduco.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rules import VectorLike

__all__ = [
    "BODIES",
    "Action",
    "Body",
    "Crossing",
    "Envelope",
    "EnvelopeLimit",
    "JointMargin",
    "SingularityMargin",
    "ToolForce",
    "ToolSpeed",
    "Zone",
]

Action: TypeAlias = Literal["refuse", "slow", "stop"]
Body: TypeAlias = Literal["tool", "elbow", "flange"]

#: the points of the arm that zones hold for: the tool's tip, the axis of joint 3, the flange
BODIES: tuple[str, ...] = get_args(Body)
_MOST = 100  # limits of one envelope


class Crossing(NamedTuple):
    """What of the arm is, or would be, beyond which limit, and where.

    Attributes:
        limit: the limit's name.
        body: "tool", "elbow" or "flange"; "joint 3" for a joint; "arm" for a singularity.
        place: where that is in the base frame [m]; NaN where it is not known.
        margin: how far within the limit it is; negative beyond it.
        unit: of the margin; empty for a singularity, which has none.
        action: what the limit is to do.
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
        return (
            f"{self.limit!r}: {self.body}{there} has a margin of "
            f"{self.margin:+.4f} {self.unit}".rstrip()
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class EnvelopeLimit:
    """What all limits of an envelope have in common.

    Attributes:
        action: what is done about a motion that would cross it. "refuse": what would cross it is
            not sent. "stop": neither, and the arm is stopped. "slow": it is allowed, with the tool
            no faster than `speed`.
        speed: of the tool beyond the limit, with the action "slow" [m/s].
        name: for errors and events; empty for one that says what it is.
    """

    action: Action = "refuse"
    speed: float = 0.1
    name: str = ""

    def __post_init__(self) -> None:
        if self.action not in get_args(Action):
            raise ParameterError("action", self.action, '"refuse", "slow" or "stop"')
        _positive("speed", self.speed, "m/s")
        if not isinstance(self.name, str) or len(self.name) > 64:
            raise ParameterError("name", self.name, "a text of up to 64 characters")

    @property
    def title(self) -> str:
        """Its name, or what it is."""
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
        bodies: the points of the arm that it holds for.
    """

    shape: Literal["box", "sphere", "plane"]
    keep: Literal["in", "out"]
    at: tuple[float, ...]
    size: tuple[float, ...]
    turn: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    bodies: tuple[Body, ...] = ("tool", "elbow", "flange")

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        if self.keep not in ("in", "out"):
            raise ParameterError("keep", self.keep, '"in" or "out"')
        if not self.bodies or any(body not in BODIES for body in self.bodies):
            raise ParameterError("bodies", self.bodies, f"some of {', '.join(BODIES)}")
        object.__setattr__(self, "bodies", tuple(self.bodies))

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
            at: its centre x, y, z [m], or a pose of six numbers [m, rad], in the base frame.
            size: its lengths along its axes [m]. Shape (3,).
            keep: whether to keep the bodies "in" it or "out" of it.
            bodies: the points of the arm that it holds for: "tool", "elbow", "flange".
            action: "refuse", "slow" or "stop".
            speed: of the tool beyond it, with "slow" [m/s].
            name: for errors and events.

        Raises:
            ParameterError: an argument is not of its kind.
        """
        numbers = _numbers("at", at, 3, 6)
        turn = _rotation(*numbers[3:]) if len(numbers) == 6 else _rotation(0.0, 0.0, 0.0)
        lengths = _numbers("size", size, 3)
        for length in lengths:
            _positive("size", length, "m")
        return cls(
            shape="box", keep=keep, at=numbers[:3], size=lengths, turn=turn,
            bodies=tuple(bodies), action=action, speed=speed, name=name,
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
            at: its centre x, y, z in the base frame [m].
            radius: its radius [m].
            keep: whether to keep the bodies "in" it or "out" of it.
            bodies: the points of the arm that it holds for: "tool", "elbow", "flange".
            action: "refuse", "slow" or "stop".
            speed: of the tool beyond it, with "slow" [m/s].
            name: for errors and events.

        Raises:
            ParameterError: an argument is not of its kind.
        """
        size = (_positive("radius", radius, "m"),)
        return cls(
            shape="sphere", keep=keep, at=_numbers("at", at, 3), size=size,
            bodies=tuple(bodies), action=action, speed=speed, name=name,
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
            point: a point of it in the base frame [m]. Shape (3,).
            normal: its normal, of any length above 0. Shape (3,).
            bodies: the points of the arm that it holds for: "tool", "elbow", "flange".
            action: "refuse", "slow" or "stop".
            speed: of the tool beyond it, with "slow" [m/s].
            name: for errors and events.

        Raises:
            ParameterError: an argument is not of its kind.
        """
        along = _numbers("normal", normal, 3)
        length = math.hypot(*along)
        if not length > 0.0:
            raise ParameterError("normal", normal, "three numbers that are not all 0")
        size = tuple(each / length for each in along)
        return cls(
            shape="plane", keep="in", at=_numbers("point", point, 3), size=size,
            bodies=tuple(bodies), action=action, speed=speed, name=name,
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class ToolSpeed(EnvelopeLimit):
    """The largest speed of the tool's tip.

    Attributes:
        most: the speed [m/s]. With the action "slow" a motion that is faster is sent slower.
    """

    most: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        _positive("most", self.most, "m/s")

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
        _positive("least", self.least, "rad")

    def _what(self) -> str:
        return "margin to joint limits"


@dataclass(frozen=True, slots=True)
class SingularityMargin(EnvelopeLimit):
    """The least distance from the singularities of shoulder, elbow and wrist.

    Attributes:
        least: the distance, as `aioduco.kinematics.Singularity` tells it, above 0 to 1.
    """

    least: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        if _positive("least", self.least, "") > 1.0:
            raise ParameterError("least", self.least, "above 0 to 1")

    def _what(self) -> str:
        return "margin to singularities"


@dataclass(frozen=True, slots=True)
class ToolForce(EnvelopeLimit):
    """The largest force on the tool. It is seen in the state alone, so it always stops.

    Attributes:
        most: the force [N].
    """

    most: float

    def __post_init__(self) -> None:
        EnvelopeLimit.__post_init__(self)
        _positive("most", self.most, "N")

    def _what(self) -> str:
        return "force on the tool"


class Envelope:
    """The operating envelope (工作包络) of an arm: the limits within which a program keeps it.

    It is set as `robot.envelope`. It is no safety function: it does not replace the controller's
    own safety zones, nor a fence.

    Args:
        arm: the arm, or the name of its model, such as "gcr5_910".
        limits: zones, speeds, margins and forces, up to 100. The tool's tip is that of the
            controller's tool in use, or of the tool that a motion names.

    Raises:
        ParameterError: an argument is not of its kind.
    """

    __slots__ = ("arm", "limits")

    def __init__(self, arm: Arm | str, *limits: EnvelopeLimit) -> None:
        # Imported here: it brings numpy, which the worker of a stream does without.
        from aioduco.kinematics import Arm  # noqa: PLC0415
        from aioduco.kinematics import arm as arm_of  # noqa: PLC0415

        model = arm_of(arm) if isinstance(arm, str) else arm
        if not isinstance(model, Arm):
            raise ParameterError("arm", arm, "an Arm, or the name of a model")
        if len(limits) > _MOST:
            raise ParameterError("limits", f"{len(limits)} limits", f"up to {_MOST}")
        for number, limit in enumerate(limits):
            if not isinstance(limit, EnvelopeLimit):
                raise ParameterError(f"limits[{number}]", limit, "a limit, such as a Zone")
        self.arm: Arm = model
        self.limits: tuple[EnvelopeLimit, ...] = limits

    def __repr__(self) -> str:
        names = ", ".join(map(repr, self.titles))
        return f"<Envelope of {self.arm.name}: {names}>"

    @property
    def titles(self) -> tuple[str, ...]:
        """The name of each limit, or what it is; numbered where several are called alike."""
        found: list[str] = []
        for limit in self.limits:
            title, number = limit.title, 1
            while title in found:
                number += 1
                title = f"{limit.title} {number}"
            found.append(title)
        return tuple(found)

    def packed(self, tool: VectorLike) -> dict[str, Any]:
        """All that `EnvelopeChecker` is told: lists, numbers and texts, which JSON can carry.

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
                    continue  # forces are known from the state alone
            rows.append(row)
        x, y, z, *angles = map(float, tool)
        return {
            "geometry": list(self.arm.geometry),
            "lower": list(self.arm.lower),
            "upper": list(self.arm.upper),
            "tool": [*_rotation(*angles), x, y, z],
            "limits": rows,
        }


def _numbers(name: str, values: Any, *counts: int) -> tuple[float, ...]:
    wanted = f"{' or '.join(map(str, counts))} finite numbers"
    try:
        numbers = tuple(float(value) for value in values)
    except (TypeError, ValueError) as exc:
        raise ParameterError(name, values, wanted) from exc
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        raise ParameterError(name, values, wanted)
    return numbers


def _positive(name: str, value: Any, unit: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 < value < math.inf:
        raise ParameterError(name, value, f"a number above 0 {unit}".rstrip())
    return float(value)


def _rotation(rx: float, ry: float, rz: float) -> tuple[float, ...]:
    """The matrix Rz·Ry·Rx by rows. Shape (9,)."""
    cx, sx, cy, sy = math.cos(rx), math.sin(rx), math.cos(ry), math.sin(ry)
    cz, sz = math.cos(rz), math.sin(rz)
    return (
        *(cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx),
        *(sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx),
        *(-sy, cy * sx, cy * cx),
    )
