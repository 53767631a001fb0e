"""Log handlers and hooks of the program delay no stop of the arm."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import anyio
import pytest
from client.bench import HOME, Bench
from for_each import for_each

import aioduco
from aioduco import HeartbeatState
from aioduco._process.reporting import BackgroundLogger, reporter
from aioduco.supervision.concurrency import BackgroundTasks
from aioduco.supervision.loop_watchdog import Liveness, LoopWatchdog
from aioduco.supervision.settings import GuardKind
from aioduco.testing import eventually, eventually_async, no_leaks

from .programs import guard_of

LEVELS = [logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR, logging.CRITICAL]
ERRORS = [ValueError, KeyboardInterrupt, SystemExit]


@pytest.fixture
def bench() -> Iterator[Bench]:
    with no_leaks(), Bench() as bench:
        bench.motion_time = 30.0
        yield bench


class Raising(logging.Handler):
    """A handler that raises, in the part of it that is chosen."""

    def __init__(self, error: type[BaseException], part: str = "handler") -> None:
        super().__init__()
        self.error = error
        self.seen = threading.Event()
        if part == "filter":
            self.addFilter(self.fail)
        elif part == "formatter":
            self.setFormatter(self._Failing(self))

    class _Failing(logging.Formatter):
        def __init__(self, handler: Raising) -> None:
            super().__init__()
            self.handler = handler

        def format(self, record: logging.LogRecord) -> str:
            return str(self.handler.fail(record))

    def fail(self, record: logging.LogRecord) -> bool:
        self.seen.set()
        raise self.error("a mistake of the program")

    def emit(self, record: logging.LogRecord) -> None:
        self.format(record)
        self.fail(record)


class Blocking(logging.Handler):
    """A handler that does not come back before it is let go."""

    def __init__(self) -> None:
        super().__init__()
        self.begun = threading.Event()
        self.let_go = threading.Event()

    def emit(self, record: logging.LogRecord) -> None:
        self.begun.set()
        self.let_go.wait(60.0)


@contextmanager
def installed(handler: logging.Handler, level: int = logging.DEBUG) -> Iterator[None]:
    """The handler gets the package's messages."""
    logger = logging.getLogger("aioduco")
    before, logger.level = logger.level, level
    logger.manager._clear_cache()  # type: ignore[attr-defined]  # as setLevel does
    logger.addHandler(handler)
    try:
        yield
    finally:
        if isinstance(handler, Blocking):
            handler.let_go.set()
        reporter.flush(10.0)
        logger.removeHandler(handler)
        logger.setLevel(before)


async def moved_and_left(bench: Bench, guard: GuardKind | None = None) -> None:
    """Start a motion, and leave the robot."""
    async with aioduco.connect(bench.host, bench.port, guard=guard) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        assert bench.moving()
    assert not bench.moving()
    assert bench.commands == ["movej2", "stop"]
    await eventually_async(lambda: bench.connections == 0)


# -- the way out ---------------------------------------------------------------------------------


@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("level", LEVELS)
async def test_a_handler_that_raises_leaves_out_no_rung(
    bench: Bench, level: int, error: type[BaseException]
) -> None:
    handler = Raising(error)
    with installed(handler, level):
        await moved_and_left(bench)
    # Above that the closing steps have nothing to say; the controller in this process may have.
    assert handler.seen.is_set() or level > logging.DEBUG


@pytest.mark.parametrize("part", ["filter", "formatter"])
async def test_a_filter_or_a_formatter_that_raises_leaves_out_no_rung(
    bench: Bench, part: str
) -> None:
    handler = Raising(ValueError, part)
    with installed(handler):
        await moved_and_left(bench)
    assert handler.seen.is_set()


