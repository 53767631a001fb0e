"""The gate: decides whether something that can move the arm may be sent. No clock, no I/O.

A program asks before it sends anything that can move the arm: when it awaits or starts a motion,
resumes, opens a stream, enters a mode. It gets a permit, which is checked once more as the last
thing before the bytes are handed to a socket. All permits end together, with

- the next stop, abort or pause, whoever requests it,
- a heartbeat that was not answered in time: the controller may stop the arm by itself,
- an event loop that hangs, or a program that stood still: it was frozen, or its computer slept,
- a stop at a limit of the envelope,
- the end of the robot's block.

So nothing that was asked before such an event is sent after it, however long it waited for a lock,
an answer or a connection.

Guarantees:
- While a stop is being confirmed, no permit is valid: what is asked meanwhile waits until the arm
  was seen to stand. If that is not known in the end, it is refused.
- After a hang or a standstill of the program, the gate stays closed until the program rearms it:
  the arm stands, and the program must first be told.
- What the program started or resumed counts as moving until the arm was seen to stand.

Times are seconds of one clock that goes on while the computer sleeps. `end`, `check` and what calls
them may run on any thread and in signal handlers: nothing waits, and each attribute is replaced as
a whole.
"""

from __future__ import annotations

import contextlib
import math
from enum import Enum
from typing import TYPE_CHECKING

from aioduco.errors import DucoError, HeartbeatLost, RobotStateError, StopUnconfirmed, TaskStopped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


#: seconds for which an arm must be seen to stand until a resumed motion counts as over: it may not
#: have begun to move
_STANDING = 0.5


class PermitEnding(Enum):
    """Why permits end."""

    STOPPED = "the arm was stopped"
    ENVELOPE = "the arm was stopped at a limit of its envelope"
    PAUSED = "the arm was paused"
    LEFT = "the robot is closed, or is being closed"
    LAPSED = "the heartbeat was lost"
    HUNG = "the event loop hung"
    FAILED = "the supervision of the robot failed"

    @property
    def stops(self) -> bool:
        """Whether the one that ended the permits also stops, or pauses, the arm."""
        return self in (
            PermitEnding.STOPPED,
            PermitEnding.ENVELOPE,
            PermitEnding.PAUSED,
            PermitEnding.LEFT,
        )


class _Epoch:
    """The time between two events that end all permits."""

    __slots__ = ("ending",)

    def __init__(self) -> None:
        self.ending: PermitEnding | None = None


class Permit:
    """Permission to send one thing, or the things of one undertaking, that can move the arm.

    Args:
        name: the function of the wire or the undertaking that it was given for.
        epoch: the epoch in which it was asked for.
        lasting: the same of undertakings.
        stops: number of stops that had been requested by then.
    """

    __slots__ = ("epoch", "lasting", "name", "stops")

    def __init__(self, name: str, epoch: _Epoch, lasting: _Epoch, stops: int) -> None:
        self.name: str = name
        self.epoch: _Epoch = epoch
        self.lasting: _Epoch = lasting
        self.stops: int = stops

    def __repr__(self) -> str:
        ending = self.epoch.ending
        return f"<Permit {self.name} {'valid' if ending is None else ending.name.lower()}>"


