"""Paths in joint space: the joints as a function of the distance along the path.

This module also has the set-point of the joints for one cycle, and the error of a motion that
cannot be planned.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from aioduco.errors import Portable
from aioduco.sim.planner.arrays import joined, numbers, shifted
from aioduco.sim.planner.slices import LONG_SLICE, slices

if TYPE_CHECKING:
    from array import array
    from collections.abc import Callable

    from aioduco.models.rotation import Array


_STENCIL = 7  # samples per derivative: sixth order for the first, fifth for the second
PlanCode: TypeAlias = Literal["unreachable", "singular", "limits", "parameter"]


class Path:
    """Joint angles as polynomials of degree five in the distance s along the path.

    s is in the unit of the motion's speed: metres of the tool centre point, or radians of the joint
    that turns furthest. A path is immutable; slices share its polynomials.

    Attributes:
        bounds: distances at which one polynomial ends and the next begins, rising.
    """

    __slots__ = ("_coefficients", "_gains", "_origins", "bounds")

    def __init__(
        self,
        bounds: array[float],
        origins: array[float],
        gains: array[float],
        coefficients: Array,
    ) -> None:
        self.bounds: array[float] = bounds
        self._origins = origins
        self._gains = gains
        self._coefficients = coefficients

    @classmethod
    def straight(cls, q0: Array, q1: Array, length: float) -> Path:
        """Go straight from q0 to q1, of any number of axes, while s goes from zero to `length`."""
        coefficients = np.zeros((6, len(q0)))
        coefficients[0] = q0
        coefficients[1] = q1 - q0
        return cls.of_one(coefficients, length)

    @classmethod
    def of_one(cls, coefficients: Array, length: float) -> Path:
        """Follow one polynomial of s / `length`, from zero to `length`. Coefficients: (6, n)."""
        bounds, gains = joined((0.0, length)), joined((1.0 / length,))
        return cls(bounds, bounds[:1], gains, coefficients[None])

    @classmethod
    def through(cls, q: Array, slope: Array, bend: Array, length: float) -> Path:
        """Go through samples with given derivatives; position, slope and bend are continuous.

        Args:
            q: joint angles at evenly spaced s from zero to `length` [rad]. Shape (n + 1, 6).
            slope: dq/ds there. Shape (n + 1, 6).
            bend: d²q/ds² there. Shape (n + 1, 6).
            length: s at the last sample.
        """
        count = len(q) - 1
        step = length / count
        coefficients = np.empty((count, 6, q.shape[1]))
        for part in slices(count, LONG_SLICE):
            ends = slice(part.start + 1, part.stop + 1)
            a, b = q[part], q[ends]
            da, db = slope[part] * step, slope[ends] * step
            dda, ddb = bend[part] * step**2, bend[ends] * step**2
            rise = b - a - da - 0.5 * dda
            slip = db - da - dda
            twist = ddb - dda
            powers = (
                a,
                da,
                0.5 * dda,
                10.0 * rise - 4.0 * slip + 0.5 * twist,
                -15.0 * rise + 7.0 * slip - twist,
                6.0 * rise - 3.0 * slip + 0.5 * twist,
            )
            np.stack(powers, axis=1, out=coefficients[part])
        bounds = numbers(np.linspace(0.0, length, count + 1))
        return cls(bounds, bounds[:-1], numbers(np.full(count, 1.0 / step)), coefficients)

    @property
    def start(self) -> float:
        """s where the path begins."""
        return self.bounds[0]

    @property
    def end(self) -> float:
        """s where the path ends."""
        return self.bounds[-1]

    def nodes(self) -> Array:
        """Give the bounds and the distances half-way between them, at which limits are computed."""
        bounds = np.array(self.bounds)
        both = np.empty(2 * len(bounds) - 1)
        both[::2] = bounds
        both[1::2] = 0.5 * (bounds[1:] + bounds[:-1])
        return both

    def piece(self, s: float, hint: int = 0) -> int:
        """Give the index of the polynomial for s, searching forward from `hint`."""
        bounds, last = self.bounds, len(self._gains) - 1
        while hint < last and s >= bounds[hint + 1]:
            hint += 1
        return hint

    def _place(self, s: float) -> int:
        """Give the index of the polynomial for any s."""
        return min(max(bisect_right(self.bounds, s) - 1, 0), len(self._gains) - 1)

    def state(self, piece: int, s: float, v: float, a: float) -> Array:
        """Give joint angles, speeds and accelerations.

        Args:
            piece: index of the polynomial for s.
            s: distance along the path.
            v: ds/dt.
            a: d²s/dt².

        Returns:
            q [rad], qd [rad/s] and qdd [rad/s²]. Shape (3, 6).
        """
        gain = self._gains[piece]
        u = (s - self._origins[piece]) * gain
        w = v * gain
        c = a * gain
        u2 = u * u
        u3 = u2 * u
        u4 = u2 * u2
        ww = w * w
        weights = np.array(
            (
                (1.0, u, u2, u3, u4, u4 * u),
                (0.0, w, 2.0 * u * w, 3.0 * u2 * w, 4.0 * u3 * w, 5.0 * u4 * w),
                (
                    0.0,
                    c,
                    2.0 * (u * c + ww),
                    3.0 * u2 * c + 6.0 * u * ww,
                    4.0 * u3 * c + 12.0 * u2 * ww,
                    5.0 * u4 * c + 20.0 * u3 * ww,
                ),
            )
        )
        result: Array = weights.dot(self._coefficients[piece])  # a third of matmul's time
        return result

    def sample(self, s: Array) -> Array:
        """Give q, dq/ds and d²q/ds² for many distances. Shape (n,) to (n, 3, 6).

        Args:
            s: the distances.
        """
        if len(s) <= LONG_SLICE:
            return self._sample(s)
        result = np.empty((len(s), 3, self._coefficients.shape[2]))
        for part in slices(len(s), LONG_SLICE):
            result[part] = self._sample(s[part])
        return result

    def _sample(self, s: Array) -> Array:
        pieces = list(map(self._place, s.tolist()))
        gain = np.asarray(self._gains)[pieces]
        u = (s - np.asarray(self._origins)[pieces]) * gain
        power = np.arange(6)
        zeros = np.zeros((len(s), 1))
        values = u[:, None] ** power
        slopes = np.concatenate([zeros, power[1:] * values[:, :-1]], axis=1)
        bends = np.concatenate([zeros, power[1:] * slopes[:, :-1]], axis=1)
        weights = np.stack([values, slopes * gain[:, None], bends * gain[:, None] ** 2], axis=1)
        result: Array = weights @ self._coefficients[pieces]
        return result

    def slice(self, start: float, end: float) -> Path:
        """Give the part from `start` to `end`, with the same distances."""
        first = self._place(start)
        last = self._place(float(np.nextafter(end, start)))
        bounds = joined((start,), self.bounds[first + 1 : last + 1], (end,))
        part = slice(first, last + 1)
        return Path(bounds, self._origins[part], self._gains[part], self._coefficients[part])

    def then(self, other: Path) -> Path:
        """Give this path followed by another one, whose distances are shifted accordingly."""
        shift = self.end - other.start
        return Path(
            joined(self.bounds, shifted(other.bounds[1:], shift)),
            joined(self._origins, shifted(other._origins, shift)),
            joined(self._gains, other._gains),
            np.concatenate((self._coefficients, other._coefficients)),
        )


@cache
def _edges() -> tuple[Array, Array]:
    """Give the weights of the first and second derivative at each of seven equidistant samples."""
    power = np.arange(_STENCIL)
    first, second = np.zeros((_STENCIL, _STENCIL)), np.zeros((_STENCIL, _STENCIL))
    for row in range(_STENCIL):
        vandermonde = (power[None, :] - row) ** power[:, None].astype(float)
        first[row] = np.linalg.solve(vandermonde, np.eye(_STENCIL)[1])
        second[row] = 2.0 * np.linalg.solve(vandermonde, np.eye(_STENCIL)[2])
    return first, second


def differentiate(values: Array, step: float) -> tuple[Array, Array]:
    """Differentiate equidistant samples by central differences, one-sided ones at the ends.

    Args:
        values: at least seven samples. Shape (n, k).
        step: distance between samples.

    Returns:
        First derivatives, sixth order, and second derivatives, fifth order or better. (n, k) each.
    """
    first, second = _edges()
    half = _STENCIL // 2
    slope, bend = np.empty_like(values), np.empty_like(values)
    windows = np.lib.stride_tricks.sliding_window_view(values, _STENCIL, axis=0)
    for part in slices(len(windows), LONG_SLICE):
        inner = slice(part.start + half, part.stop + half)
        slope[inner] = windows[part] @ first[half]
        bend[inner] = windows[part] @ second[half]
    head, tail = values[:_STENCIL], values[-_STENCIL:]
    slope[:half], slope[-half:] = first[:half] @ head, first[-half:] @ tail
    bend[:half], bend[-half:] = second[:half] @ head, second[-half:] @ tail
    return slope / step, bend / step**2


class PlanError(Portable):
    """A motion cannot be planned; the arm was not moved.

    Attributes:
        code: "unreachable": no configuration reaches a pose of the path. "singular": the path
            comes so near to a singularity that the joints could not follow. "limits": a joint
            would leave its limits. "parameter": the motion makes no sense as given.
        joints: joints to which it was to lead [rad]; None if unknown. Shape (6,).
        flange: pose of the flange at a share of its way, 0 to 1; None if unknown. Shape (4, 4).
    """

    joints: Array | None = None
    flange: Callable[[float], Array] | None = None

    def __init__(self, code: PlanCode, message: str) -> None:
        self.code: PlanCode = code
        super().__init__(message)


@dataclass(slots=True, eq=False)
class JointSetPoint:
    """Commanded state of the joints at the end of a cycle. It never changes.

    It is not frozen: that would triple the time to make one, which each cycle does.

    Attributes:
        q: joint angles [rad]. Shape (6,).
        qd: joint speeds [rad/s]. Shape (6,).
        qdd: joint accelerations [rad/s²]. Shape (6,).
    """

    q: Array
    qd: Array
    qdd: Array

    @classmethod
    def at_rest(cls, q: Array) -> JointSetPoint:
        """Give the set-point of an arm that stands at q [rad]."""
        return cls(np.array(q, dtype=float), np.zeros(6), np.zeros(6))

    def slowed(self, braking: Array, cycle: float) -> JointSetPoint:
        """Give the set-point a cycle [s] later, within decelerations [rad/s²] of the joints.

        All joints stand at the same time, so that their motion keeps its direction.
        """
        left = float((np.abs(self.qd) / braking).max())
        if left <= cycle:
            return JointSetPoint.at_rest(self.q + 0.5 * left * self.qd)
        qd = self.qd * (1.0 - cycle / left)
        return JointSetPoint(self.q + 0.5 * cycle * (self.qd + qd), qd, -self.qd / left)
