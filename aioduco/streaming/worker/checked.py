"""Conversion of a stream's set-points into configurations that the envelope's checker takes.

Speeds are checked by where the arm gets with them until it stands, from where it was read to be.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from aioduco.envelope.checker import STOPPING, EnvelopeChecker
from aioduco.streaming.shared.config import QueueDrive
from aioduco.streaming.shared.space import POSE_SPACE, rotated

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from aioduco._wire.connection import Connection
    from aioduco.envelope.limits import Crossing
    from aioduco.streaming.shared.config import EnvelopeSettings, WorkerConfig
    from aioduco.streaming.shared.space import Config

__all__ = ["CheckedPath", "EnvelopeSpace", "SpeedCheck"]

_STEP = 0.02  # length of one checked step between two points [m, rad]
_MOST_STEPS = 500
_FRESH = 10_000_000  # ns for which a position is used after it was read
_CYCLE = 0.001  # time in which the controller takes one point from its queue [s]
#: least time in which the tool comes to rest: about what the watch of the state assumes [s]
_BRAKING = 0.1


class EnvelopeSpace:
    """Converts set-points of a stream into configurations that an `EnvelopeChecker` takes.

    Args:
        envelope: the envelope, and the frames of the set-points.
        config: the configuration of the stream.
        connection: connection over which the arm's position is read.
        turn: orientation of the tool at the start, for steps that are not given in its frame;
            empty for others.
    """

    def __init__(
        self,
        envelope: EnvelopeSettings,
        config: WorkerConfig,
        connection: Connection,
        turn: Config = (),
    ) -> None:
        sent, timeout = config.sent, config.options.timeout
        self.checker: EnvelopeChecker = EnvelopeChecker(envelope.packed, by_tip=not sent.in_joints)
        self._in_joints = sent.in_joints
        self._base = POSE_SPACE.decode(envelope.wobj)
        self._turn = turn
        if not sent.in_joints:
            joints = connection.call("get_actual_joints_position", (), timeout)
            self.checker.seed = tuple(joints[:6])
        if sent.meaning == "step":
            name, *args = sent.read
            tip = POSE_SPACE.decode(connection.call(name, tuple(args), timeout))
            self._base = POSE_SPACE.composed(self._base, tip)

    def seen(self, config: Config) -> Sequence[float]:
        """A set-point as joints, or as the pose of the tool's tip in the base frame."""
        if self._in_joints:
            return config
        if self._turn:
            config = POSE_SPACE.in_axes(config, self._turn)
        return _tip(POSE_SPACE.composed(self._base, config))


def _tip(config: Config) -> Sequence[float]:
    """A pose of the tool's tip in the base frame, as the checker takes it."""
    x, y, z, w, a, b, c = config
    return (
        *(1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)),
        *(2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)),
        *(2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)),
        *(x, y, z),
    )


class CheckedPath:
    """Checks the straight lines between the points through which the controller plans a motion.

    Args:
        config: the configuration of a stream with an envelope.
        connection: connection over which the arm's position is read.
        start: the arm's position, as six numbers of the wire.
    """

    def __init__(
        self, config: WorkerConfig, connection: Connection, start: Sequence[float]
    ) -> None:
        assert config.envelope is not None
        self._space = config.sent.space
        self._place = EnvelopeSpace(config.envelope, config, connection)
        self._last = self._space.decode(start)
        self._seen = self._place.seen(self._last)
        self._begun = False

    def add(self, values: Sequence[float]) -> Crossing | None:
        """Take the next point, and return the limit that the line to it crosses, if any."""
        checker, space = self._place.checker, self._space
        if not self._begun:
            self._begun = True
            if found := checker.begin(self._seen):
                return found
        target = space.decode(values)
        way = space.difference(self._last, target)
        count = min(_MOST_STEPS, max(1, math.ceil(max(map(abs, way)) / _STEP)))
        for number in range(1, count + 1):
            share = number / count
            there = self._place.seen(space.moved(self._last, tuple(share * w for w in way)))
            # The controller chooses the speed here, so limits with the action "slow" do not apply.
            if found := checker.sweep(self._seen, there, 0.0):
                return found
            self._seen = there
        self._last = target
        return None


