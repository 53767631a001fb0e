"""Check a path before an arm follows it: limits, speeds, the envelope, incidents."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco.envelope.checker import EnvelopeChecker
from aioduco.models.bounds import outside, shown
from aioduco.models.pose import Pose
from aioduco.models.ranges import JOINT_SPEED
from aioduco.recording.playback.recorded_path import SPEED_FACTOR, RecordedPath

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.envelope import Envelope
    from aioduco.kinematics import Arm
    from aioduco.recording.playback.waypoints import WaypointFile


_LOOK = 0.001  # time between two samples of the path, as between two set-points [s]
_WINDOW = 32  # samples over which an acceleration is computed: 32 ms
_SWEEP = 0.004  # time of one sweep of the envelope's check, which is exact over its way [s]
_ACCELERATION = 15.0  # largest acceleration of a joint in a replay [rad/s²]


@dataclass(frozen=True, slots=True)
class PathFinding:
    """A reason against following a path.

    Attributes:
        kind: "arm", "joint limit", "speed", "acceleration", "envelope" or "incident".
        time: time in the recording [s].
        text: the reason, in a sentence.
    """

    kind: str
    time: float
    text: str

    def __str__(self) -> str:
        return f"{self.kind} at {self.time:.2f} s: {self.text}"


def check_path(
    path: RecordedPath,
    arm: Arm,
    *,
    envelope: Envelope | None = None,
    tool: Sequence[float] = (0.0,) * 6,
    v: float | None = None,
    a: float = _ACCELERATION,
) -> tuple[PathFinding, ...]:
    """Find reasons against leading an arm along a path.

    All incidents are listed. Of each other kind, one place is listed: the first one beyond a joint
    limit or the envelope, the largest excess of a speed or acceleration. After a joint limit,
    nothing further is checked.

    Args:
        path: the path.
        arm: the arm that will follow it.
        envelope: the limits that the path must keep; None for none.
        tool: pose of the tool's tip in the frame of the flange [m, rad], for the envelope.
        v: largest speed of each joint [rad/s]; None for the arm's.
        a: largest acceleration of each joint, over 32 ms [rad/s²].

    Returns:
        The findings; empty if there are none.
    """
    found = [PathFinding("incident", at, f"the recorded arm had {what}")
             for at, what in path.incidents]  # fmt: skip
    beyond = outside(path.positions, arm.lower, arm.upper)
    if beyond.any():
        row, joint = (int(each[0]) for each in np.nonzero(beyond))
        text = (
            f"joint {joint + 1} is at {path.positions[row, joint]:.3f} rad, of "
            f"{shown(arm.lower[joint], low=True)} to {shown(arm.upper[joint])} rad"
        )
        at = path.recorded_time(float(path.times[row]))
        return (*found, PathFinding("joint limit", at, text))
    times, q = _looks(path)
    most = np.minimum(arm.velocity if v is None else [v] * 6, JOINT_SPEED.high)
    speeds, sharp = np.diff(q, axis=0) / _LOOK, _accelerations(q)
    allowed = np.full(6, a)
    within = not _over(speeds, most) and not _over(sharp, allowed)
    helps = "" if within else _what_helps(path, speeds, sharp, most, allowed)
    found += _beyond(path, "speed", "rad/s", times[:-1], speeds, most, helps)
    middles = np.arange(-_WINDOW / 2, len(sharp) - _WINDOW / 2) * _LOOK
    found += _beyond(path, "acceleration", "rad/s²", middles, sharp, allowed, helps)
    if envelope is not None:
        found += _leaves(path, envelope, tool)
    return tuple(found)


def check_waypoints(
    waypoints: WaypointFile,
    arm: Arm,
    *,
    envelope: Envelope | None = None,
    tool: Sequence[float] = (0.0,) * 6,
) -> list[str]:
    """List the waypoints that are beyond the limits of the joints, or beyond an envelope.

    Args:
        waypoints: the file.
        arm: the arm that will move there.
        envelope: the limits that the waypoints must keep; None for none.
        tool: pose of the tool's tip in the frame of the flange [m, rad], for the envelope.
    """
    found = []
    checker = None if envelope is None else EnvelopeChecker(envelope.packed(tool))
    for each in waypoints.waypoints:
        if not arm.within_limits(each.joints):
            found.append(f"waypoint {each.name!r} is beyond the limits of the joints")
        elif checker is not None and (crossing := checker.begin(list(each.joints))) is not None:
            found.append(f"waypoint {each.name!r} is beyond the envelope: {crossing}")
    return found


def fastest(path: RecordedPath) -> float:
    """The largest joint speed of a path [rad/s]."""
    return float(np.abs(np.diff(_looks(path)[1], axis=0)).max(initial=0.0)) / _LOOK


def sharpest(path: RecordedPath) -> float:
    """The largest joint acceleration of a path, over 32 ms [rad/s²]."""
    return float(np.abs(_accelerations(_looks(path)[1])).max(initial=0.0))


def _looks(
    path: RecordedPath, interval: float = _LOOK
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    times = np.arange(0.0, path.duration + interval, interval)
    return times, path.at(np.minimum(times, path.duration))


def _accelerations(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Joint accelerations, from three places half a window apart [rad/s²]. Shape (m, 6).

    The arm stands before and after. The first window ends where the path begins.
    """
    half = _WINDOW // 2
    q = np.pad(q, ((2 * half, 2 * half), (0, 0)), "edge")
    return np.asarray((q[2 * half :] - 2 * q[half:-half] + q[: -2 * half]) / (half * _LOOK) ** 2)


