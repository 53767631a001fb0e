"""Collects a robot's data for a recording or publication: feed, calls, tasks, events, streams, log.

A publication is on a WebSocket: Foxglove, Lichtblick and any other program with Foxglove's protocol
read it. It accepts no commands.

Guarantees:
- Nothing here makes a call, a task, a stream or the event loop wait: the data is put into the
  queue of the writer's thread.
- A failure ends the recording, and nothing else: it is in `error`, and it is logged.
"""

from __future__ import annotations

import logging
import time
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self

import anyio

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco._process.reporting import BackgroundLogger
from aioduco._wire.owner_loop import loop_callback
from aioduco.errors import DucoError, RecordingError, RobotStateError, StreamClosed
from aioduco.models.host_port import host_port
from aioduco.models.ranges import FILE, LISTEN_HOST, LISTEN_PORT
from aioduco.models.samples import pose
from aioduco.models.trace import CallFinished, TraceEvent
from aioduco.recording.moving_gaps import MAX_GAP, MovingGaps
from aioduco.recording.writer import MessageWriter, PublicationWriter, RecordingWriter
from aioduco.streaming.session import Session
from aioduco.supervision.concurrency import BackgroundTasks, every, run_to_completion

if TYPE_CHECKING:
    import os
    from collections.abc import Callable
    from pathlib import Path

    from aioduco.supervision.supervisor import Supervisor
    from aioduco.supervision.task import Task


_log = BackgroundLogger(__name__)

#: seconds within which the writer must end; after that its thread is abandoned
_CLOSE_LIMIT: Final = 5.0
#: maximum number of waiting samples
_SAMPLES: Final = 256
#: seconds between two reads of the flange's pose and of the figures of a stream
_POLL_EVERY: Final = 1.0
#: age of a log line from which on the clock was set rather than a handler slow [s]
_OLDEST_LINE: Final = 10.0
#: time-out of the reads of the flange's pose and of the arm's type [s]
_ASK_LIMIT: Final = 0.5
#: figures of a stream that are recorded, besides its name and its rate
_STREAM_FIGURES: Final = (
    *("state", "reason", "ticks", "sent", "missed", "starved", "limited", "overwritten"),
    *("lateness", "interval", "round_trip", "age"),
)


class RecordingStatistics(NamedTuple):
    """Figures of a recording.

    Attributes:
        written: messages that were written, as many as the file has.
        dropped: samples, calls, tasks, events and log lines that were not written, because the
            disk or this computer was too slow.
        size: bytes in the file.
        longest_gap: longest time between two samples between which the arm moved [s]. From 0.1 s
            on, `RecordedPath` bridges it, or refuses to: a computer or controller was too busy.
        gaps: number of such times above 0.1 s.
    """

    written: int
    dropped: int
    size: int
    longest_gap: float
    gaps: int


class RecordingHandler(logging.Handler):
    """Records the log lines of the loggers that it is added to.

    Args:
        writer: the writer that gets the lines.
    """

    def __init__(self, writer: MessageWriter[Any]) -> None:
        super().__init__()
        self._writer = writer

    def emit(self, record: logging.LogRecord) -> None:
        """Record a line; on the thread that logs it."""
        try:
            age = time.time() - record.created
            # Set in between, the wall clock tells nothing.
            at = time.monotonic() - (age if 0.0 <= age < _OLDEST_LINE else 0.0)
            text = record.getMessage()
            if record.exc_info and record.exc_info[1] is not None:
                text += f" ({record.exc_info[1]!r})"
            # A logger of a library in another language may know no place.
            where = (record.name, text, record.pathname or "", record.lineno or 0)
            self._writer.put("line", at, record.levelno, *where)
        except Exception:
            self.handleError(record)
        self._show(record)

    def _show(self, record: logging.LogRecord) -> None:
        """Show a line that would be shown on stderr if this handler were not there."""
        last = logging.lastResort
        if last is None or record.levelno < last.level:
            return
        logger: logging.Logger | None = logging.getLogger(record.name)
        first: logging.Handler | None = None
        while logger is not None:
            for handler in logger.handlers:
                if not isinstance(handler, RecordingHandler):
                    return
                first = first or handler
            logger = logger.parent if logger.propagate else None
        if first is self:
            last.handle(record)