async def test_a_handler_that_raises_is_printed_as_logging_does(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    with installed(Raising(ValueError)):
        await moved_and_left(bench)
    assert "ValueError: a mistake of the program" in capsys.readouterr().err


@pytest.mark.slow
async def test_a_handler_that_blocks_holds_up_no_stop(bench: Bench) -> None:
    handler = Blocking()
    with installed(handler):
        await moved_and_left(bench)
        assert handler.begun.is_set()
        assert not handler.let_go.is_set()


async def test_failed_rungs_are_gone_through_although_their_report_raises(bench: Bench) -> None:
    bench.answer("fc_start", 4)
    bench.answer("fc_stop", 4)
    bench.answer("robotmoving", True)
    steps = aioduco.ClosingSteps(standstill=0.1, modes=0.1)
    with installed(Raising(ValueError)):
        robot = aioduco.connect(bench.host, bench.port, closing_steps=steps)
        await robot.open()
        await robot.force.fc_start()
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        with pytest.raises(aioduco.StopUnconfirmed, match="still moves"):
            await robot.aclose()
    assert "stop" in bench.commands
    await eventually_async(lambda: bench.connections == 0)


# -- the threads ---------------------------------------------------------------------------------


@pytest.mark.parametrize("error", ERRORS)
async def test_the_heartbeat_goes_on_when_its_report_raises(
    bench: Bench, error: type[BaseException]
) -> None:
    handler = Raising(error)
    with installed(handler):
        async with aioduco.connect(bench.host, bench.port, heartbeat=0.2) as robot:
            figures = robot.heartbeat
            assert figures is not None
            gate = bench.hold("rpc_heartbeat", None)
            await eventually_async(lambda: robot.heartbeat.state is HeartbeatState.LOST)  # type: ignore[union-attr]
            bench.answer("rpc_heartbeat", lambda milliseconds: None)
            gate.set()
            await eventually_async(lambda: robot.heartbeat.state is HeartbeatState.BEATING)  # type: ignore[union-attr]
    assert handler.seen.is_set()


@pytest.mark.slow
@pytest.mark.parametrize("guard", [None, "process"])
async def test_a_hung_loop_has_its_arm_stopped_while_a_handler_blocks(
    bench: Bench, guard: GuardKind | None
) -> None:
    handler = Blocking()
    with installed(handler):
        async with aioduco.connect(
            bench.host, bench.port, heartbeat=60.0, loop_stall_limit=2.0, guard=guard
        ) as robot:
            await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
            BackgroundLogger("aioduco.test").critical("the handler blocks from here on")
            eventually(handler.begun.is_set)
            eventually(lambda: not bench.moving())  # the loop does not run meanwhile
            assert not handler.let_go.is_set()


@pytest.mark.slow
async def test_the_guards_death_stops_the_arm_although_the_report_raises(bench: Bench) -> None:
    with installed(Raising(SystemExit)):
        async with aioduco.connect(
            bench.host, bench.port, heartbeat=60.0, guard="process"
        ) as robot:
            guard, first = guard_of(robot)
            await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
            os.kill(first, signal.SIGKILL)
            await eventually_async(lambda: not bench.moving())
            await eventually_async(lambda: guard.alive and guard.pid != first, 20.0)


@for_each("error", ERRORS)
def test_the_watch_over_the_loop_goes_on_when_its_report_raises(error: type[BaseException]) -> None:
    life = Liveness()
    told: list[float] = []
    watchdog = LoopWatchdog(threading.get_ident())
    with installed(Raising(error)):
        watchdog.add(life, 0.02, lambda seconds, where: told.append(seconds))
        try:
            for stalls in (1, 2):

                def stalled_again(stalls: int = stalls) -> bool:
                    # one long pause, then a keep-alive
                    if time.monotonic() - life.stamp > 0.1:
                        life.touch(time.monotonic())
                    return len(told) >= stalls

                eventually(stalled_again)
        finally:
            assert watchdog.remove(life)
            assert watchdog.join(5.0)


async def test_what_failed_in_the_background_is_dealt_with_although_the_report_raises() -> None:
    dealt: list[BaseException] = []

    async def fail() -> None:
        raise ValueError("a defect")

    with installed(Raising(SystemExit)):
        background = BackgroundTasks(dealt.append)
        background.start(fail(), "fails")
        await eventually_async(lambda: dealt)


# -- trace hooks ---------------------------------------------------------------------------------


@pytest.mark.parametrize("error", ERRORS)
async def test_a_trace_hook_that_raises_breaks_no_call_and_no_stop(
    bench: Bench, error: type[BaseException], caplog: pytest.LogCaptureFixture
) -> None:
    """It is told once: a line for each event would hide the others."""
    calls = 0

    def hook(event: object) -> None:
        nonlocal calls
        calls += 1
        raise error("a mistake of the program")

    async with aioduco.connect(bench.host, bench.port, trace=hook) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        assert await robot.state.robotmoving()
        robot.stop_now()
    assert not bench.moving()
    assert calls > 5
    assert caplog.text.count("the trace hook failed") == 1


@pytest.mark.slow
async def test_a_trace_hook_that_blocks_holds_up_no_call_and_no_stop(bench: Bench) -> None:
    begun, release = threading.Event(), threading.Event()

    def hook(event: object) -> None:
        begun.set()
        release.wait(60.0)

    try:
        async with aioduco.connect(bench.host, bench.port, trace=hook) as robot:
            await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
            await robot.stop()
            assert not bench.moving()
            assert begun.is_set()
    finally:
        release.set()


# -- the end of the interpreter ------------------------------------------------------------------

PROGRAM = """
import asyncio, logging, sys, threading, time
import aioduco
from aioduco._process.reporting import reporter

class Handler(logging.Handler):
    def emit(self, record):
        {handler}

def hook(*_):
    {hook}

logging.getLogger("aioduco").addHandler(Handler())
logging.getLogger("aioduco").setLevel({level})
sys.excepthook = hook
threading.excepthook = hook

async def main():
    robot = aioduco.connect({host!r}, {port}, heartbeat=None)
    await robot.open()
    await robot.motion.movej2({home}, v=1.0, a=1.0).start()
    globals()["kept"] = robot
    raise KeyError("no such part")

{run}
"""

RUN = "asyncio.run(main())"
BROKEN_LOOP = "asyncio.new_event_loop().run_until_complete(main())"


def run(bench: Bench, **parts: Any) -> subprocess.Popen[str]:
    given = {"handler": "pass", "hook": "pass", "level": logging.DEBUG, "run": RUN} | parts
    text = PROGRAM.format(host=bench.host, port=bench.port, home=HOME, **given)
    return subprocess.Popen(
        [sys.executable, "-c", text], stderr=subprocess.PIPE, stdin=subprocess.PIPE, text=True
    )


@pytest.mark.slow
@pytest.mark.parametrize("end", [RUN, BROKEN_LOOP])
@pytest.mark.parametrize(
    "handler", ["raise ValueError(1)", "raise KeyboardInterrupt", "sys.exit(7)"]
)
def test_the_interpreters_end_stops_the_arm_whatever_the_handler_does(
    bench: Bench, handler: str, end: str
) -> None:
    with run(bench, handler=handler, run=end) as program:
        program.communicate(timeout=60)
        assert program.returncode == 1
    assert bench.commands[-1] == "stop"
    eventually(lambda: not bench.moving())


@pytest.mark.slow
@pytest.mark.parametrize("end", [RUN, BROKEN_LOOP])
def test_the_interpreters_end_stops_the_arm_while_a_handler_blocks(bench: Bench, end: str) -> None:
    """Nothing is done to the handler: `logging` itself waits for it at the end."""
    # It blocks for longer than the test lasts, which is what is tested.
    with run(bench, handler="time.sleep(600)", run=end) as program:
        try:
            eventually(lambda: "stop" in bench.commands, 60.0)
            eventually(lambda: not bench.moving())
        finally:
            program.kill()


@pytest.mark.slow
def test_the_interpreters_end_is_reported(bench: Bench) -> None:
    handler = "print('SAID', record.getMessage(), file=sys.stderr)"
    with run(bench, handler=handler) as program:
        _, said = program.communicate(timeout=60)
    assert "SAID the program ends without having left the robot: the arm was stopped" in said
    assert bench.commands[-1] == "stop"


@pytest.mark.slow
def test_an_excepthook_that_raises_stands_before_no_stop(bench: Bench) -> None:
    with run(bench, hook="raise ValueError(1)", run=BROKEN_LOOP) as program:
        program.communicate(timeout=60)
    assert bench.commands[-1] == "stop"
    eventually(lambda: not bench.moving())


@pytest.mark.slow
def test_an_excepthook_that_blocks_stands_before_no_stop(bench: Bench) -> None:
    """As a debugger's does, which waits for a person."""
    with run(bench, hook="print('HOOK', file=sys.stderr, flush=True); sys.stdin.read()") as program:
        assert program.stderr is not None
        try:
            for line in program.stderr:
                if line.startswith("HOOK"):
                    break
            # the stop was accepted before, and the arm brakes
            assert bench.commands[-1] == "stop"
            eventually(lambda: not bench.moving())
        finally:
            program.communicate("", timeout=60)


async def test_a_robot_that_is_forgotten_is_stopped_where_warnings_are_errors(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port)
    await robot.open()
    await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ResourceWarning, match="unclosed <Robot"):
            robot.__del__()
    assert bench.commands[-1] == "stop"
    await robot._supervisor.aclose()
    await anyio.lowlevel.checkpoint()


