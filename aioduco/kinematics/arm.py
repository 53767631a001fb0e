"""An arm: its lengths, limits and masses, and its kinematics."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.errors import Described, ParameterError, Unreachable
from aioduco.kinematics import forward, inverse, single
from aioduco.kinematics.geometry import DhCorrections, Geometry
from aioduco.models import bounds, ranges
from aioduco.models.numpy_on_use import is_number, number_array
from aioduco.models.pose import JointsLike, Pose, PoseLike
from aioduco.models.rules import Number, Vector, stored

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.rotation import Array

POSITION_LIMIT = 2 * math.pi
"""Joints reach ±2π [rad] (manual section 1.3.5). The vendor's URDFs say ±π."""

_ANY, _ABOVE, _FROM_0 = Number(source="this package"), ranges.ABOVE, ranges.FROM_0
_SAME_ARM = 0.03  # distance of a flange from where its own arm has it, at most [m]
_EXACT = 4e-13  # largest difference of an element of two poses that are 1e-12 m, rad apart
_KEEP = 1e-9  # residual above which a branch counts as having no solution, after refinement


class Singularity(NamedTuple):
    """Distance of a configuration from the three singularities, each from 0 (singular) to 1.

    Attributes:
        shoulder: distance of the wrist's centre from the axis of joint 1, in the arm's plane,
            divided by the length of the arm.
        elbow: sine of joint 3: zero if the arm is stretched or folded.
        wrist: sine of joint 5: zero if the axes of joints 4 and 6 are parallel.
    """

    shoulder: float
    elbow: float
    wrist: float

    @property
    def nearest(self) -> str:
        """The name of the nearest singularity."""
        return min(self._fields, key=lambda name: float(getattr(self, name)))


