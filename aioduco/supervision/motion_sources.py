"""Modes and streams, which may move the arm besides its tasks.

There are two kinds of modes, and the function `stop` ends neither. In hand guiding and in realtime
mode the arm yields or follows: these modes count as motion, and are left along with a stop. Force
control only changes how motions are carried out: it stays on during a stop, and is left when the
robot is closed, while the arm stands (manual 1.3.10).

A stop leaves points in the track pool, and the next motion through it would follow them first
(manual 1.3.12). So points of this program are treated like a mode that a stop ends, by emptying the
pool; they move nothing by themselves.

Guarantees:
- `OpenStream.halt` is synchronous and waits for nothing. After it, a stream sends at most the
  set-point that is on its way.
- That set-point may reach the controller after a stop, and make the arm move again. So who stops
  the arm calls `halt`, sends the stop, waits until the stream is quiet or has ended, and sends the
  stop once more.
"""

from __future__ import annotations

import contextlib
import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, TypeAlias

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco._wire.way_out import EMPTIES
from aioduco.errors import (
    ControllerError,
    DucoError,
    Refused,
    RobotStateError,
    UnknownFunction,
)
from aioduco.models.enums import TaskState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Sequence

    from aioduco.supervision.gate import PermitEnding
    from aioduco.supervision.stop_channel import StopChannel


_log = BackgroundLogger(__name__)

#: seconds for the worker of a stream to stop sending: longer than it waits for an answer
_SILENCE = 2.0
#: the same in a thread that is blocked meanwhile, and seconds between two checks
_SILENCE_NOW, _QUIET_EVERY = 0.1, 0.001

#: the function of the wire that ends a mode, and its arguments
ModeEnding: TypeAlias = "tuple[str, tuple[bool, ...]]"

#: seconds within which a mode must be left after a stop
_LEAVE_LIMIT = 0.5
#: ends the "mode" in which points of this program are in the track pool
TRACK_POOL = "trackClearQueue"


class Modes:
    """The modes of one robot, each named by the function of the wire that ends it.

    Args:
        channel: sends the functions that end them.
        passed_on: told the functions that end those that are on, with their arguments, before one
            is entered and after one was left.

    Attributes:
        force_control: whether force control may be on.
    """

    def __init__(
        self,
        channel: StopChannel,
        passed_on: Callable[[Sequence[ModeEnding]], object] = lambda _: None,
    ) -> None:
        self._channel = channel
        self._passed_on = passed_on
        #: the arguments that end each, and its number among the modes that were entered
        self._on: dict[str, tuple[tuple[bool, ...], int]] = {}
        self._entered = 0
        #: of these, those that should be off by now
        self._overdue: set[str] = set()
        #: of these, those of which it was logged that they could not be ended
        self._told: set[str] = set()
        self._leaving = anyio.Lock()
        self.force_control: bool = False

    def __repr__(self) -> str:
        return f"<Modes {sorted(self._on)}{', force control' if self.force_control else ''}>"

    def __contains__(self, ending: str) -> bool:
        return ending in self._on

    @property
    def moving(self) -> bool:
        """Whether the arm may move because of a mode, without a task that is followed."""
        return any(name != TRACK_POOL for name in self._on)

    @property
    def any(self) -> bool:
        """Whether a mode of either kind is on, or points may be in the track pool."""
        return self.stoppable or self.force_control

    @property
    def stoppable(self) -> bool:
        """Whether `leave` has anything to do."""
        return bool(self._on)

    def enter(self, ending: str, args: tuple[bool, ...] = ()) -> bool:
        """Note a mode in which the arm yields or follows, before it is entered.

        Args:
            ending: the function that ends it.
            args: its arguments.

        Returns:
            Whether it was on before.
        """
        was_on = ending in self._on
        self._entered += 1
        self._on[ending] = args, self._entered
        self._overdue.discard(ending)
        self._told.discard(ending)
        self._pass_on()
        return was_on

    def over(self, ending: str) -> None:
        """Note that a mode in which the arm yields or follows is off."""
        was_on = self._on.pop(ending, None)
        self._overdue.discard(ending)
        self._told.discard(ending)
        if was_on is not None:
            self._pass_on()

    def _pass_on(self) -> None:
        self._passed_on([(name, args) for name, (args, _) in self._on.items()])

    def overdue(self, *endings: str) -> None:
        """Note that modes should be off, and may be on: they are to be ended. From any thread.

        Args:
            endings: the functions that end them; none for all modes that a stop ends.
        """
        for ending in endings or tuple(self._on):
            if ending in self._on:
                self._overdue.add(ending)

    async def leave(self) -> None:
        """Leave the modes in which the arm yields or follows, and empty the track pool.

        Failures are logged. A mode of which it is not known whether it was left is overdue.
        """
        await self._leave(self._on)

    @property
    def due(self) -> bool:
        """Whether modes should be off by now."""
        return bool(self._overdue)

    async def leave_due(self) -> None:
        """Leave the modes that should be off by now; what fails is to be tried again."""
        if self._overdue:
            await self._leave(self._overdue)

    async def leave_overdue(self, name: str) -> None:
        """Leave the modes that should be off by now, before something that moves the arm is sent.

        Args:
            name: what is to be sent.

        Raises:
            RobotStateError: one may still be on; `name` was not sent.
        """
        if self._overdue or self._leaving.locked():
            await self._leave(self._overdue)
        for ending in self._overdue:
            raise RobotStateError(
                f"{name} was not sent: {ending} was not answered, or refused, so the mode that it "
                "ends may be on; call robot.stop()"
            )

    async def _leave(self, modes: Collection[str]) -> None:
        async with self._leaving:
            for name in tuple(modes):
                if name not in modes:
                    continue  # it was left, or entered again, meanwhile
                mode, over = self._on.get(name), True
                if mode is None:  # it was left while another thread noted that it is overdue
                    self._overdue.discard(name)
                    continue
                try:
                    await self._end(name, mode[0])
                except BaseException as exc:
                    # a mode whose end is refused is not on, but a pool has its points
                    over = isinstance(exc, ControllerError)
                    over = over or (isinstance(exc, Refused) and name != TRACK_POOL)
                    if not over and self._on.get(name) == mode:
                        self._overdue.add(name)
                    if not isinstance(exc, DucoError | MemoryError):
                        raise  # it was cancelled
                    if name not in self._told:
                        self._told.add(name)
                        _log.warning("%s after a stop failed: %s", name, str(exc) or repr(exc))
                if over and self._on.get(name) == mode:  # it was not entered again meanwhile
                    self.over(name)

    async def _end(self, name: str, args: tuple[bool, ...]) -> None:
        try:
            answer = await self._channel.control(name, args, _LEAVE_LIMIT)
        except (ControllerError, Refused):
            await self._empty(name)
            raise
        if name == TRACK_POOL and answer != TaskState.FINISHED:
            raise Refused(name, answer, "the points of this program may still be in the pool")
        await self._empty(name)

    async def _empty(self, name: str) -> None:
        """Empty the queue of a mode that is off, if it has one."""
        if name in EMPTIES:
            with contextlib.suppress(UnknownFunction):  # older controllers have no such queue
                await self._channel.control(EMPTIES[name], (), _LEAVE_LIMIT)

    async def end_force_control(
        self, timeout: float, follow: Callable[[str, int, float], Awaitable[object]]
    ) -> None:
        """End force control, which may be ended only while the arm stands; failures are logged.

        Args:
            timeout: seconds for each step.
            follow: waits for the end of a task, given its name, its id and a time limit.
        """
        if not self.force_control:
            return
        try:
            await self._channel.rest(None, timeout)
        except DucoError as exc:
            _log.warning("fc_stop was not sent, since the arm is not known to stand: %s", exc)
            return
        self.force_control = False
        try:
            answer = await self._channel.control("fc_stop", (), timeout)
            if answer > max(TaskState):
                await follow("fc_stop", answer, timeout)
            elif answer != TaskState.FINISHED:
                raise Refused("fc_stop", answer, "no reason is given")
        except (DucoError, MemoryError) as exc:
            said = str(exc) or repr(exc)
            _log.warning("fc_stop failed: the mode may still be on: %s", said)


