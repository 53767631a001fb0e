"""Where a stream leads to, and who is asked and told about it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from aioduco.streaming.shared.config import Calls, EnvelopeSettings
from aioduco.supervision.heartbeat import HeartbeatState
from aioduco.supervision.motion_sources import Streams

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.streaming.shared.config import Sent
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
        envelope: what the set-points of a stream are checked against; it is given what is sent.
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
    envelope: Callable[[Sent], Awaitable[EnvelopeSettings | None]] | None = None

    @classmethod
    def of(cls, supervisor: Supervisor) -> StreamEndpoint:
        """The robot that a supervisor looks after."""

        def beats() -> bool:
            heart = supervisor.heartbeat
            return heart is None or heart.state is HeartbeatState.BEATING

        async def envelope(sent: Sent) -> EnvelopeSettings | None:
            tool, wobj = _frames(sent)
            found = await supervisor.envelope.of_stream(tool, wobj, checked=sent.meaning != "speed")
            if found is None:
                return None
            packed, base = found
            tip = ["get_tcp_pose_coord", tool, wobj]
            return EnvelopeSettings(packed=packed, wobj=base, tip=tip)

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
            envelope=envelope,
        )


def _frames(sent: Sent) -> tuple[str, str]:
    """The names of the tool and of the work object in which set-points are; empty: those in use."""
    if len(sent.read) == 3:
        return sent.read[1], sent.read[2]
    if sent.name == "servo_tcp" and isinstance(sent.drive, Calls):
        return str(sent.drive.arguments[2]), ""
    return "", ""
