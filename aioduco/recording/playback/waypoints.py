"""The file of waypoints: TOML that people edit, and values in SI units that programs use.

The names of the file's fields contain their units: degrees and millimetres, as on a pendant. A new
waypoint is appended to the existing text, so that comments, order and all other edits are kept.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

from aioduco.errors import WaypointFileError
from aioduco.models import ranges
from aioduco.models.bounds import least, most
from aioduco.models.pose import Joints, JointsLike
from aioduco.models.similar import did_you_mean
from aioduco.models.toml_files import listed, parse_toml, quoted, read_text, rewrite
from aioduco.models.toml_lines import line_of

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Collection


WaypointMotion = Literal["joints", "line"]

_HEAD: Final = """\
# Waypoints of an arm. `aioduco play FILE HOST` moves it through them, from the first to the last.
#
# A waypoint has joints_deg, its six joint angles [degrees]. It may have:
#   name        what it is called
#   motion      "joints" (all joints together) or "line" (the tool goes straight)
#   blend_mm    how far before it the arm may turn off to the next one; 0: it stops there
#   dwell_s     how long the arm stays there [seconds]
#   outputs     digital outputs of the cabinet that are set there, such as { 3 = true, 4 = false }
# and the speeds below for the way to it. [defaults] holds where a waypoint says nothing.
"""


#: what stands at the top of a file
_SECTIONS: Final = ("arm", "defaults", "waypoint")


class _WrongFieldError(Exception):
    """An error in a field."""


def _number(low: float, high: float, unit: str, scale: float) -> Callable[[Any], float]:
    """A number of the file, in SI units."""

    def check(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _WrongFieldError(f"a number is needed [{unit}]")
        if not least(low) <= value <= most(high):
            raise _WrongFieldError(f"{value:g} {unit} is not within {low:g} to {high:g}")
        return min(max(float(value), low), high) * scale

    return check


def _motion(value: Any) -> WaypointMotion:
    if value not in get_args(WaypointMotion):
        raise _WrongFieldError(f'{value!r} is neither "joints" nor "line"')
    found: WaypointMotion = value
    return found


def _outputs(value: Any) -> dict[int, bool]:
    if not isinstance(value, dict):
        raise _WrongFieldError("a table is needed, such as { 3 = true }")
    found = {}
    for key, level in value.items():
        if not key.isdecimal() or not 1 <= int(key) <= 16:
            raise _WrongFieldError(f"{key!r} is no output of the cabinet, 1 to 16")
        if not isinstance(level, bool):
            raise _WrongFieldError(f"output {key} is true or false, not {level!r}")
        found[int(key)] = level
    return found


#: for each field of the file: its attribute, and a function that checks and converts it to SI
_FIELDS: Final[dict[str, tuple[str, Callable[[Any], Any]]]] = {
    "motion": ("motion", _motion),
    "speed_deg_s": ("speed", _number(0.1, 225.0, "°/s", math.pi / 180)),
    "acceleration_deg_s2": ("acceleration", _number(0.1, 2000.0, "°/s²", math.pi / 180)),
    "line_speed_mm_s": ("line_speed", _number(10.0, 5000.0, "mm/s", 1e-3)),
    "line_acceleration_mm_s2": ("line_acceleration", _number(10.0, 20000.0, "mm/s²", 1e-3)),
    "blend_mm": ("blend", _number(0.0, 500.0, "mm", 1e-3)),
    "dwell_s": ("dwell", _number(0.0, 3600.0, "s", 1.0)),
    "outputs": ("outputs", _outputs),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Waypoint:
    """A place to which an arm moves, and the motion to it.

    Attributes:
        name: name of the waypoint; empty for none.
        joints: joint angles [rad].
        motion: "joints" for all joints together, "line" for a straight line of the tool to the
            pose that the joints give.
        speed: speed of the leading joint on the way to it [rad/s].
        acceleration: acceleration of that joint [rad/s²].
        line_speed: speed of the tool on a line [m/s].
        line_acceleration: acceleration of the tool on a line [m/s²].
        blend: blend radius (融合半径) [m]; 0 to stop there.
        dwell: how long the arm stays there [s].
        outputs: levels of the cabinet's digital outputs to set there, by number.
    """

    name: str = ""
    joints: Joints
    motion: WaypointMotion = "joints"
    speed: float = math.radians(30.0)
    acceleration: float = math.radians(60.0)
    line_speed: float = 0.1
    line_acceleration: float = 0.3
    blend: float = 0.0
    dwell: float = 0.0
    outputs: dict[int, bool] = field(default_factory=dict)

    @property
    def stops(self) -> bool:
        """Whether the arm stops there: it stays, sets outputs, or has no blend radius."""
        return not self.blend or bool(self.dwell) or bool(self.outputs)


class WaypointFile:
    """A file of waypoints, with its text.

        taught = WaypointFile.new(arm="GCR5 910")
        taught.add("above the part", joints)
        taught.save("cell.toml")

    Args:
        text: the text of the file.
        title: name of the file in errors.
        beside: names of the sections at the top of the text that are not of waypoints, and are
            left to others, as in the file of a `Cell`.

    Attributes:
        title: name of the file in errors.
        text: the text.
        arm: series and model of the arm, as its controller reports them; empty for any arm.
        waypoints: the waypoints, in their order.

    Raises:
        WaypointFileError: the text is no TOML, or a field is wrong; the message says where.
    """

    def __init__(
        self, text: str, title: str = "the waypoints", *, beside: Collection[str] = ()
    ) -> None:
        self.title: str = title
        self._beside = frozenset(beside)
        self.text: str = text
        self.arm: str
        self.waypoints: tuple[Waypoint, ...]
        self.arm, self.waypoints = self._parsed(text)

    def __repr__(self) -> str:
        return f"<WaypointFile {self.title}, {len(self.waypoints)} waypoints>"

    @classmethod
    def new(cls, *, arm: str = "", title: str = "the waypoints") -> WaypointFile:
        """Make a file without waypoints.

        Args:
            arm: series and model of the arm; empty for any.
            title: name of the file in errors.

        Raises:
            ParameterError: the arm is no string.
        """
        ranges.TEXT("arm", arm)
        default = Waypoint(joints=Joints(0, 0, 0, 0, 0, 0))
        text = (
            f"{_HEAD}\narm = {quoted(arm)}\n\n[defaults]\n"
            f"speed_deg_s = {math.degrees(default.speed):g}\n"
            f"acceleration_deg_s2 = {math.degrees(default.acceleration):g}\n"
            f"line_speed_mm_s = {default.line_speed * 1e3:g}\n"
            f"line_acceleration_mm_s2 = {default.line_acceleration * 1e3:g}\n"
        )
        return cls(text, title)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> WaypointFile:
        """Read a file.

        Args:
            path: the file.

        Raises:
            WaypointFileError: the file cannot be read, or its content is wrong.
        """
        try:
            text = read_text(path)
        except (OSError, ValueError) as exc:
            raise WaypointFileError(f"{path} cannot be read: {exc}") from exc
        return cls(text, str(path))

    def add(self, name: str, joints: JointsLike) -> Waypoint:
        """Add a waypoint after the others; the existing text stays unchanged.

        Args:
            name: name of the waypoint.
            joints: joint angles, -2π to 2π [rad]. Shape (6,).

        Raises:
            ParameterError: an argument is not allowed.
            WaypointFileError: a waypoint cannot follow the end of the text.
        """
        ranges.OWN_NAME_OR_NONE("name", name)
        angles = listed(map(math.degrees, ranges.JOINTS("joints", joints)))
        block = f"\n[[waypoint]]\nname = {quoted(name)}\njoints_deg = [{angles}]\n"
        if "\r\n" in self.text:
            block = block.replace("\n", "\r\n")
        gap = "" if self.text.endswith("\n") or not self.text else "\n"
        text = self.text + gap + block
        arm, waypoints = self._parsed(text)
        self.text, self.arm, self.waypoints = text, arm, waypoints
        return waypoints[-1]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the text to a file atomically: after a failure, the old file is still there.

        Args:
            path: the file; an existing one keeps its mode, and stays the target of symbolic links.

        Raises:
            WaypointFileError: it cannot be written.
        """
        try:
            rewrite(path, self.text)
        except OSError as exc:
            raise WaypointFileError(f"{path} cannot be written: {exc}") from exc

    # -- reading ---------------------------------------------------------------------------------

    def _parsed(self, text: str) -> tuple[str, tuple[Waypoint, ...]]:
        try:
            read = parse_toml(text)
        except ValueError as exc:
            raise WaypointFileError(f"{self.title} is no TOML: {exc}") from exc
        for key in read.keys() - self._beside:
            if key not in _SECTIONS:
                what = f"is not known: arm, defaults or waypoint{did_you_mean(key, _SECTIONS)}"
                raise self._wrong(text, None, 0, key, what)
        arm, defaults, blocks = (
            read.get("arm", ""), read.get("defaults", {}), read.get("waypoint", [])
        )  # fmt: skip
        if not isinstance(arm, str):
            raise self._wrong(text, None, 0, "arm", "is to be a text")
        if not isinstance(defaults, dict):
            raise self._wrong(text, None, 0, "defaults", "is to be a table: [defaults]")
        if not isinstance(blocks, list) or not all(isinstance(each, dict) for each in blocks):
            raise self._wrong(text, None, 0, "waypoint", "is to be tables: [[waypoint]]")
        common = self._values(text, "defaults", 0, defaults)
        found = []
        for number, block in enumerate(blocks):
            own = self._values(text, "waypoint", number, block)
            if "joints" not in own:
                raise self._wrong(text, "waypoint", number, "joints_deg", "is missing")
            found.append(Waypoint(**{**common, **own}))
        return arm, tuple(found)

    def _values(self, text: str, table: str, number: int, block: dict[str, Any]) -> dict[str, Any]:
        """The attributes in a table."""
        found: dict[str, Any] = {}
        for key, value in block.items():
            try:
                name, found_there = _value(table, key, value)
            except _WrongFieldError as exc:
                raise self._wrong(text, table, number, key, f": {exc}") from exc
            found[name] = found_there
        return found

    def _wrong(
        self, text: str, table: str | None, number: int, key: str, what: str
    ) -> WaypointFileError:
        above = () if table is None else (table, number) if table == "waypoint" else (table,)
        line = line_of(text, (*above, key))
        where = f"waypoint {number + 1}, " if table == "waypoint" else ""
        where += "[defaults], " if table == "defaults" else ""
        what = what if what.startswith(":") else f" {what}"
        return WaypointFileError(f"{self.title}, line {line}: {where}{key}{what}")


def _value(table: str, key: str, value: Any) -> tuple[str, Any]:
    """The attribute of a field, and its value in SI units."""
    own = {"name": ("name", _text), "joints_deg": ("joints", _joints)}
    known = {**(own if table == "waypoint" else {}), **_FIELDS}
    if key not in known:
        near = did_you_mean(key, known)
        raise _WrongFieldError(f"it is not known; there are {', '.join(known)}{near}")
    name, check = known[key]
    return name, check(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise _WrongFieldError("a text is needed")
    return value


def _joints(value: Any) -> Joints:
    if not isinstance(value, list) or len(value) != 6:
        raise _WrongFieldError("six angles are needed [°]")
    check = _number(-360.0, 360.0, "°", math.pi / 180)
    return Joints(*(check(each) for each in value))
