"""The watch of the state against an envelope: it stops the arm before it would cross a limit.

Every sample in which the arm moves is judged, also while a stop of the watch is being confirmed: an
arm that begins to move again is stopped again. One task brings the arm to rest, whatever happens
meanwhile.

While no samples come, or none that say how fast the joints are, the watch is blind: it stops the
arm if that may be moving, and nothing that moves it is sent.

Where the path was checked before it was sent, only an arm that is beyond a limit by more than it
may lag behind its set-points is stopped. In force control, or with a weave, the arm is on no such
path.
"""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco.envelope.checker import STOPPING, EnvelopeChecker
from aioduco.envelope.limits import Crossing, Envelope, ToolForce
from aioduco.errors import DucoError, EnvelopeViolated, StaleState
from aioduco.models.controller_clock import release_nothing
from aioduco.models.samples import pose as pose_of
from aioduco.supervision.concurrency import BackgroundTasks, Silence, every
from aioduco.supervision.events import EnvelopeLeft, EnvelopeUnwatched, Event, Events
from aioduco.supervision.gate import PermitEnding

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.rpc import AsyncRpc
    from aioduco.envelope.velocities import Ahead
    from aioduco.models.pose import Pose
    from aioduco.supervision.settings import RobotSettings
    from aioduco.supervision.state_feed import Snapshot, StateFeed
    from aioduco.supervision.stop_coordinator import StopCoordinator


_log = BackgroundLogger(__name__)

_NOWHERE = (math.nan, math.nan, math.nan)
#: shortest period that is assumed for the samples [s]: a simulated controller's may be shorter
_LEAST_PERIOD = 0.02
#: time from a sample that requires a stop until the stop takes effect: in periods of the feed, and
#: at least [s]: a busy computer may be late
_PERIODS, _REACTION = 3.0, 0.1
#: joint speed below which the arm stands [rad/s]
_STILL = 1e-3
#: rise of the fastest joint's speed after a stop at which the arm moves again [rad/s]
_AGAIN = 0.02
#: distance beyond a limit at which a checked motion may be seen, due to its lag; and by which an
#: arm that is beyond may seem to get deeper while its joints swing [m, rad]
_LAG = 3e-3
_FRESH = 0.1  # largest age of a sample that says where a moving arm is [s]
_LOOK_EVERY = 0.02  # time between two looks whether samples come [s]
_MOST_CHECKERS = 8  # checkers that are kept, each for a tool
_NO_SPEEDS = "the controller does not report the speed of each joint"
#: factor by which a controller may exceed the requested tool speed
_OVERSHOOT = 1.05
#: force by which a force that is too large may vary without growing [N], and as a share of it
_FORCE_NOISE, _FORCE_SHARE = 1.0, 0.05


