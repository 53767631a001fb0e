"""Hand guiding while somebody asks for it, as the UR driver's controller of that name.

Guarantees:
- It ends when nobody has asked for it for `timeout`: a dead client leaves no arm free.
- It does not begin while something else uses the arm.
- After a stop, requests that go on are ignored until they have ceased, or the arm was recovered.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError
from aioduco.integrations.ros.streamed_commands import StreamedCommands

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import Robot


_log = BackgroundLogger(__name__)


class Freedrive(StreamedCommands):
    """Hand guiding of one arm.

    Args:
        robot: the robot, open.
        busy: returns whether something else uses the arm.
        timeout: time without a request after which it ends [s].

    Attributes:
        following: whether the arm may be guided.
    """

    def __init__(self, robot: Robot, *, busy: Callable[[], bool], timeout: float = 1.0) -> None:
        super().__init__(robot, _log, busy=busy, timeout=timeout, options=None)
        self._asked = False

    def take(self, wanted: bool) -> None:
        """Take a request: true begins hand guiding, or keeps it; false ends it."""
        self._note_command()
        self._blocked = self._blocked and wanted
        self._asked = wanted and not self._blocked
        self._changed.set()

    def _block(self) -> None:
        super()._block()
        self._asked = False
        self._changed.set()

    async def run(self) -> None:
        """Serve requests until this is cancelled; hand guiding then ends."""
        while True:
            self._changed = anyio.Event()
            await self._changed.wait()
            if not self._wanted():
                continue
            if self._busy():
                self._warn("busy", "no hand guiding: something else uses the arm")
                continue
            try:
                async with self._robot.motion.teach_mode():
                    self._opened()
                    await self._unwanted()
            except DucoError as error:
                _log.warning("hand guiding: %s", error)
                self._block()
            finally:
                self._ended()

    def _wanted(self) -> bool:
        return self._asked and anyio.current_time() - self._came < self._timeout

    async def _unwanted(self) -> None:
        """Wait until nobody asks for it any more."""
        while self._wanted():
            self._changed = anyio.Event()
            with anyio.move_on_after(self._came + self._timeout - anyio.current_time()):
                await self._changed.wait()