def _beyond(
    path: RecordedPath,
    kind: str,
    unit: str,
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    most: NDArray[np.float64],
    helps: str,
) -> list[PathFinding]:
    if not _over(values, most):
        return []
    row, joint = np.unravel_index(int(np.argmax(np.abs(values) / most)), values.shape)
    return [
        PathFinding(
            kind,
            path.recorded_time(float(times[row])),
            f"joint {joint + 1} has {abs(values[row, joint]):.3g} {unit}, {most[joint]:.3g} "
            f"allowed; {helps}",
        )
    ]


def _over(values: NDArray[np.float64], most: NDArray[np.float64]) -> bool:
    return bool((np.abs(values) > most * (1 + 1e-6)).any())


def _what_helps(
    path: RecordedPath,
    speeds: NDArray[np.float64],
    accelerations: NDArray[np.float64],
    v: NDArray[np.float64],
    a: NDArray[np.float64],
) -> str:
    """The speed factor at which a path is within limits, tried, if there is one."""
    excess = float((np.abs(accelerations) / a).max(initial=0.0)) ** 0.5
    share = 1.0 / max(1.0, excess, float((np.abs(speeds) / v).max(initial=0.0)))
    factor = math.floor(950 * share * path.speed) / 1000
    if factor >= SPEED_FACTOR.low:
        q = _looks(path.slower(factor / path.speed))[1]
        if not _over(np.diff(q, axis=0) / _LOOK, v) and not _over(_accelerations(q), a):
            return f"it would be allowed at a speed factor (--speed) of {factor:g}"
    return (
        "a lower speed factor does not help: the times of the samples there are not known well "
        "enough. Record it again on a computer that is less busy, or leave that part out"
    )


def _leaves(
    path: RecordedPath,
    envelope: Envelope,
    tool: Sequence[float],
) -> list[PathFinding]:
    times, q = _looks(path, _SWEEP)
    checker = EnvelopeChecker(envelope.packed(tool))
    tips = (envelope.arm.fkine(q) @ Pose.of(tool).matrix)[:, :3, 3]
    speeds = np.linalg.norm(np.diff(tips, axis=0), axis=1) / _SWEEP
    points = [tuple(point) for point in q.tolist()]
    crossing = checker.begin(points[0])
    number = 0
    while crossing is None and number < len(speeds):
        speed = float(speeds[number])
        crossing = checker.sweep(points[number], points[number + 1], speed)
        crossing = crossing or checker.too_fast(speed)
        number += 1
    if crossing is None:
        return []
    return [PathFinding("envelope", path.recorded_time(float(times[number])), str(crossing))]
