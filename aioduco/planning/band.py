"""Linear equations whose matrix is symmetric, positive and zero outside of a narrow band."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Points = NDArray[np.float64]


#: whose type hints leave out what factorizes bands
_LIBRARY: Any = mujoco


class BandMatrix:
    """A sum of small square blocks along the diagonal, factorized once.

    Args:
        first: row and column at which each block begins. Shape (m,).
        blocks: upper triangles of the blocks, in the order of `np.triu_indices`. Shape (pairs, m).
        count: number of rows and columns.
        width: number of rows and columns of a block.

    Raises:
        LinAlgError: the matrix is not positive.
    """

    def __init__(self, first: NDArray[np.intp], blocks: Points, count: int, width: int) -> None:
        low, high = np.triu_indices(width)
        # Each row from the left, its diagonal last.
        places = (high * width + width - 1 - high + low)[:, None] + width * first
        band = np.bincount(places.ravel(), blocks.ravel(), count * width)
        self._size = float(np.abs(band).max())
        self._band: Any = band / self._size
        self._shape = count, width, 0
        # The factorization takes what is below 1e-15 for zero, and so would not see a small matrix.
        if not _LIBRARY.mju_cholFactorBand(self._band, *self._shape, 1e-12, 0.0) > 0.0:
            raise np.linalg.LinAlgError

    def solve(self, right: NDArray[Any]) -> Points:
        """Give the unknowns for a right side. Shape (count,)."""
        found = np.empty(len(right))
        _LIBRARY.mju_cholSolveBand(found, self._band, right / self._size, *self._shape)
        return found
