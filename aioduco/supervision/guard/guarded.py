"""The guard as one robot sees it: the heartbeat, which goes on without the program's interpreter.

Without the guard, no beats are sent: the heartbeat counts as lost as soon as the guard has ended.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

import anyio

from aioduco._process.platform import boot_time
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import ConnectError, DucoError, GuardLost
from aioduco.models.host_port import host_port
from aioduco.supervision.concurrency import DaemonThread, run_to_completion
from aioduco.supervision.guard.client import GuardLink, shared
from aioduco.supervision.guard.messages import Alive, Beat, Rearm, Release, Watch
from aioduco.supervision.heartbeat import HeartbeatState, HeartbeatStatistics

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.supervision.loop_watchdog import Endings
    from aioduco.supervision.settings import RobotSettings

#: seconds for a guard to start and to connect, on top of the time limits of the connections
_START_LIMIT: Final = 10.0
#: seconds for the guard to release a robot
_RELEASE_LIMIT: Final = 2.0


class GuardClient:
    """One robot's side of the guard, which takes over the heartbeat.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        settings: times and limits.
        lost: called on the event loop if the guard ends before `release`.
        changed: called with this after each report of the heartbeat, on any thread.
    """

    def __init__(
        self,
        host: str,
        port: int,
        settings: RobotSettings,
        lost: Callable[[], None],
        changed: Callable[[GuardClient], object],
    ) -> None:
        self._host = host
        self._port = port
        self._settings = settings
        self._link: GuardLink | None = None
        #: thread that waits for the guard, started before it is needed
        self._thread: DaemonThread | None = None
        self._robot = 0
        self._beat: Beat | None = None
        self._heard_at = 0.0
        #: how often a guard was lost
        self.losses: int = 0
        self._ended = False
        self._on_lost = lost
        self._lost: Callable[[], None] = _ignore
        self._changed = changed

    def __repr__(self) -> str:
        return f"<GuardClient of {host_port(self._host, self._port)} at {self._link!r}>"

    @property
    def alive(self) -> bool:
        """Whether the guard supervises the robot."""
        return self._link is not None and self._link.alive and self._robot != 0

    @property
    def pid(self) -> int | None:
        """The guard's process id; None without a guard."""
        return self._link.pid if self._link is not None else None

    # -- the heartbeat -------------------------------------------------------------------------

    @property
    def state(self) -> HeartbeatState:
        """State of the heartbeat."""
        beat = self._beat
        if beat is None:
            return HeartbeatState.STARTING if not self.losses else HeartbeatState.LOST
        state = HeartbeatState(beat.state)
        if self._ended or state is HeartbeatState.STALLED:
            return state
        return HeartbeatState.LOST if not self.alive or self._silent else state

    @property
    def lapsed(self) -> bool:
        """Whether no beat was sent for so long that the controller has stopped the arm by itself.

        Also False if the guard is silent: it may still send beats.
        """
        return self._beat is not None and self._beat.lapsed and self.alive and not self._silent

    @property
    def _silent(self) -> bool:
        """Whether no report of the heartbeat came for a heartbeat time: the guard hangs."""
        limit = self._settings.heartbeat
        return limit is not None and boot_time() - self._heard_at > limit

    @property
    def sent(self) -> float:
        """When the last beat that was answered was sent [s of `boot_time`]; 0 before."""
        return 0.0 if self._beat is None else self._beat.sent

    @property
    def error(self) -> DucoError | None:
        """Why the last beat was not answered; None if it was."""
        beat = self._beat
        return None if beat is None or not beat.error else GuardLost(beat.error)

    def statistics(self) -> HeartbeatStatistics:
        """Return statistics since this guard took over."""
        beat = self._beat
        if beat is None:
            return HeartbeatStatistics(self.state, 0, 0, self.losses, 0, 0.0)
        losses = beat.losses + self.losses
        return HeartbeatStatistics(
            self.state, beat.beats, beat.missed, losses, beat.stalls, beat.longest_gap
        )

    def start(self) -> None:
        """Do nothing: the guard beats as soon as it supervises the robot."""

    def rearm(self) -> None:
        """Resume the beats after a stall of the event loop."""
        if self._link is not None and self.alive:
            self._link.tell(Rearm(self._robot))

    def end(self) -> None:
        """End the heartbeat; the guard sends the last beat before it releases the robot."""
        self._ended = True

    def join(self, timeout: float) -> None:
        """Return at once: the program does not wait for the guard's thread."""

    def touch(self, stamp: float, moves: bool, modes: Endings) -> bool:
        """Pass on a keep-alive of the event loop, whether the program moves the arm, and its modes.

        Returns:
            Whether the guard will read it, as far as can be known.
        """
        link, robot = self._link, self._robot
        return link is not None and bool(robot) and link.tell(Alive(robot, stamp, moves, modes))

    # -- the guard itself ----------------------------------------------------------------------

    async def acquire(self) -> None:
        """Let the guard supervise the robot; start a guard if there is none.

        Raises:
            GuardLost: it could not be started, or does not answer.
            ConnectError: it cannot connect to the controller.
        """
        self._lost = loop_callback(self._on_lost)
        self._beat = None
        try:
            self._thread = DaemonThread("aioduco-guard-wait")
        except RuntimeError as exc:
            raise GuardLost(f"there is no thread for the guard: {exc}") from exc
        try:
            link, cancelled = await self._thread.run(shared.acquire)
        except BaseException:
            self._thread.end()
            raise
        self._link = link
        if cancelled is not None:
            await run_to_completion(self.release)
            raise cancelled
        robot = link.register(self._heard, self._gone)
        settings = self._settings
        limit = _START_LIMIT + 2 * settings.connect_timeout
        request = partial(
            Watch,
            robot,
            host=self._host,
            port=self._port,
            heartbeat=settings.heartbeat,
            stall_limit=settings.loop_stall_limit,
            connect_timeout=settings.connect_timeout,
            call_timeout=settings.call_timeout,
        )
        error: str | None = None
        try:
            error = await _request(link, request, limit)
        finally:
            self._robot = robot
            if error != "":
                await run_to_completion(self.release)
        if error is None:
            what = f"has ended: {line}" if (line := link.last_stderr_line) else "does not answer"
            raise GuardLost(f"the guard's process was started, but {what}")
        if error:
            raise ConnectError(self._host, self._port, f"the guard could not: {error}")

    def forget(self) -> None:
        """Have the guard release the robot, without waiting for it: no beat follows."""
        if self._link is not None and self._robot:
            self._link.tell(Release(self._robot, 0))  # no request has this token

    async def release(self) -> None:
        """Release the robot: the arm stands, or this program stops it."""
        link, robot = self._link, self._robot
        self._lost = _ignore
        thread, self._thread = self._thread, None
        self._link, self._robot = None, 0
        if link is None or thread is None:
            return
        cancelled: BaseException | None = None
        if robot:
            _, cancelled = await run_to_completion(
                lambda: _request(link, partial(Release, robot), _RELEASE_LIMIT)
            )
            link.unregister(robot)
        _, again = await thread.run(partial(shared.release, link))
        thread.end()
        if (cancelled := again or cancelled) is not None:
            raise cancelled

    # -- what the guard says -------------------------------------------------------------------

    def _heard(self, beat: Beat) -> None:
        self._heard_at = boot_time()
        self._beat = beat
        self._changed(self)

    def _gone(self) -> None:
        self._robot = 0
        self.losses += 1
        self._lost()


async def _request(
    link: GuardLink, request: Callable[[int], Watch | Release], limit: float
) -> str | None:
    """Send a request. Returns its error, "" if it went well, None if no answer came."""
    done = anyio.Event()
    ring = loop_callback(done.set)
    answers: list[str | None] = []

    def answered(error: str | None) -> None:  # on the link's thread
        answers.append(error)
        ring()

    if link.ask(request, answered):
        with anyio.move_on_after(limit):
            await done.wait()
    return answers[0] if answers else None


def _ignore() -> None:
    """Do nothing: the robot was released."""
