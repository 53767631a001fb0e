"""A profile: what is known of one arm, as a simulator plays it. One TOML file holds it.

Every value has an interval that holds it in 95 of 100 cases, if it was estimated. What a profile
does not have is played as the model's default.
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self

from aioduco.errors import ParameterError
from aioduco.kinematics import DhCorrections
from aioduco.kinematics import arm as arm_of
from aioduco.models.ranges import FILE
from aioduco.models.similar import did_you_mean
from aioduco.models.toml_files import parse_toml, quoted, read_text, rewrite
from aioduco.models.toml_lines import line_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from aioduco.kinematics import Arm


#: how far a length and an offset [m] or an angle [rad] of one arm may be from its model's
LENGTH_BOUND: Final = 0.01
ANGLE_BOUND: Final = math.radians(5.0)

#: the parameters of the geometry, in the standard Denavit-Hartenberg convention. d3 and d4 are not
#: among them: joints 2 to 4 are parallel, so that only d2 + d3 + d4 shows, which stands as d2
GEOMETRY: Final[tuple[str, ...]] = (
    *(f"a{i}" for i in range(1, 7)),
    *("d1", "d2", "d5", "d6"),
    *(f"alpha{i}" for i in range(1, 7)),
    *(f"theta{i}" for i in range(1, 7)),
)


def _six(name: str, low: float, high: float, unit: str) -> dict[str, tuple[float, float, str]]:
    return {f"{name}{i}": (low, high, unit) for i in range(1, 7)}


#: sections and names of a profile, with the range of each value and its unit; those of the geometry
#: are around the model's
RANGES: Final[dict[str, dict[str, tuple[float, float, str]]]] = {
    "geometry": {
        name: (-LENGTH_BOUND, LENGTH_BOUND, "m")
        if name[0] in "d" or re.fullmatch(r"a\d", name)
        else (-ANGLE_BOUND, ANGLE_BOUND, "rad")
        for name in GEOMETRY
    },
    "drives": {**_six("lag", 0.0, 0.05, "s"), **_six("gain", 5.0, 2000.0, "1/s")},
    "noise": _six("joint", 0.0, 1e-3, "rad"),
    "readings": {"period": (0.0, 0.5, "s")},
    "times": dict.fromkeys(("power_on", "enable", "disable", "power_off"), (0.0, 60.0, "s")),
    "heartbeat": {"slack": (0.0, 10.0, "s")},
    "blends": {
        **dict.fromkeys(("joint_reach", "line_reach"), (0.1, 2.0, "of the radius")),
        **dict.fromkeys(("joint_share", "line_share"), (0.05, 1.0, "of the acceleration")),
    },
    "load": {"mass": (0.0, 50.0, "kg"), **dict.fromkeys("xyz", (-1.0, 1.0, "m"))},
    "friction": {**_six("dry", 0.0, 100.0, "N m"), **_six("viscous", 0.0, 200.0, "N m s/rad")},
}


_KEYS: Final = ("model", "sources", "single_precision", *RANGES)


class Estimate(NamedTuple):
    """A value with its interval.

    Attributes:
        value: the value, in SI units.
        low, high: ends of the interval that holds it in 95 of 100 cases; the value itself if none
            is known.
    """

    value: float
    low: float
    high: float

    @classmethod
    def around(cls, value: float, half: float) -> Self:
        """An estimate with an interval of a half width on either side."""
        return cls(value, value - half, value + half)


@dataclass(frozen=True)
class ArmProfile:
    """What is known of one arm.

    Attributes:
        model: the arm's model.
        values: estimates by section and name, as in `RANGES`; those of the geometry are absolute.
        single_precision: whether readings are 32-bit floats; None if unknown.
        sources: names of the recordings from which it was made.
    """

    model: str
    values: Mapping[str, Mapping[str, Estimate]] = field(default_factory=dict)
    single_precision: bool | None = None
    sources: tuple[str, ...] = ()

    def value(self, section: str, name: str, default: float) -> float:
        """A value of the profile, or a default if it has none."""
        found = self.values.get(section, {}).get(name)
        return default if found is None else found.value

    def six(self, section: str, name: str, default: float) -> tuple[float, ...]:
        """The values of six joints, with a default for those that are not known."""
        return tuple(self.value(section, f"{name}{i}", default) for i in range(1, 7))

    def has(self, section: str) -> bool:
        """Whether anything of a section is known."""
        return bool(self.values.get(section))

    @property
    def arm(self) -> Arm:
        """The arm with the geometry of the profile."""
        nominal = arm_of(self.model)
        known = self.values.get("geometry", {})
        if not known:
            return nominal
        columns = {}
        for column in DhCorrections._fields:
            base = getattr(nominal.geometry, column)
            named = (known.get(f"{column}{i + 1}") for i in range(6))
            columns[column] = tuple(
                0.0 if found is None else found.value - base[i] for i, found in enumerate(named)
            )
        return replace(
            nominal, geometry=nominal.geometry._replace(corrections=DhCorrections(**columns))
        )

    @classmethod
    def of(cls, profile: ArmProfile | str | os.PathLike[str]) -> ArmProfile:
        """A profile, or the one of a file."""
        return profile if isinstance(profile, ArmProfile) else cls.load(profile)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a profile from a TOML file.

        A value is a number, or a table `{ value = …, low = …, high = … }`.

        Raises:
            ParameterError: the file cannot be read, or is no profile; the message has the line.
        """
        path = FILE("profile", path)
        try:
            text = read_text(path)
            data = parse_toml(text)
        except (OSError, ValueError) as error:
            raise ParameterError("profile", str(path), f"a readable TOML file: {error}") from None
        return cls(*_Reader(path, text).parts(data))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the profile to a TOML file.

        Raises:
            OSError: it cannot be written.
        """
        rewrite(path, self.toml())

    def toml(self) -> str:
        """The profile as TOML. Units are m, rad, s, kg, N m; geometry is the standard DH table."""
        lines = [f"model = {quoted(self.model)}"]
        if self.sources:
            lines.append(f"sources = [{', '.join(map(quoted, self.sources))}]")
        if self.single_precision is not None:
            lines.append(f"single_precision = {str(self.single_precision).lower()}")
        for section, names in RANGES.items():
            known = self.values.get(section, {})
            if known:
                lines += ["", f"[{section}]"]
            for name in names:
                if (found := known.get(name)) is not None:
                    unit = names[name][2]
                    value, low, high = map(_number, found)
                    lines.append(
                        f"{name} = {{ value = {value}, low = {low}, high = {high} }}  # {unit}"
                    )
        return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    text = f"{value:.10g}"
    return text if re.search(r"[.e]", text) else f"{text}.0"


class _Reader:
    """Checks the data of a file; its errors have the file's name and the line."""

    def __init__(self, path: str | os.PathLike[str], text: str) -> None:
        self._path = os.fspath(path)
        self._text = text

    def parts(
        self, data: dict[str, Any]
    ) -> tuple[str, dict[str, dict[str, Estimate]], bool | None, tuple[str, ...]]:
        for key in data:
            if key not in _KEYS:
                known = f"one of {', '.join(_KEYS)}{did_you_mean(key, _KEYS)}"
                raise self._error("", key, key, known)
        model = data.get("model")
        if not isinstance(model, str):
            raise self._error("", "model", model, "the name of the arm's model")
        try:
            nominal = arm_of(model)
        except ParameterError as error:
            raise self._error("", "model", model, error.expected) from None
        single = data.get("single_precision")
        if single is not None and not isinstance(single, bool):
            raise self._error("", "single_precision", single, "true or false")
        sources = data.get("sources", [])
        if not isinstance(sources, list) or not all(isinstance(each, str) for each in sources):
            raise self._error("", "sources", sources, "a list of names")
        values: dict[str, dict[str, Estimate]] = {}
        for section, names in RANGES.items():
            table = data.get(section, {})
            if not isinstance(table, dict):
                raise self._error("", section, table, "a table")
            for name, found in table.items():
                if name not in names:
                    known = f"one of {', '.join(names)}{did_you_mean(name, names)}"
                    raise self._error(section, name, name, known)
                low, high, unit = names[name]
                centre = _nominal(nominal, name) if section == "geometry" else 0.0
                span = (low + centre, high + centre, unit)
                values.setdefault(section, {})[name] = self._estimate(section, name, found, span)
        self._whole(values)
        return nominal.name, values, single, tuple(sources)

    def _whole(self, values: dict[str, dict[str, Estimate]]) -> None:
        drives = values.get("drives", {})
        for i in range(1, 7):
            lag, gain = drives.get(f"lag{i}"), drives.get(f"gain{i}")
            if lag is not None and gain is not None and lag.value * gain.value > 1.0 + 1e-6:
                raise self._error("drives", f"gain{i}", gain.value, f"at most 1/lag{i}")

    def _estimate(
        self, section: str, name: str, found: Any, span: tuple[float, float, str]
    ) -> Estimate:
        low, high, unit = span
        parts = found if isinstance(found, dict) else {"value": found}
        given = parts.keys() - {"value", "low", "high"}
        if given or "value" not in parts:
            raise self._error(section, name, found, "a number, or a table with value, low and high")
        value = parts["value"]
        ends = [parts.get("low", value), value, parts.get("high", value)]
        if not all(isinstance(each, int | float) and math.isfinite(each) for each in ends) or any(
            isinstance(each, bool) for each in ends
        ):
            raise self._error(section, name, found, "a finite number")
        if not low <= value <= high:
            raise self._error(section, name, value, f"from {low:g} to {high:g} {unit}")
        if sorted(ends) != ends:
            raise self._error(section, name, found, "in order: low, value, high")
        return Estimate(float(value), float(ends[0]), float(ends[2]))

    def _error(self, section: str, name: str, value: Any, expected: str) -> ParameterError:
        path = (section, name) if section else (name,)
        place = f"{self._path}, line {line_of(self._text, path)}: {'.'.join(path)}"
        return ParameterError(place, value, expected)


def _nominal(nominal: Arm, name: str) -> float:
    column, number = name[:-1], int(name[-1])
    return float(getattr(nominal.geometry, column)[number - 1])
