"""Keeps the arm within its operating envelope: checks motions, sets up streams, watches the state.

A motion whose path is known is checked before it is sent. A stream's worker checks each set-point
itself (`streaming/worker/checked.py`). All other movement is detected in the samples of the state:
a stop is sent before the arm, at its present speed, would pass a limit.

During checked motions and streams, too, an arm beyond a limit is stopped, once it is further beyond
the limit than it may lag behind its set-points.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

import anyio

from aioduco.controller_clock import release_nothing
from aioduco.envelope.checker import EnvelopeChecker
from aioduco.envelope.limits import Crossing, Envelope, ToolForce
from aioduco.errors import DucoError, EnvelopeViolated, ParameterError
from aioduco.models.samples import joints as joints_of
from aioduco.models.samples import pose as pose_of
from aioduco.reporting import BackgroundLogger
from aioduco.supervision.events import EnvelopeLeft

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.envelope.ways import Way
    from aioduco.models.pose import Pose
    from aioduco.supervision.command import Command
    from aioduco.supervision.concurrency import BackgroundTasks
    from aioduco.supervision.events import Events
    from aioduco.supervision.retry import RetryingReads
    from aioduco.supervision.settings import RobotSettings
    from aioduco.supervision.state_feed import Snapshot, StateFeed
    from aioduco.supervision.stop_coordinator import StopCoordinator

__all__ = ["EnvelopeKeeper"]

_log = BackgroundLogger(__name__)

_NOWHERE = (math.nan, math.nan, math.nan)
#: shortest period that is assumed for the samples [s]: a simulated controller's may be shorter
_LEAST_PERIOD = 0.02
#: periods of the feed within which a stop is on its way, after the sample that requires it
_PERIODS = 3.0
#: joint deceleration that a stopping arm reaches for certain [rad/s²]
_STOPPING = 5.0
#: joint speed below which the arm stands [rad/s]
_STILL = 1e-3
#: distance beyond a limit at which a checked motion may be seen, due to its lag [m, rad]
_LAG = 3e-3
#: factor by which a controller may exceed the requested tool speed
_OVERSHOOT = 1.05
#: slowest joint and tool speed that the wire accepts [rad/s, m/s], and percent
_SLOWEST = {"movej2": 0.000175, "movej_pose2": 0.000175, "movej": 0.01, "movej_pose": 0.01}
_SLOWEST_LINE = 0.01


class SendsMotions(Protocol):
    """Interface of the dispatcher that the keeper uses."""

    #: checks each motion before it is sent
    check: Callable[[Command], Awaitable[Command]] | None
    #: number of commands that the controller accepted
    accepted: int


class EnvelopeKeeper:
    """Keeps one arm within its envelope, if there is one.

    Args:
        dispatcher: sends motions.
        coordinator: brings the arm to rest.
        reads: reads the position of the arm, its tool and its work object.
        feed: samples of the state.
        events: gets an event when the arm is stopped.
        background: runs the watch of the state.
        settings: times and limits, the clock.

    Attributes:
        envelope: the envelope; None for none.
    """

    def __init__(
        self,
        dispatcher: SendsMotions,
        coordinator: StopCoordinator,
        reads: RetryingReads,
        feed: StateFeed,
        events: Events,
        background: BackgroundTasks,
        settings: RobotSettings,
    ) -> None:
        self._dispatcher = dispatcher
        self._coordinator = coordinator
        self._reads = reads
        self._feed = feed
        self._events = events
        self._background = background
        self._settings = settings
        self._clock = settings.clock
        self.envelope: Envelope | None = None
        self._open = False
        self._watching = False
        #: whether something moves the arm on a path that was not checked
        self._unchecked = False
        #: the last motion that was checked, and its checker
        self._last: tuple[Way, EnvelopeChecker] | None = None
        #: tools and work objects by name, as they were read while the arm stood
        self._named: dict[tuple[str, str], tuple[Pose, Pose]] = {}
        self._too_strong = False
        self._stopping = False
        #: number of commands that were accepted when the last motion was checked
        self._accepted = 0
        #: period of the samples in the controller's time [s]
        self._period = max(1.0 / feed.rate, _LEAST_PERIOD)
        self._release_clock: Callable[[], None] = release_nothing

    # -- which envelope ------------------------------------------------------------------------

    def use(self, envelope: Envelope | None) -> None:
        """Keep the arm within another envelope from now on; None for none."""
        if envelope is not None and not isinstance(envelope, Envelope):
            raise ParameterError("envelope", envelope, "an Envelope, or None")
        if self._open:
            self._coordinator.check_loop("envelope")
        self.envelope = envelope
        self._dispatcher.check = None if envelope is None else self._check
        if envelope is not None and any(isinstance(each, ToolForce) for each in envelope.limits):
            self._feed.forces = True
        self.begin(opened=self._open)

    def begin(self, *, opened: bool = True) -> None:
        """Start to watch the state, once the robot is open and has an envelope."""
        self._open = opened
        if opened and self.envelope is not None and not self._watching:
            self._watching = True
            self._background.start(self._watch(), "aioduco envelope")

    # -- motions -------------------------------------------------------------------------------

    async def _check(self, command: Command) -> Command:
        """Check that a motion stays within the envelope; return it, slowed down if necessary."""
        from aioduco.envelope import ways  # noqa: PLC0415  # loads numpy: only on use

        envelope = self.envelope
        if envelope is None:
            return command
        live = any(task.motion for task in self._coordinator.follower.tasks)
        if not live:
            self._unchecked, self._last = False, None
        before, self._last = self._last, None
        if self._dispatcher.accepted != self._accepted + 1:
            before = None  # the controller refused the last motion, or accepted another command
        self._accepted = self._dispatcher.accepted
        if command.name not in ways.WAYS or (live and before is None):
            self._moves_unchecked()
            return command
        _, _, tool, wobj, _ = ways.WAYS[command.name]
        frames = await self._frames(
            "" if tool is None else command.args[tool],
            "" if wobj is None else command.args[wobj],
            standing=not live,
        )
        if frames is None:
            self._moves_unchecked()
            return command
        q = await self._joints() if before is None else before[0].end
        way = ways.way_of(envelope.arm, command.name, command.args, ways.Start(q, *frames))
        if way is None:
            self._moves_unchecked()
            return command
        checker = EnvelopeChecker(envelope.packed(frames[0]), by_tip=way.by_tip)
        checker.seed = q
        found, share = ways.check_way(checker, way)
        if found is None and before is not None:
            found = ways.cut_corner(before[1], before[0], checker, way)
        if found is not None:
            self._last = before
            await self._refuse(command, found)
        if share < 1.0:
            command = replace(command, args=ways.slower(command.name, command.args, share))
            speed = command.args[ways.WAYS[command.name][0]]
            if speed < _SLOWEST.get(command.name, _SLOWEST_LINE):
                crossing = Crossing("slow", "tool", _NOWHERE, -speed, "m/s", "refuse")
                await self._refuse(command, crossing)
        self._last = way, checker
        return command

    async def _refuse(self, command: Command, found: Crossing) -> None:
        done = "was not sent"
        if found.action == "stop":
            await self._coordinator.halt()
            done = "was not sent, and the arm was stopped"
        raise EnvelopeViolated(
            f"{command.name} {done}: it would lead beyond the envelope: {found}. Choose another "
            "way or target, or set another robot.envelope",
            *found[:4],
        )

    async def _joints(self) -> tuple[float, ...]:
        return tuple(joints_of(await self._reads.rpc.get_actual_joints_position()))

    async def _frames(self, tool: str, wobj: str, *, standing: bool) -> tuple[Pose, Pose] | None:
        """Return the tip of a tool in the flange's frame, and a work object in the base frame.

        The wire has these poses only for the tool and work object in use. For others it has the
        pose of a tool in a work object, from which both are computed while the arm stands.

        Args:
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            standing: whether the arm stands.

        Returns:
            Both poses; None if they cannot be known now.
        """
        rpc = self._reads.rpc
        used = pose_of(await rpc.get_tcp_offset())
        base = pose_of(await rpc.get_wobj())
        if not tool and not wobj:
            return used, base
        if not standing:
            return self._named.get((tool, wobj))
        flange = pose_of(await rpc.get_flange_pose())
        if wobj:
            seen = await rpc.get_tcp_pose_coord("", wobj)
            if not seen:
                return None  # no work object has this name: the controller refuses the motion
            other = flange @ used @ pose_of(seen).inverse()
        else:
            other = base
        if tool:
            seen = await rpc.get_tcp_pose_coord(tool, "")
            if not seen:
                return None
            used = flange.inverse() @ base @ pose_of(seen)
        self._named[tool, wobj] = used, other
        return used, other

    # -- streams -------------------------------------------------------------------------------

    async def of_stream(
        self, tool: str, wobj: str, *, checked: bool
    ) -> tuple[dict[str, Any], list[float]] | None:
        """Return the limits against which a stream's worker checks its set-points.

        Args:
            tool: name of the tool of the set-points; empty for the one in use.
            wobj: name of the work object of the set-points; empty for the one in use.
            checked: whether the worker can check the set-points; for speeds, the state is watched.

        Returns:
            The packed envelope, and the pose of the work object; None if nothing is checked.
        """
        if self.envelope is None:
            return None
        self._unchecked, self._last = False, None
        frames = await self._frames(tool, wobj, standing=True) if checked else None
        if frames is None:
            self._moves_unchecked()
            return None
        return self.envelope.packed(frames[0]), list(frames[1])

    # -- the state -----------------------------------------------------------------------------

    def _hold(self) -> None:
        """Hold the controller's time at the next sample, if the clock can be held."""
        held = self._release_clock
        self._release_clock = self._clock.hold(self._clock.now() + self._period)
        held()

    def _moves_unchecked(self) -> None:
        """Note that something is about to move the arm on an unknown path."""
        self._unchecked = True
        self._hold()

    async def _watch(self) -> None:
        """Check each sample, and stop the arm if necessary."""
        try:
            with self._feed.subscribe("latest") as samples:
                async for sample in samples:
                    envelope = self.envelope
                    if envelope is not None and not self._stopping:
                        found = self._force(envelope, sample) or await self._place(envelope, sample)
                        if found is not None:
                            await self._stop(found)
                    if self._unchecked and envelope is not None:
                        self._hold()
                    else:
                        self._release_clock()
        finally:
            self._release_clock()
            self._watching = False

    def _force(self, envelope: Envelope, sample: Snapshot) -> Crossing | None:
        """Return the limit of a force that has just become too large; None if there is none."""
        if sample.read_forces is None:
            return None
        force = math.hypot(*sample.read_forces.tool[:3].tolist())
        limits = zip(envelope.titles, envelope.limits, strict=True)
        strong = [
            Crossing(title, "tool", _NOWHERE, limit.most - force, "N", "stop")
            for title, limit in limits
            if isinstance(limit, ToolForce) and force > limit.most
        ]
        was, self._too_strong = self._too_strong, bool(strong)
        return strong[0] if strong and not was else None

    async def _place(self, envelope: Envelope, sample: Snapshot) -> Crossing | None:
        """Return the limit that a moving arm has passed or is about to pass; None if none."""
        status = sample.status
        q, speeds = tuple(status.joints), status.joint_speeds.tolist()
        fastest = max(map(abs, speeds))
        if not fastest > _STILL:
            return None
        try:
            tool = pose_of(await self._reads.rpc.get_tcp_offset())
        except DucoError:
            return None  # a lost connection is handled elsewhere
        checker = EnvelopeChecker(envelope.packed(tool))
        speed = math.hypot(*status.tool_speed[:3].tolist()) / _OVERSHOOT
        if found := checker.too_fast(speed):
            return found
        now = {each.limit: each for each in checker.margins(q)}
        coordinator = self._coordinator
        # A checked motion may be on its way, and not be followed yet.
        ours = bool(coordinator.pending) or bool(coordinator.streams)
        ours = ours or any(task.motion for task in coordinator.follower.tasks)
        if ours and not self._unchecked:
            beyond = (each for each in now.values() if each.margin < -_LAG)
            return next((each for each in beyond if each.action != "slow"), None)
        ahead = _PERIODS * self._period + fastest / _STOPPING / 2
        there = tuple(a + ahead * v for a, v in zip(q, speeds, strict=True))
        checker.begin(q)
        found = checker.sweep(q, there, speed)
        if found is not None and now[found.limit].margin < 0.0:
            # An arm that is already beyond a limit may move back.
            then = next(each for each in checker.margins(there) if each.limit == found.limit)
            found = found if then.margin < now[found.limit].margin else None
        return found

    async def _stop(self, found: Crossing) -> None:
        _log.warning("the arm is stopped, since it would leave its envelope: %s", found)
        self._events.tell(EnvelopeLeft(time.monotonic(), found))
        why = EnvelopeViolated(
            f"the arm was stopped, since it would have left its envelope: {found}", *found[:4]
        )
        for task in self._coordinator.follower.tasks:
            task.stopped_by = why
        self._stopping = True
        accepted = anyio.Event()
        self._background.start(self._rest(accepted), "aioduco stop at the envelope", accepted.set)
        await accepted.wait()

    async def _rest(self, accepted: anyio.Event) -> None:
        """Stop the arm, and wait until it stands. The clock is held until a stop is accepted."""
        settings = self._settings
        try:
            await self._coordinator.send_stop(settings.stop_timeout)
            accepted.set()
            await self._coordinator.rest(settings.stop_timeout, settings.standstill_timeout)
        except DucoError as exc:
            _log.critical("the arm leaves its envelope, and %s", exc)
        finally:
            self._stopping = False
