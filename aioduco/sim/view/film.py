"""The frames of a film: which instants are kept, and how long each is shown. No pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from aioduco.models.rotation import Array


#: change of a position that can be seen [rad, m]
_VISIBLE = 1e-3


class Frame(NamedTuple):
    """One picture of a film.

    Attributes:
        positions: positions of everything that moves.
        duration: time for which it is shown [s].
    """

    positions: Array
    duration: float


class Film:
    """Keeps the frames that differ visibly, up to a limit.

    While nothing moves, no frame is added, and a long rest is cut short. When the film is full,
    every other frame is dropped: a long film has fewer frames per second.

    Args:
        limit: largest number of frames, at least 2.
        rest: longest time for which a rest is shown [s].
    """

    def __init__(self, limit: int = 300, rest: float = 1.0) -> None:
        self._limit = limit
        self._rest = rest
        self._interval = 0.0
        self._times: list[float] = []
        self._positions: list[Array] = []
        self._end = 0.0

    def add(self, time: float, positions: Array) -> None:
        """Add an instant, if it differs visibly from the last frame.

        Args:
            time: time of the simulation [s]; later than the one before.
            positions: positions of everything that moves.
        """
        self._end = time
        if self._times:
            same = float(np.abs(positions - self._positions[-1]).max()) < _VISIBLE
            if same or time - self._times[-1] < self._interval:
                return
        self._times.append(time)
        self._positions.append(positions)
        if len(self._times) > self._limit:
            span = self._times[-1] - self._times[0]
            self._times, self._positions = self._times[::2], self._positions[::2]
            self._interval = span / self._limit * 2.0

    @property
    def frames(self) -> list[Frame]:
        """The film so far, in simulated time."""
        ends = [*self._times[1:], self._end][: len(self._times)]
        return [
            Frame(positions, min(end - time, self._rest))
            for time, end, positions in zip(self._times, ends, self._positions, strict=True)
        ]