class OpenStream(ABC):
    """A stream as the supervision uses it.

    Attributes:
        stopped_by: why the watch of the envelope has stopped the arm, if it has.
    """

    stopped_by: DucoError | None

    @property
    @abstractmethod
    def quiet(self) -> bool:
        """Whether its worker can send nothing any more; from any thread."""

    @property
    @abstractmethod
    def unanswered(self) -> bool:
        """Whether its worker is stopping the arm until an unanswered set-point cannot move it."""

    @abstractmethod
    def halt(self) -> None:
        """Stop sending at once: the arm is being stopped; from any thread or signal handler."""

    @abstractmethod
    def withdraw(self, ending: PermitEnding) -> None:
        """Stop sending at once, and stop the arm; from any thread or signal handler.

        Args:
            ending: why its permit has ended.
        """

    @abstractmethod
    def renew(self, lease: float) -> None:
        """Note until when the controller does not stop the arm by itself; from any thread.

        Args:
            lease: that time [s of `boot_time`]; inf: for ever.
        """

    @abstractmethod
    def kill(self) -> None:
        """End a worker that does not end by itself."""

    @abstractmethod
    async def ended(self) -> None:
        """Wait until its worker has ended."""


def halt_streams(streams: Sequence[OpenStream]) -> bool:
    """Stop all streams from sending; from any thread. Returns whether there was one."""
    found = tuple(streams)
    for stream in found:
        stream.halt()
    return bool(found)


async def silence(stream: OpenStream) -> bool:
    """Wait until a stream can send nothing more; if its worker takes too long, it is killed.

    A worker that handles an unanswered set-point may take longer: it ends by itself.

    Returns:
        Whether it was killed: it may have sent a last set-point.
    """
    with anyio.move_on_after(_SILENCE) as scope:
        await stream.ended()
    if not scope.cancelled_caught:
        return False
    if stream.unanswered:
        await stream.ended()
        return False
    stream.kill()
    return True


def wait_until_quiet(streams: Sequence[OpenStream]) -> None:
    """As `silence`, of all streams and in any thread, for a short time; no worker is killed."""
    due = time.monotonic()
    until = due + _SILENCE_NOW
    while not all(stream.quiet for stream in tuple(streams)):
        due += _QUIET_EVERY
        if due > until:
            return
        time.sleep(max(0.0, due - time.monotonic()))
