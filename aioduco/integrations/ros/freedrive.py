"""Hand guiding while somebody asks for it, as the UR driver's controller of that name.

Guarantees:
- It ends when nobody has asked for it for `timeout`: a dead client leaves no arm free.
- It does not begin while something else uses the arm.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import Robot


_log = BackgroundLogger(__name__)


class Freedrive:
    """Hand guiding of one arm.

    Args:
        robot: the robot, open.
        busy: returns whether something else uses the arm.
        timeout: time without a request after which it ends [s].

    Attributes:
        active: whether the arm may be guided.
    """

    def __init__(self, robot: Robot, *, busy: Callable[[], bool], timeout: float = 1.0) -> None:
        self._robot = robot
        self._busy = busy
        self._timeout = timeout
        self._until = -math.inf
        self._changed = anyio.Event()
        self.active: bool = False

    def take(self, wanted: bool) -> None:
        """Take a request: true begins hand guiding, or keeps it; false ends it."""
        self._until = anyio.current_time() + self._timeout if wanted else -math.inf
        self._changed.set()

    async def run(self) -> None:
        """Serve requests until this is cancelled; hand guiding then ends."""
        while True:
            self._changed = anyio.Event()
            await self._changed.wait()
            if not self._wanted():
                continue
            if self._busy():
                _log.warning("no hand guiding: something else uses the arm")
                continue
            try:
                async with self._robot.motion.teach_mode():
                    self.active = True
                    await self._unwanted()
            except DucoError as error:
                _log.warning("hand guiding: %s", error)
                self._until = -math.inf  # it is to be asked for again
            finally:
                self.active = False

    def _wanted(self) -> bool:
        return anyio.current_time() < self._until

    async def _unwanted(self) -> None:
        """Wait until nobody asks for it any more."""
        while self._wanted():
            self._changed = anyio.Event()
            with anyio.move_on_after(self._until - anyio.current_time()):
                await self._changed.wait()
