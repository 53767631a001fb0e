"""Observe an arm for a monitor, and carry out the commands of its keys.

Guarantees:
- It has connections of its own and no heartbeat: the program that moves the arm keeps its
  supervision, and quitting the monitor stops nothing.
- A stop uses the stop lane. It waits neither for the screen nor for a pause in progress.
"""

from __future__ import annotations

import enum
import logging
import os
import re
import signal
import time
from collections import deque
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import anyio

from aioduco.cli.command_terms import in_commands
from aioduco.cli.monitor.view_state import EventLine, MonitorState, history_point
from aioduco.cli.output import OutputFailed
from aioduco.cli.signals import receive_signals
from aioduco.errors import DucoError, RobotStateError, StopUnconfirmed
from aioduco.models.host_port import host_port
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.robot import Robot


#: seconds between two polls of a console that cannot be waited for
_LOOK: Final = 0.05


class Key(enum.Enum):
    """Command of a key."""

    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    QUIT = "quit"


_KEYS: Final = {" ": Key.STOP, "s": Key.STOP, "p": Key.PAUSE, "r": Key.RESUME, "q": Key.QUIT}
#: sequences that terminals send for arrows, function keys and the like; no letter in them is a key
_SEQUENCE: Final = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]?|O.?|.?)", re.DOTALL)
#: one whose end is still to come
_BEGUN: Final = re.compile(r"\x1b(?:\[[0-?]*|O)?\Z")


class TerminalKeys:
    """The keys of a terminal.

    Args:
        terminal: file descriptor from which they are read.
    """

    def __init__(self, terminal: int) -> None:
        self._terminal = terminal
        self._begun = ""

    async def wait(self) -> list[Key] | None:
        """Wait for keys, and return their commands; None if the terminal was closed."""
        try:
            import msvcrt  # noqa: PLC0415 - Windows has it, and its console cannot be waited for
        except ImportError:
            await anyio.wait_readable(self._terminal)
            try:
                data = os.read(self._terminal, 1024)
            except OSError:
                return None
            return self.commands(data) if data else None
        console: Any = msvcrt
        while not console.kbhit():  # noqa: ASYNC110 - nothing else tells of a key
            await anyio.sleep(_LOOK)
        letter = console.getwch()
        if letter in "\0\xe0":  # prefix of an arrow or a function key: the next code is no letter
            console.getwch()
            return []
        return self.commands(letter.encode())

    def commands(self, data: bytes) -> list[Key]:
        """The commands in further bytes of the terminal; other keys are ignored.

        A sequence may come in pieces: the R of F3 is none that resumes. A stop at the begin of the
        bytes is one, whatever came before.
        """
        text = data.decode(errors="replace")
        stops = _KEYS.get(text[:1].lower()) is Key.STOP
        if not stops and (self._begun != "\x1b" or text[:1] in ("[", "O")):
            text = self._begun + text
        begun = _BEGUN.search(text)
        self._begun = begun[0] if begun is not None else ""
        text = _SEQUENCE.sub("", text)
        return [_KEYS[letter] for letter in text.lower() if letter in _KEYS]


#: seconds between two reads of values that change seldom
_SELDOM: Final = 1.0
#: number of events that are kept
_KEPT: Final = 200


class LogLines(logging.Handler):
    """Log handler that adds log lines to the events.

    Args:
        tell: adds a line with a text and a severity.
    """

    def __init__(self, tell: Callable[[str, str], object]) -> None:
        super().__init__(logging.WARNING)
        self._tell = tell

    def emit(self, record: logging.LogRecord) -> None:
        """Add a line; called on the thread that logs it."""
        self._tell(record.getMessage(), "warning")


