"""Stop and heartbeat by the guard, instead of the local ones.

Guarantees:
- A stop is sent to the guard before anything is awaited. If the guard does not confirm it at once,
  it is also sent over the local lanes: stop is safe to repeat.
- Without the guard, no beats are sent: the heartbeat counts as lost as soon as the guard has ended.
"""

from __future__ import annotations

import time
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final

import anyio

from aioduco._process.platform import boot_time
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import ConnectError, DucoError, GuardLost
from aioduco.supervision.concurrency import DaemonThread, run_to_completion
from aioduco.supervision.guard.client import Answer, GuardLink, GuardListener, shared
from aioduco.supervision.guard.messages import Alive, Beat, Rearm, Release, Stop, Watch
from aioduco.supervision.heartbeat import HeartbeatState, HeartbeatStatistics
from aioduco.supervision.loop_watchdog import SignOfLife
from aioduco.supervision.stop_channel import StopChannel

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.lane import WireLane
    from aioduco.supervision.settings import RobotSettings
    from aioduco.supervision.stop_channel import ByGuard

#: seconds after which a stop that the guard has not confirmed is also sent over the local lanes
CONFIRM_LIMIT: Final = 0.1
#: seconds for a guard to start and to connect, on top of the time limits of the connections
_START_LIMIT: Final = 10.0
#: seconds for the guard to release a robot
_RELEASE_LIMIT: Final = 2.0


