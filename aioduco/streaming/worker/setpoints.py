"""Conversion of the program's set-points to one set-point of the wire per tick, within the limits.

`SetpointSource` decides which target is followed, and when and why the stream ends. It is pure. Its
states are those of `Life`. While it is HOLDING, the arm goes to the last target and stays there; a
stream of speeds keeps its speed.
"""

from __future__ import annotations

import json
import time
from typing import TYPE_CHECKING, TypeAlias

from aioduco.streaming.shared.space import POSE_SPACE, Config, Limits, Space, read_six, too_far
from aioduco.streaming.shared.turning import Directions
from aioduco.streaming.shared.words import ActionTag, Reason, StatusWord, StreamState
from aioduco.streaming.worker.interpolation import Linear, interpolator
from aioduco.streaming.worker.life import Life
from aioduco.streaming.worker.limiter import JerkLimiter, Limiter, SpeedGenerator

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection import Connection
    from aioduco.envelope.limits import Crossing
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.shared.options import Feeding
    from aioduco.streaming.shared.ring import SetPoint
    from aioduco.streaming.worker.checked import EnvelopeCheck
    from aioduco.streaming.worker.chunks import ActionTimeline


_LONGEST = 0.5  # seconds between two targets: the longest interval from which a slope is computed
_FIRST = 0.05  # seconds assumed for the interval until one is measured
_LATE = 1.2  # share of the interval in which a target is reached: the next may be a bit late
_DUE = 1.5  # share of the interval after which an unpaced set-point counts as late
_ROUNDING = 1 - 1e-9
_PER_TICK = 64  # actions taken in one tick at most, so that a long chunk delays no tick


class PositionGenerator:
    """Generates a position per tick: an interpolator of the targets, and the limiter after it.

    With a check, the arm can come to rest within the envelope from every set-point. A set-point
    that breaks this is not sent: the generator brakes from the one before it.

    Args:
        way: method of up-sampling, see `Feeding`.
        space: the space of the set-points.
        limits: limits of velocity and acceleration; for "ruckig" also of jerk.
        period: time between two ticks of the stream [s].
        start: position of the arm, at rest.
        reference: joins chunks of actions; it starts at `start`. None: an interpolator.
        check: checks set-points against the robot's envelope; None: there is none.
    """

    def __init__(
        self,
        way: str,
        space: Space,
        limits: Limits,
        period: float,
        start: Config,
        reference: ActionTimeline | None = None,
        check: EnvelopeCheck | None = None,
    ) -> None:
        self._reference: Linear | ActionTimeline = reference or interpolator(
            way, space, period, start
        )
        kind = JerkLimiter if way == "ruckig" else Limiter
        self._limiter = kind(space, limits, period, start)
        self._check = check

    @property
    def config(self) -> Config:
        """The set-point of the last tick."""
        return self._limiter.config

    @property
    def limited(self) -> int:
        """Ticks in which the limits kept the set-point from the reference."""
        return self._limiter.limited

    @property
    def ready(self) -> bool:
        """Whether the time of the last target is over in this tick: the next one can be taken."""
        return self._reference.ready

    @property
    def at_rest(self) -> bool:
        """Whether the last target is met and the set-point is at rest."""
        return self._reference.met and self._limiter.at_rest

    def aim(self, target: Config, interval: float, duration: float) -> None:
        """Take a new target, to be reached if the limits allow it.

        Args:
            target: the target.
            interval: time since the target before it [s].
            duration: time in which to reach it [s].
        """
        self._reference.aim(target, interval, duration)

    def step(self, passed: int = 1) -> Config:
        """Advance by one tick, or brake before the envelope; returns the set-point."""
        limiter, check = self._limiter, self._check
        if check is None:
            return limiter.follow(self._reference.step())
        snapshot = limiter.snapshot()
        config = limiter.follow(self._reference.step())
        found = check.look(config, limiter)
        if found is None:
            return config
        limiter.restore(snapshot)
        if found.action != "slow":
            check.crossed(found)
            return self.brake(passed)
        config = limiter.brake(passed)
        check.moved(config)
        return config

    def brake(self, passed: int = 1) -> Config:
        """Brake for the ticks that have passed, within the limits; returns the set-point."""
        config = self._limiter.brake(passed)
        self._reference.reset(config)
        if self._check is not None:
            self._check.moved(config)
        return config


