"""Brings the arm to rest, by the steps of `UnansweredMotion`, on the worker's only thread."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._wire.lifecycle import ConnectionState
from aioduco.errors import ControllerError, DucoError
from aioduco.streaming.worker.clock import sleep_until
from aioduco.supervision.unanswered import LOOK_EVERY, NextStep, UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection import Connection

__all__ = ["Line", "bring_to_rest"]

#: seconds for which each step waits for a late answer
_LISTEN = 0.001
#: ns between two queries whether the arm moves
_LOOK_EVERY = int(LOOK_EVERY * 1e9)
#: ns between two attempts to reach a controller that does not answer
_TRY_EVERY = 50_000_000


def bring_to_rest(
    motion: UnansweredMotion,
    line: Line,
    alive: Callable[[], None],
    lost: Connection | None = None,
) -> bool:
    """Return when the arm stands and an unanswered set-point cannot move it any more.

    Args:
        motion: decides on the next step.
        line: stops the arm, and queries whether it moves.
        alive: function called at each step, to show that the worker runs.
        lost: the connection on which the answer to a set-point did not come; None for none.

    Returns:
        Whether that is certain.
    """
    due = time.monotonic_ns()
    while True:
        alive()
        if lost is not None:
            _report(motion, lost)
        match step := motion.step(time.monotonic()):
            case NextStep.DONE | NextStep.GIVE_UP:
                return step is NextStep.DONE
            case NextStep.RESET:
                assert lost is not None
                lost.close()
            case NextStep.STOP | NextStep.LOOK:
                every = _LOOK_EVERY if line.ask(motion, step) else _TRY_EVERY
                due = sleep_until(max(due + every, time.monotonic_ns()))


def _report(motion: UnansweredMotion, lost: Connection) -> None:
    """Report what became of an unanswered set-point."""
    if lost.late_answer(time.monotonic() + _LISTEN):
        motion.answered(time.monotonic())
    elif not lost.overdue:
        motion.connection_reset(time.monotonic())


class Line:
    """Stops the arm and queries whether it moves; opens a connection when there is none.

    Args:
        connect: makes a new connection that is not open yet.
        timeout: seconds for one answer of the controller.
        connection: the connection to use as long as it is open.
    """

    def __init__(
        self,
        connect: Callable[[], Connection],
        timeout: float,
        connection: Connection | None = None,
    ) -> None:
        self._connect = connect
        self._timeout = timeout
        self._connection = connection

    def ask(self, motion: UnansweredMotion, step: NextStep) -> bool:
        """Do a step and report its result to `motion`. Returns whether the controller answered."""
        begin = time.monotonic()
        try:
            if step is NextStep.STOP:
                self.call("stop", False)
                motion.stopped(begin, time.monotonic())
            else:
                motion.seen(begin, time.monotonic(), moving=self._moves())
        except DucoError:
            motion.poll_failed(begin, time.monotonic())
            return False
        return True

    def call(self, name: str, *args: object) -> int:
        """Call a function of the wire.

        Raises:
            DucoError: the controller was not reached, or answered with an error.
        """
        connection = self._connection
        if connection is None or connection.state is not ConnectionState.IDLE:
            self.close()
            connection = self._connection = self._connect()
            connection.open(time.monotonic() + self._timeout)
        answer: int = connection.call(name, args, self._timeout)
        return answer

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self._connection is not None:
            self._connection.close()

    def _moves(self) -> bool:
        try:
            return bool(self.call("robotmoving"))
        except ControllerError:
            return False  # this controller does not report it, so it counts as standing
