"""Whether a stream's worker may send a set-point: a state machine without I/O.

What the program asked for before its permit ended must not move the arm afterwards, however long
the bytes waited. The worker cannot ask the program at each set-point, so the permit is in the
shared block: the program's commands, its last keep-alive, and the time until which the controller
does not stop the arm for want of a heartbeat. The program's gate writes the latter, on the thread
on which a beat was answered.

The worker checks the permit before each tick, and once more as the last thing before the bytes of
each call that can move the arm. It sends nothing if

- the program has halted it or withdrawn the permit,
- the worker itself did not run for too long: it was frozen, or the computer slept. What it knows is
  old then, and the set-point was meant for another time,
- the controller may have stopped the arm by itself, since the heartbeat was lost,
- the program's event loop sent no keep-alive for too long.

The first reason stays: a permit that has ended never becomes valid again.

Two clocks are needed. Ticks are due by the monotonic clock, which on Linux stands still while the
computer sleeps; the other one, of `boot_time`, goes on. Tests give the times of both.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._process.platform import boot_time
from aioduco.streaming.shared.words import ControlWord, Reason

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


class PermitEnded(Exception):
    """A set-point was not sent, since the permit has ended."""


def _both_clocks() -> tuple[int, int]:
    """The monotonic time, and the one that goes on while the computer sleeps [ns]."""
    return time.monotonic_ns(), int(boot_time() * 1e9)


class StreamPermit:
    """The permit of one worker.

    Args:
        control: words of `ControlWord`, which the program writes.
        stall_limit: time without a keep-alive after which the program's event loop hangs [s].
        away_limit: time for which the worker may not run [s].
        times: returns the monotonic time, and the one that goes on while the computer sleeps [ns].

    Attributes:
        reason: why it has ended; NONE while it is valid.
        text: more about the reason.
    """

    def __init__(
        self,
        control: Sequence[int],
        stall_limit: float,
        away_limit: float,
        times: Callable[[], tuple[int, int]] = _both_clocks,
    ) -> None:
        self._control = control
        self._stall_limit = int(stall_limit * 1e9)
        self._away_limit = int(away_limit * 1e9)
        self._times = times
        self.reason: Reason = Reason.NONE
        self.text: str = ""
        self.begin()

    def begin(self) -> None:
        """Do not count the time until now: nothing was sent, and the set-up may take long."""
        self._runs(*self._times())

    def _runs(self, now: int, boot: int) -> None:
        #: when the worker was last seen to run, and by how much that clock was ahead of the other
        self._seen = boot
        self._ahead = boot - now

    def look(self, due: int = 0) -> Reason:
        """Check the permit.

        Args:
            due: monotonic time until which the worker meant to sleep since the last look [ns].

        Returns:
            Why the permit has ended; NONE if a set-point may be sent.
        """
        if self.reason:
            return self.reason
        now, boot = self._times()
        away = boot - max(self._seen, due + self._ahead)
        self._runs(now, boot)
        control = self._control
        silent = boot - control[ControlWord.ALIVE]
        if control[ControlWord.WITHDRAW]:
            self.reason = Reason(control[ControlWord.WITHDRAW])
        elif control[ControlWord.HALT]:
            self.reason = Reason.STOPPED
        elif away > self._away_limit:
            self._end(Reason.AWAY, f"it did not run for {away * 1e-9:.2f} s")
        elif boot >= control[ControlWord.LEASE]:
            self._end(Reason.LAPSED, "no beat was answered in time")
        elif silent > self._stall_limit:
            self._end(Reason.HUNG, f"no keep-alive for {silent * 1e-9:.2f} s")
        return self.reason

    def require(self, due: int = 0) -> None:
        """Check it: before a tick, and as the last thing before bytes that can move the arm.

        Raises:
            PermitEnded: it has ended.
        """
        if self.look(due):
            raise PermitEnded

    def _end(self, reason: Reason, text: str) -> None:
        self.reason, self.text = reason, text
