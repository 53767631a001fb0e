"""Events of the robot: their detection in the samples, and their delivery to subscribers."""

from __future__ import annotations

import time
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, ClassVar, Final, Literal, TypeAlias

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco.errors import DucoError, RobotStateError
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
from aioduco.supervision.concurrency import BackgroundTasks, every
from aioduco.supervision.state_feed import Policy, Snapshot, StateFeed, Subscription, left
from aioduco.supervision.task_state import added_entries

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco._wire.lane import WireLane
    from aioduco.envelope.limits import Crossing
    from aioduco.supervision.heartbeat import HeartbeatState

__all__ = [
    "CollisionDetected",
    "CollisionReset",
    "ConnectionBack",
    "ConnectionGone",
    "EmergencyStopPressed",
    "EmergencyStopReleased",
    "EnvelopeLeft",
    "EnvelopeUnwatched",
    "ErrorsChanged",
    "Event",
    "Events",
    "HeartbeatChanged",
    "LoopBlocked",
    "ModeChanged",
    "ProgramStateChanged",
    "RobotStateChanged",
    "SafetyStateChanged",
    "Severity",
    "TwinDiverged",
    "changes",
]

Severity: TypeAlias = Literal["alarm", "warning", "info"]
"""How serious an event is."""

#: after which the safety controller has stopped the arm, or does not let it move
_UNSAFE: Final = frozenset(
    SafetyState[name] for name in ("STOP0", "STOP1", "STOP2", "FAIL", "RECOVERY", "MODEL", "UPDATE")
)


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened to the robot.

    Attributes:
        at: when it was detected [s of `time.monotonic`].
    """

    at: float

    def __post_init__(self) -> None:
        if trial.current is not None:
            object.__setattr__(self, "at", trial.moment(self.at))

    #: of every event of the class
    _severity: ClassVar[Severity] = "info"

    @property
    def severity(self) -> Severity:
        """How serious it is: "alarm", "warning", or "info" for what belongs to normal work."""
        return self._severity

    def line(self) -> str:
        """Format it as one line: its name in words, and its values."""
        name = "".join(
            f" {letter.lower()}" if letter.isupper() else letter for letter in type(self).__name__
        )
        said = {}
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "since":  # a time of the computer's clock says nothing to a person
                said["for"] = f"{self.at - value:.3g} s"
            elif field.name != "at" and value not in ("", (), {}):
                text = f"{value:.3g}" if isinstance(value, float) else value
                said[field.name] = str(getattr(value, "name", None) or text)
        if said.keys() == {"before", "after"}:
            return f"{name.strip()} from {said['before']} to {said['after']}"
        values = ", ".join(f"{field} {value}" for field, value in said.items())
        return f"{name.strip()}{': ' if said else ''}{values}"


@dataclass(frozen=True, slots=True)
class ConnectionGone(Event):
    """The controller does not answer any more.

    Attributes:
        reason: the error of the last request.
    """

    reason: str

    _severity = "alarm"


@dataclass(frozen=True, slots=True)
class ConnectionBack(Event):
    """The controller answers again.

    Attributes:
        seconds: how long it did not answer.
    """

    seconds: float


@dataclass(frozen=True, slots=True)
class RobotStateChanged(Event):
    """The state of the robot (机器人状态) changed."""

    before: RobotState
    after: RobotState


@dataclass(frozen=True, slots=True)
class ProgramStateChanged(Event):
    """The state of the program (程序状态) changed."""

    before: ProgramState
    after: ProgramState


@dataclass(frozen=True, slots=True)
class SafetyStateChanged(Event):
    """The state of the safety controller (安全控制器状态) changed."""

    before: SafetyState
    after: SafetyState

    @property
    def severity(self) -> Severity:
        """A warning if the arm was stopped, or needs help to run; a start is normal work."""
        return "warning" if self.after in _UNSAFE else "info"


@dataclass(frozen=True, slots=True)
class ModeChanged(Event):
    """The operation mode (操作模式) changed."""

    before: OperationMode
    after: OperationMode


@dataclass(frozen=True, slots=True)
class ErrorsChanged(Event):
    """The controller's error list (错误列表) changed.

    Attributes:
        errors: the list now.
        added: entries that it has gained, also those that it had before.
    """

    errors: tuple[str, ...]
    added: tuple[str, ...]

    @property
    def severity(self) -> Severity:
        """A warning if there are new ones."""
        return "warning" if self.added else "info"


@dataclass(frozen=True, slots=True)
class CollisionDetected(Event):
    """The controller detected a collision (碰撞).

    Attributes:
        joint: the joint that detected it, 1 to 6.
    """

    joint: int

    _severity = "alarm"


@dataclass(frozen=True, slots=True)
class CollisionReset(Event):
    """The collision was reset."""


@dataclass(frozen=True, slots=True)
class EmergencyStopPressed(Event):
    """An emergency stop (急停) was pressed."""

    _severity = "alarm"


@dataclass(frozen=True, slots=True)
class EmergencyStopReleased(Event):
    """The emergency stop was released."""


@dataclass(frozen=True, slots=True)
class EnvelopeLeft(Event):
    """The arm passed, or was about to pass, a limit of the envelope, and is being stopped.

    Attributes:
        crossing: the limit, the body, the place and the margin.
    """

    crossing: Crossing

    _severity = "alarm"


@dataclass(frozen=True, slots=True)
class EnvelopeUnwatched(Event):
    """The envelope is not watched, since no samples come, and the arm is being stopped.

    Attributes:
        seconds: how long none came.
        reason: the error of the last read; empty if the controller has not answered it yet.
    """

    seconds: float
    reason: str

    _severity = "alarm"


@dataclass(frozen=True, slots=True)
class TwinDiverged(Event):
    """The arm and its twin have parted: something is not as in the good run.

    Attributes:
        quantity: what differs: "torque", "tracking error", "geometry", "path", "delay", "state" or
            "outcome".
        where: where, such as "joint 3" or "tool's position".
        since: when it began, as far as that is known [s of `time.monotonic`].
        value, limit: the size of the difference and its limit, in `unit`.
        unit: their unit; empty for states and outcomes.
        cause: the probable cause: "payload", "lost part", "friction", "contact", "geometry",
            "another program", "delayed controller" or "unknown".
        estimate: the size of the cause, by name and unit, such as {"mass [kg]": 0.48}.
        action: what the twin did: "report", "pause" or "stop".
    """

    quantity: str
    where: str
    since: float
    value: float
    limit: float
    unit: str
    cause: str
    estimate: dict[str, float]
    action: str

    # What it found may be harmless, and it stops the arm only on request.
    _severity = "warning"


@dataclass(frozen=True, slots=True)
class HeartbeatChanged(Event):
    """The state of the heartbeat (心跳) changed."""

    before: HeartbeatState
    after: HeartbeatState

    @property
    def severity(self) -> Severity:
        """A warning if the controller has stopped the arm for want of beats."""
        return "warning" if self.after.name in {"LOST", "STALLED"} else "info"


@dataclass(frozen=True, slots=True)
class LoopBlocked(Event):
    """The event loop did not run for a while, since something blocked it.

    Attributes:
        seconds: for how long.
        where: the line of the program that ran meanwhile: file, number, function and text; empty if
            none did, as on a busy computer.
    """

    seconds: float
    where: str

    _severity = "warning"


def changes(before: Snapshot, after: Snapshot) -> Iterator[Event]:
    """Yield every event between two samples, the most serious first."""
    at = after.received_at
    old, new = before.status, after.status
    if new.emergency_stop != old.emergency_stop:
        yield EmergencyStopPressed(at) if new.emergency_stop else EmergencyStopReleased(at)
    if new.collision != old.collision:
        yield CollisionDetected(at, new.collision_axis) if new.collision else CollisionReset(at)
    was, now = before.states, after.states
    if now.safety != was.safety:
        yield SafetyStateChanged(at, was.safety, now.safety)
    if now.robot != was.robot:
        yield RobotStateChanged(at, was.robot, now.robot)
    if now.mode != was.mode:
        yield ModeChanged(at, was.mode, now.mode)
    if now.program != was.program:
        yield ProgramStateChanged(at, was.program, now.program)


def suspicious(before: Snapshot, after: Snapshot) -> bool:
    """Whether the error list may have changed between two samples."""
    old, new = before.status, after.status
    return (
        old.error != new.error
        or old.collision != new.collision
        or old.emergency_stop != new.emergency_stop
        or before.states.safety != after.states.safety
    )


#: seconds between two reads of the error list while no sample suggests that it changed
_ERRORS_EVERY = 1.0
#: seconds between two checks of the heartbeat and of the age of the newest sample
_LOOK_EVERY = 0.02


class Events(Uncopied):
    """Detects the events of one robot, and delivers them to every subscriber.

    Args:
        feed: source of the samples.
        lane: lane on which the error list is read.
        background: runs the tasks of this object.
        heartbeat: returns the heartbeat's state.
    """

    def __init__(
        self,
        feed: StateFeed,
        lane: WireLane,
        background: BackgroundTasks,
        heartbeat: Callable[[], HeartbeatState],
    ) -> None:
        self._feed = feed
        self._lane = lane
        self._background = background
        self._heartbeat = heartbeat
        self._subscriptions: list[Subscription[Event]] = []
        self._errors: tuple[str, ...] | None = None
        self._running = False
        self._closed = False

    def __repr__(self) -> str:
        return f"<Events {len(self._subscriptions)} subscribers>"

    def tell(self, event: Event) -> None:
        """Give an event to every subscriber; on the event loop."""
        for subscription in self._subscriptions:
            subscription.give(event)

    @contextmanager
    def subscribe(
        self, policy: Policy = "every", *, size: int = 1024
    ) -> Iterator[Subscription[Event]]:
        """Receive every event from now on: `with robot.events.subscribe() as stream:`.

        Args:
            policy: what happens to events that are not taken in time; as for samples.
            size: maximum number of waiting events.

        Yields:
            The subscription, for `async for`. It raises `RobotStateError` when the robot closes.
        """
        if self._closed:
            raise RobotStateError("the robot is closed: no more events come")
        self._lane.owner_loop.require("events")
        if not self._running:
            self._running = True
            self._background.start(self._watch_feed(), "aioduco events of the state")
            self._background.start(self._watch_lines(), "aioduco events of the lines")
        subscription = Subscription[Event](policy, size, self._lane.owner_loop)
        self._subscriptions.append(subscription)
        try:
            yield subscription
        finally:
            self._subscriptions.remove(subscription)
            subscription.end(left())

    def close(self) -> None:
        """End all subscriptions: no more events come."""
        self._closed = True
        for subscription in self._subscriptions:
            subscription.end(RobotStateError("the robot is closed: no more events come"))

    async def _watch_feed(self) -> None:
        before: Snapshot | None = None
        asked = -_ERRORS_EVERY
        with self._feed.subscribe() as samples:
            async for sample in samples:
                at = trial.wall(sample.received_at)
                doubt = at - asked >= _ERRORS_EVERY
                if before is not None:
                    for event in changes(before, sample):
                        self.tell(event)
                    doubt = doubt or suspicious(before, sample)
                if doubt:
                    asked = at
                    await self._look_at_errors()
                before = sample

    async def _look_at_errors(self) -> None:
        try:
            errors = tuple(await self._lane.rpc.get_last_error())
        except DucoError:
            # A lost connection is handled elsewhere; the list is read again later.
            return
        before, self._errors = self._errors, errors
        if before is not None and errors != before:
            self.tell(ErrorsChanged(time.monotonic(), errors, added_entries(before, errors)))

    async def _watch_lines(self) -> None:
        heartbeat = self._heartbeat()
        gone_since: float | None = None
        async for _ in every(_LOOK_EVERY):
            now = time.monotonic()
            state = self._heartbeat()
            if state is not heartbeat:
                self.tell(HeartbeatChanged(now, heartbeat, state))
                heartbeat = state
            heard = self._feed.heard_at
            lost = now - heard > self._feed.silence_limit and self._feed.error is not None
            if gone_since is None and lost:
                gone_since = heard
                self.tell(ConnectionGone(now, str(self._feed.error)))
            elif gone_since is not None and heard > gone_since:
                self.tell(ConnectionBack(now, heard - gone_since))
                gone_since = None
