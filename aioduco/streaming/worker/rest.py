"""Brings the arm to rest, by the steps of `UnansweredMotion`, on the worker's only thread."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco.errors import ControllerError, DucoError
from aioduco.streaming.worker.clock import sleep_until
from aioduco.supervision.unanswered import LOOK_EVERY, NextStep, UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection import Connection
    from aioduco._wire.own_connection import OwnConnection


#: seconds for which each step waits for a late answer
_LISTEN = 0.001
#: ns between two queries whether the arm moves
_LOOK_EVERY = int(LOOK_EVERY * 1e9)
#: ns between two attempts to reach a controller that does not answer
_TRY_EVERY = 50_000_000


def bring_to_rest(
    motion: UnansweredMotion,
    own: OwnConnection,
    timeout: float,
    alive: Callable[[], None],
    lost: Connection | None = None,
) -> bool:
    """Return when the arm stands and an unanswered set-point cannot move it any more.

    Args:
        motion: decides on the next step.
        own: the connection on which the arm is stopped, and queried whether it moves.
        timeout: seconds for one answer of the controller.
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
                every = _LOOK_EVERY if _ask(motion, step, own, timeout) else _TRY_EVERY
                due = sleep_until(max(due + every, time.monotonic_ns()))


def _report(motion: UnansweredMotion, lost: Connection) -> None:
    """Report what became of an unanswered set-point."""
    if lost.late_answer(time.monotonic() + _LISTEN):
        motion.answered(time.monotonic())
    elif not lost.overdue:
        motion.connection_reset(time.monotonic())


def _ask(motion: UnansweredMotion, step: NextStep, own: OwnConnection, timeout: float) -> bool:
    """Do a step and report its result to `motion`. Returns whether the controller answered."""
    begin = time.monotonic()
    try:
        if step is NextStep.STOP:
            own.call("stop", (False,), timeout)
            motion.stopped(begin, time.monotonic())
        else:
            motion.seen(begin, time.monotonic(), moving=moves(own, timeout))
    except DucoError:
        motion.poll_failed(begin, time.monotonic())
        return False
    return True


def moves(connection: Connection | OwnConnection, timeout: float) -> bool:
    """Whether the arm moves, as far as this controller reports it.

    Args:
        connection: the connection on which it is asked.
        timeout: seconds for its answer.
    """
    try:
        return bool(connection.call("robotmoving", (), timeout))
    except ControllerError:
        return False  # this controller does not report it, so it counts as standing
