"""What may move the arm beside its tasks, and the claim that says so to the guard.

Modes are of two kinds, and the function `stop` ends neither. In hand guiding and in realtime mode
the arm gives way or follows: they count as motion, and are left along with a stop. Force control
changes only what motions do: it goes on through a stop, and is left on the way out of the robot,
while the arm stands (manual 1.3.10).

The guard, and the heartbeat's thread, stop the arm of a program that is gone or hangs. They must
not stop the arm of another program when one dies that only looked on. So a program makes a claim
before it sends anything that may move the arm, and drops it when the arm was seen to stand and
nothing of it is left.

Guarantees:
- `Streams.halt` is synchronous and waits for nothing. After it, a stream sends at most the
  set-point that is on its way.
- That one may reach the controller behind a stop, and set the arm moving again. So whoever stops
  the arm calls `halt`, sends the stop, waits for `settled` or `quiet`, and sends it once more.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Protocol

import anyio

from aioduco.errors import DucoError, GuardLost, Refused, RobotStateError
from aioduco.models.enums import TaskState
from aioduco.reporting import BackgroundLogger

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterator

    from aioduco.supervision.stop_channel import StopChannel

__all__ = ["Claim", "Modes", "OpenStream", "Streams"]

_log = BackgroundLogger(__name__)

#: seconds for a mode to be left after a stop
_LEAVE_LIMIT = 0.5


class Modes:
    """The modes of one robot, each named by the function of the wire that ends it.

    Args:
        channel: sends what ends them.

    Attributes:
        standing: modes that may be left only while the arm stands.
    """

    def __init__(self, channel: StopChannel) -> None:
        self._channel = channel
        self._moving: dict[str, tuple[bool, ...]] = {}
        self.standing: set[str] = set()

    def __repr__(self) -> str:
        return f"<Modes {sorted(self._moving)}, while standing {sorted(self.standing)}>"

    def __contains__(self, ending: str) -> bool:
        return ending in self._moving

    @property
    def moving(self) -> bool:
        """Whether the arm may move because of one, with nobody following it."""
        return bool(self._moving)

    @property
    def any(self) -> bool:
        """Whether there is one of either kind."""
        return bool(self._moving or self.standing)

    def enter(self, ending: str, args: tuple[bool, ...] = ()) -> bool:
        """Note a mode in which the arm gives way or follows, before it is entered.

        Args:
            ending: the function that ends it.
            args: its arguments.

        Returns:
            Whether it was on before.
        """
        was_on = ending in self._moving
        self._moving[ending] = args
        return was_on

    def over(self, ending: str) -> None:
        """Note that a mode in which the arm gives way or follows is off."""
        self._moving.pop(ending, None)

    async def leave(self) -> None:
        """Leave the modes in which the arm gives way or follows; what fails is logged."""
        modes, self._moving = self._moving, {}
        for name, args in modes.items():
            try:
                await self._channel.leave(name, args, _LEAVE_LIMIT)
            except DucoError as exc:
                _log.warning("%s after a stop was not carried out: %s", name, exc)

    async def leave_standing(
        self, timeout: float, follow: Callable[[str, int, float], Awaitable[object]]
    ) -> None:
        """Leave the modes that may be left only while the arm stands; what fails is logged.

        Args:
            timeout: seconds for each of what it takes.
            follow: waits for the end of a task, given its name, its id and the time for it.
        """
        if not self.standing:
            return
        try:
            await self._channel.standstill(timeout)
        except DucoError as exc:
            names = ", ".join(sorted(self.standing))
            _log.warning("%s was not sent, since the arm is not known to stand: %s", names, exc)
            return
        for name in sorted(self.standing):
            self.standing.discard(name)
            try:
                answer = await self._channel.leave(name, (), timeout)
                if answer > max(TaskState):
                    await follow(name, answer, timeout)
                elif answer != TaskState.FINISHED:
                    raise Refused(name, answer, "no reason is given")
            except DucoError as exc:
                _log.warning("%s was not carried out: the mode may still be on: %s", name, exc)


_LOOK = 0.001  # seconds between two looks at whether a lane is quiet


class OpenStream(Protocol):
    """A stream as the supervision sees it."""

    @property
    def quiet(self) -> bool:
        """Whether its lane can send nothing any more; from any thread."""
        ...

    @property
    def unanswered(self) -> bool:
        """Whether its lane stops the arm until its last set-point cannot move it any more."""
        ...

    def halt(self) -> None:
        """Send nothing more, at once; from any thread or signal handler."""

    def kill(self) -> None:
        """End a lane that does not end by itself."""

    async def ended(self) -> None:
        """Wait until its lane is gone."""


class Streams:
    """The open streams of one robot: at most one, since the arm can follow only one."""

    def __init__(self) -> None:
        self._open: list[OpenStream] = []

    def __len__(self) -> int:
        return len(self._open)

    def __iter__(self) -> Iterator[OpenStream]:
        return iter(tuple(self._open))

    def __repr__(self) -> str:
        return f"<Streams {self._open}>"

    def add(self, stream: OpenStream) -> None:
        """Take a stream that is being opened.

        Raises:
            RobotStateError: another one is open.
        """
        for other in self:
            raise RobotStateError(
                f"{other!r} is open on this robot; close it before you open another one. "
                "Nothing was sent"
            )
        self._open.append(stream)

    def remove(self, stream: OpenStream) -> None:
        """Forget a stream that is over."""
        if stream in self._open:
            self._open.remove(stream)

    def halt(self) -> bool:
        """Have no stream send anything more; from any thread or signal handler.

        Returns:
            Whether there was a stream.
        """
        streams = tuple(self._open)
        for stream in streams:
            stream.halt()
        return bool(streams)

    async def settled(self, timeout: float) -> bool:
        """Wait until no lane can send anything more; one that goes on after that is ended.

        Args:
            timeout: seconds for that. A lane that looks after an unanswered set-point has more:
                it ends by itself.

        Returns:
            Whether each ended by itself; one that was ended may have sent a last set-point.
        """
        by_itself = True
        for stream in self:
            with anyio.move_on_after(timeout) as scope:
                await stream.ended()
            if scope.cancelled_caught and stream.unanswered:
                await stream.ended()
            elif scope.cancelled_caught:
                stream.kill()
                by_itself = False
        return by_itself

    def quiet(self, timeout: float) -> None:
        """As `settled`, from any thread, without ending anything.

        Args:
            timeout: seconds to wait.
        """
        start = time.monotonic()
        looks = 0
        while not all(stream.quiet for stream in self):
            looks += 1
            due = start + looks * _LOOK
            if due > start + timeout:
                return
            time.sleep(max(0.0, due - time.monotonic()))


class Claim:
    """Says to those who stop the arm for a program whether that program may be moving it.

    Args:
        say: passes on whether the program may move the arm, before it returns; it returns whether
            that was possible.

    Attributes:
        made: whether the program may be moving the arm.
    """

    def __init__(self, say: Callable[[bool], bool]) -> None:
        self._say = say
        self.made: bool = False

    def __repr__(self) -> str:
        return f"<Claim {'made' if self.made else 'not made'}>"

    def make(self, name: str) -> None:
        """Claim the arm, before a command is sent that may move it.

        It is said each time: the guard may be another one than at the last time.

        Args:
            name: what is about to be sent.

        Raises:
            GuardLost: nobody would stop the arm in the program's place; it must not be sent.
        """
        self.made = True
        if not self._say(True):
            raise GuardLost(
                f"{name} was not sent: the guard is gone or does not read, and would not stop the "
                "arm if this program died. Another guard is being started; try again, or connect "
                "without a guard"
            )

    def drop(self) -> None:
        """Drop the claim: the arm stands, and nothing that this program started still runs."""
        self.made = False
        self._say(False)
