"""What a force sensor shows without a force: an offset, and noise."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Vector: TypeAlias = NDArray[np.float64]

__all__ = ["SensorNoise"]

#: three standard deviations of the noise; of the forces as public logs show [N], of the torques an
#: assumption [N m]
_NOISE = np.array([0.5] * 3 + [0.02] * 3)
#: largest offset: an assumption [N, N m]
_OFFSET = np.array([5.0] * 3 + [0.2] * 3)


class SensorNoise:
    """Adds to a signal what its sensor shows by itself.

    Args:
        seed: of offset and noise: the same seed gives the same sequence.

    Attributes:
        offset: what it shows on average without a force [N, N m]. Shape (6,).
    """

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        self.offset: Vector = self._random.uniform(-_OFFSET, _OFFSET)

    def __call__(self, signal: Vector) -> Vector:
        """The signal as the sensor gives it at this instant [N, N m]. Shape (6,)."""
        noise: Vector = self._random.standard_normal(6) * (_NOISE / 3.0)
        return signal + self.offset + noise