class GuardClient:
    """One robot's side of the guard, which takes over stop and heartbeat.

    Args:
        host: name or address of the controller.
        port: its TCP port.
        settings: times and limits.
    """

    def __init__(self, host: str, port: int, settings: RobotSettings) -> None:
        self._host = host
        self._port = port
        self._settings = settings
        self._link: GuardLink | None = None
        #: thread that waits for the guard, started before it is needed
        self._thread: DaemonThread | None = None
        self._robot = 0
        self._beat: Beat | None = None
        self._heard_at = 0.0
        self._losses = 0
        self._lost: Callable[[], None] = _ignore
        self._beaten: Callable[[Beat], object] = _ignore_beat

    def __repr__(self) -> str:
        return f"<GuardClient of {self._host}:{self._port} at {self._link!r}>"

    @property
    def alive(self) -> bool:
        """Whether the guard supervises the robot."""
        return self._link is not None and self._link.alive and self._robot != 0

    @property
    def pid(self) -> int | None:
        """The guard's process id; None without a guard."""
        return self._link.pid if self._link is not None else None

    @property
    def beat(self) -> Beat | None:
        """The last report of the heartbeat."""
        return self._beat

    @property
    def silent(self) -> bool:
        """Whether no report of the heartbeat came for a heartbeat time: the guard hangs."""
        limit = self._settings.heartbeat
        return limit is not None and boot_time() - self._heard_at > limit

    @property
    def lapsed(self) -> bool:
        """Whether the guard sent no beat for so long that the controller has stopped the arm."""
        return self._beat is not None and self._beat.lapsed

    @property
    def losses(self) -> int:
        """How often a guard was lost."""
        return self._losses

    async def acquire(self, lost: Callable[[], None], beaten: Callable[[Beat], object]) -> None:
        """Let the guard supervise the robot; start a guard if there is none.

        Args:
            lost: called on the event loop if the guard ends before `release`.
            beaten: called with each report of the heartbeat, on any thread.

        Raises:
            GuardLost: it could not be started, or does not answer.
            ConnectError: it cannot connect to the controller.
        """
        self._lost = loop_callback(lost)
        self._beaten = beaten
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
        robot = link.register(GuardListener(self._heard, self._gone))
        settings = self._settings
        limit = _START_LIMIT + 2 * settings.connect_timeout

        def request(token: int) -> Watch:
            return Watch(
                robot,
                token,
                self._host,
                self._port,
                settings.heartbeat,
                settings.loop_stall_limit,
                settings.connect_timeout,
                settings.call_timeout,
            )

        error: str | None = None
        try:
            error = await self._request(link, request, limit)
        finally:
            self._robot = robot
            if error != "":
                await run_to_completion(self.release)
        if error is None:
            what = f"has ended: {line}" if (line := link.last_stderr_line) else "does not answer"
            raise GuardLost(f"the guard's process was started, but {what}")
        if error:
            raise ConnectError(self._host, self._port, f"the guard could not: {error}")

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
            _, cancelled = await run_to_completion(lambda: self._released(link, robot))
            link.unregister(robot)
        _, again = await thread.run(partial(shared.release, link))
        thread.end()
        if (cancelled := again or cancelled) is not None:
            raise cancelled

    async def _released(self, link: GuardLink, robot: int) -> None:
        await self._request(link, lambda token: Release(robot, token), _RELEASE_LIMIT)

    def touch(self, stamp: float, moves: bool) -> bool:
        """Pass on a sign of life of the event loop, and whether the program moves the arm.

        Returns:
            Whether the guard will read it, as far as can be known.
        """
        link, robot = self._link, self._robot
        if link is None or not robot:
            return False
        return link.tell(Alive(robot, stamp, moves))

    def rearm(self) -> None:
        """Let the guard send beats again after a stall."""
        if self.alive:
            assert self._link is not None
            self._link.tell(Rearm(self._robot))

    def stop(self, timeout: float, notify: Callable[[], None], *, at_once: bool) -> Answer | None:
        """Send a stop by the guard, from any thread. Returns None if there is no guard.

        Args:
            timeout: seconds after which the guard must not send it any more.
            notify: called when the answer is there.
            at_once: whether to send it now, even while stops are collected.
        """
        link, robot = self._link, self._robot
        if link is None or not robot:
            return None
        answer = Answer(notify)
        until = time.monotonic() + timeout
        sent = link.ask(lambda token: Stop([robot], [token], until), answer, at_once=at_once)
        return answer if sent else None

    async def _request(
        self, link: GuardLink, request: Callable[[int], Watch | Release], limit: float
    ) -> str | None:
        """Send a request. Returns its error, "" if it went well, None if no answer came."""
        done = anyio.Event()
        answer = Answer(loop_callback(done.set))
        if not link.ask(request, answer):
            return None
        with anyio.move_on_after(limit):
            await done.wait()
        return answer.error if answer.given and not answer.lost else None

    def _heard(self, beat: Beat) -> None:
        self._heard_at = boot_time()
        self._beat = beat
        self._beaten(beat)

    def _gone(self) -> None:
        self._robot = 0
        self._losses += 1
        self._lost()


class GuardedStopChannel(StopChannel):
    """Stops by the guard, and by the local lanes if the guard does not confirm at once.

    Args:
        client: the robot's side of the guard.
        stop: local lane for stops alone.
        others: lane for pause, resume and abort.
        watch: lane for polls whether the arm moves.
    """

    attempts: int

    def __init__(
        self, client: GuardClient, stop: WireLane, others: WireLane, watch: WireLane
    ) -> None:
        super().__init__(stop, others, watch)
        self._client = client

    def _ask_guard(self, timeout: float) -> ByGuard | None:
        """Send a stop to the guard at once, or with the stops that are being collected."""
        begin = time.monotonic()
        done = anyio.Event()
        # No longer than this waits for it: a stop after that of the local lanes would end motions
        # that were sent since.
        timeout = min(CONFIRM_LIMIT, timeout)
        answer = self._request_stop(timeout, loop_callback(done.set), at_once=False)
        if answer is None:
            return None

        async def by_guard() -> bool:
            with anyio.move_on_after(begin + timeout - time.monotonic()):
                await done.wait()
            return self._confirmed(answer, begin)

        return by_guard

    def _by_guard_now(self, timeout: float) -> bool:
        begin = time.monotonic()
        done: SimpleQueue[None] = SimpleQueue()
        timeout = min(CONFIRM_LIMIT, timeout)
        answer = self._request_stop(timeout, lambda: done.put(None), at_once=True)
        if answer is None:
            return False
        try:
            done.get(timeout=timeout)
        except Empty:
            return False
        return self._confirmed(answer, begin)

    def _confirmed(self, answer: Answer, begin: float) -> bool:
        """Whether the controller accepted the guard's stop; if so, report it to the observers."""
        confirmed = answer.given and not answer.error
        if confirmed:
            self._stop.report("stop", (False,), None, None, begin)
        return confirmed

    def _request_stop(
        self, timeout: float, notify: Callable[[], None], *, at_once: bool
    ) -> Answer | None:
        answer = self._client.stop(timeout, notify, at_once=at_once)
        self.attempts += answer is not None
        return answer