class RobotObserver(Uncopied):
    """Observes a robot and passes its data to a writer; the base of recording and publication.

    Args:
        supervisor: the robot's supervisor.
        writer: the writer that gets the data.
        forces: whether samples include forces.

    Attributes:
        handler: the handler for log lines. It is added to the logger `aioduco`; a program may add
            it to its own loggers.
    """

    #: its name in error messages, and the function that makes it
    _KIND = "an observer"
    _MADE_BY = "observe"

    def __init__(self, supervisor: Supervisor, writer: MessageWriter[Any], forces: bool) -> None:
        self._supervisor = supervisor
        self._forces = forces
        self._started = False
        self._ended = anyio.Event()
        self._missed = 0
        self._gaps = MovingGaps()
        self._failure: Exception | None = None
        self._undo: list[Callable[[], object]] = []
        self._background = BackgroundTasks(self._crashed)
        #: the last written set-point of each open stream
        self._streams: dict[Session, tuple[float, ...] | None] = {}
        self._writer = writer
        self.handler: logging.Handler = RecordingHandler(writer)

    def __repr__(self) -> str:
        state = "running" if self.running else "ended" if self._started else "not started"
        why = f" ({self.error})" if self.error is not None else ""
        return f"<{type(self).__name__} {self._described(state + why)}>"

    def _described(self, state: str) -> str:
        return state

    @property
    def running(self) -> bool:
        """Whether the robot is being recorded or published."""
        return self._writer.accepts

    @property
    def over(self) -> bool:
        """Whether it has ended."""
        return self._ended.is_set()

    @property
    def error(self) -> Exception | None:
        """Why it ended by itself, such as a full disk; None if it did not."""
        return self._failure or self._writer.error

    async def start(self) -> Self:
        """Begin to record or publish the robot.

        Raises:
            RobotStateError: the robot is not open, or this was started before.
            RecordingError: the file cannot be written, or the address cannot be listened on.
            MissingExtra: the extra `record` is not installed.
        """
        self._supervisor.check_open(self._MADE_BY)
        if self._started:
            raise RobotStateError(f"{self._KIND} is started once; make another one")
        self._started = True
        metadata = {**self._metadata(), "arm": await self._arm()}
        opened = anyio.Event()
        self._writer.begin(metadata, loop_callback(opened.set), loop_callback(self._over))
        try:
            await opened.wait()
            self._raise_open_error()
            self._begin()
        except BaseException:
            await self.stop()
            raise
        return self

    def tell(self, topic: str, at: float, values: dict[str, Any]) -> None:
        """Write a message of another part of the package to one of the channels in JSON."""
        self._writer.put("other", topic, at, values)

    async def stop(self) -> None:
        """Write the remaining data, and close the file or the port.

        A failure is logged and not raised; it is in `error`. In a forked child it does nothing.
        """
        if self._started and not self._supervisor.owner_loop.in_forked_child:
            _, cancelled = await run_to_completion(self._stop)
            if cancelled is not None:
                raise cancelled

    async def __aenter__(self) -> Self:
        return await self.start()

    async def __aexit__(self, *_: object) -> None:
        await self.stop()

    async def _stop(self) -> None:
        await self._background.aclose()
        self._detach()
        self._writer.finish()
        if not self._writer.begun:  # its start was cancelled before
            self._ended.set()
        with anyio.move_on_after(_CLOSE_LIMIT):
            await self._ended.wait()
        # The thread reports its end as its last action.
        if not self._ended.is_set() or not self._writer.join(_CLOSE_LIMIT):
            _log.error(
                "%s was not closed within %g s: what it writes to hangs, or is too slow",
                *(self._writer.target, _CLOSE_LIMIT),
            )

    def _raise_open_error(self) -> None:
        error = self._writer.error
        if isinstance(error, DucoError):
            raise error
        if error is not None:
            raise RecordingError(f"{self._cannot}: {error}") from error

    @property
    def _cannot(self) -> str:
        """The error's text if the target cannot be opened."""
        return f"{self._writer.target} cannot be opened"

    def _over(self) -> None:
        """Handle the end of the writer, for whatever reason; on the event loop."""
        self._detach()
        self._ended.set()

    def _crashed(self, error: BaseException) -> None:
        """Handle the failure of a task of this observer: end the others, and nothing else."""
        self._failure = error if isinstance(error, Exception) else RuntimeError(repr(error))
        self._detach()
        self._writer.finish()

    def _begin(self) -> None:
        supervisor = self._supervisor
        if self._forces:
            supervisor.feed.force_readers += 1
            self._undo.append(self._forget_forces)
        logger = logging.getLogger("aioduco")
        logger.addHandler(self.handler)
        self._undo.append(lambda: logger.removeHandler(self.handler))
        for task in supervisor.stop_coordinator.follower.tasks:
            self._task_changed(task)
        self._undo.append(supervisor.observe(self._called, self._task_changed))
        self._background.start(self._record_samples(), "aioduco recording of samples")
        self._background.start(self._record_events(), "aioduco recording of events")
        self._background.start(self._record_polled(), "aioduco recording of figures")

    def _detach(self) -> None:
        """Stop observing the robot."""
        for stream in tuple(self._streams):
            self._stream_figures(stream)
        self._streams.clear()
        undo, self._undo = self._undo, []
        for step in undo:
            step()

    def _forget_forces(self) -> None:
        self._supervisor.feed.force_readers -= 1

    async def _arm(self) -> str:
        """Read series and model of the arm; empty if its controller does not report them."""
        try:
            told = await self._supervisor.poll.call("get_robot_type", (), _ASK_LIMIT)
        except DucoError:
            return ""
        return " ".join(filter(None, told[:3]))

    def _metadata(self) -> dict[str, str]:
        from aioduco import __version__  # noqa: PLC0415  # the package imports this for types

        wall, monotonic = time.time_ns(), time.monotonic_ns()
        return {
            "library": f"aioduco {__version__}",
            "controller": self._supervisor.version.text,
            "address": host_port(self._supervisor.host, self._supervisor.port),
            "started": str(wall),
            "clock_offset": str(wall - monotonic),
            "state_rate": f"{self._supervisor.feed.rate:g}",
        }

    # -- observing -------------------------------------------------------------------------------

    async def _record_samples(self) -> None:
        streams = self._supervisor.stop_coordinator.streams
        try:
            with self._supervisor.feed.subscribe(size=_SAMPLES) as samples:
                async for sample in samples:
                    self._writer.put("sample", sample)
                    status = sample.status
                    at = trial.wall(status.received_at)
                    self._gaps.sampled(at, status.expected_joints)
                    self._missed = samples.dropped
                    if streams or self._streams:
                        self._record_setpoints(at)
        except RobotStateError:
            return  # the robot was closed

    async def _record_events(self) -> None:
        try:
            with self._supervisor.events.subscribe("drop_oldest") as events:
                async for event in events:
                    self._writer.put("event", event)
        except RobotStateError:
            return

    async def _record_polled(self) -> None:
        """Poll the data that no event reports: the flange's pose, and the figures of streams."""
        async for _ in every(_POLL_EVERY):
            for stream in tuple(self._streams):
                self._stream_figures(stream)
            try:
                offset = await self._supervisor.poll.call("get_tcp_offset", (), _ASK_LIMIT)
                self._writer.put("flange", pose(offset).inverse())
            except DucoError:
                # Some controllers do not report it, and a lost connection is recorded as an event.
                continue

    def _record_setpoints(self, at: float) -> None:
        there = [s for s in self._supervisor.stop_coordinator.streams if isinstance(s, Session)]
        for stream in there:
            point = stream.commanded
            if point is not None and point != self._streams.get(stream):
                found = {"stream": stream.name, "taken": stream.taken, "point": point}
                self._writer.put("other", "/stream_setpoints", at, found)
            self._streams[stream] = point
        for stream in [stream for stream in self._streams if stream not in there]:
            del self._streams[stream]
            self._stream_figures(stream)

    def _stream_figures(self, stream: Session) -> None:
        try:
            figures = stream.statistics()
        except StreamClosed:
            return  # the stream was never opened
        found: dict[str, Any] = {"stream": stream.name, "rate": stream.rate}
        for name in _STREAM_FIGURES:
            found[name] = getattr(figures, name)
        self._writer.put("other", "/streams", time.monotonic(), found)

    def _called(self, event: TraceEvent) -> None:
        """Record a finished call; on the call's thread."""
        assert isinstance(event, CallFinished)
        error = "" if event.error is None else f"{type(event.error).__name__}: {event.error}"
        self._writer.put(
            "command",
            *(event.at, event.lane, event.function, event.arguments, event.result),
            *(error, event.duration),
        )

    def _task_changed(self, task: Task) -> None:
        life = task.life  # a recording is not the program, which may not ask how the task ended
        found = {
            "id": task.id,
            "name": task.name,
            "state": life.state,
            "outcome": life.outcome.name if life.outcome and task.done else "",
            "done": task.done,
            "motion": task.motion,
            "duration": round(task.duration, 6),
            "errors": task.errors,
        }
        self._writer.put("other", "/tasks", time.monotonic(), found)


