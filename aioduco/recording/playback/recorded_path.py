"""The joints of a recording over time, as a path that an arm can follow again.

`sample_times` computes when the samples were taken, and what is missing between them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from aioduco.errors import ParameterError, RecordingError
from aioduco.models.pose import Joints
from aioduco.models.ranges import TIMEOUT, WAIT
from aioduco.models.rules import Number
from aioduco.models.words import one_of
from aioduco.recording.playback.sample_times import (
    SAME,
    STILL,
    RecordedGap,
    gaps_between,
    is_fresh,
    steady_times,
)
from aioduco.recording.run import of_any_maker
from aioduco.streaming.joint_trajectory import JointTrajectory, TrajectoryResult

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from aioduco.recording import RecordedRun

    Array = NDArray[np.float64]


#: factor on the recorded speed
SPEED_FACTOR = Number(0.01, 10.0, source="this package")
_BRIDGE = Number(0.0, 0.1, source="this package")
#: shortest time between two samples [s]: closer ones are the same sample of the controller
_SHORTEST = 5e-4
#: time of rest that is kept before and after the motion [s]
_REST = 0.05
#: time in which a path that begins or ends within a motion accelerates or stops [s]
_EASE = 0.4


#: names of the joints, in their order
_NAMES = [f"joint_{number}" for number in range(1, 7)]


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
        gaps: times without samples that were bridged.
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
    gaps: tuple[RecordedGap, ...] = ()

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
        bridge: float = 0.005,
    ) -> RecordedPath:
        """Take the path out of a recording, from when the arm begins to move until it stands.

        Pauses on the way are kept. If `begin` or `end` lies within a motion, the path accelerates
        or stops within 0.4 s, or its whole time if that is less, on the recorded way.

        This takes seconds for ten minutes of recording: in an event loop, call it on a thread,
        or the heartbeat is lost: `await anyio.to_thread.run_sync(RecordedPath.of, run)`.

        Args:
            run: the recording.
            begin: time in the recording to begin at [s]; None for its beginning.
            end: time in the recording to end at [s]; None for its end.
            speed: factor on the recorded speed, 0.01 to 10.
            of: "setpoints" for the commanded joints; "states" for the actual joints.
            bridge: a gap of more than 0.1 s between two samples of the moving arm is bridged, from
                the positions and speeds at its ends, if no joint can have been farther from there
                than this, 0 to 0.1 [rad]. A recording is taken not to hide a larger acceleration
                than it has elsewhere.

        Raises:
            ParameterError: an argument is out of range.
            RecordingError: the recording has no joints, the arm did not move in that time, or a
                gap is too wide to be bridged: the message says where, and what helps.
        """
        if not hasattr(run, "arrays"):
            made = "a recording, as aioduco.recording.read returns it"
            raise ParameterError("run", run, made)
        speed, bridge = SPEED_FACTOR("speed", speed), _BRIDGE("bridge", bridge)
        one_of("of", of, ("setpoints", "states"))
        first = 0.0 if begin is None else WAIT("begin", begin)
        last = run.duration if end is None else TIMEOUT("end", end)
        if (begin is not None or end is not None) and not 0.0 <= first < last:
            raise ParameterError("begin", begin, f"at least 0, and before the end, {last:g} s")
        topic = f"/joint_{of}"
        if topic not in run.topics:
            raise RecordingError(f"{run.path} has no joints to follow: it has no channel {topic}")
        read = run.arrays(topic)
        positions = np.asarray(read["position"])
        if positions.ndim != 2 or positions.shape[1] != 6:
            raise RecordingError(f"{run.path} has no six joints in {topic}")
        inside = (read["time"] >= first) & (read["time"] <= last)
        inside &= np.isfinite(positions).all(axis=1)
        received, positions = read["time"][inside], positions[inside]
        if len(positions) < 2:
            raise RecordingError(f"{run.path} has no joints from {first:g} to {last:g} s")
        for names in read["names"][inside] if "names" in read else ():
            if names not in (None, _NAMES):
                raise RecordingError(
                    f"{run.path} has the joints {', '.join(names)}, where joint_1 to joint_6 are "
                    "to be, in this order"
                )
        velocities = np.asarray(read.get("velocity", np.full_like(read["position"], np.nan)))
        velocities = velocities[inside]
        kept = _moving_part(run, received, positions)
        received, positions, velocities = received[kept], positions[kept], velocities[kept]
        fresh = is_fresh(positions, velocities)
        received, positions, velocities = received[fresh], positions[fresh], velocities[fresh]
        times, sharpest, factor = steady_times(received, positions, velocities)
        velocities = velocities * factor
        gaps = gaps_between(received, times, positions, velocities, sharpest)
        _bridged(run, gaps, bridge)
        apart = np.concatenate([[True], np.diff(times) > _SHORTEST])
        times, positions, velocities = times[apart], positions[apart], velocities[apart]
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
            velocities=velocities if factor else None,
            outputs=_outputs(run, times, eased),
            incidents=_incidents(run, float(times[0]), float(times[-1])),
            gaps=gaps,
        )

    def __repr__(self) -> str:
        return (
            f"<RecordedPath {self.source.name}, {self.duration:.2f} s from {self.begin:.2f} s, "
            f"{len(self.times)} points>"
        )

    def slower(self, share: float) -> RecordedPath:
        """The same path, at a share of its speed."""
        return replace(
            self,
            speed=self.speed * share,
            times=self.times / share,
            velocities=None if self.velocities is None else self.velocities * share,
            outputs=tuple(each._replace(time=each.time / share) for each in self.outputs),
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


def _moving_part(run: RecordedRun, received: Array, positions: Array) -> slice:
    """The samples from just before the arm leaves its first place until just after its last."""
    left, before = (
        np.flatnonzero(np.abs(positions - place).max(axis=1) > SAME) for place in positions[[0, -1]]
    )
    if not (len(left) and len(before)):
        raise RecordingError(
            f"{run.path}: the arm did not move from {received[0]:.2f} to {received[-1]:.2f} s"
        )
    first = int(np.searchsorted(received, received[left[0] - 1] - _REST))
    last = int(np.searchsorted(received, received[before[-1] + 1] + _REST, "right"))
    return slice(first, last)


def _bridged(run: RecordedRun, gaps: tuple[RecordedGap, ...], bridge: float) -> None:
    """Refuse a gap in which the arm may have been farther from the curve than is allowed."""
    wide = [gap for gap in gaps if gap.off > bridge]
    if not wide:
        return
    gap = wide[0]
    further = f" There are {len(wide)} such gaps." if len(wide) > 1 else ""
    largest = max(each.off for each in wide)
    helps = (
        "Record it again, with 20 samples a second or more, on a computer that is less busy; or "
        "play"
    )
    if np.isfinite(largest) and largest < _BRIDGE.high:
        helps += f" with bridge (--bridge) {math.ceil(largest * 1e4) / 1e4:g} rad, or"
    raise RecordingError(
        f"{run.path}: {gap}; at most {bridge * 1e3:g} mrad are bridged.{further} {helps} up to "
        f"{gap.time:.2f} s (--to), or from {gap.time + gap.duration:.2f} s on (--from)"
    )


def _eased(times: Array, positions: Array) -> tuple[Array, Array]:
    """Times from 0, adapted so that a path that begins or ends within a motion does so at rest.

    Returns:
        The times [s], and the factors on the recorded speed at the points.
    """
    since, left = times - times[0], times[-1] - times
    made, rates = since.copy(), np.ones_like(since)
    ease = min(_EASE, since[-1])
    speeds = np.abs(np.diff(positions, axis=0)).max(axis=1) / np.diff(times)
    if speeds[0] > 10 * STILL:
        slow = since < ease / 2
        made = np.where(slow, np.sqrt(2 * ease * since), since + ease / 2)
        rates = np.where(slow, made / ease, rates)
    if speeds[-1] > 10 * STILL:
        slow, late = left < ease / 2, np.sqrt(2 * ease * left)
        made = np.where(slow, made[-1] + ease / 2 - late, made)
        rates = np.where(slow, late / ease, rates)
    return made, rates


def _outputs(run: RecordedRun, recorded: Array, times: Array) -> tuple[RecordedOutput, ...]:
    """Changes of the cabinet's outputs in the recorded state, including those that an Op makes."""
    found: list[RecordedOutput] = []
    before: list[bool] = []  # those that were told last: a controller that starts tells none
    for message in run.messages("/io"):
        now = message.data["digital_outputs"]
        if recorded[0] <= message.time <= recorded[-1]:
            at = float(np.interp(message.time, recorded, times))
            found += [
                RecordedOutput(at, number, value)
                for number, (was, value) in enumerate(zip(before, now, strict=False), 1)
                if was != value
            ]
        before = now or before
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
