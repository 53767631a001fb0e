"""Texts for errors that this computer causes, and not the controller."""

from __future__ import annotations

import errno
from typing import Final

__all__ = ["resource_error"]

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
