"""Where a stream leads to, and who is asked and told about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from aioduco.supervision.heartbeat import HeartbeatState
from aioduco.supervision.motion_sources import Streams

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.supervision.supervisor import Supervisor

__all__ = ["StreamEndpoint"]


@dataclass(frozen=True, slots=True)
class StreamEndpoint:
    """Where a stream leads to.

    Attributes:
        host: name or address of the controller.
        port: its TCP port.
        stop: stops the robot on another connection, for a worker that cannot do it any more; it is
            given the function of the wire that ends the mode in which the worker was, or "".
        streams: the open streams of the robot.
        admit: raises if the robot cannot take a stream now; it is given the stream's name.
        guarded: whether the robot is stopped by others when the program dies.
        stall_limit: time without the program's event loop running after which it counts as hung,
            and the arm is brought to rest, whatever is still queued [s].
        unanswered_timeout: most time for which an unanswered set-point is waited for, with the arm
            stopped: it may reach the controller late [s].
        beats: whether the robot's heartbeat beats; without it the controller stops the arm, and
            the stream must not set it moving again.
    """

    host: str
    port: int
    stop: Callable[[str], Awaitable[object]] | None = None
    streams: Streams = field(default_factory=Streams)
    admit: Callable[[str], Awaitable[object]] | None = None
    guarded: bool = False
    stall_limit: float = 1.0
    unanswered_timeout: float = 60.0
    beats: Callable[[], bool] | None = None

    @classmethod
    def of(cls, supervisor: Supervisor) -> StreamEndpoint:
        """The robot that a supervisor looks after."""

        def beats() -> bool:
            heart = supervisor.heartbeat
            return heart is None or heart.state is HeartbeatState.BEATING

        return cls(
            supervisor.host,
            supervisor.port,
            stop=supervisor.stop_coordinator.stop_stream,
            streams=supervisor.stop_coordinator.streams,
            admit=supervisor.admit_stream,
            guarded=supervisor.guard is not None,
            stall_limit=supervisor.settings.loop_stall_limit,
            unanswered_timeout=supervisor.settings.unanswered_timeout,
            beats=beats,
        )
