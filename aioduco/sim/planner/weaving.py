"""Weaves (复合运动, manual 1.3.13): a periodic shape laid over the path of the tool.

A weave is a shape in space: how far the tool has swung depends on how far it has come along the
path, not on the time. At the speed asked for it swings at the frequency asked for; where the arm
is slower (at the ends, after a pause, at a lower global speed) it swings as much more slowly, and
the way of the tool stays the same.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.sim.planner.path import PlanError

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.curves import Curve

__all__ = ["Weave", "Woven", "offsets"]

_TABLE = 4096  # points in which one swing is tabulated
_ROUNDED = 2e-4  # what rounding takes off a corner of the shape at most [m]
_SHARPEST, _BLUNTEST = 0.005, 0.03  # width of the rounding, in parts of a swing
_FINE = 24  # samples of the path per swing, at least
_SLIGHT = 3e-5  # share of the amplitude below which a wave asks for no finer samples
_SQUARE = 0.1  # sine of the angle between path and normal of the plane, below which it is refused
_MOST = 30_000  # samples of one path
_NUDGE = 1e-5  # share of the length over which the direction of the path is measured
#: the third axis, to which each plane is square
_NORMALS = {"XY": 2, "XZ": 1, "YZ": 0}


@dataclass(frozen=True, slots=True, eq=False)
class Weave:
    """A weave as it is asked for.

    Attributes:
        shape: of a swing.
        plane: in which it swings.
        frequency: swings a second at the speed asked for, dwells not counted [Hz].
        amplitude: how far it swings to either side [m].
        left: how long it dwells on the left [s].
        right: how long it dwells on the right [s].
        stands: whether the path waits while it dwells.
        work_object: orientation of the work object in the base. Shape (3, 3).
    """

    shape: WeaveShape
    plane: WeavePlane
    frequency: float
    amplitude: float
    left: float = 0.0
    right: float = 0.0
    stands: bool = False
    work_object: Array = field(default_factory=lambda: np.eye(3))

    @property
    def of_tool(self) -> bool:
        """Whether its plane turns with the tool, or else stands with the work object."""
        return self.plane <= WeavePlane.TOOL_YZ

    @property
    def normal(self) -> int:
        """The axis to which the plane is square: 0 to 2 for x, y, z."""
        return _NORMALS[self.plane.name[-2:]]

    def over(self, curve: Curve, v: float) -> Woven | None:
        """Lay it over a path, in as many whole swings as come nearest to the frequency.

        Args:
            curve: of the tool centre point, in the base frame.
            v: speed asked for along it [m/s].

        Returns:
            The path with the weave; None if less than half a swing fits on it, or if it does not
            lead anywhere.

        Raises:
            PlanError: more swings than can be planned at once.
        """
        ends = curve.poses(np.array([0.0, 0.5, 1.0]) * curve.length)[:, :3, 3]
        if self.amplitude <= 0.0 or np.abs(ends - ends[0]).max() < 1e-6:
            return None
        swing = 1.0 / self.frequency
        dwells = (0.0, 0.0) if self.stands else (self.left, self.right)
        swings = curve.length / (v * (swing + sum(dwells)))
        if swings < 0.5:
            return None
        if swings <= _MOST / _FINE:
            woven = Woven(self, curve, max(round(swings), 1), dwells)
            if woven.length <= _MOST * woven.detail:
                return woven
        raise PlanError("parameter", f"{swings:.0f} swings are too many to be planned at once")


def offsets(weave: Weave, x: Array, dwells: tuple[float, float]) -> Array:
    """Give how far the tool is from the path in one swing, its corners not rounded.

    The tool swings to the left first. Left is about the plane's normal, by the right hand, from
    the direction of the path.

    Args:
        weave: the weave.
        x: where in the swing, 0 to 1. Shape (n,).
        dwells: on the left and on the right, while the path goes on [s].

    Returns:
        To the left, and forward [m]. Shape (n, 2).
    """
    swing = 1.0 / weave.frequency
    parts = np.array([0.25 * swing, dwells[0], 0.5 * swing, dwells[1], 0.25 * swing])
    bounds = np.concatenate([[0.0], np.cumsum(parts)]) / parts.sum()
    turn = np.interp(x, bounds, [0.0, 0.25, 0.25, 0.75, 0.75, 1.0])
    zigzag = np.interp(turn, [0.0, 0.25, 0.75, 1.0], [0.0, 1.0, -1.0, 0.0])
    wave, forward = np.sin(2 * np.pi * turn), np.zeros_like(turn)
    match weave.shape:
        case WeaveShape.TRIANGLE:
            left = zigzag
        case WeaveShape.TRAPEZOID:
            left = np.clip(2.0 * zigzag, -1.0, 1.0)
        case WeaveShape.CIRCLE:
            left, forward = wave, 1.0 - np.cos(2 * np.pi * turn)
        case WeaveShape.FIGURE_EIGHT:
            left, forward = wave, 0.5 * np.sin(4 * np.pi * turn)
        case _:
            left = wave
    return weave.amplitude * np.stack([left, forward], axis=-1)


class Woven:
    """A path with a weave over it, travelled by the distance along the path.

    Corners of the shape are rounded, by 0.2 mm or by 1.6 % of the amplitude if that is more: a
    corner would be a jump of the speed.

    Attributes:
        length: of the path [m].
        turning: angle that the orientation turns by along it [rad].
        detail: distance along it between samples that show every swing [m].
        stops: where the path waits, and for how long [m, s].
    """

    def __init__(
        self, weave: Weave, curve: Curve, swings: int, dwells: tuple[float, float]
    ) -> None:
        self._weave, self._curve = weave, curve
        self._swing = curve.length / swings
        self._table, self._slope, finest = _rounded(weave, dwells)
        self.length: float = curve.length
        self.turning: float = curve.turning
        self.detail: float = self._swing / max(_FINE, 4 * finest)
        held = ((0.25, weave.left), (0.75, weave.right)) if weave.stands else ()
        self.stops: tuple[tuple[float, float], ...] = tuple(
            ((number + part) * self._swing, time)
            for number in range(swings)
            for part, time in held
            if time > 0.0
        )

    def poses(self, s: Array) -> Array:
        """Give the poses at distances s. Shape (n,) to (n, 4, 4).

        Raises:
            PlanError: the path is square to the plane of the weave.
        """
        poses = self._curve.poses(s)
        nudge = _NUDGE * self.length
        ahead = self._curve.poses(np.minimum(s + nudge, self.length))
        behind = self._curve.poses(np.maximum(s - nudge, 0.0))
        forward = ahead[:, :3, 3] - behind[:, :3, 3]
        forward /= np.linalg.norm(forward, axis=1, keepdims=True)
        axes = poses[:, :3, :3] if self._weave.of_tool else self._weave.work_object
        normal = axes[..., self._weave.normal]
        left = np.cross(normal, forward)
        size = np.linalg.norm(left, axis=1, keepdims=True)
        if size.min() < _SQUARE:
            raise PlanError("parameter", "the path is square to the plane of the weave")
        left /= size
        swung = self._offsets(s)
        poses[:, :3, 3] += swung[:, :1] * left + swung[:, 1:] * np.cross(left, normal)
        return poses

    def _offsets(self, s: Array) -> Array:
        place = s / self._swing % 1.0 * _TABLE
        i = np.minimum(place.astype(int), _TABLE - 1)
        t = (place - i)[:, None]
        a, b = self._table[i], self._table[i + 1]
        da, db = self._slope[i], self._slope[i + 1]
        rise = b - a
        found: Array = a + t * (da + t * (3 * rise - 2 * da - db + t * (da + db - 2 * rise)))
        return found


def _rounded(weave: Weave, dwells: tuple[float, float]) -> tuple[Array, Array, int]:
    """Tabulate one swing as a sum of waves, the high ones of which are damped.

    Returns:
        Offsets and their change from point to point, the first point once more at the end; and
        the number of the highest wave that counts.
    """
    raw = offsets(weave, np.arange(_TABLE) / _TABLE, dwells)
    waves = np.fft.rfft(raw, axis=0)
    number = np.arange(len(waves))[:, None]
    if weave.shape in (WeaveShape.TRIANGLE, WeaveShape.TRAPEZOID) or any(dwells):
        # Rounded by a bell of this width, a corner loses 3.2 amplitudes times it.
        width = min(max(_ROUNDED / (3.2 * weave.amplitude), _SHARPEST), _BLUNTEST)
        width /= 1.0 + sum(dwells) * weave.frequency  # parts of a swing without its dwells
        waves *= np.exp(-2.0 * (np.pi * width * number) ** 2)
    size = np.abs(waves).max(axis=1) / _TABLE
    finest = int(np.flatnonzero(size > _SLIGHT * weave.amplitude).max(initial=1))
    table = np.fft.irfft(waves, _TABLE, axis=0)
    slope = np.fft.irfft(2j * np.pi / _TABLE * number * waves, _TABLE, axis=0)
    table -= table[0]  # a weave begins on the path
    return np.concatenate([table, table[:1]]), np.concatenate([slope, slope[:1]]), finest