# -- the reporter itself -------------------------------------------------------------------------


def test_a_message_tells_when_and_where_it_was_made(caplog: pytest.LogCaptureFixture) -> None:
    before = time.time()
    with caplog.at_level(logging.INFO, "aioduco.test"):
        BackgroundLogger("aioduco.test").info("%d of %s", 3, "four")
        BackgroundLogger("aioduco.test").debug("not wanted")
        assert reporter.flush(10.0)
    (record,) = caplog.records
    assert record.getMessage() == "3 of four"
    assert (record.name, record.levelname) == ("aioduco.test", "INFO")
    assert record.threadName == threading.current_thread().name
    assert record.pathname == __file__
    assert record.funcName == "test_a_message_tells_when_and_where_it_was_made"
    assert before <= record.created <= time.time()


@pytest.mark.slow
def test_messages_keep_their_order_and_those_too_many_are_counted() -> None:
    handler = Blocking()
    seen: list[str] = []
    handler.addFilter(lambda record: not seen.append(record.getMessage()))  # type: ignore[func-returns-value]
    log = BackgroundLogger("aioduco.test")
    with no_leaks(), installed(handler):
        log.info("first")
        eventually(handler.begun.is_set)
        for number in range(10_100):
            log.info("%d", number)
        handler.let_go.set()
        assert reporter.flush(30.0)
    assert seen[0] == "first"
    assert any("100 messages and trace events were dropped" in line for line in seen)
    numbers = [int(line) for line in seen if line.isdigit()]
    assert numbers == list(range(10_000))


def test_an_argument_that_cannot_be_shown_is_no_error(caplog: pytest.LogCaptureFixture) -> None:
    class Odd:
        def __repr__(self) -> str:
            raise ValueError("odd")

    BackgroundLogger("aioduco.test").warning("there is %r", Odd())
    assert reporter.flush(10.0)
    assert "its values cannot be shown" in caplog.text


@pytest.mark.linux("os.fork")
def test_a_forked_child_reports_by_a_thread_of_its_own() -> None:
    program = """
import logging, os, sys
from aioduco._process.reporting import BackgroundLogger, reporter
logging.basicConfig(level=logging.INFO, stream=sys.stdout, format="%(message)s")
BackgroundLogger("a").info("parent")
reporter.flush()
child = os.fork()
if child == 0:
    BackgroundLogger("a").info("child")
    reporter.flush(10.0)
    sys.stdout.flush()
    os._exit(0)
os.waitpid(child, 0)
"""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["parent", "child"]
