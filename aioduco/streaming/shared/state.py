"""The states of a stream, and the reasons for its end."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["Reason", "StreamState"]


class StreamState(IntEnum):
    """State of a stream."""

    WAITING = 0
    FOLLOWING = 1
    HOLDING = 2
    DECELERATING = 3
    ENDED = 4


class Reason(IntEnum):
    """Why a stream ended."""

    NONE = 0
    #: the program closed it
    CLOSED = 1
    #: the program left the stream because of an error or a cancellation
    ABORTED = 2
    #: the program sent nothing for longer than the hold time
    STARVED = 3
    #: the program died
    PROGRAM_DIED = 4
    #: the robot was stopped
    STOPPED = 5
    #: the first set-point was too far from the arm's position
    TOO_FAR = 6
    #: the controller refused a set-point, or left the state in which it accepts them
    REFUSED = 7
    #: the connection to the controller broke, or an answer did not come in time
    CONNECTION = 8
    #: the worker ended because of an internal error
    FAILED = 9
    #: the worker ended without giving a reason
    WORKER_DIED = 10
    #: the program's event loop hung
    HUNG = 11
    #: a set-point would have crossed a limit of the robot's envelope
    ENVELOPE = 12
    #: the worker did not run for too long: it was frozen, or the computer slept
    AWAY = 13
    #: the robot's heartbeat was lost
    LAPSED = 14
