"""The interface of drivers, each one way to send set-points to the controller."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from aioduco.streaming.shared.words import Reason, StatusWord, StreamState
from aioduco.streaming.worker.rest import moves
from aioduco.streaming.worker.watch import disabled, ended

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.worker.life import Life


#: seconds for which an arm may swing out from its program's last motion
_SWING = 1.0


class Driver(ABC):
    """One way to send set-points to the controller.

    Args:
        life: the state of the stream, and why it ends.
        connection: the worker's connection, open.
        block: the shared block.

    Attributes:
        task: id of the controller's task that moves the arm; 0: none yet, or there is none.
    """

    def __init__(self, life: Life, connection: Connection, block: Block) -> None:
        options = block.config.options
        self.life: Life = life
        self.task: int = 0
        self._connection = connection
        self._block = block
        self._timeout = options.timeout
        #: time between two polls whether the controller still follows [ns], when the next is due,
        #: and whether it is about the task
        self._watch_every = int(options.watch * 1e9)
        self._watch_due = time.monotonic_ns() + self._watch_every
        self._task_next = False
        #: until when the arm may still move before the stream begins [s]; inf: it was not looked at
        self._swings_until = math.inf
        self._round_trip = block.histograms["round_trip"].record
        self._sent = 0

    @property
    def state(self) -> StreamState:
        """State of the stream."""
        return self.life.state

    @abstractmethod
    def tick(self, hurry: bool) -> bool:
        """Do the work of one tick; returns whether there is another one.

        Args:
            hurry: whether the next tick is due before an answer can arrive.
        """

    def brake(self, reason: Reason, text: str = "") -> None:
        """Come to rest at once, then end."""
        self.life.brake(reason, text)

    def end(self, reason: Reason, text: str = "") -> None:
        """Send nothing more."""
        self.life.end(reason, text)

    def publish(self) -> None:
        """Write the status of the stream into the shared block."""
        self._block.status[StatusWord.SENT] = self._sent

    def _follows(self, task: int, *, waits: bool = False) -> bool:
        """Poll whether the controller still follows, if it is time to; if it does not, end.

        Args:
            task: the id that the controller returned for the last set-point; 0: none.
            waits: whether the stream goes on when a task that was paused is resumed.

        Returns:
            Whether there is another tick.
        """
        now = time.monotonic_ns()
        if not self._watch_every or now < self._watch_due:
            return True
        self._watch_due = now + self._watch_every
        self._task_next = not self._task_next
        call, timeout = self._connection.call, self._timeout
        if self._task_next and task > 0:
            state = call("get_noneblock_taskstate", (task,), timeout)
            reason, text = ended(task, state, waits=waits)
        else:
            reason, text = disabled(call("get_robot_state", (), timeout), waits=waits)
        return not reason or self._finish(reason, text)

    def _may_begin(self) -> bool:
        """Whether the controller would follow at once; if it never would, end: nothing was sent.

        What waits behind a paused motion would move the arm when somebody resumes that. What waits
        behind a motion of another program would lead back to where the arm was when it was sent.
        """
        reason, text = disabled(self._connection.call("get_robot_state", (), self._timeout))
        if not reason and moves(self._connection, self._timeout):
            now = time.monotonic()
            self._swings_until = min(self._swings_until, now + _SWING)
            if now < self._swings_until:
                return False
            text = "the arm moves, by a person or by another program: open a stream when it stands"
            reason = Reason.REFUSED
        return not reason or self._finish(reason, text)

    def _finish(self, reason: Reason, text: str = "") -> bool:
        """End: no deceleration is possible or needed. Returns that there is no other tick."""
        self.end(reason, text)
        return False
