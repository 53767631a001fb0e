"""Requests to the system's scheduler."""

from __future__ import annotations

import os
import struct
import sys

#: number of the system call sched_setattr, by machine; glibc has a name for it only from 2.41 on
_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274, "riscv64": 274, "armv7l": 380}
#: size, policy, flags, nice, priority, runtime, deadline, period
_ATTRIBUTES = struct.Struct("=IIQiIQQQ")


def shorten_slice(nanoseconds: int) -> bool:
    """Ask the system to give the calling thread short time slices, but soon.

    A thread that wakes up for a short piece of work then runs before a thread that has been working
    for milliseconds, such as the program's own loop, instead of waiting for the end of its slice.
    It gets no larger share of the processor, so it needs no permission. Linux does this since 6.12;
    earlier versions ignore it. A thread under another policy keeps that policy: a real-time thread,
    such as one under `chrt`, runs before others anyway, and has no slices of such a length.

    Args:
        nanoseconds: length of a slice [ns], 100 µs to 100 ms.

    Returns:
        Whether the system accepted it, or the thread runs under a real-time policy.
    """
    # imported here: only the processes of this package need it
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
