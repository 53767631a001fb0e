"""The joints of a recording over time, as a path that an arm can follow again.

A sample has the time of its reception. Its delay varies, and the arm would shake on a path with
these times. The recorded speeds give the true time between two samples. If they agree with the
positions, the times within a motion are computed from them; only the position of the whole motion
on the time axis is taken from the times of reception.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from aioduco.errors import ParameterError, RecordingError
from aioduco.models.pose import Joints
from aioduco.models.ranges import TIMEOUT, WAIT
from aioduco.models.rules import Number
from aioduco.recording.foreign import of_any_maker
from aioduco.streaming.joint_trajectory import JointTrajectory

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from aioduco.recording import RecordedRun
    from aioduco.streaming.joint_trajectory import TrajectoryResult

    Array = NDArray[np.float64]

__all__ = ["RecordedOutput", "RecordedPath"]

_FACTOR = Number(0.01, 10.0, source="this package")
#: longest time between two samples of a moving arm [s]: a curve through them is off by less than
#: 0.1 mrad up to there, at a jerk of 100 rad/s³
MAX_GAP = 0.1
#: joint speed [rad/s], and distance between two samples [rad], up to which the arm stands
_STILL, _SAME = 2e-3, 3e-5
#: largest relative difference between times from speeds and of reception, in one motion
_AGREES = 0.1
#: shortest time between two samples [s]: closer ones are the same sample of the controller
_SHORTEST = 5e-4
#: time of rest that is kept before and after the motion [s]
_REST = 0.05
#: time in which a path that begins or ends within a motion accelerates or stops [s]
_EASE = 0.4


class RecordedOutput(NamedTuple):
    """A digital output that changed.

    Attributes:
        time: time of the change, since the begin of the path [s].
        num: number of the cabinet's output, from 1.
        value: the new level.
    """

    time: float
    num: int
    value: bool


@dataclass(frozen=True, slots=True, eq=False)
class RecordedPath:
    """Joint positions over time from a recording. Made by `of`.

    Attributes:
        source: the file.
        arm: series and model of the arm, as its controller reported; empty if it reported none.
        speed: factor on the recorded speed.
        times: times of the points, from 0 [s]. Shape (n,).
        recorded: times of the points in the recording [s]. Shape (n,).
        positions: joint angles [rad]. Shape (n, 6).
        velocities: joint speeds [rad/s]; None if they do not agree with the positions.
        outputs: digital outputs of the cabinet that changed on the way.
        incidents: times [s] and names of incidents of the recorded arm, such as a collision.
    """

    source: Path
    arm: str
    speed: float
    times: Array
    recorded: Array
    positions: Array
    velocities: Array | None
    outputs: tuple[RecordedOutput, ...]
    incidents: tuple[tuple[float, str], ...]

    @classmethod
    @of_any_maker
    def of(
        cls,
        run: RecordedRun,
        *,
        begin: float | None = None,
        end: float | None = None,
        speed: float = 1.0,
        of: Literal["setpoints", "states"] = "setpoints",
    ) -> RecordedPath:
        """Take the path out of a recording, from when the arm begins to move until it stands.

        Pauses on the way are kept. If `begin` or `end` lies within a motion, the path accelerates
        or stops within 0.4 s, on the recorded way.

        Args:
            run: the recording.
            begin: time in the recording to begin at [s]; None for its beginning.
            end: time in the recording to end at [s]; None for its end.
            speed: factor on the recorded speed, 0.01 to 10.
            of: "setpoints" for the commanded joints; "states" for the actual joints.

        Raises:
            ParameterError: an argument is out of range.
            RecordingError: the recording has no joints, the arm did not move in that time, or
                samples are missing while it moved: the message says where.
        """
        speed = _FACTOR("speed", speed)
        if of not in ("setpoints", "states"):
            raise ParameterError("of", of, '"setpoints" or "states"')
        first = 0.0 if begin is None else WAIT("begin", begin)
        last = run.duration if end is None else TIMEOUT("end", end)
        if not 0.0 <= first < last:
            raise ParameterError("begin", begin, f"at least 0, and before the end, {last:g} s")
        topic = f"/joint_{of}"
        if topic not in run.topics:
            raise RecordingError(f"{run.path} has no joints to follow: it has no channel {topic}")
        read = run.arrays(topic)
        inside = (read["time"] >= first) & (read["time"] <= last)
        received, positions = read["time"][inside], np.asarray(read["position"])[inside]
        if positions.ndim != 2 or positions.shape[1] != 6 or len(positions) < 2:
            raise RecordingError(f"{run.path} has no joints from {first:g} to {last:g} s")
        velocities = np.asarray(read.get("velocity", np.full_like(read["position"], np.nan)))
        velocities = velocities[inside]
        kept = _moving_part(run, received, positions)
        received, positions, velocities = received[kept], positions[kept], velocities[kept]
        times, known = steady_times(received, positions, velocities)
        fresh = np.concatenate([[True], np.diff(times) > _SHORTEST])
        times, received = times[fresh], received[fresh]
        positions, velocities = positions[fresh], velocities[fresh]
        _refuse_gaps(run, times, positions)
        eased, rates = _eased(times, positions)
        velocities = velocities * rates[:, None] * speed
        velocities[0] = velocities[-1] = 0.0
        eased /= speed
        return cls(
            source=run.path,
            arm=run.metadata.get("arm", ""),
            speed=speed,
            times=eased,
            recorded=times,
            positions=positions,
            velocities=velocities if known else None,
            outputs=_outputs(run, times, eased),
            incidents=_incidents(run, float(times[0]), float(times[-1])),
        )

    def __repr__(self) -> str:
        return (
            f"<RecordedPath {self.source.name}, {self.duration:.2f} s from {self.begin:.2f} s, "
            f"{len(self.times)} points>"
        )

    @property
    def begin(self) -> float:
        """Time in the recording at which the path begins [s]."""
        return float(self.recorded[0])

    @property
    def duration(self) -> float:
        """Duration of the path [s]."""
        return float(self.times[-1])

    @property
    def start(self) -> Joints:
        """Joints at the begin of the path [rad]."""
        return Joints.of(self.positions[0].tolist())

    @property
    def trajectory(self) -> JointTrajectory:
        """The path as an argument of `robot.motion.follow_joint_trajectory`."""
        return JointTrajectory(self.positions, self.times, self.velocities)

    def at(self, times: Array) -> Array:
        """Joints at the given times [rad]. Shape (m, 6)."""
        return self.trajectory.curve(self.positions[0].tolist()).at(np.asarray(times, dtype=float))

    def recorded_time(self, time: float) -> float:
        """Time in the recording for a time of the path [s]."""
        return float(np.interp(time, self.times, self.recorded))

    async def run_on(
        self, motion: Any, read_joints: Any, **options: Any
    ) -> TrajectoryResult | None:
        """Follow the path; called by `robot.motion.execute`."""
        from aioduco.recording.playback.player import follow  # noqa: PLC0415 - it names this class

        return await follow(motion, read_joints, self, **options)


def steady_times(received: Array, positions: Array, velocities: Array) -> tuple[Array, bool]:
    """Times at which samples were really taken, from the speeds between them.

    Args:
        received: times of reception, rising [s]. Shape (n,).
        positions: joint angles [rad]. Shape (n, 6).
        velocities: joint speeds [rad/s]; NaN where they are not known. Shape (n, 6).

    Returns:
        The times [s], and whether the speeds agree with the positions throughout.
    """
    times = received.copy()
    ways, mean = np.diff(positions, axis=0), (velocities[1:] + velocities[:-1]) / 2
    square = (mean * mean).sum(axis=1)
    moving = (square > (10 * _STILL) ** 2) & (np.abs(ways).max(axis=1) > _SAME)
    moving &= np.diff(received) < MAX_GAP  # speeds say nothing about the motion in a gap
    agree = bool(np.all(np.isfinite(velocities)))
    for first, last in _stretches(moving):
        span = received[last] - received[first]
        steps = (ways[first:last] * mean[first:last]).sum(axis=1) / square[first:last]
        steps = np.maximum(steps, 0.0)
        if not agree or abs(steps.sum() - span) > _AGREES * span + 0.02:
            agree = False
            continue
        made = np.concatenate([[0.0], np.cumsum(steps)])
        # Samples are never early: the 25 % quantile of the offsets tells when the motion began.
        times[first : last + 1] = made + np.quantile(received[first : last + 1] - made, 0.25)
    return np.maximum.accumulate(times), agree


def _stretches(moving: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last sample of each motion; `moving` says whether the arm moves after a sample."""
    edges = np.diff(np.concatenate([[0], moving.astype(int), [0]]))
    firsts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return list(zip(firsts.tolist(), ends.tolist(), strict=True))