class EnvelopeWatch:
    """Watches the state of one arm, and stops it if it would leave its envelope.

    Args:
        coordinator: brings the arm to rest.
        rpc: reads the tool and the work object in use.
        feed: samples of the state.
        events: gets an event when the arm is stopped.
        background: runs the watch, and brings the arm to rest.
        settings: times and limits, the clock.

    Attributes:
        envelope: the envelope; None for none.
        unchecked: whether something moves the arm on a path that was not checked.
        strays: functions of the wire that this program called, because of which motions may leave
            their paths, or be faster than asked.
        only_unchecked: whether it stops the arm on such paths alone, since a program that is tried
            sent a motion that leaves the envelope.
        velocity: the motion at a velocity that was sent last, and the work object in use; None if
            something else moves the arm.
        tool: the tool in use, as last read.
        wobj: the work object in use, as last read. None: it is not read with the samples.
        reaction: time within which a stop takes effect after a sample that requires it [s].
    """

    def __init__(
        self,
        coordinator: StopCoordinator,
        rpc: AsyncRpc,
        feed: StateFeed,
        events: Events,
        background: BackgroundTasks,
        settings: RobotSettings,
    ) -> None:
        self._coordinator = coordinator
        self._rpc = rpc
        self._feed = feed
        self._events = events
        self._background = background
        self._settings = settings
        self._clock = settings.clock
        self.envelope: Envelope | None = None
        self.unchecked: bool = False
        self.strays: set[str] = set()
        self.only_unchecked: bool = False
        self.velocity: tuple[Ahead, Pose] | None = None
        self._newest: Snapshot | None = None
        self.tool: Pose | None = None
        self.wobj: Pose | None = None
        #: period of the samples in the controller's time [s]
        self._period = max(1.0 / feed.rate, _LEAST_PERIOD)
        self.reaction: float = max(_PERIODS * self._period, _REACTION)
        self._checkers: dict[tuple[Pose, bool], EnvelopeChecker] = {}
        self._running = False
        self._silence = Silence(_LOOK_EVERY)
        #: whether the newest sample says how fast each joint is
        self._has_speeds = True
        #: whether the tool in use is being read
        self._reading = False
        #: speed of the fastest joint in the last sample [rad/s]
        self._fastest = 0.0
        #: whether the tool was too fast in the last sample
        self._fast = False
        #: best margins that the moving arm had, of the limits that it is beyond
        self._best: dict[str, float] = {}
        #: force at which the arm was stopped, while it is too large [N]
        self._force_at_stop = math.inf
        #: whether a stop is being confirmed, and the lowest speed of the fastest joint since then
        self._stopping = False
        self._slowest = 0.0
        #: stops that were sent, and after which the arm was not seen to stand yet
        self._unconfirmed = 0
        self._release_clock: Callable[[], None] = release_nothing

    def use(self, envelope: Envelope | None) -> None:
        """Judge samples by another envelope; None for none."""
        self.envelope = envelope
        self._checkers = {}
        self._best = {}

    def begin(self) -> None:
        """Start to watch the state, unless it is watched."""
        if not self._running:
            self._running = True
            self._background.start(self._run(), "aioduco envelope")
            self._background.start(self._look_for_samples(), "aioduco envelope's samples")

    def checker(self, envelope: Envelope, tool: Pose, *, by_tip: bool = False) -> EnvelopeChecker:
        """A checker for an envelope and a tool, which is made once."""
        if envelope is not self.envelope:
            return EnvelopeChecker(envelope.packed(tool), by_tip=by_tip)
        found = self._checkers.get((tool, by_tip))
        if found is None:
            if len(self._checkers) > _MOST_CHECKERS:
                self._checkers = {}
            found = EnvelopeChecker(envelope.packed(tool), by_tip=by_tip)
            self._checkers[tool, by_tip] = found
        return found

    def fresh(self) -> Snapshot | None:
        """The newest sample, if it says where a moving arm is."""
        newest = self._newest
        return newest if newest is not None and newest.age <= _FRESH else None

    def moves_unchecked(self) -> None:
        """Note that something is about to move the arm on an unknown path."""
        self.unchecked = True
        self._hold()

    @property
    def _loose(self) -> bool:
        """Whether the arm may be on another path than those that were checked."""
        force_control = self._coordinator.modes.force_control
        return self.unchecked or bool(self.strays) or force_control

    def _hold(self) -> None:
        """Hold the controller's time at the next sample, if the clock can be held."""
        held = self._release_clock
        self._release_clock = self._clock.hold(self._clock.now() + self._period)
        held()

    async def _run(self) -> None:
        """Judge each sample, and stop the arm if necessary."""
        try:
            with self._feed.subscribe("latest") as samples:
                async for sample in samples:
                    self._newest = sample
                    envelope = self.envelope
                    if envelope is not None:
                        await self._judge(envelope, sample)
                    if self._loose and envelope is not None:
                        self._hold()
                    else:
                        self._release_clock()
        finally:
            self._release_clock()
            self._running = False

    # -- no samples ----------------------------------------------------------------------------

    @property
    def _blind(self) -> bool:
        """Whether no samples come that can be judged, although an envelope is to be watched."""
        silent = self._silence.seconds > self._feed.silence_limit
        return self.envelope is not None and (silent or not self._has_speeds)

    def require_samples(self, name: str) -> None:
        """Check that the state is watched, before `name` is sent, which may move the arm.

        Raises:
            StaleState: no samples come, or none with joint speeds; nothing was sent.
        """
        if self._blind:
            raise StaleState(f"{name} was not sent, since {self._unwatched()}")

    def _unwatched(self) -> str:
        if not self._has_speeds:
            return (
                f"the envelope is not watched: {_NO_SPEEDS}. Take robot.envelope away (None) for "
                "an arm that cannot report them"
            )
        error = self._feed.error
        return (
            f"the envelope is not watched: no sample of the state came for "
            f"{self._silence.seconds:.2g} s{'' if error is None else f' ({error})'}. "
            "Try again when the controller answers, or take robot.envelope away (None)"
        )

    async def _look_for_samples(self) -> None:
        """Stop the arm whenever it may be moving while no samples come."""
        told = False
        async for _ in every(_LOOK_EVERY):
            self._silence.look(time.monotonic(), self._feed.heard_at)
            if not self._blind:
                told = False
            elif not self._stopping and await self._may_move():
                why = StaleState(f"the arm was stopped, since {self._unwatched()}")
                seconds = self._silence.seconds
                reason = str(self._feed.error or "") if self._has_speeds else _NO_SPEEDS
                event = EnvelopeUnwatched(time.monotonic(), seconds, reason)
                await self._stop(why, None if told else event, 0.0)
                told = True
                self._release_clock()

    async def _may_move(self) -> bool:
        """Whether this program moves the arm, or the controller says that it moves."""
        if self._coordinator.moving:
            return True
        try:
            return await self._rpc.robotmoving()
        except DucoError:
            return False  # a lost connection is handled elsewhere

    # -- samples -------------------------------------------------------------------------------

    async def _judge(self, envelope: Envelope, sample: Snapshot) -> None:
        fastest = max(map(abs, speeds := sample.status.joint_speeds.tolist()))
        self._has_speeds = all(map(math.isfinite, speeds))
        if not self._has_speeds:
            return  # whether it moves is not known, and where to
        found = self._force(envelope, sample, fastest) or await self._place(
            envelope, sample, fastest
        )
        again = fastest > self._slowest + _AGAIN
        self._slowest = fastest if again else min(self._slowest, fastest)
        self._fastest = fastest
        if found is None:
            return
        if not self._stopping:
            if self.unchecked or not self.only_unchecked:
                event = EnvelopeLeft(time.monotonic(), found)
                await self._stop(_violated(found), event, fastest)
        elif again:
            await self._stop_again(_violated(found))

    def _force(self, envelope: Envelope, sample: Snapshot, fastest: float) -> Crossing | None:
        """Return the limit of a force that is too large; None if there is none.

        It counts when it becomes too large, and then while the arm moves and it grows: so the arm
        can be led back. One that the controller does not report counts whenever the arm moves.
        """
        if sample.read_forces is None:
            return None
        force = math.hypot(*sample.read_forces.tool[:3].tolist())
        limits = zip(envelope.titles, envelope.limits, strict=True)
        strong = [
            Crossing(title, "tool", _NOWHERE, limit.most - force, "N", "stop")
            for title, limit in limits
            if isinstance(limit, ToolForce) and not force <= limit.most
        ]
        if math.isnan(force):
            return strong[0] if strong and fastest > _STILL else None
        if not strong:
            self._force_at_stop = math.inf
            return None
        first = self._force_at_stop == math.inf
        most = self._force_at_stop * (1.0 + _FORCE_SHARE) + _FORCE_NOISE
        if first:
            self._force_at_stop = force
        return strong[0] if first or (fastest > _STILL and force > most) else None

    async def _place(self, envelope: Envelope, sample: Snapshot, fastest: float) -> Crossing | None:
        """Return the limit that a moving arm has passed or is about to pass; None if none."""
        if not fastest > _STILL:
            self._best = {}
            self._fast = False
            return None
        if self.tool is None:
            await self._read_frames()
        else:
            self._refresh_frames()
        if (tool := self.tool) is None:
            return None  # a lost connection is handled elsewhere
        status, checker = sample.status, self.checker(envelope, tool)
        q, speeds = tuple(status.joints), status.joint_speeds.tolist()
        speed = math.hypot(*status.tool_speed[:3].tolist()) / _OVERSHOOT
        if (found := self._too_fast(checker, speed)) is not None:
            return found
        ahead = self.reaction + fastest / STOPPING / 2
        there = tuple([a + ahead * v for a, v in zip(q, speeds, strict=True)])
        coordinator = self._coordinator
        # A checked motion may be on its way, and not be followed yet.
        ours = coordinator.pending or coordinator.streams or coordinator.follower.motions
        checked = bool(ours) and not self._loose
        if found := self._beyond(checker, q, there, _LAG if checked else 0.0):
            return found
        if checked:
            return None
        checker.begin(q, leaving=True, slack=math.inf)
        found = checker.sweep(q, there, speed)
        if found is None and not self._best and fastest > self._fastest:
            found = self._speeding_up(envelope, tool, q)
        return found

    def _too_fast(self, checker: EnvelopeChecker, speed: float) -> Crossing | None:
        """Return the limit of a speed of the tool that is too high; None if there is none.

        A stream's worker keeps to less than a limit that slows. After a late set-point the arm may
        catch up for a moment: then the limit counts in two samples in a row.
        """
        found, before = checker.too_fast(speed), self._fast
        self._fast = found is not None
        if found is not None and found.action == "slow" and self._coordinator.streams:
            return found if before else None
        return found

    def _refresh_frames(self) -> None:
        """Read the tool in use for the next sample; this one does not wait for other calls."""
        if not self._reading:
            self._reading = True
            self._background.start(self._read_frames(), "aioduco tool in use", self._was_read)

    def _was_read(self) -> None:
        self._reading = False

    async def _read_frames(self) -> None:
        rpc = self._rpc
        try:
            self.tool = pose_of(await rpc.get_tcp_offset())
            if self.wobj is not None:
                self.wobj = pose_of(await rpc.get_wobj())
        except DucoError:
            return  # the next sample tries again

    def _beyond(
        self, checker: EnvelopeChecker, q: Sequence[float], there: Sequence[float], lag: float
    ) -> Crossing | None:
        """Return a limit that the arm is beyond, and gets deeper beyond."""
        beyond = {
            each.limit: each
            for each in checker.margins(q)
            if each.margin < -lag and each.action != "slow"
        }
        self._best = {
            limit: max(self._best.get(limit, each.margin), each.margin)
            for limit, each in beyond.items()
        }
        if not beyond:
            return None
        then = {each.limit: each.margin for each in checker.margins(there)}
        deeper = (
            each
            for limit, each in beyond.items()
            if then.get(limit, -math.inf) < self._best[limit] - _LAG
        )
        return next(deeper, None)

    def _speeding_up(self, envelope: Envelope, tool: Pose, q: tuple[float, ...]) -> Crossing | None:
        """Return the limit that the arm will cross before a stop, once it has its full velocity."""
        from aioduco.envelope import velocities, ways  # noqa: PLC0415  # loads numpy: only on use

        if self.velocity is None:
            return None
        motion, wobj = self.velocity
        start = ways.Start(q, tool, wobj)
        way = velocities.velocity_way(envelope.arm, motion, start, self.reaction)
        if way is None:
            return None
        checker = self.checker(envelope, tool, by_tip=way.by_tip)
        checker.seed = q
        found, _ = ways.check_way(checker, way)
        return found

    # -- stops ---------------------------------------------------------------------------------

    async def _stop(self, why: DucoError, event: Event | None, fastest: float) -> None:
        """Stop the arm; return when the controller has accepted a stop, or that has failed.

        Args:
            why: the cause for the tasks and the stream that this ends.
            event: what subscribers are told; None if they were told.
            fastest: speed of the fastest joint [rad/s].
        """
        if event is not None:
            _log.warning("%s", why)
            self._events.tell(event)
        self._name_cause(why)
        # At once: what is on its way to a socket must not pass while the stop's task starts.
        self._coordinator.gate.end(PermitEnding.ENVELOPE)
        self._stopping, self._slowest = True, fastest
        accepted = anyio.Event()
        rest = self._rest(why, accepted)
        self._background.start(rest, "aioduco stop at the envelope", accepted.set)
        await accepted.wait()

    async def _rest(self, why: DucoError, accepted: anyio.Event) -> None:
        """Stop the arm, and wait until it stands. The clock is held until a stop is accepted."""
        settings = self._settings
        try:
            with self._coordinator.gate.stop(PermitEnding.ENVELOPE):
                self._unconfirmed = 1
                await self._coordinator.send_stop(settings.stop_timeout)
                accepted.set()
                while self._unconfirmed:
                    self._unconfirmed -= 1
                    await self._coordinator.rest(settings.stop_timeout, settings.standstill_timeout)
        except DucoError as exc:
            _log.critical("%s. But %s", why, exc)
        finally:
            self._stopping = False

    async def _stop_again(self, why: DucoError) -> None:
        """Stop an arm that moves again while `_rest` waits for it to stand."""
        _log.warning("the arm moves again: %s", why)
        self._name_cause(why)
        self._unconfirmed += 1
        try:
            await self._coordinator.send_stop(self._settings.stop_timeout)
        except DucoError as exc:
            _log.critical("%s. But %s", why, exc)

    def _name_cause(self, why: DucoError) -> None:
        """Give the tasks and the stream that a stop ends its cause."""
        for task in self._coordinator.follower.tasks:
            task.stopped_by = why
        for stream in self._coordinator.streams:
            stream.stopped_by = why


def _violated(found: Crossing) -> EnvelopeViolated:
    return EnvelopeViolated(
        f"the arm was stopped, since it would have left its envelope: {found}", *found[:4]
    )
