"""Waking a thread that waits, so that an interrupt of either side leaves it whole.

`threading.Event` has a lock that an interrupt of `set` may leave held: Ctrl-C raises between any
two instructions of the main thread. Each later `set` would then wait for that lock for ever; and a
stop, or the closing of a robot, which an interrupt only makes begin anew, would hang in it, however
often Ctrl-C is pressed.
"""

from __future__ import annotations

from queue import Empty, SimpleQueue


class Wakeup:
    """Wakes one thread; one that does not wait yet is woken when it will."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[None] = SimpleQueue()

    def set(self) -> None:
        """Wake the thread; from any thread or signal handler, without waiting."""
        self._queue.put(None)

    def wait(self, timeout: float) -> bool:
        """Wait until this is set, each time it is.

        Args:
            timeout: seconds to wait at most.

        Returns:
            Whether it was set.
        """
        try:
            self._queue.get(timeout=timeout)
        except Empty:
            return False
        return True