class SpeedCheck:
    """Checks speeds: where the arm gets with them until a stop takes effect, and until it stands.

    It reads the arm's position over the worker's connection, so it must not be used while a call
    on that connection is not answered.

    Args:
        envelope: the envelope, and the work object in use.
        config: the configuration of the stream.
        connection: connection over which the arm's position is read.
        turned: function that rotates speeds into the frame of the wire.
    """

    def __init__(
        self,
        envelope: EnvelopeSettings,
        config: WorkerConfig,
        connection: Connection,
        turned: Callable[[Config], Config],
    ) -> None:
        sent, drive = config.sent, config.sent.drive
        self.checker: EnvelopeChecker = EnvelopeChecker(envelope.packed, by_tip=not sent.in_joints)
        self._in_joints = sent.in_joints
        self._limits = tuple(zip(sent.space.groups, sent.limits.acceleration, strict=True))
        self._connection = connection
        self._timeout = config.options.timeout
        self._turned = turned
        #: orientation of the frame of the wire; empty for that of the tool
        self._frame: Config = ()
        #: time at a speed until a stop takes effect: the program's, after two ticks without any [s]
        self._reach = envelope.reaction + 2 * config.period + _FRESH * 1e-9
        if isinstance(drive, QueueDrive):
            self._frame = POSE_SPACE.decode(envelope.wobj)
            self._reach += drive.depth * _CYCLE
        self._place: Config = ()
        self._read_at = 0

    def look(self, speeds: Config) -> tuple[Crossing | None, float]:
        """Check speeds.

        Args:
            speeds: of the joints [rad/s], or of the tool, in the program's frame [m/s, rad/s].

        Returns:
            The limit that the arm would cross, if any; and the share of the speeds at which the
            limits with the action "slow" are kept.
        """
        if not any(speeds):
            return None, 1.0
        braking = 0.0 if self._in_joints else _BRAKING
        for group, a in self._limits:
            top = math.hypot(*speeds[group])
            braking = max(braking, top / a, top / STOPPING if self._in_joints else 0.0)
        seconds = self._reach + braking / 2
        checker = self.checker
        place = self._position()
        here = place if self._in_joints else _tip(place)
        checker.begin(here, leaving=True)
        share = 1.0
        for there, passed in self._ahead(place, speeds, seconds):
            speed = 0.0
            if checker.times:
                begin, end = checker.places(here)[0], checker.places_ahead(there)[0]
                speed = math.dist(begin, end) / passed
            while found := checker.too_fast(share * speed) or checker.sweep(
                here, there, share * speed
            ):
                if found.action != "slow":
                    return found, share
                share *= checker.slow_speed(found.limit) / (share * speed) * (1 - 1e-9)
            checker.arrived(there)
            here = there
        return checker.not_left(here), share

    def _position(self) -> Config:
        """The arm's joints, or its tip in the base frame, read at most 10 ms ago."""
        now = time.monotonic_ns()
        if not self._place or now - self._read_at > _FRESH:
            call, timeout = self._connection.call, self._timeout
            if self._in_joints or not self._place:
                joints = tuple(call("get_actual_joints_position", (), timeout)[:6])
                self._place = self.checker.seed = joints
            if not self._in_joints:
                self._place = POSE_SPACE.decode(call("get_tcp_pose", (), timeout))
            self._read_at = now
        return self._place

    def _ahead(
        self, place: Config, speeds: Config, seconds: float
    ) -> Iterator[tuple[Sequence[float], float]]:
        """Where the arm gets, in steps, and how long each takes [s]."""
        count = min(_MOST_STEPS, math.ceil(seconds * math.hypot(*speeds) / _STEP))
        step = seconds / count
        if self._in_joints:
            for number in range(1, count + 1):
                passed = number * step
                yield tuple([q + passed * v for q, v in zip(place, speeds, strict=True)]), step
            return
        wire = self._turned(speeds)
        for _ in range(count):
            axes = (self._frame or place)[3:]
            shift = (*rotated(axes, wire[:3]), *rotated(axes, wire[3:]))
            place = POSE_SPACE.moved(place, tuple([step * each for each in shift]))
            yield _tip(place), step