class GuardedSignOfLife(SignOfLife):
    """Passes the event loop's signs of life on to the guard."""

    __slots__ = ("_client",)

    def __init__(self, client: GuardClient) -> None:
        super().__init__()
        self._client = client

    def touch(self, due: float, *, counts: bool = True) -> None:
        """Note that the loop runs; `SignOfLife.touch` describes it."""
        super().touch(due, counts=counts)
        self._client.touch(self.stamp, self.moves)

    def set_moves(self, moves: bool) -> bool:
        """Set whether the program may move the arm from now on. Returns whether it was sent."""
        self.moves = moves
        return self._client.touch(self.stamp, moves)


class GuardedHeartbeat:
    """The program's view of the heartbeat that the guard sends."""

    def __init__(self, client: GuardClient) -> None:
        self._client = client
        self._ended = False

    def __repr__(self) -> str:
        return f"<GuardedHeartbeat {self.state.value}>"

    @property
    def state(self) -> HeartbeatState:
        """State of the heartbeat."""
        beat = self._client.beat
        if beat is None:
            return HeartbeatState.STARTING if not self._client.losses else HeartbeatState.LOST
        state = beat.heartbeat_state
        if self._ended or state is HeartbeatState.STALLED:
            return state
        return HeartbeatState.LOST if not self._client.alive or self._client.silent else state

    @property
    def answered(self) -> bool:
        """Whether a beat was answered, and no later one was lost."""
        return self.state is HeartbeatState.BEATING

    @property
    def lapsed(self) -> bool:
        """Whether no beat was sent for so long that the controller has stopped the arm by itself.

        Also False if the guard is silent: it may still send beats.
        """
        return self._client.alive and not self._client.silent and self._client.lapsed

    @property
    def error(self) -> DucoError | None:
        """Why the last beat was not answered; None if it was."""
        beat = self._client.beat
        if beat is None or not beat.error:
            return None
        return GuardLost(beat.error)

    def statistics(self) -> HeartbeatStatistics:
        """Return statistics since this guard took over."""
        beat = self._client.beat
        if beat is None:
            return HeartbeatStatistics(self.state, 0, 0, self._client.losses, 0, 0.0)
        return HeartbeatStatistics(
            self.state,
            beat.beats,
            beat.missed,
            beat.losses + self._client.losses,
            beat.stalls,
            beat.longest_gap,
        )

    def start(self) -> None:
        """Do nothing: the guard beats as soon as it supervises the robot."""

    def rearm(self) -> None:
        """Resume the beats after a stall of the event loop."""
        self._client.rearm()

    def end(self) -> None:
        """End the heartbeat; the guard sends the last beat before it releases the robot."""
        self._ended = True

    def join(self, timeout: float) -> bool:  # noqa: ARG002  # signature of the local one
        """Return at once: the program does not wait for the guard's thread."""
        return True


def _ignore() -> None:
    """Do nothing: the robot was released."""


def _ignore_beat(beat: Beat) -> None:
    """Do nothing: no guard supervises the robot yet."""
