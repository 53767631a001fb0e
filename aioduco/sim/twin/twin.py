"""A twin beside a robot: it observes the robot, and a process of its own compares.

Guarantees:
- Nothing of the robot waits for the twin: samples and calls are queued for a thread that sends
  them. If the process is too slow, further ones are dropped and counted.
- The twin commands the arm in one case alone: by the action that the program chose, `Robot.pause`
  or `Robot.stop`.
- A failure ends the twin, and nothing else: it is in `error`, and it is logged.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, Self, TypeAlias, get_args

import anyio

from aioduco._process.copying import Uncopied
from aioduco._process.linked_process import LinkedProcess
from aioduco._process.reporting import BackgroundLogger
from aioduco._process.spawn import MUJOCO_PACKAGES, Unstartable
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import DucoError, ParameterError, RobotStateError
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.catalogue import arm_named, model_named
from aioduco.kinematics.mounting import base_in_world, gravity
from aioduco.models.pose import Pose
from aioduco.models.rules import Flag
from aioduco.models.trace import CallFinished, TraceEvent
from aioduco.models.words import one_of
from aioduco.sim.twin.data import Divergence, TwinCommand, TwinSample
from aioduco.sim.twin.limits import TwinLimits
from aioduco.sim.twin.monitor import TwinFigures
from aioduco.sim.twin.rehearsal import PATHS
from aioduco.sim.twin.worker import Begin, TwinUpdate
from aioduco.supervision.concurrency import BackgroundTasks, DaemonThread, run_to_completion
from aioduco.supervision.events import TwinDiverged

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics.mounting import MountingLike
    from aioduco.supervision.supervisor import Supervisor


_log = BackgroundLogger(__name__)

_COMMANDS = Flag(source="this package")

TwinAction: TypeAlias = Literal["report", "pause", "stop"]

#: largest number of samples and calls that wait for the process
_MOST: Final = 500
#: time-outs: of a read of the controller's settings, and until the process is ready [s]
_ASK, _START = 0.5, 60.0
#: time for the process to exit [s]
_END: Final = 5.0
#: beginnings of functions that only read, or that the twin does not use: they are not sent to it
_READS = ("get", "read_", "rpc_heartbeat", "robotmoving", "cal_", "reach_check", "log_info")


class TwinStatistics(NamedTuple):
    """Figures of a twin since its start.

    Attributes:
        samples: samples that were compared.
        dropped: samples and calls that were not, because the twin was too slow.
        divergences: how often the arm and its twin have parted.
        processor: processor time of the twin's process, as a share of one processor.
    """

    samples: int
    dropped: int
    divergences: int
    processor: float


class Twin(Uncopied):
    """A simulated arm beside a real one: `Robot.twin` makes it, `async with` or `start` begins it.

    Attributes:
        figures: the newest differences.
        joints: where the arm should be [rad]; None before the first sample. Shape (6,).
        divergences: the last hundred divergences, oldest first.
        over: whether it has ended.
        error: why it ended by itself; None if it did not.
        limits: the limits; None before the start, if none were given.
    """

    def __init__(
        self,
        supervisor: Supervisor,
        tell: Callable[[str, float, dict[str, Any]], object],
        limits: TwinLimits | None,
        action: TwinAction,
        arm: str | None,
        mounting: MountingLike | None,
        commands: bool,
    ) -> None:
        one_of("action", action, get_args(TwinAction))
        if limits is not None and not isinstance(limits, TwinLimits):
            raise ParameterError("limits", limits, "a TwinLimits, or None")
        self._supervisor = supervisor
        self._tell = tell
        self.limits: TwinLimits | None = limits
        self._action = action
        self._model = None if arm is None else arm_of(arm).name
        self._mounting: MountingLike = "floor" if mounting is None else mounting
        gravity(self._mounting)  # refuses what is no mounting
        self._commands = _COMMANDS("commands", commands)
        self._queue: SimpleQueue[object] = SimpleQueue()
        self._received: deque[TwinUpdate | Exception] = deque()
        self._linked: LinkedProcess | None = None
        self._background = BackgroundTasks(self._crashed)
        self._undo: list[Callable[[], object]] = []
        self._started_at = 0.0
        self._started = self._starting = False
        self.over: bool = False
        self._samples = self._dropped = self._count = 0
        self._busy = 0.0
        self._sampled = anyio.Event()
        self.figures: TwinFigures = TwinFigures()
        self.joints: tuple[float, ...] | None = None
        self.divergences: deque[TwinDiverged] = deque(maxlen=100)
        self.error: Exception | None = None

    def __repr__(self) -> str:
        state = "running" if self.running else "ended" if self._started else "not started"
        return f"<Twin {state}, {self._count} divergences>"

    @property
    def running(self) -> bool:
        """Whether it compares."""
        return self._started and not self.over

    def statistics(self) -> TwinStatistics:
        """Figures since the start."""
        passed = max(time.monotonic() - self._started_at, 1e-3)
        share = self._busy / passed if self._started else 0.0
        return TwinStatistics(self._samples, self._dropped, self._count, share)

    async def start(self) -> Self:
        """Start the process, and compare from now on.

        Raises:
            RobotStateError: the robot is not open, this was started before, the controller does not
                report which arm it has, or the process cannot be started.
            ParameterError: the limits are of another arm.
        """
        self._supervisor.check_open("twin")
        if self._started or self._starting:
            raise RobotStateError("a twin is started once; make another one")
        self._starting = True
        try:
            begin = await self._settings()
            self.limits = begin.limits
            thread = DaemonThread("aioduco-twin-start")
            try:
                link, cancelled = await thread.run(lambda: _process(begin))
            finally:
                thread.end()
        finally:
            self._starting = False
        self._linked, self._started, self._started_at = link, True, time.monotonic()
        if cancelled is not None:
            await self.stop()
            raise cancelled
        ring = loop_callback(self._take)
        for name, work in (
            ("send", lambda: _send(link, self._queue)),
            ("receive", lambda: _receive(link, self._received, ring)),
        ):
            threading.Thread(target=work, name=f"aioduco-twin-{name}", daemon=True).start()
        self._begin()
        try:
            # A sample before the first motion, if one comes: the rehearsal begins where the arm
            # stands.
            with anyio.move_on_after(_ASK):
                await self._sampled.wait()
        except BaseException:
            await self.stop()
            raise
        return self

    async def stop(self) -> None:
        """End the process. A failure is logged and not raised; it is in `error`.

        In a forked child it does nothing.
        """
        if not self._started or self._supervisor.owner_loop.in_forked_child:
            return
        _, cancelled = await run_to_completion(self._stop)
        if cancelled is not None:
            raise cancelled

    async def __aenter__(self) -> Self:
        return await self.start()

    async def __aexit__(self, *_: object) -> None:
        await self.stop()

    async def _stop(self) -> None:
        self._detach()
        await self._background.aclose()
        linked, self._linked = self._linked, None
        self._queue.put(None)
        if linked is not None:
            thread = DaemonThread("aioduco-twin-end")
            try:
                await thread.run(linked.close)
            finally:
                thread.end()

    def _crashed(self, error: BaseException) -> None:
        self._fail(error if isinstance(error, Exception) else RuntimeError(repr(error)))

    def _fail(self, error: Exception) -> None:
        if not self.over:
            self.error = error
            _log.error("the twin ended early: %r", error)
            self._detach()

    # -- observing -----------------------------------------------------------------------------

    async def _settings(self) -> Begin:
        """Read from the controller what the twin begins with."""

        async def ask(function: str) -> Any:
            try:
                return await self._supervisor.poll.call(function, (), _ASK)
            except DucoError:
                return []  # some controllers do not have the function

        if self._model is None:
            told = arm_named(map(str, await ask("get_robot_type")))
            if (known := model_named(told)) is None:
                raise RobotStateError(
                    f"the controller reports {told or 'no arm'}, which is not known here: give "
                    '`arm`, such as "gcr5_910". Nothing was started'
                )
            self._model = known.name
        limits = TwinLimits.of(arm_of(self._model)) if self.limits is None else self.limits
        if limits.arm != self._model:
            raise ParameterError("limits", limits.arm, f"limits of this arm, {self._model}")
        offset, wobj, load = [
            list(await ask(each)) for each in ("get_tcp_offset", "get_wobj", "get_tool_load")
        ]
        settings: list[tuple[str, tuple[Any, ...]]] = []
        if len(offset) == 6:
            settings.append(("set_tool_data", ("twin", offset, load[:4] or [0.0] * 4, [])))
        if len(wobj) == 6:
            settings.append(("set_wobj", ("twin", wobj)))
        if speed := await ask("get_global_speed"):
            settings.append(("speed", (float(speed),)))
        tool = Pose(*offset) if len(offset) == 6 else None
        base = base_in_world(self._mounting, arm_of(self._model))
        return Begin(self._model, limits, tool, base, self._commands, tuple(settings))

    def _begin(self) -> None:
        supervisor = self._supervisor
        supervisor.feed.force_readers += 1
        self._undo.append(self._forget_forces)
        if self._commands:
            self._undo.append(supervisor.observe(self._called, lambda _: None))
        self._background.start(self._compare(), "aioduco twin")

    def _forget_forces(self) -> None:
        self._supervisor.feed.force_readers -= 1

    def _detach(self) -> None:
        self.over = True
        undo, self._undo = self._undo, []
        for step in undo:
            step()

    async def _compare(self) -> None:
        coordinator = self._supervisor.stop_coordinator
        try:
            with self._supervisor.feed.subscribe(size=256) as samples:
                async for sample in samples:
                    # a call without a deadline is known when its motion has ended
                    blocks = any(call.deadline is None for call in coordinator.pending)
                    led = bool(coordinator.streams) or coordinator.modes.any or blocks
                    self._put(
                        TwinSample.of(sample.states, sample.status, sample.read_forces, led=led)
                    )
                    self._samples += 1
                    self._sampled.set()
        except RobotStateError:
            return  # the robot was closed

    def _called(self, event: TraceEvent) -> None:
        """Queue a finished call; on the call's thread."""
        assert isinstance(event, CallFinished)
        if event.function.startswith(_READS) or (
            event.lane == "blocking" and event.function in PATHS
        ):
            return
        error = "" if event.error is None else type(event.error).__name__
        middle = event.at - 0.5 * event.duration
        self._put(TwinCommand.of(middle, event.function, event.arguments, error, event.result))

    def _put(self, item: TwinSample | TwinCommand) -> None:
        if self._queue.qsize() >= _MOST:
            self._dropped += 1
            return
        self._queue.put(item)

    # -- what has parted -----------------------------------------------------------------------

    def _take(self) -> None:
        """Take what the process has sent; on the event loop."""
        while self._received:
            found = self._received.popleft()
            if isinstance(found, Exception):
                if self._linked is not None:
                    self._fail(RuntimeError(f"its process has ended: {self._linked.stderr_tail}"))
                return
            self._busy = found.busy
            self.figures, self.joints = found.figures, found.joints
            self._tell("/twin", found.at, {**found.figures._asdict()})
            for divergence in found.divergences:
                self._parted(divergence)

    def _parted(self, divergence: Divergence) -> None:
        self._count += 1
        event = TwinDiverged(
            divergence.at,
            divergence.quantity.value,
            divergence.where,
            divergence.since,
            divergence.value,
            divergence.limit,
            divergence.unit,
            divergence.cause.value,
            dict(divergence.estimate),
            self._action,
        )
        self.divergences.append(event)
        _log.warning("the arm and its twin have parted: %s", divergence)
        self._supervisor.events.tell(event)
        if self._action != "report":
            self._background.start(self._act(), f"aioduco twin {self._action}")

    async def _act(self) -> None:
        coordinator = self._supervisor.stop_coordinator
        try:
            if self._action == "pause":
                await coordinator.pause()
            else:
                await coordinator.stop()
        except DucoError as exc:
            _log.error("the twin's %s failed: %r", self._action, exc)


