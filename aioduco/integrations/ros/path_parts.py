"""Parts of a goal's path: the whole, or what remains of it for an arm that is elsewhere. No I/O."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco import JointTrajectory

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from aioduco.integrations.ros.trajectory_goals import NamedLimits


_SAMPLE = 0.02  # time between two points of what remains of a path [s]
#: points of what remains besides those of the path itself, between which it is one polynomial
_MOST_SAMPLES = 3000
_SHORTEST = 0.2  # shortest time in which the arm reaches the path's speed [s]
#: times in which a moving arm comes onto a path, the shortest that keeps the limits is taken [s]
_BLENDS = (0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8, 1.2, 1.6, 2.4)
_SEARCH = 0.01  # distance of the times among which the nearest is searched [s]


@dataclass(frozen=True, slots=True, eq=False)
class PathPart:
    """A trajectory of the arm, and where on the goal's path it is when.

    Attributes:
        trajectory: the trajectory.
        path_time: the time on the goal's path of a time on the trajectory [s].
    """

    trajectory: JointTrajectory
    path_time: Callable[[float], float]


def whole_path(trajectory: JointTrajectory, factor: float) -> PathPart:
    """A whole path, at a factor of its speed.

    Args:
        trajectory: the goal's trajectory.
        factor: factor of its speed, above 0 to 1.
    """
    if factor == 1.0:
        return PathPart(trajectory, lambda time: time)
    v, a = trajectory.velocities, trajectory.accelerations
    slower = JointTrajectory(
        trajectory.positions,
        trajectory.times / factor,
        None if v is None else v * factor,
        None if a is None else a * factor**2,
    )
    return PathPart(slower, lambda time: time * factor)


def rest_of_path(
    path: Any, actual: Sequence[float], *, begin: float, factor: float, profile: NamedLimits
) -> PathPart:
    """What remains of a path, from an arm at rest that need not be on it.

    The arm gains the path's speed from rest, and comes onto the path meanwhile, within the joints'
    speeds: the time for that is at least six times that of its way to the path at full speed.

    Args:
        path: the curve of the goal's trajectory.
        actual: position of the arm [rad]. Shape (6,).
        begin: time on the path with which the arm begins [s].
        factor: factor of the path's speed, above 0 to 1.
        profile: limits of the arm.
    """
    here = np.asarray(actual, dtype=np.float64)
    off = here - path.at(np.array([begin]))[0]
    remains = float(path.times[-1]) - begin
    speed = np.abs(path.velocity(np.array([begin]))).max() * factor
    away = float((np.abs(off) / profile.velocity).max())
    ramp = max(_SHORTEST, 1.5 * speed / profile.acceleration, 6.0 * away)
    if remains / factor > ramp / 2:
        duration = remains / factor + ramp / 2
        moments = _moments(ramp, duration, ramp / 2 + (path.times - begin) / factor)
        rising = np.minimum(moments / ramp, 1.0)
        place = begin + factor * (moments - ramp * rising * (1.0 - rising / 2.0))
        rate = factor * rising
    else:
        # so near to the end that it is one smooth motion there
        ramp = duration = max(_SHORTEST, 1.6 * (remains / factor + away))
        moments = _moments(duration, duration)
        share = moments / duration
        place = begin + remains * share**2 * (3.0 - 2.0 * share)
        rate = remains * 6.0 * share * (1.0 - share) / duration
        rising = share
    place = np.minimum(place, path.times[-1])
    blend = (1.0 - rising**2 * (3.0 - 2.0 * rising))[:, None]
    slope = np.where(moments < ramp, -6.0 * rising * (1.0 - rising) / ramp, 0.0)[:, None]
    positions = path.at(place) + blend * off
    velocities = path.velocity(place) * rate[:, None] + slope * off
    velocities[-1] = 0.0
    low, high = np.asarray(profile.lower), np.asarray(profile.upper)
    made = JointTrajectory(np.clip(positions, low, high), moments, velocities)
    return PathPart(made, lambda time: float(np.interp(time, moments, place)))


def path_from_motion(
    path: Any,
    place: NDArray[np.float64],
    speed: NDArray[np.float64],
    *,
    begin: float,
    factor: float,
    profile: NamedLimits,
) -> PathPart | None:
    """What remains of a path, from an arm that moves and need not be on it.

    Position and speed begin with those of the arm, and fade into those of the path.

    Args:
        path: the curve of the goal's trajectory.
        place: set-point of the arm [rad]. Shape (6,).
        speed: its speed [rad/s]. Shape (6,).
        begin: time on the path at which the arm is there [s].
        factor: factor of the path's speed, above 0 to 1.
        profile: limits of the arm.

    Returns:
        The part; None if no fading within the limits ends before the path does.
    """
    begin = min(max(begin, float(path.times[0])), float(path.times[-1]))
    duration = (float(path.times[-1]) - begin) / factor
    at = np.array([begin])
    gap, drift = place - path.at(at)[0], speed - factor * path.velocity(at)[0]
    if duration < _BLENDS[0]:
        return None
    near = min(duration, _BLENDS[-1])  # as long as it may fade
    moments = _moments(near, duration, (path.times - begin) / factor)
    own, rate = path.at(begin + factor * moments), factor * path.velocity(begin + factor * moments)
    own_change = np.abs(np.gradient(rate, moments, axis=0)).max(axis=0)
    for blend in _BLENDS:
        if blend > duration:
            return None
        share = np.minimum(moments / blend, 1.0)[:, None]
        keep, out = (1.0 - share) ** 2 * (1.0 + 2.0 * share), share * (1.0 - share) ** 2 * blend
        fading = -6.0 * share * (1.0 - share) / blend, (1.0 - share) * (1.0 - 3.0 * share)
        positions = own + keep * gap + out * drift
        velocities = rate + fading[0] * gap + fading[1] * drift
        velocities[-1] = 0.0
        # where the arm comes from, its speed was within the limits
        fastest = np.maximum(profile.velocity, np.abs(speed))
        slow = np.all(np.abs(velocities) <= fastest)
        most = np.maximum(profile.acceleration, own_change)
        soft = np.all(6.0 * np.abs(gap) / blend**2 + 4.0 * np.abs(drift) / blend <= most)
        within = np.all((positions >= profile.lower) & (positions <= profile.upper))
        if slow and soft and within:
            made = JointTrajectory(positions, moments, velocities)
            return PathPart(made, lambda time: min(begin + factor * time, float(path.times[-1])))
    return None


def nearest_time(path: Any, actual: Sequence[float], begin: float, end: float) -> float:
    """The time of the path's place that is nearest to the arm.

    Args:
        path: the curve of a trajectory.
        actual: position of the arm [rad]. Shape (6,).
        begin: earliest time [s].
        end: latest time [s].
    """
    first, last = np.clip([begin, end], path.times[0], path.times[-1]).tolist()
    times = np.linspace(first, last, max(2, math.ceil((last - first) / _SEARCH) + 1))
    away = np.abs(path.at(times) - np.asarray(actual, dtype=np.float64)).sum(axis=1)
    return float(times[int(np.argmin(away))])


def _moments(
    near: float, duration: float, points: NDArray[np.float64] | Sequence[float] = ()
) -> NDArray[np.float64]:
    """Times of the points: close together at first, then those of the path, and some between.

    Args:
        near: time in which the arm comes onto the path [s].
        duration: time of the whole [s].
        points: times of the path's own points [s].
    """
    own = [time for time in points if near + _SAMPLE < time < duration - _SAMPLE]
    edges = np.array([0.0, *([near, *own] if near + _SAMPLE < duration else ()), duration])
    steps = np.full(len(edges) - 1, max(_SAMPLE, duration / _MOST_SAMPLES))
    steps[0] = min(_SAMPLE, near / 10)
    counts = np.concatenate([[0], np.cumsum(np.ceil(np.diff(edges) / steps))])
    moments: NDArray[np.float64] = np.interp(np.arange(counts[-1] + 1), counts, edges)
    return moments