@dataclass(frozen=True, slots=True)
class Arm:
    """A DUCO arm: lengths, limits and masses, with forward and inverse kinematics.

    Poses are those of the flange (法兰) in the base frame. `arm("gcr5_910")` returns one of the
    models; `dataclasses.replace` can replace every number of it.

    Attributes:
        name: the model, as in `models()`.
        geometry: the six lengths [m].
        velocity: maximum joint speeds [rad/s], six.
        effort: maximum joint torques [N m], six.
        acceleration: joint accelerations that the torques allow with the arm stretched out
            [rad/s²], six; computed from masses and lengths, not published.
        masses: masses of the base and the six links [kg], seven.
        centres: centres of mass [m], seven times three numbers, in the frames of the modified
            Denavit-Hartenberg convention.
        lower: lower joint limits [rad], six.
        upper: upper joint limits [rad], six.

    Raises:
        ParameterError: one of them is not what it should be.
    """

    name: str
    geometry: Geometry
    velocity: tuple[float, ...]
    effort: tuple[float, ...]
    acceleration: tuple[float, ...]
    masses: tuple[float, ...] = field(repr=False)
    centres: tuple[tuple[float, ...], ...] = field(repr=False)
    lower: tuple[float, ...] = (-POSITION_LIMIT,) * 6
    upper: tuple[float, ...] = (POSITION_LIMIT,) * 6

    def __post_init__(self) -> None:
        above, angles = _tuple(Vector(_ABOVE, length=6)), _tuple(Vector(_ANY, length=6))
        stored(self, name=ranges.OWN_NAME, geometry=_geometry, centres=_centres)
        stored(self, masses=_tuple(Vector(_FROM_0, length=7)))
        stored(self, velocity=above, effort=above, acceleration=above, lower=angles, upper=angles)
        if not all(low < high for low, high in zip(self.lower, self.upper, strict=True)):
            raise ParameterError("upper", self.upper, f"above the lower limits, {self.lower}")

    @property
    def reach(self) -> float:
        """Length of the stretched upper arm and forearm [m]."""
        return self.geometry.a2 + self.geometry.a3

    def fkine(self, q: JointsLike) -> Array:
        """Return the pose of the flange (正解).

        Args:
            q: joint angles [rad]. Shape (..., 6). Angles beyond the joint limits are allowed, since
                solvers try them; so degrees are not detected here. `within_limits` tells.

        Returns:
            Homogeneous matrices in the base frame. Shape (..., 4, 4).
        """
        return forward.fkine(self.geometry, _joints(q))

    def fits(self, q: JointsLike, flange: PoseLike) -> bool:
        """Return whether a flange is where this arm has it, within 30 mm; else it is another arm.

        The lengths of an arm differ from those of its model by less. Models of the same lengths
        are not told apart.

        Args:
            q: joint angles that a controller reports [rad]. Shape (6,).
            flange: its pose of the flange then.
        """
        return math.dist(self.fkine(_six(q))[:3, 3], Pose.of(flange)[:3]) <= _SAME_ARM

    def jacobian(self, q: JointsLike) -> Array:
        """Return the geometric Jacobian of the flange in the base frame.

        Args:
            q: joint angles [rad]. Shape (..., 6).

        Returns:
            For each joint a column: linear velocity [m/rad], then angular velocity [rad/rad].
            Shape (..., 6, 6).
        """
        return forward.jacobian(self.geometry, _joints(q))

    def singularity(self, q: JointsLike) -> Singularity:
        """Return the distance of a configuration from the arm's singularities (奇异点).

        Args:
            q: joint angles [rad]. Shape (6,).
        """
        values = forward.singular_values(self.geometry, _six(q))
        return Singularity(*np.abs(values).tolist())

    def within_limits(self, q: JointsLike) -> bool:
        """Return whether all joints are inside their limits, but for the rounding of a reading."""
        return not bounds.outside(_joints(q), self.lower, self.upper).any()

    def ikine_all(self, flange: PoseLike | Array) -> Array:
        """Return every configuration that reaches a pose (逆解), up to eight.

        At a singularity two solutions coincide; both are returned, and are equal. At a wrist
        singularity joint 6 may have any angle; here it is zero, or the angle nearest to zero with
        which the arm reaches the pose. `ikine` takes the angle from `q_near`.

        Args:
            flange: the pose in the base frame: a `Pose`, six numbers, or a matrix of shape (4, 4).

        Returns:
            Joint angles in [-π, π] [rad], ordered by shoulder, elbow and wrist. Shape (n, 6),
            with n = 0 when the pose is out of reach.

        Raises:
            ParameterError: `flange` has none of the forms above, or is not finite.
        """
        found = self._solve(_matrix(flange), 0.0)
        return inverse.wrap(np.array(found).reshape(-1, 6))

    def ikine(
        self, flange: PoseLike | Array, q_near: JointsLike, *, max_jump: float | None = None
    ) -> Array:
        """Return the configuration that reaches a pose and is nearest to another one.

        Whole turns are added if the limits allow it, so that a joint at 6 rad stays near 6 rad, and
        one that is read at its limit, beyond it by rounding, gets the limit. Otherwise the
        configuration reaches the pose to 1e-12 m and rad; if the arm is stretched or folded, or
        within 1e-9 of a wrist singularity, to 1e-9. At a wrist singularity joint 6 may have any
        angle: it is that of `q_near`, or the nearest one with which the arm reaches the pose.

        Args:
            flange: the pose in the base frame: a `Pose`, six numbers, or a matrix of shape (4, 4).
            q_near: the reference configuration [rad]. Shape (6,).
            max_jump: maximum difference of one joint from `q_near` [rad]; None for any difference.

        Returns:
            Joint angles [rad]. Shape (6,).

        Raises:
            Unreachable: no configuration reaches the pose, or none within the joint limits, or
                none within `max_jump`.
            ParameterError: `flange` or `q_near` has none of the forms above, or is not finite;
                `max_jump` is no angle.
        """
        if max_jump is not None and not (is_number(max_jump) and max_jump >= 0.0):
            raise ParameterError("max_jump", max_jump, "an angle of at least 0 [rad], or None")
        target = _matrix(flange)
        near = _joints(q_near).tolist()
        if len(near) != 6 or not all(map(math.isfinite, near)):
            raise ParameterError("q_near", near, "six finite numbers [rad]")
        found = self._solve(target, near[5])
        if self.geometry.corrections is not None:
            # Beside a singularity the steps from the lengths' own solutions may lead far, or to
            # nothing, although the arm is at the pose.
            found += self._refined([near], target)
        if not found:
            pose = Pose.from_matrix(target)
            missing = inverse.shortfall(self.geometry, target)
            by = f", by at least {missing:.4f} m" if missing > 0 else " in this orientation"
            raise Unreachable(f"{pose} is out of the reach of {self.name}{by}")
        turned = (single.nearest_turns(q, near, self.lower, self.upper) for q in found)
        inside = [q for q in turned if q is not None]
        if not inside:
            raise Unreachable(
                f"{self.name} reaches {Pose.from_matrix(target)} only outside its joint limits"
            )
        if max_jump is not None:
            turns = [[abs(a - b) for a, b in zip(q, near, strict=True)] for q in inside]
            least = min(turns, key=max)
            if max(least) > max_jump:
                raise Unreachable(
                    f"the nearest configuration for {Pose.from_matrix(target)} turns joint "
                    f"{least.index(max(least)) + 1} by {max(least):.4f} rad, "
                    f"more than {max_jump:.4f} rad"
                )
            inside = [q for q, each in zip(inside, turns, strict=True) if max(each) <= max_jump]
        best = min(inside, key=lambda q: math.dist(q, near))
        return np.array(best)

    def _solve(self, target: Array, q6: float) -> list[single.Configuration]:
        rows = target.tolist()
        found = single.solutions(self.geometry, rows, q6)
        if all(single.pose_error(self.geometry, q, rows) < _EXACT for q in found):
            return found
        return self._refined(found, target)

    def _refined(
        self, near: Sequence[Sequence[float]], target: Array
    ) -> list[single.Configuration]:
        """The solutions beside given configurations, for those that have one."""
        refined = inverse.refine(self.geometry, np.array(near), target)
        error = np.abs(inverse.residual(self.geometry, refined, target)).max(axis=-1)
        return [tuple(q) for q in refined[error < _KEEP].tolist()]


