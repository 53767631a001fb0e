"""The error that a program gets for each reason for which a stream ends."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from aioduco.envelope.limits import Crossing
from aioduco.errors import (
    EnvelopeViolated,
    FirstPointTooFar,
    StreamClosed,
    StreamError,
    StreamLeavesEnvelope,
    StreamLost,
    StreamRefused,
    StreamStarved,
    StreamStopped,
    WorkerFailed,
)
from aioduco.streaming.shared.words import Reason

if TYPE_CHECKING:
    from aioduco.errors import DucoError


_BRAKED = "the stream was ended by its program; the arm was braked"
_STARVED = (
    "no set-point came for longer than the hold time: the arm was brought to rest, and the robot "
    "stopped. Send more often, or open the stream with a longer hold"
)
_HUNG = (
    "the program's event loop did not run for longer than the robot's loop_stall_limit: no further "
    "set-point was sent, and the robot was stopped. Call robot.rearm_heartbeat() or "
    "robot.recover(), and open a new stream"
)
_LAPSED = (
    "the robot's heartbeat was lost, and its controller may have stopped the arm by itself: no "
    "further set-point was sent, and the robot was stopped. Open a new stream when the heartbeat "
    "beats again"
)
_AWAY = (
    "the stream's worker did not run for longer than its away_limit: it was frozen, or the "
    "computer slept or was too busy. No further set-point was sent, and the robot was stopped. See "
    "where the arm is, and open a new stream"
)
_ALONE = "the worker lost sight of the program: the arm was brought to rest, and the robot stopped"
_STOPPED = "the robot was stopped, and nothing more is sent. Open a new stream to go on"
_TOO_FAR = (
    "the first set-point is further from where the arm is than the stream's reach; nothing was "
    "sent. Move there first, or begin the stream at the arm's own position"
)
_REFUSED = (
    "the controller does not follow any more; if anything was sent that moves the arm, it was told "
    "to stop. See its errors, and the robot's state"
)
_CONNECTION = (
    "the stream's connection failed; if anything was sent, a stop was tried over a new one. Look "
    "at the robot's state before you go on"
)
_FAILED = "the stream's worker failed; the robot was told to stop"
_ENVELOPE = (
    "the next set-point would have led beyond the robot's envelope, and was not sent; the arm was "
    "brought to rest, and the robot stopped"
)
_READING = "it could not read on; nothing was sent that moves or stops the arm"
_DIED = (
    "the stream's worker is gone without a word; the robot was told to stop on another connection, "
    "if there was one"
)

_ENDS: dict[Reason, tuple[type[StreamError], str]] = {
    Reason.ABORTED: (StreamClosed, _BRAKED),
    Reason.STARVED: (StreamStarved, _STARVED),
    Reason.HUNG: (StreamStarved, _HUNG),
    Reason.PROGRAM_DIED: (WorkerFailed, _ALONE),
    Reason.STOPPED: (StreamStopped, _STOPPED),
    Reason.TOO_FAR: (FirstPointTooFar, _TOO_FAR),
    Reason.REFUSED: (StreamRefused, _REFUSED),
    Reason.CONNECTION: (StreamLost, _CONNECTION),
    Reason.FAILED: (WorkerFailed, _FAILED),
    Reason.WORKER_DIED: (WorkerFailed, _DIED),
    Reason.AWAY: (WorkerFailed, _AWAY),
    Reason.LAPSED: (StreamStarved, _LAPSED),
}


def failure(
    name: str,
    reason: Reason,
    text: str,
    statistics: object,
    stopped_by: DucoError | None = None,
    *,
    reads: bool = False,
) -> StreamError | None:
    """The error for the end of a stream; None if it has not ended, or was closed.

    Args:
        name: function of the stream.
        reason: reason of the end.
        text: what is known beyond that.
        statistics: the stream's statistics.
        stopped_by: why the watch of the envelope has stopped the arm, if it has.
        reads: whether its worker sends no set-points, and only reads.
    """
    if reason is Reason.STOPPED and stopped_by is not None:
        message = f"{name}: {stopped_by}. Nothing more is sent: open a new stream to go on"
        if not isinstance(stopped_by, EnvelopeViolated):
            return StreamStopped(message, statistics)
        limit, body = stopped_by.limit, stopped_by.body
        return StreamLeavesEnvelope(
            message, limit, body, stopped_by.place, stopped_by.margin, statistics
        )
    if reason is Reason.ENVELOPE:
        # The worker may have added to the crossing that it could not stop the arm after it.
        (limit, body, place, *others), end = json.JSONDecoder().raw_decode(text)
        found = Crossing(limit, body, tuple(place), *others)
        message = f"{name}: {_ENVELOPE}: {found}{text[end:]}"
        return StreamLeavesEnvelope(message, *found[:4], statistics)
    if reason not in _ENDS:
        return None
    kind, meaning = _ENDS[reason]
    meaning = _READING if reads else meaning
    return kind(f"{name}: {meaning}{f' ({text})' if text else ''}", statistics)
