"""A robot published live: the channels of a recording, on a WebSocket.

Foxglove, Lichtblick and any other program with Foxglove's protocol read it. It accepts no commands.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco.models.host_port import host_port
from aioduco.models.ranges import LISTEN_HOST, LISTEN_PORT
from aioduco.recording.recorder import RobotObserver
from aioduco.recording.writer import PublicationWriter

if TYPE_CHECKING:
    from aioduco.supervision.supervisor import Supervisor


class PublicationStatistics(NamedTuple):
    """Figures of a publication.

    Attributes:
        sent: messages that were sent to the watchers, if any.
        dropped: samples, calls, tasks, events and log lines that were not sent, because this
            computer was too slow. Messages that a watcher lost because the watcher was too slow are
            not counted.
    """

    sent: int
    dropped: int


class Publication(RobotObserver):
    """A robot published live: `Robot.publish` makes it, `async with` or `start` begins it."""

    _KIND = "a publication"
    _MADE_BY = "publish"

    def __init__(self, supervisor: Supervisor, port: int, host: str, forces: bool) -> None:
        port = LISTEN_PORT("port", port)
        LISTEN_HOST("host", host)
        self._server = PublicationWriter(host, port)
        super().__init__(supervisor, self._server, forces)

    def _described(self, state: str) -> str:
        return f"{self.url} {state}"

    @property
    def port(self) -> int:
        """The port that it listens on; before the start, the requested one."""
        return self._server.port

    @property
    def url(self) -> str:
        """The address to which watchers connect, such as `ws://127.0.0.1:8765`."""
        return f"ws://{host_port(self._server.host, self.port)}"

    def statistics(self) -> PublicationStatistics:
        """Figures since its start."""
        return PublicationStatistics(self._server.written, self._server.dropped + self._missed)
