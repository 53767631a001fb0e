"""Requests to the system's scheduler."""

from __future__ import annotations

import os
import struct
import sys

__all__ = ["shorten_slice"]

#: number of the system call sched_setattr, by machine; glibc has a name for it only from 2.41 on
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274, "riscv64": 274, "armv7l": 380}
#: size, policy, flags, nice, priority, runtime, deadline, period
_ATTRIBUTES = struct.Struct("=IIQiIQQQ")


def shorten_slice(nanoseconds: int) -> bool:
    """Ask the system to give the calling thread short slices of a processor, but soon.

    A thread that wakes up to work for a moment then goes before one that has been working for
    milliseconds, such as the program's own loop, instead of waiting for the end of its slice. It
    gets no more of the processor by this, so no permission is needed. Linux does it since 6.12;
    earlier versions ignore it. A thread that runs under another policy keeps it: one for real time,
    such as under `chrt`, goes before others anyway, and has no slices of such a length.

    Args:
        nanoseconds: the length of a slice, 100 µs to 100 ms.

    Returns:
        Whether the system took it, or the thread runs under a policy for real time.
    """
    # imported here: only a worker needs it
    import ctypes  # noqa: PLC0415

    if sys.platform != "linux" or not hasattr(os, "SCHED_OTHER"):
        return False
    number = _SCHED_SETATTR.get(os.uname().machine)
    if number is None:
        return False
    policy = os.sched_getscheduler(0)
    if policy != os.SCHED_OTHER:
        return policy in (os.SCHED_FIFO, os.SCHED_RR)
    attributes = _ATTRIBUTES.pack(
        _ATTRIBUTES.size, os.SCHED_OTHER, 0, os.nice(0), 0, nanoseconds, 0, 0
    )
    return bool(ctypes.CDLL(None).syscall(number, 0, attributes, 0) == 0)
