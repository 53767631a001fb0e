"""How a worker outlasts a set-point that was sent but not answered.

It applies the supervision's rule for motions, `UnansweredMotion`, without an event loop: the worker
has its own connections and only one thread.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from aioduco._wire.lifecycle import ConnectionState
from aioduco.errors import ControllerError, DucoError, StopUnconfirmed
from aioduco.streaming.worker.clock import sleep_until
from aioduco.supervision.unanswered import NextStep, UnansweredMotion

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.connection import Connection

__all__ = ["outlast"]

#: ns between two queries whether the arm moves
_LOOK_EVERY = 10_000_000
#: seconds for which each step waits for the late answer
_LISTEN = 0.001
#: seconds for a stop and a standstill after the wait for the answer has ended
_MARGIN = 5.0
#: ns between two attempts to reach a controller that does not answer
_TRY_EVERY = 50_000_000


def outlast(
    lost: Connection,
    connect: Callable[[], Connection],
    timeout: float,
    limit: float,
    alive: Callable[[], None],
) -> None:
    """Stop the robot, and return when an unanswered set-point cannot start it any more.

    Args:
        lost: the connection on which the answer did not come.
        connect: makes a new connection that is not open yet.
        timeout: seconds for one answer of the controller.
        limit: seconds for which to wait for the late answer.
        alive: function called at each step, to show that the worker runs.

    Raises:
        StopUnconfirmed: the set-point may still start the arm.
    """
    now = time.monotonic()
    motion = UnansweredMotion(now, now + limit, now + limit + _MARGIN)
    line = _Line(connect, timeout)
    due = time.monotonic_ns()
    try:
        while (step := _next(motion, lost)) is not NextStep.DONE:
            alive()
            match step:
                case NextStep.DISSOLVE:
                    lost.close()
                case NextStep.GIVE_UP:
                    raise StopUnconfirmed(
                        "a set-point was sent, and it is not known what became of it: the arm may "
                        "be moving, or begin to. Press the emergency stop"
                    )
                case _:
                    every = _LOOK_EVERY if line.ask(motion, step) else _TRY_EVERY
                    due = sleep_until(max(due + every, time.monotonic_ns()))
    finally:
        line.close()
        lost.close()


def _next(motion: UnansweredMotion, lost: Connection) -> NextStep:
    """Report the state of the set-point to `motion`, and return the next step."""
    if lost.late_answer(time.monotonic() + _LISTEN):
        motion.answered(time.monotonic())
    elif not lost.overdue:
        motion.dissolved(time.monotonic())
    return motion.step(time.monotonic())


class _Line:
    """Stops the arm and queries whether it moves, over new connections."""

    def __init__(self, connect: Callable[[], Connection], timeout: float) -> None:
        self._connect = connect
        self._timeout = timeout
        self._connection: Connection | None = None

    def ask(self, motion: UnansweredMotion, step: NextStep) -> bool:
        """Do a step and report its result to `motion`. Returns whether the controller answered."""
        begin = time.monotonic()
        try:
            connection = self._open()
            if step is NextStep.STOP:
                connection.call("stop", (False,), self._timeout)
                motion.stopped(begin, time.monotonic())
            else:
                moving = self._moves(connection)
                motion.seen(begin, time.monotonic(), moving=moving)
        except DucoError:
            motion.poll_failed(time.monotonic())
            return False
        return True

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self._connection is not None:
            self._connection.close()

    def _open(self) -> Connection:
        if self._connection is None or self._connection.state is not ConnectionState.IDLE:
            self.close()
            self._connection = self._connect()
            self._connection.open(time.monotonic() + self._timeout)
        return self._connection

    def _moves(self, connection: Connection) -> bool:
        try:
            moving: bool = connection.call("robotmoving", (), self._timeout)
        except ControllerError:
            return False  # this controller does not report it, so it counts as standing
        return moving