def _process(begin: Begin) -> LinkedProcess:
    """Start the process, and wait until it is ready."""
    try:
        linked = LinkedProcess("aioduco.sim.twin.worker", packages=MUJOCO_PACKAGES, patience=_END)
    except (Unstartable, OSError) as exc:
        raise RobotStateError(f"the twin's process was not started: {exc}") from exc
    try:
        linked.channel.send(begin)
        linked.channel.receive(_START)
    except (EOFError, TimeoutError, OSError) as exc:
        linked.close()
        raise RobotStateError(f"the twin's process did not start: {linked.stderr_tail}") from exc
    return linked


def _send(linked: LinkedProcess, queue: SimpleQueue[object]) -> None:
    """Send what is queued, several items at once if several wait, until None comes."""
    while (item := queue.get()) is not None:
        items = [item]
        while not queue.empty() and item is not None:
            item = queue.get()
            items.append(item)
        try:
            linked.channel.send([each for each in items if each is not None])
        except OSError:
            return  # the process has ended: the other thread reports it
        if item is None:
            return


def _receive(
    linked: LinkedProcess, received: deque[TwinUpdate | Exception], ring: Callable[[], None]
) -> None:
    try:
        while True:
            received.append(linked.channel.receive())
            ring()
    except (EOFError, OSError, ValueError) as exc:
        received.append(exc)
        ring()
