"""Paths in joint space: where the joints are for a distance along the path.

Besides the path this module has the set-point that comes of it in each cycle, and the error of a
motion that has none.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from aioduco.models.rotation import Array


__all__ = ["JointSetPoint", "Path", "PlanCode", "PlanError", "differentiate"]

_STENCIL = 7  # samples per derivative: sixth order for the first, fifth for the second
PlanCode: TypeAlias = Literal["unreachable", "singular", "limits", "parameter"]


class Path:
    """Joint angles as polynomials of degree five in the distance s along the path.

    s is in the unit that the motion's speed is given in: metres of the tool centre point, or
    radians of the joint that turns furthest. A path is immutable; slices share its polynomials.

    Attributes:
        bounds: where one polynomial ends and the next begins, rising.
    """

    __slots__ = ("_coefficients", "_gains", "_origins", "bounds")

    def __init__(
        self,
        bounds: list[float],
        origins: list[float],
        gains: list[float],
        coefficients: list[Array],
    ) -> None:
        self.bounds: list[float] = bounds
        self._origins = origins
        self._gains = gains
        self._coefficients = coefficients

    @classmethod
    def straight(cls, q0: Array, q1: Array, length: float) -> Path:
        """Go straight from q0 to q1, of any number of axes, while s goes from zero to `length`."""
        coefficients = np.zeros((6, len(q0)))
        coefficients[0] = q0
        coefficients[1] = q1 - q0
        return cls([0.0, length], [0.0], [1.0 / length], [coefficients])

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
        a, b = q[:-1], q[1:]
        da, db = slope[:-1] * step, slope[1:] * step
        dda, ddb = bend[:-1] * step**2, bend[1:] * step**2
        rise = b - a - da - 0.5 * dda
        slip = db - da - dda
        turn = ddb - dda
        coefficients = np.stack(
            [
                a,
                da,
                0.5 * dda,
                10.0 * rise - 4.0 * slip + 0.5 * turn,
                -15.0 * rise + 7.0 * slip - turn,
                6.0 * rise - 3.0 * slip + 0.5 * turn,
            ],
            axis=1,
        )
        bounds = np.linspace(0.0, length, count + 1).tolist()
        return cls(bounds, bounds[:-1], [1.0 / step] * count, list(coefficients))

    @property
    def start(self) -> float:
        """s where the path begins."""
        return self.bounds[0]

    @property
    def end(self) -> float:
        """s where the path ends."""
        return self.bounds[-1]

    def nodes(self) -> Array:
        """Give the bounds and the places half-way between them, where limits are looked at."""
        bounds = np.array(self.bounds)
        both = np.empty(2 * len(bounds) - 1)
        both[::2] = bounds
        both[1::2] = 0.5 * (bounds[1:] + bounds[:-1])
        return both

    def piece(self, s: float, hint: int = 0) -> int:
        """Give the index of the polynomial for s, looking forward from `hint`."""
        bounds, last = self.bounds, len(self._gains) - 1
        while hint < last and s >= bounds[hint + 1]:
            hint += 1
        return hint

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
        """Give q, dq/ds and d²q/ds² for many distances. Shape (n,) to (n, 3, 6)."""
        pieces = np.clip(np.searchsorted(self.bounds, s, side="right") - 1, 0, len(self._gains) - 1)
        gain = np.array(self._gains)[pieces]
        u = (s - np.array(self._origins)[pieces]) * gain
        power = np.arange(6)
        zeros = np.zeros((len(s), 1))
        values = u[:, None] ** power
        slopes = np.concatenate([zeros, power[1:] * values[:, :-1]], axis=1)
        bends = np.concatenate([zeros, power[1:] * slopes[:, :-1]], axis=1)
        weights = np.stack([values, slopes * gain[:, None], bends * gain[:, None] ** 2], axis=1)
        result: Array = weights @ np.array(self._coefficients)[pieces]
        return result

    def slice(self, start: float, end: float) -> Path:
        """Give the part from `start` to `end`, with the same distances."""
        first = self.piece(start)
        last = self.piece(np.nextafter(end, start), first)
        bounds = [start, *self.bounds[first + 1 : last + 1], end]
        part = slice(first, last + 1)
        return Path(bounds, self._origins[part], self._gains[part], self._coefficients[part])

    def then(self, other: Path) -> Path:
        """Give this path followed by another one, whose distances are moved to follow on."""
        shift = self.end - other.start
        return Path(
            self.bounds + [bound + shift for bound in other.bounds[1:]],
            self._origins + [origin + shift for origin in other._origins],
            self._gains + other._gains,
            self._coefficients + other._coefficients,
        )


@cache
def _edges() -> tuple[Array, Array]:
    """Give the weights of the first and second derivative at each of seven even samples."""
    power = np.arange(_STENCIL)
    first, second = np.zeros((_STENCIL, _STENCIL)), np.zeros((_STENCIL, _STENCIL))
    for row in range(_STENCIL):
        vandermonde = (power[None, :] - row) ** power[:, None].astype(float)
        first[row] = np.linalg.solve(vandermonde, np.eye(_STENCIL)[1])
        second[row] = 2.0 * np.linalg.solve(vandermonde, np.eye(_STENCIL)[2])
    return first, second


def differentiate(values: Array, step: float) -> tuple[Array, Array]:
    """Differentiate even samples by central differences, one-sided ones at the ends.

    Args:
        values: at least seven samples. Shape (n, k).
        step: distance between samples.

    Returns:
        First derivatives, sixth order, and second derivatives, fifth order or better. (n, k) each.
    """
    first, second = _edges()
    count, half = len(values), _STENCIL // 2
    slope, bend = np.empty_like(values), np.empty_like(values)
    inner = slice(half, count - half)
    windows = np.lib.stride_tricks.sliding_window_view(values, _STENCIL, axis=0)
    slope[inner] = windows @ first[half]
    bend[inner] = windows @ second[half]
    head, tail = values[:_STENCIL], values[-_STENCIL:]
    slope[:half], slope[-half:] = first[:half] @ head, first[-half:] @ tail
    bend[:half], bend[-half:] = second[:half] @ head, second[-half:] @ tail
    return slope / step, bend / step**2


class PlanError(Exception):
    """A motion cannot be planned; the arm was not moved.

    Attributes:
        code: "unreachable": no configuration reaches a pose of the path. "singular": the path
            comes so near to a singularity that the joints could not follow. "limits": a joint
            would leave its limits. "parameter": the motion makes no sense as given.
    """

    def __init__(self, code: PlanCode, message: str) -> None:
        self.code: PlanCode = code
        super().__init__(message)


@dataclass(frozen=True, slots=True, eq=False)
class JointSetPoint:
    """What the joints shall do at the end of a cycle.

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
        """Stand at q [rad]."""
        return cls(np.array(q, dtype=float), np.zeros(6), np.zeros(6))
