"""Weaves (复合运动, manual 1.3.13): a periodic shape that is added to the path of the tool.

A weave is a shape in space: the swing of the tool depends on the distance along the path, not on
the time. At the requested speed it swings at the requested frequency. Where the arm is slower (at
the ends, after a pause, at a lower global speed), it swings slower in proportion, and the path of
the tool stays the same.
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


_TABLE = 4096  # points of the table of one swing
_ROUNDED = 2e-4  # length that rounding takes off a corner of the shape, within the widths below [m]
_SHARPEST, _BLUNTEST = 0.005, 0.03  # limits of the width of the rounding, in parts of a swing
_FINE = 24  # least number of samples of the path per swing
_SLIGHT = 3e-5  # share of the amplitude below which a wave needs no finer samples
_SQUARE = 0.1  # sine of the angle between path and normal of the plane, below which it is refused
_MOST = 30_000  # largest number of samples of one path
_NUDGE = 1e-5  # share of the length over which the direction of the path is measured
#: the axis that is perpendicular to each plane
_NORMALS = {"XY": 2, "XZ": 1, "YZ": 0}


@dataclass(frozen=True, slots=True, eq=False)
class Weave:
    """A weave as requested.

    Attributes:
        shape: shape of a swing.
        plane: plane of the swing.
        frequency: swings per second at the requested speed, without dwells [Hz].
        amplitude: largest distance of the swing to either side [m].
        left: dwell time on the left [s].
        right: dwell time on the right [s].
        stands: whether the motion along the path stands during a dwell.
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
        """Whether its plane turns with the tool; otherwise it is fixed to the work object."""
        return self.plane <= WeavePlane.TOOL_YZ

    @property
    def normal(self) -> int:
        """The axis that is perpendicular to the plane: 0 to 2 for x, y, z."""
        return _NORMALS[self.plane.name[-2:]]

    def over(self, curve: Curve, v: float) -> Woven | None:
        """Add the weave to a path, with the number of whole swings nearest to the frequency.

        Args:
            curve: curve of the tool centre point, in the base frame.
            v: requested speed along it [m/s].

        Returns:
            The path with the weave; None if less than half a swing fits on it, if the path does not
            move the tool centre point, or if the amplitude is zero.

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
    """Give the offset of the tool from the path in one swing, without rounded corners.

    The tool swings to the left first. Left is the direction of the path after a right-handed
    quarter turn about the plane's normal.

    Args:
        weave: the weave.
        x: position in the swing, 0 to 1. Shape (n,).
        dwells: dwell times on the left and on the right, while the path goes on [s].

    Returns:
        Offsets to the left, and forward [m]. Shape (n, 2).
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
    """A path with a weave, as a function of the distance along the path.

    Corners of the shape are rounded, because a corner would be a jump of the speed: by 0.2 mm, but
    at least by 1.6 % and at most by 9.6 % of the amplitude.

    Attributes:
        length: length of the path [m].
        turning: angle by which the orientation turns along it [rad].
        detail: distance along it between samples that resolves every swing [m].
        stops: distances at which the motion stands, and for how long [m, s].
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
            PlanError: the path is perpendicular to the plane of the weave.
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
    """Tabulate one swing as a sum of waves, with the high ones damped.

    Returns:
        Offsets and their change from point to point, with the first point repeated at the end; and
        the number of the highest wave that counts.
    """
    raw = offsets(weave, np.arange(_TABLE) / _TABLE, dwells)
    waves = np.fft.rfft(raw, axis=0)
    number = np.arange(len(waves))[:, None]
    if weave.shape in (WeaveShape.TRIANGLE, WeaveShape.TRAPEZOID) or any(dwells):
        # Rounding by a bell curve of this width takes 3.2 · width · amplitude off a corner.
        width = min(max(_ROUNDED / (3.2 * weave.amplitude), _SHARPEST), _BLUNTEST)
        width /= 1.0 + sum(dwells) * weave.frequency  # it was in parts of a swing without dwells
        waves *= np.exp(-2.0 * (np.pi * width * number) ** 2)
    size = np.abs(waves).max(axis=1) / _TABLE
    finest = int(np.flatnonzero(size > _SLIGHT * weave.amplitude).max(initial=1))
    table = np.fft.irfft(waves, _TABLE, axis=0)
    slope = np.fft.irfft(2j * np.pi / _TABLE * number * waves, _TABLE, axis=0)
    table -= table[0]  # a weave begins on the path
    return np.concatenate([table, table[:1]]), np.concatenate([slope, slope[:1]]), finest
