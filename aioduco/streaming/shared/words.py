"""What the program and the worker tell each other in the shared block: words, and their values.

Each word has one writer: the program writes `ControlWord`, the worker writes `StatusWord`.
"""

from __future__ import annotations

import struct
from enum import IntEnum, IntFlag
from typing import NamedTuple

from aioduco.models.named_int import NamedInt

_TAG = struct.Struct("<QQII")


class StreamState(NamedInt):
    """State of a stream."""

    WAITING = 0
    FOLLOWING = 1
    HOLDING = 2
    DECELERATING = 3
    ENDED = 4


class Reason(NamedInt):
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


class ControlWord(IntEnum):
    """Words that the program writes.

    The first four are commands; a higher one overrides a lower one. A command is set once and never
    reset, so two threads that give different commands at the same moment cannot undo each other.
    """

    #: follow all set-points that were sent, then end
    CLOSE = 0
    #: come to rest at once, then end
    ABORT = 1
    #: send nothing more, from now on: another one stops the robot
    HALT = 2
    #: send nothing more, from now on, and stop the robot: the permit has ended, and nobody else
    #: stops it for certain; the value is the `Reason`
    WITHDRAW = 3
    #: wake the program when no more than this many set-points are in the ring; 0: do not
    WAKE_BELOW = 4
    #: when the program's event loop last sent a keep-alive [ns of `boot_time`]
    ALIVE = 5
    #: until then the controller does not stop the arm for want of a heartbeat [ns of `boot_time`]
    LEASE = 6


class StatusWord(IntEnum):
    """Words that the worker writes."""

    #: the worker is connected and runs
    READY = 0
    STATE = 1
    REASON = 2
    TICKS = 3
    SENT = 4
    MISSED = 5
    STARVED = 6
    LIMITED = 7
    OVERWRITTEN = 8
    #: points in the controller's queue at the last poll
    DEPTH = 9
    #: how often the controller's queue was found empty
    DRAINED = 10
    #: number of the last set-point taken
    TAKEN = 11
    #: monotonic time of the last tick [ns]
    BEAT = 12
    #: length of the text that says why the stream ended
    TEXT = 13
    #: peak size of the worker's process [kB]
    MEMORY = 14
    #: requests that the system did not allow: flags of `Unmet`
    UNMET = 15
    #: whether the worker waits until an unanswered set-point cannot move the arm any more
    UNANSWERED = 16
    #: chunks of actions: taken, of these late and dropped; actions that came too late; how often
    #: the actions ran out
    CHUNKS = 17
    CHUNKS_LATE = 18
    CHUNKS_DROPPED = 19
    ACTIONS_LATE = 20
    EXHAUSTED = 21
    #: the worker's real-time priority
    PRIORITY = 22
    #: whether the controller's mode of the stream may be on, or its points in the track pool
    MODE = 23
    #: whether the worker could not bring the arm to rest, as far as it knows
    UNSTOPPED = 24


class Unmet(IntFlag):
    """Requests of a worker that the system did not allow."""

    TIMER_SLACK = 1
    CPUS = 2
    PRIORITY = 4
    SLICE = 8


class ActionTag(NamedTuple):
    """The chunk to which an action belongs, and its position there.

    Attributes:
        chunk: running number of the chunk, from 1.
        begin: monotonic time at which its first action is due [ns]; 0: when the worker takes it.
        position: number of this action in the chunk, from 0.
        total: actions in the chunk.
    """

    chunk: int
    begin: int
    position: int
    total: int

    @staticmethod
    def size() -> int:
        """Number of bytes of a packed tag."""
        return _TAG.size

    def pack(self) -> bytes:
        """Encode it for the ring."""
        return _TAG.pack(*self)

    @classmethod
    def unpack(cls, data: bytes) -> ActionTag:
        """Decode the result of `pack`."""
        return cls(*_TAG.unpack(data))
