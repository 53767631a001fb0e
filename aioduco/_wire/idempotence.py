"""Whether a call may be repeated if its answer does not arrive, by function of the wire."""

from __future__ import annotations

import enum
from typing import Final


class CallKind(enum.Enum):
    """Effect of a second call of a function.

    READ: no additional effect; the call may be sent again.
    COMMAND: an additional effect: a second motion, or more bytes taken from a buffer. The call is
    never repeated automatically.
    STOP: the call acts, but a second one has no additional effect. It may be sent again.
    """

    READ = "read"
    COMMAND = "command"
    STOP = "stop"

    @property
    def repeatable(self) -> bool:
        """Whether a call may be sent a second time if its answer was lost."""
        return self is not CallKind.COMMAND


#: `abort` is not here: it also discards motions that others have queued since
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
        # it only sets the time until the watchdog acts, to the same value each time
        "rpc_heartbeat",
    }
)


def call_kind(name: str) -> CallKind:
    """Return the kind of a function of the wire; COMMAND unless it is known to be harmless.

    The functions that read RS-485 and CAN remove the bytes from the controller's buffer, and
    `fc_wait_*` measure from the moment of the call. So they are commands.
    """
    if name in _STOPS:
        return CallKind.STOP
    if name in _READS or name.startswith(("get_", "cal_")):
        return CallKind.READ
    return CallKind.COMMAND
