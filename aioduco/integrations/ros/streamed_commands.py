"""When commands that arrive as a stream may be followed: of joints, of speeds, for hand guiding.

Guarantee: after a stop, further commands are ignored. They are followed again only after they have
ceased, or after the arm was brought up or recovered. So are commands that go on as the driver
starts: it may have died while it followed them. Time in which the driver itself stood still is no
time in which they ceased.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import anyio

from aioduco._process.reporting import BackgroundLogger
from aioduco.errors import DucoError
from aioduco.supervision.concurrency import Silence, every

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco import Robot, WorkerOptions


_LOOK = 0.1  # seconds between two checks at most whether commands have ceased
_AGAIN = 2.0  # seconds before a warning of the same kind is logged again
_log = BackgroundLogger(__name__)


class StreamedCommands:
    """Commands for one arm, followed by a stream that is open while they arrive.

    Args:
        robot: the robot, open.
        log: the logger for refused commands.
        busy: returns whether something else uses the arm, such as a trajectory goal.
        timeout: time without commands after which the stream ends [s].
        options: options of the stream; None: in a separate process.

    Attributes:
        following: whether the stream is open.
    """

    def __init__(
        self,
        robot: Robot,
        log: BackgroundLogger,
        *,
        busy: Callable[[], bool],
        timeout: float,
        options: WorkerOptions | None,
    ) -> None:
        self._robot = robot
        self._busy = busy
        self._timeout = timeout
        self._options = options
        self.following: bool = False
        self._came = -math.inf
        self._ceased = False
        self._blocked = True
        self._changed = anyio.Event()
        self._log = log
        self._said: dict[str, float] = {}

    async def watch(self) -> None:
        """Notice when commands have ceased, until this is cancelled."""
        period = min(_LOOK, self._timeout / 4.0)
        silence = Silence(period)
        async for _ in every(period):
            if silence.look(anyio.current_time(), self._came) > self._timeout:
                self._ceased, self._blocked = True, False

    def _opened(self) -> None:
        """Note that the stream is open."""
        self.following = True

    def _ended(self) -> None:
        """Note that the stream has ended, so that the arm is free."""
        self.following = False

    def allow(self) -> None:
        """Accept commands again: the arm was brought up or recovered."""
        self._blocked = False

    def ignore(self) -> None:
        """Ignore the commands that arrive at present: the arm is stopped or paused."""
        if not self._ceased:
            self._block()

    def leave(self) -> None:
        """The driver serves no more: if it does again, commands that go on then are ignored."""
        self._block()

    def _block(self) -> None:
        """Ignore commands until they cease, those that are not followed yet, too."""
        self._note_command()
        self._blocked = True

    def _refused(self) -> bool:
        """Whether commands are ignored at present, which is logged then."""
        if self._blocked:
            self._warn("blocked", "commands are ignored until they cease, or a recovery")
        return self._blocked

    def _note_command(self) -> float:
        """Note that a command has come; return when [s]."""
        self._came, self._ceased = anyio.current_time(), False
        return self._came

    def _warn(self, kind: str, text: str, *values: object) -> None:
        """Log a warning that may come with every message, unless one of its kind was just now."""
        now = anyio.current_time()
        if now - self._said.get(kind, -math.inf) > _AGAIN:
            self._said[kind] = now
            self._log.warning(text, *values)


class Freedrive(StreamedCommands):
    """Hand guiding while somebody asks for it, as the UR driver's controller of that name.

    It ends when nobody has asked for it for `timeout`: a dead client leaves no arm free. It does
    not begin while something else uses the arm.

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
        self._asked = wanted and not self._refused()
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
