"""Checks that a stream stays within the robot's envelope, and can come to rest within it.

Set-points are converted into configurations that the envelope's checker takes.

Speeds are checked by where the arm gets with them until it stands, from where it was read to be.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from aioduco.envelope.checker import SLOW_SHARE, STOPPING, EnvelopeChecker
from aioduco.models.quaternions import rotated
from aioduco.streaming.shared.space import POSE_SPACE, Config, Space, read_six
from aioduco.streaming.worker.limiter import JerkLimiter, Limiter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from aioduco._wire.connection import Connection
    from aioduco.envelope.limits import Crossing
    from aioduco.envelope.zones import Point
    from aioduco.streaming.shared.config import CheckedEnvelope, WorkerConfig


_JOINTS = ("get_actual_joints_position",)
_STEP = 0.02  # length of one checked step between two points [m, rad]
_MOST_STEPS = 500
#: deviation from the straight line, as a share of its length, if each axis brakes in its own time;
#: 7 % for two axes
_DEVIATION = 0.1
#: the same for one step of the closer check; larger, because the last step ends with cubic motion
_DEVIATION_OF_STEP = 0.4
_STEPS = 16  # of the closer check
_FRESH = 10_000_000  # ns for which a position is used after it was read
_CYCLE = 0.001  # time in which the controller takes one point from its queue [s]
#: least time in which the tool comes to rest: about what the watch of the state assumes [s]
_BRAKING = 0.1


class EnvelopeCheck:
    """Checks that the arm stays within the envelope on its way, and can come to rest within it.

    Args:
        checker: checks configurations of the arm.
        seen: converts a set-point into a configuration for the checker.
        space: the space of the set-points.
        period: time between two ticks of the stream [s].
        start: position of the arm, at rest.
        crossed: callback with the limit that would have been crossed; it must end the stream.
        curved: whether each axis comes to rest in its own time, as with a limit of jerk: its
            braking path is then not straight.
    """

    def __init__(
        self,
        checker: EnvelopeChecker,
        seen: Callable[[Config], Sequence[float]],
        space: Space,
        period: float,
        start: Config,
        crossed: Callable[[Crossing], None],
        *,
        curved: bool = False,
    ) -> None:
        self._checker = checker
        checker.deviation = _DEVIATION if curved else 0.0
        checker.slow_share = SLOW_SHARE
        self._configuration = seen
        self._space = space
        self._period = period
        self._last = start
        self._seen = seen(start)
        self._begun = False
        self.crossed: Callable[[Crossing], None] = crossed

    def begin(self) -> Crossing | None:
        """Check the arm's position, and return the limit that it is beyond, if any."""
        self._begun = True
        return self._checker.begin(self._seen)

    def moved(self, config: Config) -> None:
        """Note a set-point that was sent without a look, while the arm brakes."""
        self._seen = self._configuration(config)
        self._checker.moved(self._seen)

    def look(self, config: Config, limiter: Limiter | JerkLimiter) -> Crossing | None:
        """Check the next set-point, and the braking path from it.

        Args:
            config: the set-point.
            limiter: its state is that after this set-point.

        Returns:
            The limit that would be crossed, if any.
        """
        here = self._configuration(config)
        found = self._look(config, here, limiter)
        if found is None:
            self._seen = here
        return found

    def _look(
        self, config: Config, here: Sequence[float], limiter: Limiter | JerkLimiter
    ) -> Crossing | None:
        checker = self._checker
        speed = math.inf
        if checker.times:
            # The last position first: the checker still has it cached.
            before, now = checker.places(self._seen)[0], checker.places(here)[0]
            speed = self._speed_ahead(config, before, now, limiter)
            found = checker.too_fast(speed)
            if found is not None:
                return found
        if isinstance(limiter, Limiter) and checker.clear(here, limiter.ticks_to_rest()):
            return None
        rest = limiter.braking()
        if not any(rest):
            return checker.sweep(here, here, speed)
        found = checker.sweep(here, self._configuration(self._space.moved(config, rest)), speed)
        if found is None or found.action == "slow":
            return found
        return self._look_closer(here, speed, limiter)

    def _speed_ahead(
        self, config: Config, before: Point, now: Point, limiter: Limiter | JerkLimiter
    ) -> float:
        """Speed of the tool in this tick, or later if it brakes from now on [m/s]."""
        speed = math.dist(before, now) / self._period
        fastest = limiter.fastest()
        if fastest == limiter.velocity:
            return speed
        step = tuple([v * self._period for v in fastest])
        there = self._configuration(self._space.moved(config, step))
        return max(speed, math.dist(now, self._checker.places_ahead(there)[0]) / self._period)

    def _look_closer(
        self, here: Sequence[float], speed: float, limiter: Limiter | JerkLimiter
    ) -> Crossing | None:
        """Check the braking path in small steps: for one large step the bound is too large."""
        checker = self._checker
        seed, deviation = checker.seed, checker.deviation
        checker.deviation = deviation and _DEVIATION_OF_STEP
        try:
            for config in limiter.stopping(_STEPS):
                there = self._configuration(config)
                found = checker.sweep(here, there, speed)
                if found is not None:
                    return found
                here = there
            return None
        finally:
            checker.seed, checker.deviation = seed, deviation

    def line_to(self, target: Config) -> Crossing | None:
        """Check the straight line to the next point, of a motion that the controller plans.

        Returns:
            The limit that it crosses, if any.
        """
        checker, space = self._checker, self._space
        if not self._begun and (found := self.begin()):
            return found
        way = space.difference(self._last, target)
        count = min(_MOST_STEPS, max(1, math.ceil(max(map(abs, way)) / _STEP)))
        for number in range(1, count + 1):
            share = number / count
            there = self._configuration(space.moved(self._last, tuple(share * w for w in way)))
            # The controller chooses the speed here, so limits with the action "slow" do not apply.
            if found := checker.sweep(self._seen, there, 0.0):
                return found
            self._seen = there
        self._last = target
        return None