def _moving_part(run: RecordedRun, received: Array, positions: Array) -> slice:
    """The samples from just before the arm moves until just after."""
    moved = np.flatnonzero(np.abs(np.diff(positions, axis=0)).max(axis=1) > _SAME)
    if not len(moved):
        raise RecordingError(
            f"{run.path}: the arm did not move from {received[0]:.2f} to {received[-1]:.2f} s"
        )
    first = int(np.searchsorted(received, received[moved[0]] - _REST))
    last = int(np.searchsorted(received, received[moved[-1] + 1] + _REST, "right"))
    return slice(first, last)


def _refuse_gaps(run: RecordedRun, times: Array, positions: Array) -> None:
    steps, ways = np.diff(times), np.abs(np.diff(positions, axis=0)).max(axis=1)
    gaps = np.flatnonzero((steps > MAX_GAP) & (ways > 10 * _SAME))
    if len(gaps):
        at = int(gaps[0])
        raise RecordingError(
            f"{run.path}: {steps[at]:.2f} s are missing from {times[at]:.2f} s on, in which the "
            f"arm moved by {ways[at]:.3f} rad; how is not known. "
            f"Play it up to {times[at]:.2f} s, or from {times[at + 1]:.2f} s on"
        )


def _eased(times: Array, positions: Array) -> tuple[Array, Array]:
    """Times from 0, adapted so that a path that begins or ends within a motion does so at rest.

    Returns:
        The times [s], and the factors on the recorded speed at the points.
    """
    since, left = times - times[0], times[-1] - times
    made, rates = since.copy(), np.ones_like(since)
    if since[-1] < _EASE:
        return made, rates
    speeds = np.abs(np.diff(positions, axis=0)).max(axis=1) / np.diff(times)
    if speeds[0] > 10 * _STILL:
        slow = since < _EASE / 2
        made = np.where(slow, np.sqrt(2 * _EASE * since), since + _EASE / 2)
        rates = np.where(slow, made / _EASE, rates)
    if speeds[-1] > 10 * _STILL:
        slow, late = left < _EASE / 2, np.sqrt(2 * _EASE * left)
        made = np.where(slow, made[-1] + _EASE / 2 - late, made)
        rates = np.where(slow, late / _EASE, rates)
    return made, rates


def _outputs(run: RecordedRun, recorded: Array, times: Array) -> tuple[RecordedOutput, ...]:
    """Changes of the cabinet's outputs in the recorded state, including those that an Op makes."""
    found: list[RecordedOutput] = []
    before: list[bool] | None = None
    for message in run.messages("/io"):
        now = message.data["digital_outputs"]
        if before is not None and recorded[0] <= message.time <= recorded[-1]:
            at = float(np.interp(message.time, recorded, times))
            found += [
                RecordedOutput(at, number, value)
                for number, (was, value) in enumerate(zip(before, now, strict=True), 1)
                if was != value
            ]
        before = now
    return tuple(found)


def _incidents(run: RecordedRun, begin: float, end: float) -> tuple[tuple[float, str], ...]:
    """Incidents of the arm with their times in the recording; each kind once."""
    found: dict[str, float] = {}
    for message in run.messages("/state"):
        if not begin <= message.time <= end:
            continue
        state = message.data
        for name, what in (("collision", "a collision"), ("emergency_stop", "an emergency stop")):
            if state[name]:
                found.setdefault(what, message.time)
        if state["error"]:
            found.setdefault(f"fault {state['error']}", message.time)
    return tuple((time, what) for what, time in found.items())
