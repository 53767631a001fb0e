"""The simulator to which all connections of a program lead."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.simulator import Simulator


class ProgramSimulator:
    """The simulator that the program runs on: its own, if it starts one, else the preflight's.

    Args:
        make: returns the preflight's simulator, started, when `attach` was called with it.
        attached: called with each simulator that is used.
    """

    def __init__(
        self, make: Callable[[], Simulator], attached: Callable[[Simulator], object]
    ) -> None:
        self._make = make
        self._attached = attached
        self._lock = threading.RLock()
        self.own: Simulator | None = None
        self.simulator: Simulator | None = None
        self.used: bool = False

    def address(self) -> tuple[str, int]:
        """Host and port of the simulator, to which the program's connections lead."""
        with self._lock:
            if self.simulator is None:
                self.own = self._make()
            assert self.simulator is not None
            self.used = True
            return self.simulator.host, self.simulator.port

    def attach(self, simulator: Simulator) -> None:
        """Use a simulator from now on."""
        with self._lock:
            self.simulator = simulator
            self._attached(simulator)

    def ports(self) -> set[int]:
        """The ports of the simulator that is used."""
        # Without the lock: a thread that holds it may be connecting.
        used = self.simulator
        return set() if used is None else {used.port, used.status_port or used.port}

    def close(self) -> None:
        """Close the preflight's simulator, if there is one."""
        if self.own is not None:
            self.own.close()
