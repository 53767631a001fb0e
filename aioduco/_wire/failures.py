"""What becomes of a call whose connection failed: without socket, thread or clock.

`EOFError` stands for a connection that the other side closed, or that was given up.
"""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING, Final

from aioduco._wire.framing import Malformed
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import Progress
from aioduco.errors import (
    CallTimeout,
    ConnectError,
    ConnectionLost,
    DucoError,
    NotSent,
    OutcomeUnknown,
    ProtocolError,
    WrongProcess,
)

if TYPE_CHECKING:
    from aioduco._wire.idl import Function


#: resources that this computer refuses
_WORDS: Final = {
    errno.EMFILE: "this process has no file descriptor left (EMFILE); close some, or raise its "
    "limit (ulimit -n)",
    errno.ENFILE: "this computer has no file descriptor left (ENFILE)",
    errno.ENOBUFS: "this computer has no memory left for sockets (ENOBUFS)",
    errno.ENOMEM: "this computer has no memory left (ENOMEM)",
    errno.EAGAIN: "this computer gives this user no more processes or memory (EAGAIN)",
    errno.EACCES: "this computer does not permit it (EACCES)",
    errno.EPERM: "this computer does not permit it (EPERM)",
}


class DeadlinePassed(Exception):
    """The deadline of an operation has passed."""


def is_failure(exc: BaseException) -> bool:
    """Whether a connection failed by this; else a signal handler raised it, as for Ctrl-C."""
    if isinstance(exc, DeadlinePassed | DucoError | EOFError | Malformed | MemoryError):
        return True
    return isinstance(exc, OSError) and exc.errno is not None


def reason_of(exc: BaseException, progress: Progress) -> str:
    """Return in words why a connection failed during a call with this progress."""
    if not is_failure(exc):
        return f"it was interrupted ({type(exc).__name__})"
    match exc:
        case DeadlinePassed():
            unsent = progress is Progress.NOTHING_SENT
            return "the system did not take it in time" if unsent else "no answer came in time"
        case EOFError():
            return "the controller closed the connection"
        case OSError():
            return f"the connection broke ({exc.strerror or exc})"
        case Malformed():
            return f"something else than its answer came: {exc}"
    return f"its answer could not be read ({type(exc).__name__}: {exc})"


def failure(
    function: Function, progress: Progress, exc: BaseException, reason: str
) -> ConnectionLost:
    """Return the error for the caller of a call whose connection failed.

    Args:
        function: the function that was called.
        progress: progress of the call.
        exc: how the connection failed.
        reason: the same in words, from `reason_of`, or why the connection was given up.
    """
    name, late = function.name, isinstance(exc, DeadlinePassed)
    if progress is Progress.NOTHING_SENT:
        return (NotSent if late else ConnectionLost)(f"{name} was not sent, since {reason}")
    if call_kind(name) is not CallKind.READ:
        return OutcomeUnknown(name, reason)
    if late:
        return CallTimeout(f"{name}: {reason}; the connection was closed")
    if isinstance(exc, EOFError | OSError):
        return ConnectionLost(f"{name}: {reason}; it only reads, so it may be called again")
    return ProtocolError(f"{name}: {reason}; the connection was closed")


def may_send_again(function: Function, progress: Progress) -> bool:
    """Whether a call with this progress on a broken connection may be sent on another one."""
    if progress is Progress.NOTHING_SENT:
        return True
    if progress is Progress.SENT:
        return call_kind(function.name).repeatable
    # an incomplete answer shows that the call was received; only a stop is repeated to be sure
    return call_kind(function.name) is CallKind.STOP


def of_two(first: ConnectionLost | None, second: BaseException) -> BaseException:
    """Return the error of a call that was sent again: of the two, the one that says more.

    A stop may have been sent the first time although it was not sent the second time.
    """
    unsent = isinstance(second, ConnectError | ConnectionLost | WrongProcess)
    if isinstance(first, OutcomeUnknown) and unsent and not isinstance(second, OutcomeUnknown):
        first.__cause__ = second
        return first
    return second


def resource_error(error: BaseException | None) -> str:
    """Describe the resource that this computer refused; "" if the error has another cause.

    Args:
        error: the error; its causes are searched too.
    """
    while error is not None:
        if isinstance(error, OSError) and error.errno in _WORDS:
            return _WORDS[error.errno]
        # Python sets no errno here, only this text.
        if isinstance(error, RuntimeError) and "start new thread" in str(error):
            return "this process can start no more threads"
        error = error.__cause__
    return ""