class MonitorClient:
    """Observes one robot.

    Args:
        robot: robot to observe, not open yet, without a heartbeat.
        name: name of the robot on the screen.
        terminal: file descriptor from which keys are read.
        draw: function that shows a state; called on a thread, one call at a time.
    """

    def __init__(
        self, robot: Robot, name: str, terminal: int, draw: Callable[[MonitorState], object]
    ) -> None:
        self._robot = robot
        self._keys = TerminalKeys(terminal)
        self._draw = draw
        self._state = MonitorState(name, rate=robot.feed.rate)
        self._events: deque[EventLine] = deque(maxlen=_KEPT)
        self._history: deque[tuple[float, float, float]] = deque(maxlen=self._state.history_length)
        self._lines = LogLines(self._tell)
        self._doing: list[Key] = []
        self._told: signal.Signals | None = None
        self._unconfirmed: StopUnconfirmed | None = None

    async def watch(self) -> signal.Signals | None:
        """Open the robot and observe it until a key quits; a stop in progress is completed.

        Returns:
            The signal that ended it, SIGHUP for a closed terminal; None if a key did.

        Raises:
            ConnectError: there is no controller.
            StopUnconfirmed: it is not known that the last stop was carried out.
        """
        log = logging.getLogger("aioduco")
        log.addHandler(self._lines)  # log lines appear among the events, not across the screen
        try:
            # The inner group ends first: commands of keys that have begun are completed.
            async with (
                self._robot,
                anyio.create_task_group() as work,
                anyio.create_task_group() as looks,
            ):
                looks.start_soon(self._until_told, looks.cancel_scope)
                for look in (self._samples, self._happenings, self._seldom, self._show):
                    looks.start_soon(look)
                await self._follow_keys(work)
                looks.cancel_scope.cancel()
        finally:
            log.removeHandler(self._lines)
        if self._unconfirmed is not None:
            raise self._unconfirmed
        return self._told

    async def _until_told(self, looking: anyio.CancelScope) -> None:
        with receive_signals() as signals:
            async for self._told in signals:
                looking.cancel()

    async def _follow_keys(self, work: anyio.abc.TaskGroup) -> None:
        while (keys := await self._keys.wait()) is not None:
            for key in keys:
                if key is Key.QUIT:
                    return
                self._begin(key, work)
        self._told = signal.SIGHUP  # the terminal is gone, whether or not the signal has come yet

    def _begin(self, key: Key, work: anyio.abc.TaskGroup) -> None:
        """Start the command of a key, unless it is running already."""
        if key is Key.RESUME and self._state.sample is None:
            # typed, or pasted with other lines, before anybody saw what would go on
            text = "nothing was resumed: the key came before the arm was shown"
            self._change(notice=self._tell(text, "warning"))
        elif key not in self._doing:
            self._doing.append(key)
            work.start_soon(self._carry_out, key)

    async def _carry_out(self, key: Key) -> None:
        steps: dict[Key, tuple[Callable[[], Awaitable[bool | None]], str]] = {
            Key.STOP: (self._robot.stop, "stopped: the arm stands"),
            Key.PAUSE: (self._robot.pause, "paused: the arm stands"),
            Key.RESUME: (self._robot.resume, "resumed"),
        }
        step, said = steps[key]
        self._change(busy=" and ".join(each.value for each in self._doing))
        try:
            done = await step()
        except DucoError as error:
            line = self._tell(f"{key.value} failed: {error}", "alarm")
            if isinstance(error, StopUnconfirmed):
                self._unconfirmed = error
        else:
            if key is Key.STOP:
                self._unconfirmed = None
            line = self._tell("nothing was paused" if done is False else said, "good")
        self._doing.remove(key)
        busy = " and ".join(each.value for each in self._doing)
        self._change(busy=busy, notice=line)

    # -- readings --------------------------------------------------------------------------------

    async def _samples(self) -> None:
        with self._robot.feed.subscribe("latest") as samples:
            async for sample in samples:
                self._history.append(history_point(sample))
                self._change(
                    sample=sample,
                    history=tuple(self._history),
                    measured_rate=self._robot.feed.statistics().measured_rate,
                    answer_time=time.monotonic() - sample.received_at,
                )

    async def _happenings(self) -> None:
        with self._robot.events.subscribe("drop_oldest") as events:
            async for event in events:
                self._tell(event.line(), event.severity)

    async def _seldom(self) -> None:
        robot = self._robot
        told = await _asked(robot.version.get_robot_type)
        arm = "" if told is None else f"{told.series} {told.model}{told.extension}".strip()
        self._change(arm=f"{arm} {robot.version.controller}".strip())
        async for _ in every(_SELDOM):
            errors = await _asked(robot.state.get_last_error)
            self._change(
                project=await _asked(robot.program.get_current_project) or "",
                speed=await _asked(robot.settings.get_global_speed),
                errors=self._state.errors if errors is None else tuple(errors),
            )

    async def _show(self) -> None:
        async for _ in every(1.0 / self._state.rate):
            sample = self._state.sample
            if sample is not None:
                self._change(age=sample.age)
            # On a thread: a terminal that blocks, as on a slow line, must not delay a stop.
            try:
                await anyio.to_thread.run_sync(self._draw, self._state, abandon_on_cancel=True)
            except OutputFailed:
                return  # the terminal is gone, which ends the wait for keys, too

    def _tell(self, text: str, severity: str) -> EventLine:
        """Add a line to the events; also called on other threads, which log."""
        where = host_port(self._robot.host, self._robot.port)
        line = EventLine(time.strftime("%H:%M:%S"), in_commands(text, where), severity)
        self._events.append(line)
        return line

    def _change(self, **values: Any) -> None:
        self._state = replace(self._state, **values, events=tuple(self._events))


async def _asked(ask: Callable[[], Awaitable[Any]]) -> Any:
    """The answer to a request; None after an error other than `RobotStateError`."""
    try:
        return await ask()
    except RobotStateError:
        raise
    except DucoError:
        return None