def envelope_check(
    config: WorkerConfig,
    connection: Connection,
    start: Config,
    crossed: Callable[[Crossing], None],
    turn: Config = (),
) -> EnvelopeCheck | None:
    """The check of a stream of positions or steps; None: the robot has no envelope.

    Args:
        config: the configuration of the stream.
        connection: connection over which the arm's position is read.
        start: position of the arm, at rest.
        crossed: callback with the limit that would have been crossed; it must end the stream.
        turn: orientation of the tool at the start, for steps that are not given in its frame;
            empty for others.
    """
    envelope, sent, timeout = config.envelope, config.sent, config.options.timeout
    if envelope is None:
        return None
    packed, wobj, _ = envelope
    checker = EnvelopeChecker(packed, by_tip=not sent.in_joints)
    base = POSE_SPACE.decode(wobj)
    if not sent.in_joints:
        checker.seed = read_six(connection.call, _JOINTS, timeout)
    if sent.meaning == "step":
        tip = POSE_SPACE.decode(read_six(connection.call, sent.read, timeout))
        base = POSE_SPACE.composed(base, tip)

    def seen(point: Config) -> Sequence[float]:
        """A set-point as joints, or as the pose of the tool's tip in the base frame."""
        if sent.in_joints:
            return point
        if turn:
            point = POSE_SPACE.in_axes(point, turn)
        return _tip(POSE_SPACE.composed(base, point))

    curved = config.feeding.upsample == "ruckig"
    return EnvelopeCheck(
        checker, seen, sent.space, 1 / config.feeding.rate, start, crossed, curved=curved
    )


def _tip(config: Config) -> Sequence[float]:
    """A pose of the tool's tip in the base frame, as the checker takes it."""
    x, y, z, w, a, b, c = config
    return (
        *(1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)),
        *(2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)),
        *(2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)),
        *(x, y, z),
    )


class SpeedCheck:
    """Checks speeds: where the arm gets with them until a stop takes effect, and until it stands.

    It reads the arm's position over the worker's connection, so it must not be used while a call
    on that connection is not answered.

    Args:
        envelope: the envelope, the work object in use, and the program's time to stop.
        config: the configuration of the stream.
        connection: connection over which the arm's position is read.
        turned: function that rotates speeds into the frame of the wire.
        crossed: callback with the limit that would have been crossed; it must end the stream.
    """

    def __init__(
        self,
        envelope: CheckedEnvelope,
        config: WorkerConfig,
        connection: Connection,
        turned: Callable[[Config], Config],
        crossed: Callable[[Crossing], None],
    ) -> None:
        sent = config.sent
        self._crossed = crossed
        packed, wobj, reaction = envelope
        self._checker = EnvelopeChecker(packed, by_tip=not sent.in_joints)
        self._checker.slow_share = SLOW_SHARE
        self._in_joints = sent.in_joints
        self._limits = tuple(zip(sent.space.groups, sent.limits.acceleration, strict=True))
        self._connection = connection
        self._timeout = config.options.timeout
        self._turned = turned
        #: orientation of the frame of the wire; empty for that of the tool
        self._frame: Config = ()
        #: time at a speed until a stop takes effect: the program's, after two ticks without any [s]
        self._reach = reaction + 2 * config.period + _FRESH * 1e-9
        if sent.kind == "queue":
            self._frame = POSE_SPACE.decode(wobj)
            self._reach += sent.high * _CYCLE
        self._place: Config = ()
        self._read_at = 0

    def allowed(self, speeds: Config) -> float | None:
        """Check speeds, and report the limit that the arm would cross, if any.

        Args:
            speeds: of the joints [rad/s], or of the tool, in the program's frame [m/s, rad/s].

        Returns:
            The share of the speeds at which the limits with the action "slow" are kept; None if the
            arm would cross a limit.
        """
        if not any(speeds):
            return 1.0
        braking = 0.0 if self._in_joints else _BRAKING
        for group, a in self._limits:
            top = math.hypot(*speeds[group])
            braking = max(braking, top / a, top / STOPPING if self._in_joints else 0.0)
        seconds = self._reach + braking / 2
        checker = self._checker
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
                    self._crossed(found)
                    return None
                share *= checker.slow_speed(found.limit) / (share * speed) * (1 - 1e-9)
            checker.arrived(there)
            here = there
        if found := checker.not_left(here):
            self._crossed(found)
            return None
        return share

    def _position(self) -> Config:
        """The arm's joints, or its tip in the base frame, read at most 10 ms ago."""
        now = time.monotonic_ns()
        if not self._place or now - self._read_at > _FRESH:
            call, timeout = self._connection.call, self._timeout
            if self._in_joints or not self._place:
                self._place = self._checker.seed = read_six(call, _JOINTS, timeout)
            if not self._in_joints:
                self._place = POSE_SPACE.decode(read_six(call, ("get_tcp_pose",), timeout))
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
