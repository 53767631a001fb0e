"""Trajectories that are given by points and times, sampled at other times."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import Described, ParameterError
from aioduco.models.numpy_on_use import number_array
from aioduco.models.rules import LONGEST
from aioduco.streaming.shared.space import PoseSpace, Space

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray


_AT_ONCE = 256  # set-points computed at a time
#: largest number of set-points of one trajectory: 5.5 hours at 500 Hz, half a gigabyte
_MOST_INSTANTS = 10_000_000


class Spline:
    """A curve through points at given times, per axis: cubic, or of fifth order.

    Without velocities it is monotone between the points (Fritsch and Carlson), so it overshoots
    none of them. With velocities, and with accelerations, it has these values at the points.

    Args:
        times: rising times [s]. Shape (n,).
        points: positions. Shape (n, k).
        velocities: per second. Shape (n, k).
        accelerations: per second squared, only with velocities. Shape (n, k).
    """

    def __init__(
        self,
        times: NDArray[np.float64],
        points: NDArray[np.float64],
        velocities: NDArray[np.float64] | None = None,
        accelerations: NDArray[np.float64] | None = None,
    ) -> None:
        self.times = times
        self._points = points
        self._velocities = _monotone(times, points) if velocities is None else velocities
        self._accelerations = accelerations if velocities is not None else None

    @property
    def duration(self) -> float:
        """Time from the first point to the last [s]."""
        return float(self.times[-1] - self.times[0])

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Positions at given times; outside of the curve its ends. Shape (m, k)."""
        return self._evaluate(times)[0]

    def velocity(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Velocities at given times, zero outside of the curve. Shape (m, k)."""
        inside = (times >= self.times[0]) & (times <= self.times[-1])
        return np.asarray(np.where(inside[:, None], self._evaluate(times)[1], 0.0))

    def _evaluate(
        self, times: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        if len(self.times) == 1:
            flat = np.repeat(self._points, len(times), axis=0)
            return flat, np.zeros_like(flat)
        index = np.clip(np.searchsorted(self.times, times, "right") - 1, 0, len(self.times) - 2)
        length = np.diff(self.times)[index][:, None]
        share = np.clip((times - self.times[index])[:, None] / length, 0.0, 1.0)
        start, way = self._points[index], self._points[index + 1] - self._points[index]
        leave, come = self._velocities[index] * length, self._velocities[index + 1] * length
        if self._accelerations is None:
            square, cube = 3 * way - 2 * leave - come, leave + come - 2 * way
            terms = [start, leave, square, cube]
        else:
            bend, bent = (self._accelerations[at] * length**2 for at in (index, index + 1))
            terms = [
                start,
                leave,
                bend / 2,
                10 * way - 6 * leave - 4 * come - 1.5 * bend + 0.5 * bent,
                -15 * way + 8 * leave + 7 * come + 1.5 * bend - bent,
                6 * way - 3 * leave - 3 * come - 0.5 * bend + 0.5 * bent,
            ]
        place = np.zeros_like(start)
        rate = np.zeros_like(start)
        for term in reversed(terms):
            rate = rate * share + place
            place = place * share + term
        return place, rate / length


def _monotone(times: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Velocities at the points that overshoot none of them, with rest at both ends."""
    velocities = np.zeros_like(points)
    if len(times) < 3:
        return velocities
    steps = np.diff(times)[:, None]
    slopes = np.diff(points, axis=0) / steps
    before, after = slopes[:-1], slopes[1:]
    first, second = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
    same = before * after > 0
    safe_before, safe_after = np.where(same, before, 1.0), np.where(same, after, 1.0)
    mean = (first + second) / (first / safe_before + second / safe_after)
    velocities[1:-1] = np.where(same, mean, 0.0)
    return velocities


def sampled(space: Space, trajectory: Any, times: Any, interval: float) -> Iterator[list[float]]:
    """Set-points at a fixed interval, from points at given times.

    They are computed as they are taken: those of a long trajectory take seconds, in which an event
    loop must run.

    Args:
        space: the space of the points.
        trajectory: the points. Shape (n, 6).
        times: due time of each point, rising [s]. Shape (n,). None: one point per interval.
        interval: time between two set-points [s].

    Yields:
        Each set-point, from the first point to the last. Shape (6,).

    Raises:
        ParameterError: the shapes do not match, a number is not finite, or times do not rise; it
            is raised before the first set-point.
    """
    points = number_array("trajectory", trajectory)
    if points.ndim != 2 or points.shape[1] != 6 or not len(points):
        raise ParameterError("trajectory", points.shape, "of the shape (n, 6), n at least 1")
    if times is None:
        for begin in range(0, len(points), _AT_ONCE):
            yield from points[begin : begin + _AT_ONCE].tolist()
        return
    moments = number_array("times", times)
    if moments.shape != (len(points),):
        raise ParameterError("times", moments.shape, f"of the shape ({len(points)},)")
    if np.any(np.diff(moments) <= 0):
        raise ParameterError("times", times, "rising")
    moments = moments - moments[0]
    at = instants(float(moments[-1]), interval)
    in_poses = isinstance(space, PoseSpace) and len(points) > 1
    # orientations by the shortest turn between two points
    spline = Spline(moments, points[:, :3] if in_poses else points)
    turned: Iterator[tuple[float, ...]] = (
        _turned(space, points, moments, at) if in_poses else itertools.repeat(())
    )
    for begin in range(0, len(at), _AT_ONCE):
        for placed in spline.at(at[begin : begin + _AT_ONCE]).tolist():
            yield [*placed, *next(turned)]


def instants(duration: float, interval: float) -> NDArray[np.float64]:
    """Times from 0 to a duration at a fixed interval, the end included [s].

    Raises:
        ParameterError: there would be too many for a computer's memory.
    """
    if not duration <= _MOST_INSTANTS * interval:
        hint = " (seconds, not nanoseconds)" if duration >= LONGEST else ""
        expected = f"at most {_MOST_INSTANTS * interval:g} s long at {1 / interval:g} Hz{hint}"
        raise ParameterError("times", Described(f"{duration:g} s long"), expected)
    count = int(np.ceil(duration / interval - 1e-9))
    found: NDArray[np.float64] = np.minimum(np.arange(count + 1) * interval, duration)
    return found


def _turned(
    space: Space, points: NDArray[np.float64], moments: NDArray[np.float64], at: NDArray[np.float64]
) -> Iterator[tuple[float, ...]]:
    """The orientation of each set-point, by the shortest turn between two points [rad]."""
    indices = np.clip(np.searchsorted(moments, at, "right") - 1, 0, len(points) - 2)
    for index, rows in itertools.groupby(range(len(at)), indices.__getitem__):
        start, end = (space.decode(point) for point in points[index : index + 2].tolist())
        begin, length = moments[index], moments[index + 1] - moments[index]
        way = space.difference(start, end)
        for row in rows:
            share = float((at[row] - begin) / length)
            yield space.encode(space.moved(start, tuple(share * w for w in way)))[3:]
