"""The errors of a force sensor: an offset, and noise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from aioduco.models.rotation import Array


__all__ = ["SensorNoise"]

#: three standard deviations of the noise: for the forces from public logs [N], for the torques an
#: assumption [N m]
_NOISE = np.array([0.5] * 3 + [0.02] * 3)
#: largest offset: an assumption [N, N m]
_OFFSET = np.array([5.0] * 3 + [0.2] * 3)


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
