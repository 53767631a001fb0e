"""The watchdog behind rpc_heartbeat (manual 1.3.1)."""

from __future__ import annotations

#: what a controller takes, in milliseconds; anything else is moved to the nearer end
SHORTEST, LONGEST = 200, 60_000


class Heartbeat:
    """Notices that the beats have stopped. Armed by the first beat, disarmed by the loss.

    Times are those of the network, not of the simulation: a client beats by its own clock,
    however fast simulated time goes.
    """

    def __init__(self) -> None:
        self._deadline: float | None = None
        self.time: int = 0

    @property
    def armed(self) -> bool:
        """Whether a missing beat would be noticed."""
        return self._deadline is not None

    def beat(self, now: float, time: int) -> None:
        """A client is alive, and promises the next beat within `time` milliseconds."""
        self.time = min(max(time, SHORTEST), LONGEST)
        self._deadline = now + self.time / 1000.0

    def disarm(self) -> None:
        """Forget the promise."""
        self._deadline = None

    def lost(self, now: float) -> bool:
        """Whether the promise was broken; said once."""
        if self._deadline is None or now <= self._deadline:
            return False
        self._deadline = None
        return True
