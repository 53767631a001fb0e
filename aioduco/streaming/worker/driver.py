"""The interface of drivers, each one way to send set-points to the controller."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from aioduco.streaming.shared.words import StatusWord
from aioduco.streaming.worker.watch import ControllerWatch

if TYPE_CHECKING:
    from aioduco._wire.connection import Connection
    from aioduco.streaming.shared.block import Block
    from aioduco.streaming.shared.words import Reason, StreamState
    from aioduco.streaming.worker.life import Life

__all__ = ["Driver"]


class Driver(ABC):
    """One way to send set-points to the controller.

    Args:
        life: the state of the stream, and why it ends.
        connection: the worker's connection, open.
        block: the shared block.
    """

    def __init__(self, life: Life, connection: Connection, block: Block) -> None:
        options = block.config.options
        self.life: Life = life
        self._connection = connection
        self._block = block
        self._timeout = options.timeout
        self._watch = ControllerWatch(connection, options.watch, options.timeout)
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

    def _finish(self, reason: Reason, text: str = "") -> bool:
        """End: no deceleration is possible or needed. Returns that there is no other tick."""
        self.end(reason, text)
        return False