class Recording(RobotObserver):
    """A recording of one robot: `Robot.record` makes it, `async with` or `start` begins it."""

    _KIND = "a recording"
    _MADE_BY = "record"

    def __init__(self, supervisor: Supervisor, path: str | os.PathLike[str], forces: bool) -> None:
        self._file = RecordingWriter(FILE("path", path), self._figures)
        super().__init__(supervisor, self._file, forces)

    def _described(self, state: str) -> str:
        return f"{self.path} {state}, {self._file.size} bytes"

    @property
    def path(self) -> Path:
        """The file; if one of its name existed, a number was added to the name."""
        return self._file.path

    def statistics(self) -> RecordingStatistics:
        """Figures since its start."""
        writer = self._file
        dropped, gaps = writer.dropped + self._missed, self._gaps
        return RecordingStatistics(writer.written, dropped, writer.size, gaps.longest, gaps.count)

    @property
    def _cannot(self) -> str:
        return f"{self.path} cannot be written"

    def _over(self) -> None:
        super()._over()
        if self._gaps.count:
            _log.warning(
                "%s: %d times the arm moved for more than %g s without a sample, for %.2f s at "
                "most; `aioduco play %s --check` says whether it can be played",
                *(self.path, self._gaps.count, MAX_GAP, self._gaps.longest, self.path),
            )

    def _figures(self) -> dict[str, str]:
        figures = self.statistics()
        return {
            "written": str(figures.written),
            "dropped": str(figures.dropped),
            "longest_gap": f"{figures.longest_gap:.3f}",
            "gaps": str(figures.gaps),
        }


