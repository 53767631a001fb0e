"""Taught points by name, stored in a TOML file; needs no robot."""

from __future__ import annotations

import math
from collections.abc import Iterator, MutableMapping
from typing import TYPE_CHECKING, Any, Self, TypeAlias

from aioduco.errors import ParameterError
from aioduco.models.pose import Joints, Pose
from aioduco.models.ranges import OWN_NAME
from aioduco.models.similar import did_you_mean
from aioduco.models.toml_files import key_text, read_toml, rewrite

if TYPE_CHECKING:
    import os


#: joint angles [rad], or a pose of the tool [m, rad]
Point: TypeAlias = Joints | Pose

_EXPECTED = "a Joints or a Pose"


class TaughtPoints(MutableMapping[str, Point]):
    """Points by name, in the order in which they were taught: a mapping that can be saved.

        points = TaughtPoints.load("cell.toml")
        points["above the bin"] = await robot.state.get_tcp_pose_coord()
        points.save("cell.toml")
        await robot.motion.movej2(points.joints("home"), v=1.0, a=1.0)

    In the file each point is a table, with joints [rad] or a pose [m, rad]:

        [home]
        joints = [0.5236, -0.2618, 1.8326, 0.0, -1.5708, 0.0]

        ["above the bin"]
        pose = [0.4, 0.1, 0.3, 3.1416, 0.0, 0.0]

    A person may write joints_deg [°] or pose_mm_deg [mm, °] in their place. A pose is that of a
    tool in a work object. The file does not contain these two: a program that moves to the pose
    must use those with which it was taught.

    Args:
        points: initial points by name.

    Raises:
        ParameterError: they are no points by name.
    """

    def __init__(self, points: Any = ()) -> None:
        self._points: dict[str, Point] = {}
        try:
            given = dict(points)
        except (TypeError, ValueError) as exc:
            known = "points by their names; `TaughtPoints.load` reads a file"
            raise ParameterError("points", points, known) from exc
        self.update(given)

    def __repr__(self) -> str:
        return f"TaughtPoints({self._points!r})"

    def __getitem__(self, name: str) -> Point:
        return self._points[name]

    def __setitem__(self, name: str, point: Point) -> None:
        OWN_NAME("name", name)
        if not isinstance(point, (Joints, Pose)):
            raise ParameterError(name, point, _EXPECTED)
        self._points[name] = point

    def __delitem__(self, name: str) -> None:
        del self._points[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._points)

    def __len__(self) -> int:
        return len(self._points)

    def joints(self, name: str) -> Joints:
        """Return the joint angles of this name [rad].

        Raises:
            ParameterError: there is no such point, or it is a pose.
        """
        point = self._named(name)
        if not isinstance(point, Joints):
            raise ParameterError("name", name, "the name of joint angles; this one is a pose")
        return point

    def pose(self, name: str) -> Pose:
        """Return the pose of this name [m, rad].

        Raises:
            ParameterError: there is no such point, or it is joint angles.
        """
        point = self._named(name)
        if not isinstance(point, Pose):
            raise ParameterError("name", name, "the name of a pose; this one is joint angles")
        return point

    def _named(self, name: str) -> Point:
        if not isinstance(name, str) or name not in self._points:
            listed = ", ".join(self._points) or "none"
            raise ParameterError("name", name, f"one of {listed}{did_you_mean(name, self._points)}")
        return self._points[name]

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a file.

        Args:
            path: the file.

        Raises:
            ParameterError: the file cannot be read, is not TOML, or a point, which the error names,
                is not as described above.
        """
        try:
            tables = read_toml(path)
        except OSError as exc:
            raise ParameterError("path", str(path), f"a file that can be read: {exc}") from exc
        except ValueError as exc:
            raise ParameterError("path", str(path), f"a TOML file: {exc}") from exc
        return cls({name: point_of(name, table) for name, table in tables.items()})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a file completely or not at all. Comments of an existing file are lost.

        Args:
            path: the file; an existing one keeps its mode and its line ends, and stays the target
                of symbolic links.

        Raises:
            OSError: the file cannot be written; an existing one stays unchanged.
        """
        rewrite(path, "\n".join(map(_table, self._points, self._points.values())))


_DEGREES = (math.pi / 180,) * 6
#: by the name of a field: the class of the point, and the factors from its numbers to SI units
_KINDS: dict[str, tuple[type[Joints] | type[Pose], tuple[float, ...] | None]] = {
    "joints": (Joints, None),
    "pose": (Pose, None),
    "joints_deg": (Joints, _DEGREES),
    "pose_mm_deg": (Pose, (*(1e-3,) * 3, *_DEGREES[:3])),
}


def point_of(name: str, table: Any) -> Point:
    """The point in a table of a file.

    Args:
        name: name of the point.
        table: the table, with one field.

    Raises:
        ParameterError: it is not as `TaughtPoints` describes.
    """
    expected = "a table with joints, joints_deg, pose or pose_mm_deg, and nothing else"
    if not isinstance(table, dict) or len(table) != 1:
        raise ParameterError(name, table, expected)
    ((kind, values),) = table.items()
    if kind not in _KINDS:
        raise ParameterError(name, table, expected + did_you_mean(kind, _KINDS))
    if not isinstance(values, list) or any(type(value) not in (int, float) for value in values):
        raise ParameterError(name, values, "six numbers")
    point, factors = _KINDS[kind]
    try:
        if factors is not None and len(values) == len(factors):
            return point.of([each * factor for each, factor in zip(values, factors, strict=True)])
        return point.of(values)
    except ParameterError as exc:
        raise ParameterError(name, values, "six finite numbers") from exc


def _table(name: str, point: Point) -> str:
    kind = "joints" if isinstance(point, Joints) else "pose"
    numbers = ", ".join(repr(float(value)) for value in point)
    return f"[{key_text(name)}]\n{kind} = [{numbers}]\n"