#: what gives one set-point per tick, within the limits
Generator: TypeAlias = PositionGenerator | SpeedGenerator


class SetpointSource(Life):
    """One set-point per tick, until a defined end.

    Args:
        space: the space of the set-points.
        period: time between two ticks [s].
        hold: time without a set-point after which the stream ends [s].
        interval: time between two targets of the program [s]; None: measured by their stamps.
        paced: whether each target has its whole interval before the next one is taken (first
            in, first out); otherwise the next one is taken as soon as it arrives.
        reach: largest distance of the first target from the arm, per group [rad, m].
        speeds: whether the set-points are speeds; a stream of speeds ends at speed zero.
        timeline: joins chunks of actions, of which each tick takes what there is; the program is
            late when its actions have run out. None: each set-point is a target.
        clock: returns the monotonic time [ns], for the timeline.

    Attributes:
        starved: ticks in which the arm moved, a set-point was due and none had arrived.
    """

    def __init__(
        self,
        space: Space,
        period: float,
        *,
        hold: float,
        interval: float | None = None,
        paced: bool = False,
        reach: tuple[float, ...] = (),
        speeds: bool = False,
        timeline: ActionTimeline | None = None,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        super().__init__()
        self._space = space
        self._period = period
        self._hold = hold
        self._fixed = interval
        self._interval = _FIRST if interval is None else interval
        self._paced = paced
        self._reach = reach
        self._speeds = speeds
        self._timeline = timeline
        self._clock = clock
        self._chunk: list[Config] = []
        #: whether a chunk was compared with the arm's position
        self._compared = False
        self._generator: Generator | None = None
        self._stamp = 0
        self._idle = 0
        self.starved: int = 0

    def begin(self, generator: Generator) -> None:
        """Set what generates set-points to the targets; it starts at the arm's position."""
        self._generator = generator

    def step(self, take: Callable[[], SetPoint | None], passed: int = 1) -> Config | None:
        """Advance by one tick.

        Args:
            take: returns the program's next set-point, if there is one.
            passed: number of ticks that each call takes on a slow connection.

        Returns:
            The point to send; None: nothing.
        """
        generator = self._generator
        if generator is None or self.state is StreamState.ENDED:
            if self.closing:
                self.end(Reason.CLOSED)
            return None
        if self.state is not StreamState.DECELERATING:
            if self._timeline is None:
                self._follow(generator, take, passed)
            else:
                self._follow_actions(self._timeline, generator, take, passed)
        match self.state:
            case StreamState.WAITING | StreamState.ENDED:
                return None
            case StreamState.DECELERATING:
                config = generator.brake(passed)
                if generator.at_rest:
                    self.ended()
            case _:
                config = generator.step(passed)
        return config

    def _follow(
        self, generator: Generator, take: Callable[[], SetPoint | None], passed: int
    ) -> None:
        due = generator.ready or not self._paced
        point = take() if due else None
        if point is not None:
            self._aim(generator, point)
        elif self.state is StreamState.WAITING:
            if self.closing:
                self.end(Reason.CLOSED)
        elif self.closing and due:
            self._finish(generator)
        else:
            self._wait(generator, passed if due else 1)

    def _aim(self, generator: Generator, point: SetPoint) -> None:
        target = point.values if self._speeds else self._space.decode(point.values)
        if self.state is StreamState.WAITING:
            if not self._speeds and self._begins_too_far(generator, target):
                return
        elif self._fixed is None:
            since = (point.stamp - self._stamp) * 1e-9
            self._interval = max(self._period, min(since, _LONGEST))
        self._stamp = point.stamp
        self._idle = 0
        self.following()
        duration = self._interval if self._paced else self._interval * _LATE
        generator.aim(target, self._interval, duration)

    def _finish(self, generator: Generator) -> None:
        """End when the arm has reached the last target: there are no more."""
        if self._speeds:
            self.brake(Reason.CLOSED)
        elif generator.at_rest:
            self.end(Reason.CLOSED)

    def _wait(self, generator: Generator, passed: int) -> None:
        """Process a tick without a new set-point; it counts as starved only if the arm moves."""
        self._idle += passed
        idle = self._idle * self._period
        due = self._interval if self._paced else self._interval * _DUE
        if idle < due * _ROUNDING:
            return
        self.starved += not generator.at_rest
        self.holding()
        if idle > self._hold:
            self.brake(Reason.STARVED)

    def _follow_actions(
        self,
        timeline: ActionTimeline,
        generator: Generator,
        take: Callable[[], SetPoint | None],
        passed: int,
    ) -> None:
        timeline.advance(self._clock() * 1e-9, closing=self.closing)
        point: SetPoint | None = None
        for _ in range(_PER_TICK):
            point = take()
            if point is None:
                break
            self._add(timeline, generator, point)
        more = point is not None  # they may come in the next tick
        if self.state is StreamState.WAITING:
            if self.closing and not more:
                self.end(Reason.CLOSED)
        elif self.state is StreamState.ENDED:
            return
        elif more or not timeline.ready:
            self._idle = 0
            self.following()
        elif self.closing:
            self._finish(generator)
        else:
            self._wait(generator, passed)

    def _add(self, timeline: ActionTimeline, generator: Generator, point: SetPoint) -> None:
        """Add an action to its chunk; the last one completes it."""
        tag = ActionTag.unpack(point.extra)
        if tag.position == 0:
            self._chunk.clear()
        self._chunk.append(self._space.decode(point.values))
        if tag.position + 1 < tag.total or self.state is StreamState.ENDED:
            return
        begin = tag.begin * 1e-9 if tag.begin else None
        place = timeline.take(begin, tuple(self._chunk))
        if self.state is StreamState.WAITING:
            self.holding()
        # not the first chunk, but the first that is followed: those before it were wholly late
        if place is not None and not self._compared:
            self._compared = True
            self._begins_too_far(generator, place)

    def _begins_too_far(self, generator: Generator, first: Config) -> bool:
        """End if the first target is too far from the arm."""
        found = too_far(self._space, generator.config, first, self._reach)
        if found:
            self.end(Reason.TOO_FAR, found)
        return bool(found)


class SetpointFeed:
    """Set-points from the shared ring, within the limits; used by servo, speed and realtime.

    Args:
        connection: the worker's connection, open.
        block: the shared block.
        begun: called when the stream has begun, before its first set-point.
    """

    def __init__(self, connection: Connection, block: Block, begun: Callable[[], object]) -> None:
        config = block.config
        self._begun = begun
        self._config = config
        self._connection = connection
        self._block = block
        self._timeout = config.options.timeout
        self._directions = Directions(config.sent.turning, connection.call, self._timeout)
        self._space = config.sent.space
        self._meaning = config.sent.meaning
        self._before = POSE_SPACE.decode((0.0,) * 6)
        #: orientation of the tool at the start, for steps that are not given in its frame
        self._start: Config = ()
        self._period = 1 / config.feeding.rate
        self._timeline: ActionTimeline | None = None
        self.source: SetpointSource = self._make_source(config.feeding)
        self._generator: Generator | None = None
        self._sent: tuple[float, ...] | None = None
        self._next = block.ring.newest if config.feeding.latest else block.ring.take
        self._age = block.histograms["age"].record

    def _make_source(self, feeding: Feeding) -> SetpointSource:
        interval = feeding.interval
        if feeding.chunks:
            # imported here: only a stream with chunks needs it
            from aioduco.streaming.worker.chunks import ActionTimeline  # noqa: PLC0415

            assert interval is not None
            self._timeline = ActionTimeline(self._space, self._period, interval, feeding.blend)
            interval = self._period
        return SetpointSource(
            self._space,
            self._period,
            hold=feeding.hold,
            interval=interval,
            paced=not feeding.latest,
            reach=tuple(feeding.reach),
            speeds=self._meaning == "speed",
            timeline=self._timeline,
        )

    @property
    def reads(self) -> bool:
        """Whether a step may read over the connection, which then must have no open call."""
        return self._meaning == "speed" and self._config.envelope is not None

    def begin(self, allowed: Callable[[], bool]) -> bool:
        """Read the arm's position, as soon as there is a first set-point.

        Args:
            allowed: called before that, in each tick until the stream may begin; whether it may.

        Returns:
            Whether the stream has begun.
        """
        if self._generator is not None:
            return True
        if not self._block.ring.level or not allowed():
            return False
        limits, space, period = self._config.sent.limits, self._space, self._period
        if self._meaning == "speed":
            self._generator = SpeedGenerator(space, limits, period, self._allowed())
        else:
            way, start = self._config.feeding.upsample, space.decode(self._actual())
            if self._timeline is not None:
                self._timeline.reset(start)
            check = self._envelope_check(start)
            self._generator = PositionGenerator(
                way, space, limits, period, start, self._timeline, check
            )
            if check is not None and (found := check.begin()):
                self._crossed(found)
        self.source.begin(self._generator)
        self._begun()
        return True

    def _envelope_check(self, start: Config) -> EnvelopeCheck | None:
        if self._config.envelope is None:
            return None
        # imported here: only a stream with an envelope needs it
        from aioduco.streaming.worker.checked import envelope_check  # noqa: PLC0415

        return envelope_check(self._config, self._connection, start, self._crossed, self._start)

    def _allowed(self) -> Callable[[Config], float | None] | None:
        config = self._config
        if config.envelope is None:
            return None
        # imported here: as above
        from aioduco.streaming.worker.checked import SpeedCheck  # noqa: PLC0415

        turned = self._directions.turned
        return SpeedCheck(config.envelope, config, self._connection, turned, self._crossed).allowed

    def _crossed(self, found: Crossing) -> None:
        """Come to rest, if the arm moves: a set-point would have crossed the envelope."""
        self.source.brake(Reason.ENVELOPE, json.dumps(found))

    def _actual(self) -> tuple[float, ...]:
        """The arm's position; zero for steps, which are relative to it."""
        if self._meaning == "step":
            turning = self._config.sent.turning
            if turning is not None:
                place = self._directions.place(turning)
                self._start = (0.0, 0.0, 0.0, *place[3:])
                self._before = self._start
            return (0.0,) * 6
        return read_six(self._connection.call, self._config.sent.read, self._timeout)

    def step(self, passed: int = 1) -> tuple[float, ...] | None:
        """The next set-point for the controller; None if there is nothing to send.

        Args:
            passed: as for `SetpointSource.step`.
        """
        config = self.source.step(self._take, passed)
        if config is None:
            return None
        self._sent = self.values(config)
        return self._sent

    def resting(self) -> tuple[float, ...]:
        """The set-point at which the arm stays where it is; only after `begin`."""
        assert self._generator is not None
        return self.values(self._generator.config)

    def values(self, config: Config) -> tuple[float, ...]:
        """The six numbers of the wire."""
        if self._meaning == "speed":
            return config
        if self._meaning == "place":
            return self._space.encode(config)
        if self._start:
            config = POSE_SPACE.composed(config, self._start)
        before, self._before = self._before, config
        return POSE_SPACE.encode(POSE_SPACE.offset(before, config))

    def wire(self, values: tuple[float, ...]) -> tuple[float, ...]:
        """A set-point in the frame of the wire: speeds are rotated when they are sent.

        Steps are rotated once, where they are added up.
        """
        return self._directions.turned(values) if self._meaning == "speed" else values

    def _take(self) -> SetPoint | None:
        point = self._next()
        if point is not None:
            self._age(time.monotonic_ns() - point.stamp)
        return point

    def publish(self) -> None:
        """Write the counters and the last set-point into the shared block."""
        status, ring = self._block.status, self._block.ring
        status[StatusWord.STARVED] = self.source.starved
        status[StatusWord.TAKEN] = ring.read
        status[StatusWord.OVERWRITTEN] = ring.overwritten
        if (timeline := self._timeline) is not None:
            status[StatusWord.CHUNKS] = timeline.taken
            status[StatusWord.CHUNKS_LATE] = timeline.late
            status[StatusWord.CHUNKS_DROPPED] = timeline.dropped
            status[StatusWord.ACTIONS_LATE] = timeline.late_actions
            status[StatusWord.EXHAUSTED] = timeline.exhausted
        if self._generator is not None:
            status[StatusWord.LIMITED] = self._generator.limited
        if self._sent is not None:
            self._block.report.overwrite(self._sent, time.monotonic_ns())