def _joints(q: JointsLike) -> Array:
    if type(q) is np.ndarray and q.dtype == np.float64:  # solvers come here often
        array = q
    else:
        array = number_array("q", q, "numbers of the shape (..., 6) [rad]", finite=False)
    if array.shape[-1:] != (6,):
        raise ParameterError(
            "q", Described(f"an array of shape {array.shape}"), "of shape (..., 6) [rad]"
        )
    return array


def _six(q: JointsLike) -> Array:
    array = _joints(q)
    if array.shape != (6,):
        raise ParameterError(
            "q", Described(f"an array of shape {array.shape}"), "of shape (6,) [rad]"
        )
    return array


def _matrix(flange: PoseLike | Array) -> Array:
    if isinstance(flange, np.ndarray) and flange.shape == (4, 4):
        return number_array("flange", flange, "a matrix of numbers")
    return Pose.of(flange).matrix


def _tuple(rule: Vector) -> Callable[[str, Any], tuple[float, ...]]:
    return lambda name, value: tuple(rule(name, value))


def _geometry(name: str, value: Any) -> Geometry:
    if not isinstance(value, Geometry):
        raise ParameterError(name, value, "a Geometry")
    # An upper arm and a forearm: without one of them the inverse kinematics have no solution.
    rules = {"a2": _ABOVE, "a3": _ABOVE}
    lengths: dict[str, Any] = {
        each: rules.get(each, _ANY)(each, length)
        for each, length in zip(value._fields, value.lengths, strict=False)
    }
    own = value.corrections
    if own is not None:
        if not isinstance(own, DhCorrections):
            raise ParameterError(f"{name}.corrections", own, "DhCorrections, or None")
        own = DhCorrections(*map(_tuple(Vector(_ANY, length=6)), own._fields, own))
    return value._replace(**lengths, corrections=own)


def _centres(name: str, value: Any) -> tuple[tuple[float, ...], ...]:
    expected = "seven times three numbers [m]"
    array = number_array(name, value, expected)
    if array.shape != (7, 3):
        raise ParameterError(name, value, expected)
    return tuple(map(tuple, array.tolist()))