class Gate:
    """Gives permits, and ends them.

    Args:
        heartbeat: seconds without a beat after which the controller stops the arm; None if there is
            no heartbeat.
        stall_limit: seconds without a keep-alive after which the program counts as hung. Without
            a heartbeat, which the program could rearm, this ends permits, but does not close the
            gate.
        now: the time.
        ended: called at once when permits end, with the reason. It must not raise or wait.

    Attributes:
        closed: why no permit is given any more; empty while the robot is open.
        hung: whether the program hung or stood still, and has not rearmed the gate.
        stops: number of stops that were begun.
        unconfirmed: whether the last stop was not confirmed.
        lease: time until which the controller does not stop the arm for want of a beat; inf: for
            ever.
        resumed: whether a motion that this program resumed may be moving the arm.
        paused: whether this program has paused the arm last, and not stopped or resumed it since.
    """

    def __init__(
        self,
        heartbeat: float | None,
        stall_limit: float,
        now: float,
        ended: Callable[[PermitEnding], object] = lambda _: None,
    ) -> None:
        self._heartbeat = heartbeat
        self._stall_limit = stall_limit
        self._ended = ended
        self._epoch = _Epoch()
        #: the epoch of undertakings, which a pause does not end: the program may resume
        self._lasting = _Epoch()
        self._alive = now
        #: why no beat is answered; empty: the controller does not answer
        self._unbeaten = ""
        #: the stops that are being confirmed
        self._stopping: set[object] = set()
        self._standing_since: float | None = None
        self.closed: str = ""
        self.hung: bool = False
        self.stops: int = 0
        self.unconfirmed: bool = False
        self.lease: float = math.inf if heartbeat is None else -math.inf
        self.resumed: bool = False
        self.paused: bool = False

    def __repr__(self) -> str:
        state = (
            *(["closed"] if self.closed else []),
            *(["hung"] if self.hung else []),
            *(["stopping"] if self._stopping else []),
        )
        return f"<Gate {', '.join(state) or 'open'}, {self.stops} stops>"

    # -- keep-alives -------------------------------------------------------------------------

    def alive(self, now: float) -> bool:
        """Take in a keep-alive of the event loop.

        Returns:
            Whether it counts. It does not after a gap that is longer than the stall limit: the
            program stood still, and has not noticed.
        """
        self.look(now)
        if not self.hung:
            self._alive = max(self._alive, now)
        return not self.hung

    def beaten(self, sent: float) -> None:
        """Take in a beat that the controller answered.

        Args:
            sent: when it was sent.
        """
        if self._heartbeat is None or sent + self._heartbeat <= self.lease:
            return
        if sent > self.lease > -math.inf:
            self.end(PermitEnding.LAPSED)
        self.lease = sent + self._heartbeat
        self._unbeaten = ""

    def lapse(self, why: str = "") -> None:
        """Note that no beat is answered any more.

        Args:
            why: the reason, for errors; empty: the controller does not answer.
        """
        if self._heartbeat is not None:
            self.end(PermitEnding.LAPSED)
            self.lease = -math.inf
            self._unbeaten = why

    def hang(self) -> None:
        """Note that the program hangs, or stood still: no permit is given until `rearm`."""
        if not self.hung:
            self.hung = self._heartbeat is not None
            self.end(PermitEnding.HUNG)

    def rearm(self, now: float) -> None:
        """Open the gate after a hang, on request of the program."""
        self._alive = now
        self.hung = False

    def look(self, now: float) -> None:
        """Notice a hang or a lapse that no other part has noticed yet."""
        if self.hung:
            return
        if now - self._alive > self._stall_limit:
            self._alive = now
            self.hang()
        elif now > self.lease > -math.inf:
            self.lapse()

    # -- permits -------------------------------------------------------------------------------

    def ask(
        self,
        name: str,
        now: float,
        within: Permit | None = None,
        *,
        moves: bool = True,
        lasting: bool = False,
    ) -> Permit:
        """Ask for a permit. It is not valid before the stops that are being confirmed are over.

        Args:
            name: what can move the arm.
            now: the time.
            within: permit of the undertaking to which it belongs, and with which it ends.
            moves: whether it can move the arm; what cannot needs an open robot only.
            lasting: whether it is an undertaking: a pause does not end it.

        Raises:
            RobotStateError: the robot is closed, or is being closed.
            HeartbeatLost: the heartbeat does not beat, or the program hung.
            TaskStopped: the permit of the undertaking has ended.
        """
        self.look(now)
        if (refusal := self._closed(name)) is not None and (moves or self.closed):
            raise refusal
        if within is not None:
            self._require_current(name, within)
        epoch = self._lasting if lasting else self._epoch
        return Permit(name, epoch, self._lasting, self.stops)

    def present(self, name: str) -> Permit:
        """Return a permit of this moment, valid or not: what belongs to it ends with it."""
        return Permit(name, self._epoch, self._lasting, self.stops)

    def check(self, permit: Permit, now: float) -> None:
        """Check that a permit is valid; the last thing before bytes are handed to a socket.

        Raises:
            TaskStopped, HeartbeatLost, RobotStateError: it has ended; nothing was sent.
        """
        self.look(now)
        self._require_current(permit.name, permit)
        if self._stopping:
            raise TaskStopped(permit.name, None, "was not sent, since the arm is being stopped")

    def waits(self, permit: Permit, now: float) -> bool:
        """Whether the holder of a permit must still wait for the end of a stop.

        Raises:
            StopUnconfirmed: the stop is over, and it is not known that the arm stands.
            TaskStopped, HeartbeatLost, RobotStateError: the permit has ended; nothing was sent.
        """
        self.look(now)
        self._require_current(permit.name, permit)
        if not self._stopping and self.unconfirmed:
            raise StopUnconfirmed(
                f"{permit.name} was not sent: it waited for a stop, and it is not known that the "
                "arm stands. Press the emergency stop if it moves"
            )
        return bool(self._stopping)

    def ending(self, permit: Permit) -> PermitEnding | None:
        """Return why a permit has ended, what came after a pause first; None if it has not."""
        if permit.epoch in (self._epoch, self._lasting):
            return None
        return permit.lasting.ending or permit.epoch.ending or PermitEnding.STOPPED

    def end(self, ending: PermitEnding) -> None:
        """End all permits, from any thread."""
        if ending in (PermitEnding.STOPPED, PermitEnding.ENVELOPE):
            self.stops += 1
        if ending.stops:
            self.paused = ending is PermitEnding.PAUSED
        epoch, self._epoch = self._epoch, _Epoch()
        epoch.ending = ending
        if ending is not PermitEnding.PAUSED:
            lasting, self._lasting = self._lasting, _Epoch()
            lasting.ending = ending
        self._ended(ending)

    def close(self, why: str, ending: PermitEnding = PermitEnding.LEFT) -> None:
        """Give no permit any more.

        Args:
            why: the reason, for errors.
            ending: why permits end.
        """
        self.closed = self.closed or why
        # No keep-alive counts any more: a guard must not go on beating for a failed supervision.
        self.hung = self.hung or ending is PermitEnding.FAILED
        self.end(ending)

    def _closed(self, name: str) -> DucoError | None:
        if self.closed:
            return RobotStateError(f"{name} was not sent: {self.closed}")
        if not self.hung and self.lease > -math.inf:
            return None
        what = (
            "the event loop hung; call robot.rearm_heartbeat() to go on"
            if self.hung
            else self._unbeaten or "the controller does not answer it; it is tried on"
        )
        return HeartbeatLost(f"{name} was not sent, since the heartbeat does not beat: {what}")

    def _require_current(self, name: str, permit: Permit) -> None:
        ending = self.ending(permit)
        if ending is None:
            return
        if ending.stops and not self.closed:
            raise TaskStopped(name, None, f"was not sent, since {ending.value}")
        kind = RobotStateError if self._heartbeat is None else HeartbeatLost
        raise self._closed(name) or kind(
            f"{name} was not sent, since {ending.value} after the program had asked for it"
        )

    # -- stops ---------------------------------------------------------------------------------

    @property
    def stopping(self) -> bool:
        """Whether a stop is being confirmed."""
        return bool(self._stopping)

    @contextlib.contextmanager
    def stop(self, ending: PermitEnding = PermitEnding.STOPPED) -> Iterator[None]:
        """End all permits, and give no valid one until the block is left.

        The block sends the stop, and returns when the arm was seen to stand; it raises if that is
        not known.
        """
        token = object()
        self._stopping.add(token)
        self.end(ending)
        try:
            yield
        except BaseException:
            self.unconfirmed = True
            raise
        else:
            self.unconfirmed = self.resumed = False
        finally:
            self._stopping.discard(token)

    # -- what the program moves ----------------------------------------------------------------

    def resume(self) -> None:
        """Note that this program makes the arm move without a task that it follows."""
        self.resumed, self.paused = True, False
        self._standing_since = None

    def seen(self, now: float, *, standing: bool) -> None:
        """Take in whether the arm stands: what stood for a while is not this program's any more."""
        if not standing:
            self._standing_since = None
        elif self._standing_since is None:
            self._standing_since = now
        elif now - self._standing_since >= _STANDING:
            self.resumed = False
