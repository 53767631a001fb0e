"""The words of the shared block: by which the program and the worker tell each other what to do.

Each word has one writer: the program writes `StreamCommand` and `ControlWord`, the worker writes
`StatusWord`.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

__all__ = ["ControlWord", "StatusWord", "StreamCommand", "Unmet"]


class StreamCommand(IntEnum):
    """Commands of the program to the worker; a higher command overrides a lower one.

    Each command is a word of `Block.control`. It is set once and never reset, so two threads that
    send different commands at the same moment cannot undo each other.
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


class ControlWord(IntEnum):
    """Words that the program writes, after those of `StreamCommand`."""

    #: wake the program when no more than this many set-points are in the ring; 0: do not
    WAKE_BELOW = 4
    #: when the program's event loop last gave a sign of life [ns of `boot_time`]
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


class Unmet(IntFlag):
    """Requests of a worker that the system did not allow."""

    TIMER_SLACK = 1
    CPUS = 2
    PRIORITY = 4
    SLICE = 8
