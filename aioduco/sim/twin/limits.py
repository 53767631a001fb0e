"""Limits of the differences between an arm and its twin: given, or learned from a good run."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from aioduco.errors import Described, ParameterError
from aioduco.models.numpy_on_use import is_number
from aioduco.models.ranges import ABOVE, FINITE, FROM_0, OWN_NAME
from aioduco.models.rules import Vector, stored
from aioduco.models.toml_files import read_text
from aioduco.models.whole_files import write_whole
from aioduco.sim.twin.data import Six, TwinCommand, TwinSample
from aioduco.sim.twin.patterns import Friction, PatternFit
from aioduco.sim.twin.predictor import Deviation, Predictor

if TYPE_CHECKING:
    import os
    from collections.abc import Iterable, Iterator, Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.pose import Pose
    from aioduco.models.rotation import Array


#: factor of a limit over the largest difference of a good run
_MARGIN = 1.35
#: least limits: of a mass [kg], a force [N], a share of friction, a torque as a share of the
#: joint's largest, a tracking error [rad], a position [m], an angle [rad], a path [rad], a delay
#: [s]
_FLOOR = {
    "mass": 0.08,
    "force": 2.0,
    "friction": 0.08,
    "torque": 0.004,
    "tracking": 5e-4,
    "position": 2e-4,
    "angle": 5e-4,
    "path": 2e-3,
    "delay": 0.02,
}
#: share of a joint's largest torque that its noise has at the least
_NOISE = 1e-3
#: time over which differences are averaged before their largest counts [s]
_AVERAGED = 0.05
#: speed from which a joint does not stick [rad/s]
_SLIDES = 0.05
#: least number of samples in motion for a fit, and least time of a good run in motion [s]
_ENOUGH, _LEAST = 50, 5.0

#: fields that are limits, and those of six numbers
_LIMITS = ("mass", "force", "friction", "position", "angle", "path", "delay")
_SIXES = ("torque", "tracking", "dry", "viscous", "offset", "lag", "noise")
_SIX_NUMBERS = Vector(FINITE, length=6)


def _limit(name: str, value: Any) -> float:
    return math.inf if is_number(value) and value == math.inf else ABOVE(name, value)


def _six_of(name: str, value: Any) -> tuple[float, ...]:
    return tuple(_SIX_NUMBERS(name, value))


@dataclass(frozen=True, kw_only=True)
class TwinLimits:
    """Limits for one arm, and what is normal for it. `TwinLimits.of` gives some without a good run.

    Limits are above 0. `math.inf` is no limit, but for the torques and tracking errors.

    Attributes:
        arm: the model, such as "gcr5_910".
        mass: additional mass at the flange [kg].
        force: force at the flange [N].
        friction: additional share of the joints' friction.
        torque: external torques of the joints [N m]. Six.
        tracking: tracking errors of the joints [rad]. Six.
        position, angle: difference of the tool's pose for its joints [m, rad].
        path: distance of set-points from the rehearsed path [rad].
        delay: time by which set-points may come later than usual [s].
        usual_delay: time by which they usually come later than rehearsed [s].
        dry, viscous, offset: friction of the joints and offset of their torques, as the observed
            external torques show them [N m, N m s/rad, N m]. Six each.
        lag: time by which the joints follow their set-points [s]. Six.
        noise: standard deviations of the external torques [N m]. Six.
        learned: seconds in motion from which this was learned; 0 if it was not.

    Raises:
        ParameterError: a field is of a wrong type, or out of range.
    """

    arm: str
    mass: float
    force: float
    friction: float
    torque: tuple[float, ...]
    tracking: tuple[float, ...]
    position: float
    angle: float
    path: float
    delay: float
    usual_delay: float = 0.0
    dry: tuple[float, ...] = field(default=(0.0,) * 6)
    viscous: tuple[float, ...] = field(default=(0.0,) * 6)
    offset: tuple[float, ...] = field(default=(0.0,) * 6)
    lag: tuple[float, ...] = field(default=(0.0,) * 6)
    noise: tuple[float, ...]
    learned: float = 0.0

    def __post_init__(self) -> None:
        stored(
            self, arm=OWN_NAME, **dict.fromkeys(_LIMITS, _limit), **dict.fromkeys(_SIXES, _six_of),
            usual_delay=FINITE, learned=FROM_0,
        )  # fmt: skip
        for name in ("torque", "tracking"):
            for each in getattr(self, name):
                _limit(name, each)

    @classmethod
    def of(cls, arm: Arm) -> Self:
        """Wide limits for an arm of which no good run is known."""
        effort = arm.effort
        return cls(
            arm=arm.name,
            mass=1.0,
            force=25.0,
            friction=math.inf,
            torque=tuple(0.1 * each for each in effort),
            tracking=(0.01,) * 6,
            position=3e-3,
            angle=0.01,
            path=0.03,
            delay=0.3,
            noise=tuple(0.01 * each for each in effort),
        )

    @property
    def normal_friction(self) -> Friction:
        """The friction of the arm in good order."""
        return Friction(np.array(self.dry), np.array(self.viscous), np.array(self.offset))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the limits to a file of JSON, in which null is no limit."""
        found = {name: None if value == math.inf else value for name, value in asdict(self).items()}
        write_whole(path, json.dumps(found, indent=2, allow_nan=False) + "\n")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read limits that `save` wrote.

        Raises:
            ParameterError: the file holds no such limits.
        """
        rule = "a file of limits, as TwinLimits.save writes it"
        try:
            found: Any = json.loads(read_text(path))
            names = {each.name for each in fields(cls)}
            values: dict[str, Any] = {
                name: math.inf if value is None and name in _LIMITS else value
                for name, value in found.items()
                if name in names
            }
            return cls(**values)
        except ParameterError as exc:
            raise ParameterError(f"{path}: {exc.parameter}", exc.value, exc.expected) from exc
        except (OSError, ValueError, TypeError, AttributeError, RecursionError) as exc:
            raise ParameterError("path", str(path), rule) from exc


def deviations(
    arm: Arm,
    items: Iterable[TwinSample | TwinCommand],
    tool: Pose | None = None,
    mounting: Pose | None = None,
) -> list[Deviation]:
    """Compare samples with what they should be, in the order of their times.

    Args:
        arm: the arm.
        items: samples and commands; `predictor.AHEAD` is subtracted from the times of commands.
        tool, mounting: as of `Predictor`.
    """
    predictor = Predictor(arm, tool, mounting)
    found = []
    for item in items:
        if isinstance(item, TwinCommand):
            predictor.command(item)
        elif item.whole:
            found.append(predictor.deviation(item))
    return found


def learn(arm: Arm, good: Sequence[Deviation]) -> TwinLimits:
    """Learn limits from a run in which everything was as it should be.

    What the run does not show has the wide limit of `TwinLimits.of`.

    Args:
        arm: the arm.
        good: the differences of its samples, with commands if their timing is to be judged.

    Raises:
        ParameterError: the arm moved for less than five seconds, so that nothing is known.
    """
    moving = [each for each in good if each.moving]
    seconds = sum(each.step for each in moving)
    if seconds < _LEAST:
        rule = f"a run in which the arm moves for {_LEAST:g} s or more, by all its joints"
        raise ParameterError("run", Described(f"{seconds:.1f} s in motion"), rule)
    effort = np.array(arm.effort)
    friction, noise = _friction(moving, effort)
    lag = _lag(moving)
    fit = PatternFit(friction, noise)
    largest: dict[str, Any] = dict.fromkeys(_FLOOR, 0.0)
    torque, tracking = _Average(), _Average()
    delays = []
    for each in good:
        if (fits := fit.update(each)) is not None:
            rest, patterns = fits
            _raise(largest, "torque", np.abs(torque.of(rest, each.step)))
            _raise(largest, "mass", abs(patterns.mass))
            _raise(largest, "force", patterns.pushed)
            _raise(largest, "friction", abs(patterns.friction))
        behind = each.tracking - lag * each.expected_speeds
        _raise(largest, "tracking", np.abs(tracking.of(behind, each.step)))
        if each.position is not None and each.angle is not None:
            _raise(largest, "position", each.position)
            _raise(largest, "angle", each.angle)
        if (match := each.match) is not None and match.moving:
            _raise(largest, "path", match.distance)
            if each.moving:
                delays.append(match.delay)
    usual = float(np.median(delays)) if delays else 0.0
    largest["delay"] = float(np.max(delays)) - usual if delays else 0.0
    floors = {**_FLOOR, "torque": _FLOOR["torque"] * effort}
    # Beside the floor, not above it: a good run shows only a part of what is normal.
    total = {
        name: np.maximum(_MARGIN * value, 0.0) + floors[name] for name, value in largest.items()
    }
    found: dict[str, Any] = {
        name: _six(value) if np.ndim(value) else float(value) for name, value in total.items()
    }
    limits = TwinLimits(
        arm=arm.name,
        **found,
        usual_delay=usual,
        dry=_six(friction.dry),
        viscous=_six(friction.viscous),
        offset=_six(friction.offset),
        lag=_six(lag),
        noise=_six(noise),
        learned=round(seconds, 1),
    )
    wide = TwinLimits.of(arm)
    return replace(limits, **{name: getattr(wide, name) for name in _unseen(moving, delays)})


def _unseen(moving: Sequence[Deviation], delays: Sequence[float]) -> Iterator[str]:
    """The limits about which a run says nothing."""
    if all(each.external is None for each in moving):
        yield from ("friction", "torque", "noise")
        if all(each.force is None for each in moving):
            yield from ("mass", "force")
    if all(each.position is None for each in moving):
        yield from ("position", "angle")
    if not delays:
        yield from ("path", "delay")


def _six(values: Any) -> Six:
    numbers: list[float] = np.broadcast_to(values, 6).tolist()
    return tuple(numbers)


def _raise(largest: dict[str, Any], name: str, value: Any) -> None:
    largest[name] = np.maximum(largest[name], value)


class _Average:
    """Average that fades, of six values."""

    def __init__(self) -> None:
        self._value = np.zeros(6)

    def of(self, values: Array, step: float) -> Array:
        self._value = self._value + step / (step + _AVERAGED) * (values - self._value)
        return self._value


def _friction(moving: Sequence[Deviation], effort: Array) -> tuple[Friction, Array]:
    """Fit dry and viscous friction, offset and noise of each joint while it slides."""
    dry, viscous, offset = np.zeros(6), np.zeros(6), np.zeros(6)
    noise = _NOISE * effort
    rows = [(each.speeds, each.external) for each in moving if each.external is not None]
    if rows:
        speeds, external = (np.array(part) for part in zip(*rows, strict=True))
        for joint in range(6):
            slides = np.abs(speeds[:, joint]) > _SLIDES
            if np.count_nonzero(slides) < _ENOUGH:
                continue
            speed, felt = speeds[slides, joint], external[slides, joint]
            columns = np.column_stack((-np.sign(speed), -speed, np.ones(speed.size)))
            if abs(np.sign(speed).mean()) > 0.95:
                columns = columns[:, :1]  # one direction alone: an offset cannot be told from it
            found = np.linalg.lstsq(columns, felt, rcond=None)[0]
            rest = felt - columns @ found
            dry[joint] = max(0.0, found[0])
            if found.size > 1:
                viscous[joint], offset[joint] = max(0.0, found[1]), found[2]
            noise[joint] = max(noise[joint], float(np.std(rest)))
    return Friction(dry, viscous, offset), noise


def _lag(moving: Sequence[Deviation]) -> Array:
    """Fit the time by which each joint follows its set-point [s]."""
    tracking = np.array([each.tracking for each in moving])
    speeds = np.array([each.expected_speeds for each in moving])
    lag: Array = np.sum(tracking * speeds, axis=0) / np.maximum(np.sum(speeds**2, axis=0), 1e-9)
    return lag
