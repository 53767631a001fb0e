"""Waking a thread that waits, so that an interrupt of either side leaves it whole.

`threading.Event` has a lock that an interrupt of `set` may leave held: Ctrl-C raises between any
two instructions of the main thread. Each later `set` would then wait for that lock for ever; and a
stop, or the closing of a robot, which an interrupt only makes begin anew, would hang in it, however
often Ctrl-C is pressed. `queue.SimpleQueue` has no such lock, but before Python 3.13 its `get`
loses its limit if a signal's handler returns after the timeout.
"""

from __future__ import annotations

import contextlib
import threading


class Wakeup:
    """Wakes one thread; one that does not wait yet is woken when it will."""

    def __init__(self) -> None:
        self._unset = threading.Lock()  # held until it is set
        self._unset.acquire()

    def set(self) -> None:
        """Wake the thread; from any thread or signal handler, without waiting."""
        if self._unset.locked():
            with contextlib.suppress(RuntimeError):  # another thread was faster
                self._unset.release()

    def wait(self, timeout: float) -> bool:
        """Wait until this is set, and make it ready to be set again.

        Args:
            timeout: seconds to wait at most.

        Returns:
            Whether it was set.
        """
        return self._unset.acquire(timeout=max(timeout, 0.0))
