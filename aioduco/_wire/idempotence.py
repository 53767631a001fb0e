"""What may be done with a call whose answer did not come: by function of the wire."""

from __future__ import annotations

import enum
from typing import Final


class CallKind(enum.Enum):
    """What a second call of a function would do.

    READ: nothing that the first did not; it may be sent again.
    COMMAND: something more: a second motion, or bytes that are taken from a buffer twice. It
    is never sent again by itself.
    STOP: it acts, but a second one ends no more than the first. It may be sent again.
    """

    READ = "read"
    COMMAND = "command"
    STOP = "stop"

    @property
    def repeatable(self) -> bool:
        """Whether a call may be sent a second time when its answer was lost."""
        return self is not CallKind.COMMAND


#: `abort` is not here: it also drops what others have queued since
_STOPS: Final = frozenset({"stop"})

#: functions that only read although their names do not begin with `get_` or `cal_`
_READS: Final = frozenset(
    {
        "fc_get_ft",
        "fc_mode_is_active",
        "getQueueSize",
        "getRobotIOStatus",
        "getRobotStatus",
        "modbus_read",
        "reach_check",
        "read_bool_reg",
        "read_encoder_count",
        "read_float_reg",
        "read_word_reg",
        "robotmoving",
        # sets nothing but the time until the watchdog acts, to the same value each time
        "rpc_heartbeat",
    }
)


def call_kind(name: str) -> CallKind:
    """The kind of a function of the wire; COMMAND unless it is known to be harmless.

    The functions that read RS-485 and CAN take the bytes out of the controller's buffer, and
    `fc_wait_*` measure from the moment of the call: they are commands.
    """
    if name in _STOPS:
        return CallKind.STOP
    if name in _READS or name.startswith(("get_", "cal_")):
        return CallKind.READ
    return CallKind.COMMAND
