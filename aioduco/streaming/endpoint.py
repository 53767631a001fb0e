"""The robot to which a stream sends, and the callbacks that supervise it."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from aioduco.supervision.gate import Gate

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.streaming.shared.config import CheckedEnvelope, StreamSpec
    from aioduco.supervision.gate import Permit
    from aioduco.supervision.motion_sources import Modes, OpenStream
    from aioduco.supervision.supervisor import Supervisor


@dataclass(frozen=True, slots=True)
class StreamEndpoint:
    """The robot to which a stream sends, and the callbacks that supervise it.

    Attributes:
        host: name or address of the controller.
        port: its TCP port.
        stop: stops the robot on another connection, for a worker that cannot do it any more; its
            argument is the function of the wire that ends the stream's mode, or "".
        streams: the open streams of the robot, at most one.
        asked: lets what its block awaits before the stream begins count as asked for now, or raises
            if the stream may not begin; its argument is the stream's name.
        admit: returns the permit of a stream, or raises if the robot cannot accept one now; its
            argument is the stream's name.
        gate: decides until when the permit is valid; by default, for ever.
        modes: the modes of the robot.
        guarded: whether a guard stops the robot when the program dies.
        stall_limit: time after which a program whose event loop does not run counts as hung; the
            worker then stops the arm, even if set-points are queued [s].
        unanswered_timeout: longest wait for an unanswered set-point, with the arm stopped: it may
            reach the controller late [s].
        envelope: returns the envelope for the checks of set-points; its argument is what the stream
            sends.
    """

    host: str
    port: int
    stop: Callable[[str], Awaitable[object]] | None = None
    streams: list[OpenStream] = field(default_factory=list)
    asked: Callable[[str], AbstractContextManager[object]] = nullcontext
    admit: Callable[[str], Awaitable[Permit]] | None = None
    gate: Gate = field(default_factory=lambda: Gate(None, math.inf, 0.0))
    modes: Modes | None = None
    guarded: bool = False
    stall_limit: float = 1.0
    unanswered_timeout: float = 60.0
    envelope: Callable[[StreamSpec], Awaitable[CheckedEnvelope | None]] | None = None

    @classmethod
    def of(cls, supervisor: Supervisor) -> StreamEndpoint:
        """The endpoint for the robot of a supervisor."""
        coordinator = supervisor.stop_coordinator

        def asked(name: str) -> AbstractContextManager[None]:
            supervisor.check_permitted(name)
            return supervisor.permits.from_now(name)

        async def envelope(sent: StreamSpec) -> CheckedEnvelope | None:
            return await supervisor.envelope.of_stream(
                sent.name, sent.tool, sent.wobj, speeds=sent.meaning == "speed"
            )

        return cls(
            supervisor.host,
            supervisor.port,
            stop=coordinator.stop_stream,
            streams=coordinator.streams,
            asked=asked,
            admit=supervisor.dispatcher.admit_stream,
            gate=coordinator.gate,
            modes=coordinator.modes,
            guarded=supervisor.guard is not None,
            stall_limit=supervisor.settings.loop_stall_limit,
            unanswered_timeout=supervisor.settings.unanswered_timeout,
            envelope=envelope,
        )
