"""A program of blocking calls that is interrupted twice in each, at two lines of whatever it runs.

    python interrupted_calls.py HOST PORT NUMBER...

The first interrupt comes at the first line that the main thread runs once its motion was accepted,
where it waits for the end, or does not have its task yet; the second one NUMBER lines after the
call began to cancel its work, in any module. Each time the program writes what the call raised, and
whether the arm moved then.
"""

from __future__ import annotations

import faulthandler
import itertools
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import aioduco.sync
from aioduco.models.trace import CallFinished
from aioduco.sync import _runner


class Interruption:
    """Interrupts the main thread at two of its lines."""

    def __init__(self) -> None:
        self._armed = self._at_end = False
        self._left: list[int] = []

    def begin(self, number: int, *, at_end: bool) -> None:
        """Prepare two interrupts of a motion: when it is accepted, or the call's work ends."""
        self._left, self._armed, self._at_end = [1, number], False, at_end
        sys.settrace(self._line)

    def look(self, event: object) -> None:
        """Take note of an accepted motion: a trace hook of the robot."""
        if isinstance(event, CallFinished) and event.function == "movej2" and not self._at_end:
            self._armed = True

    def end(self) -> None:
        """Take note that the work of a call has ended, which its thread does not know yet."""
        if self._at_end:
            self._armed = True

    def finish(self) -> None:
        """Interrupt nothing more: the call may have taken fewer lines."""
        sys.settrace(None)
        self._left = []

    def again(self) -> None:
        """Go on: what a trace function raises ends it."""
        if self._left:
            sys.settrace(self._line)

    def _line(self, _frame: FrameType, event: str, _arg: object) -> Any:
        if event == "line" and self._armed and self._left:
            self._left[0] -= 1
            if not self._left[0]:
                del self._left[0]
                raise KeyboardInterrupt
        return self._line


def main(host: str, port: int, numbers: list[int]) -> None:
    """Move once for each number."""
    interruption = Interruption()
    uninterrupted = _runner.uninterrupted

    def watched(step: Callable[[], object]) -> list[BaseException]:
        def again() -> None:
            interruption.again()
            step()

        return uninterrupted(again)

    set_latch = _runner.Latch.set

    def ending(latch: _runner.Latch) -> None:
        interruption.end()
        set_latch(latch)

    _runner.uninterrupted = watched
    latches: Any = _runner.Latch
    latches.set = ending
    with aioduco.sync.connect(host, port, trace=interruption.look) as robot:
        movej2 = robot.motion.movej2
        moves: tuple[tuple[bool, Callable[..., object]], ...] = (
            (False, movej2),
            (True, movej2.start),
        )
        for number, (at_end, move) in itertools.product(numbers, moves):
            raised: BaseException | None = None
            try:
                interruption.begin(number, at_end=at_end)
                try:
                    move([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0)
                finally:
                    interruption.finish()
            except BaseException as exc:  # whatever it is, it is what is tested
                raised = exc
            moving = robot.state.robotmoving()
            sys.stdout.write(f"{type(raised).__name__} {moving}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    # whoever waits in vain for this program ends it by SIGABRT, and reads where it was
    faulthandler.enable()
    _, given_host, given_port, *given = sys.argv
    main(given_host, int(given_port), [int(number) for number in given])