class PublicationStatistics(NamedTuple):
    """Figures of a publication.

    Attributes:
        sent: messages that were sent to the watchers, if any.
        dropped: samples, calls, tasks, events and log lines that were not sent, because this
            computer was too slow. Messages that a watcher lost because the watcher was too slow are
            not counted.
    """

    sent: int
    dropped: int


class Publication(RobotObserver):
    """A robot published live: `Robot.publish` makes it, `async with` or `start` begins it."""

    _KIND = "a publication"
    _MADE_BY = "publish"

    def __init__(self, supervisor: Supervisor, port: int, host: str, forces: bool) -> None:
        port = LISTEN_PORT("port", port)
        LISTEN_HOST("host", host)
        self._server = PublicationWriter(host, port)
        super().__init__(supervisor, self._server, forces)

    def _described(self, state: str) -> str:
        return f"{self.url} {state}"

    @property
    def port(self) -> int:
        """The port that it listens on; before the start, the requested one."""
        return self._server.port

    @property
    def url(self) -> str:
        """The address to which watchers connect, such as `ws://127.0.0.1:8765`."""
        return f"ws://{host_port(self._server.host, self.port)}"

    def statistics(self) -> PublicationStatistics:
        """Figures since its start."""
        return PublicationStatistics(self._server.written, self._server.dropped + self._missed)
