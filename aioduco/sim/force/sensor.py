"""The force sensor at the flange: its errors, and how the controller interprets its signal."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from aioduco.kinematics.mounting import GRAVITY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array


DOWN = (0.0, 0.0, -GRAVITY)
"""Gravity along the axes of a base that stands on the floor [m/s²]."""

_NOTHING = (0.0,) * 6
#: three standard deviations of the noise: for the forces from public logs [N], for the torques an
#: assumption [N m]
_NOISE = np.array([0.5] * 3 + [0.02] * 3)
#: largest offset: an assumption [N, N m]
_OFFSET = np.array([5.0] * 3 + [0.2] * 3)


@dataclass(frozen=True, slots=True, eq=False)
class ForceAxes:
    """The reference point and the axes of forces.

    Attributes:
        tip: the tool's tip in the flange's frame. Shape (4, 4).
        wobj: the work object in the base frame. Shape (4, 4).
        of_tool: whether the axes are the tool's, rather than the work object's.
    """

    tip: Array
    wobj: Array
    of_tool: bool = True
    _at: list[float] = field(init=False, repr=False)
    _axes: list[list[float]] = field(init=False, repr=False)
    _turn: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_at", self.tip[:3, 3].tolist())
        object.__setattr__(self, "_axes", self.tip[:3, :3].tolist())
        object.__setattr__(self, "_turn", (self.tip if self.of_tool else self.wobj)[:3, :3])

    def turn(self, flange: Array) -> Array:
        """Give the axes as columns in the base frame, (3, 3), for the flange's rotation there."""
        turned: Array = flange.dot(self._turn) if self.of_tool else self._turn
        return turned

    def seen(self, wrench: Sequence[float], flange: Array) -> list[float]:
        """Convert a wrench on the flange to one on the tip, along the axes.

        Args:
            wrench: force [N], then torque about the flange's origin [N m], in its frame.
            flange: rotation of the flange in the base frame. Shape (3, 3).
        """
        fx, fy, fz, tx, ty, tz = wrench
        x, y, z = self._at
        tx, ty, tz = tx - (y * fz - z * fy), ty - (z * fx - x * fz), tz - (x * fy - y * fx)
        if self.of_tool:
            (a, b, c), (d, e, f), (g, h, i) = self._axes
        else:
            (a, b, c), (d, e, f), (g, h, i) = flange.T.dot(self._turn).tolist()
        # The axes are columns. Plain floats take a fifth of an array's time.
        return [
            fx * a + fy * d + fz * g,
            fx * b + fy * e + fz * h,
            fx * c + fy * f + fz * i,
            tx * a + ty * d + tz * g,
            tx * b + ty * e + tz * h,
            tx * c + ty * f + tz * i,
        ]


@dataclass(frozen=True, slots=True, eq=False)
class ForceSensor:
    """How the signal of the sensor is interpreted. It is immutable: taring makes another one.

    The signal is what the flange's surroundings apply to it, in its frame: force [N], then torque
    [N m]. It is the sum of three parts: the sensor's own offset, the weight of what the flange
    carries, and the external force.

    Attributes:
        zero: subtracted from the signal to get the reading. Six numbers.
        bare: the signal without load and force, as the controller assumes it. Six numbers.
        mass: mass of the load that was set on the controller [kg].
        centre: its centre of mass in the flange's frame [m].
        gravity: gravity along the base's axes [m/s²].
    """

    zero: tuple[float, ...] = _NOTHING
    bare: tuple[float, ...] = _NOTHING
    mass: float = 0.0
    centre: tuple[float, ...] = (0.0, 0.0, 0.0)
    gravity: tuple[float, ...] = DOWN

    def reading(self, signal: Array) -> list[float]:
        """Give the signal after taring (fc_get_ft)."""
        return _less(signal.tolist(), self.zero)

    def felt(self, signal: Array) -> list[float]:
        """Give the sum of the load's weight and the external force."""
        return _less(signal.tolist(), self.bare)

    def external(self, signal: Array, flange: Array) -> list[float]:
        """Give the external force.

        Args:
            signal: signal of the sensor [N, N m]. Shape (6,).
            flange: the flange's rotation in the base frame. Shape (3, 3).
        """
        felt = self.felt(signal)
        return felt if self.mass == 0.0 else _less(felt, self.weight(flange))

    def weight(self, flange: Array) -> tuple[float, ...]:
        """Give the weight of the known load, as a wrench on the flange, in its frame."""
        if self.mass == 0.0:
            return _NOTHING
        x, y, z = (self.mass * (np.array(self.gravity) @ flange)).tolist()
        a, b, c = self.centre
        return (x, y, z, b * z - c * y, c * x - a * z, a * y - b * x)

    def carrying(self, mass: float, centre: Sequence[float]) -> ForceSensor:
        """Give a sensor with another load [kg], whose centre is in the flange's frame [m]."""
        return replace(self, mass=mass, centre=tuple(centre))

    def tared(
        self,
        signal: Array,
        flange: Array,
        direction: Sequence[bool] = (True,) * 6,
        value: Sequence[float] = _NOTHING,
    ) -> ForceSensor:
        """Give a sensor that reads certain values now, and takes them for external forces.

        Args:
            signal: present signal of the sensor [N, N m]. Shape (6,).
            flange: the flange's rotation in the base frame. Shape (3, 3).
            direction: which of the six readings are set.
            value: the values that they get [N, N m].
        """
        now, weight = signal.tolist(), self.weight(flange)
        zero, bare = list(self.zero), list(self.bare)
        for i, on in enumerate(direction):
            if on:
                zero[i] = now[i] - value[i]
                bare[i] = zero[i] - weight[i]
        return replace(self, zero=tuple(zero), bare=tuple(bare))


class SensorNoise:
    """Adds the sensor's offset and noise to a signal.

    Args:
        seed: seed of offset and noise: the same seed gives the same sequence.

    Attributes:
        offset: mean signal without a force [N, N m]. Shape (6,).
    """

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self.offset: Array = self._random.uniform(-_OFFSET, _OFFSET)

    def __call__(self, signal: Array) -> Array:
        """Give the signal with the offset and a new sample of the noise [N, N m]. Shape (6,)."""
        noise: Array = self._random.standard_normal(6) * (_NOISE / 3.0)
        return signal + self.offset + noise


def _less(left: Sequence[float], right: Sequence[float]) -> list[float]:
    a, b, c, d, e, f = left
    u, v, w, x, y, z = right
    return [a - u, b - v, c - w, d - x, e - y, f - z]
