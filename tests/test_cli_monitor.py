"""The monitor: its screen, its keys, and its program in a terminal."""

from __future__ import annotations

import errno
import io
import logging
import math
import os
import signal
import threading
from collections.abc import Iterator
from typing import Any

import anyio
import pytest
from client.bench import Bench
from for_each import for_each
from rich.console import Console
from terminals import ENDS, terminal
from test_cli import COMMAND, run, wait_until_it_moves
from test_cli_robot import HOME, at, ready_arm

import aioduco
import aioduco.sync
from aioduco._wire import rpc
from aioduco.cli.monitor.observer import Key, MonitorClient, TerminalKeys
from aioduco.cli.monitor.screen import bar, chart, screen
from aioduco.cli.monitor.view_state import EventLine, MonitorState
from aioduco.cli.output import OutputFailed
from aioduco.errors import StopUnconfirmed
from aioduco.models.enums import Outcome, SafetyState
from aioduco.models.samples import Samples
from aioduco.sim import Simulator
from aioduco.supervision.heartbeat import HeartbeatState
from aioduco.supervision.state_feed import Snapshot
from aioduco.testing import eventually, eventually_async


def sample(states: tuple[int, ...] = (6, 5, 5, 1), **status: Any) -> Snapshot:
    """A sample as the feed makes one."""
    make = Samples()
    given: dict[str, Any] = {
        "jointActualPosition": [0.5, -1.0, 1.5, 0.0, 6.2, -7.0],
        "jointActualVelocity": [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
        "cartActualPosition": [0.4, -0.1, 0.35, 3.0, 0.0, -1.5],
        "jointExpectPosition": [0.0] * 6,
        "cartExpectPosition": [0.0] * 6,
        "robotState": states[0],
    }
    signals = rpc.IOStatus(
        digitalInputs=[number == 3 for number in range(1, 17)], digitalOutputs=[False] * 16
    )
    seen, arm = make.states(states), make.status(rpc.RobotStatus(**given | status))
    forces = make.forces([1.0, -2.5, 30.0, 0.0, 0.1, 0.0], [])
    return Snapshot(0, seen.received_at, seen, arm, make.io(lambda: signals), forces)


def drawn(state: MonitorState, width: int = 110, height: int = 30) -> list[str]:
    """The lines of the screen."""
    console = Console(file=io.StringIO(), width=width, height=height, record=True)
    console.print(screen(state, width, height))
    return console.export_text().rstrip("\n").split("\n")


# -- the screen ----------------------------------------------------------------------------------


def test_the_screen_shows_all_that_is_known() -> None:
    events = tuple(EventLine("10:00:00", f"event {number}") for number in range(50))
    state = MonitorState(
        "left (10.0.0.1:7003)",
        arm="GCR5 910 3.8.1",
        sample=sample(),
        age=0.05,
        measured_rate=9.9,
        answer_time=0.004,
        project="pick.jspf",
        speed=50.0,
        errors=("E 7",),
        events=events,
        notice=EventLine("10:00:09", "paused: the arm stands", "good"),
    )
    lines = drawn(state)
    text = "\n".join(lines)
    for what in (
        *("left (10.0.0.1:7003)  GCR5 910 3.8.1", "9.9 of 10 Hz, answered in 4 ms"),
        *("robot ENABLE", "program TASK_RUNNING", "safety RUN", "mode AUTO", "speed 50 %"),
        *("moving, task TASK_RUNNING, project pick.jspf", "errors: E 7"),
        *("28.65°", "11.5", "400.0 mm", "171.9  °", "30.00 N", "0.10 N·m", "–"),
        *("··●· ···· ···· ····", "event 49", "paused: the arm stands", "-360° … 360°"),
        *(" space ", "s stop", "p pause", "r resume", "q quit"),
    ):
        assert what in text, what
    assert len(lines) <= 30
    assert "event 30" not in text, "only the newest events that fit"


@for_each("width, height", [(80, 24), (100, 30), (200, 60), (60, 20), (60, 10), (20, 5)])
def test_the_screen_fits_its_terminal(width: int, height: int) -> None:
    """Also in a low one it is said that the arm does not answer, and that a stop has failed."""
    events = tuple(EventLine("10:00:00", "x" * 300) for _ in range(100))
    failed = EventLine("10:00:00", "stop failed", "alarm")
    lines = drawn(
        MonitorState(
            "a" * 40, sample=sample(), age=3.0, events=events, errors=("E",), notice=failed
        ),
        width,
        height,
    )
    assert all(len(line) <= width for line in lines)
    assert len(lines) <= height
    assert "stop" in lines[-1]
    assert "stop fail" in lines[-2]
    assert any("NO ANSWER FOR" in line for line in lines)


def test_nothing_is_cut_off_in_80_columns_and_24_lines() -> None:
    events = (EventLine("10:00:00", "word " * 30), EventLine("10:00:01", "the last one"))
    state = MonitorState(
        "left (192.168.1.10:7003)", arm="GCR5-910 3.8.1", sample=sample(), age=0.0, speed=100.0,
        project="pick.jspf", errors=("E 7",), events=events,
    )  # fmt: skip
    lines = drawn(state, 80, 24)
    assert len(lines) <= 24
    assert not any("…" in line for line in lines if "° …" not in line)
    assert " ".join(lines).count("word") == 30
    for what in ("mode AUTO", "speed 100 %", "errors: E 7", "volts", "the last one", "N·m"):
        assert what in "\n".join(lines), what


def test_a_large_terminal_is_used() -> None:
    history = [(100.0, 5.0, 0.1), (200.0, math.nan, 0.4)] * 100
    state = MonitorState("left", sample=sample(), age=0.0, history=history)
    lines = drawn(state, 200, 50)
    bars = [line for line in lines if line.startswith(" J")]
    assert all(len(line.rstrip()) > 180 for line in bars)
    text = "\n".join(lines)
    for what in ("told", "behind", "°C", "to 200.0 mm/s", "to 5.0 N", "to 0.4 °", "last minute"):
        assert what in text, what
    assert len(lines) <= 50
    assert "last minute" not in "\n".join(drawn(state, 80, 24))


def test_a_chart_shows_the_largest_value_of_each_column() -> None:
    upper, lower = chart([0.0, 16.0, 8.0, 0.0, math.nan, 4.0], 3, 6)
    assert (upper, lower) == ("█  ", "██▄")
    assert chart([1.0], 4, 4) == ("   █", "   █")
    assert chart([], 2, 4) == ("  ", "  ")
    assert chart([1.0], 2, 2, least=16.0) == ("  ", " ▁"), "noise stays small"


@for_each(
    "state, said",
    [
        (MonitorState("a"), "waiting for the first answer"),
        (MonitorState("a", sample=sample(), age=3.2), "NO ANSWER FOR 3 s: WHAT IS SHOWN IS OLD"),
        (MonitorState("a", sample=sample(emcStopSignal=True), age=0), "EMERGENCY STOP PRESSED"),
        (
            MonitorState("a", sample=sample(collision=True, collisionAxis=3), age=0),
            "COLLISION AT JOINT 3",
        ),
        (MonitorState("a", sample=sample((6, 0, 9, 1)), age=0), "SAFETY STOP0"),
        (MonitorState("a", sample=sample(), age=0, busy="stop"), "stop …"),
        (
            MonitorState("a", sample=sample((6, 0, 5, 1), jointActualVelocity=[0.0] * 6), age=0),
            "standing, no task",
        ),
        (
            MonitorState("a", sample=sample(jointActualVelocity=[math.nan] * 6), age=0),
            "no speeds are told, ",
        ),
        (MonitorState("a", sample=sample(jointActualVelocity=[]), age=0), "no speeds are told, "),
    ],
)
def test_the_screen_says_what_is_wrong(state: MonitorState, said: str) -> None:
    assert said in "\n".join(drawn(state))


@for_each(
    "value, shown, style",
    [
        (0.0, "·····█·····", "green"),
        (0.6, "·····│━━█··", "green"),
        (-1.0, "█━━━━│·····", "yellow"),
        (0.99, "·····│━━━━█", "yellow"),
        (1.5, "·····│━━━━█", "bold red"),
    ],
)
def test_a_bar_shows_a_joint_between_its_limits(value: float, shown: str, style: str) -> None:
    text = bar(value, -1.0, 1.0, 11)
    assert text.plain == shown
    assert style in [span.style for span in text.spans]


def test_an_event_is_a_line() -> None:
    changed = aioduco.events.SafetyStateChanged(1.0, SafetyState.RUN, SafetyState.STOP1)
    assert changed.line() == "safety state changed from RUN to STOP1"
    assert changed.severity == "warning"
    started = aioduco.events.SafetyStateChanged(1.0, SafetyState.POWER_OFF, SafetyState.RUN)
    assert started.severity == "info"
    hit = aioduco.events.CollisionDetected(1.0, 3)
    assert (hit.line(), hit.severity) == ("collision detected: joint 3", "alarm")


def test_log_lines_name_commands_for_the_arm_that_is_watched() -> None:
    robot = aioduco.connect("10.0.0.7", 7004, heartbeat=None)
    watching = MonitorClient(robot, "left", 0, lambda _: None)
    lines = watching._lines
    lines.handle(logging.makeLogRecord({"msg": "call robot.recover()", "levelno": 30}))
    (line,) = watching._events
    assert (line.text, line.severity) == ("call `aioduco recover 10.0.0.7:7004`", "warning")


# -- keys ----------------------------------------------------------------------------------------


@for_each(
    "pieces, keys",
    [
        ([b" "], [Key.STOP]),
        ([b"sSpRq"], [Key.STOP, Key.STOP, Key.PAUSE, Key.RESUME, Key.QUIT]),
        ([b"x\n\xff?"], []),
        ([b"\x1b[A\x1bOP\x1b[15~\x1b[1;5R"], []),  # arrow up, F1, F5, an answer of the terminal
        ([b"\x1b[Cs"], [Key.STOP]),
        # F3 as it may come over a slow line, and with a modifier
        ([b"\x1b", b"OR", b"r"], [Key.RESUME]),
        ([b"\x1bO", b"Rr"], [Key.RESUME]),
        ([b"\x1b[1", b";2", b"R"], []),
        # Esc, then a key; a stop is one in any case
        ([b"\x1b", b"r"], [Key.RESUME]),
        ([b"\x1b[", b" "], [Key.STOP]),
        ([b"\x1b", b"s"], [Key.STOP]),
    ],
)
def test_a_key_asks_for_what_it_says_and_no_other_does(
    pieces: list[bytes], keys: list[Key]
) -> None:
    terminal = TerminalKeys(0)
    assert [key for piece in pieces for key in terminal.commands(piece)] == keys


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        yield bench


async def test_a_monitor_looks_on_and_disturbs_nobody(bench: Bench) -> None:
    """No heartbeat, no stop on leaving; a stop holds up no picture, and a picture no stop."""
    quiet: dict[str, Any] = {"heartbeat": None, "lag_limit": None, "call_timeout": 30.0}
    robot = aioduco.connect(bench.host, bench.port, state_rate=50.0, **quiet)
    states: list[MonitorState] = []
    free = threading.Event()
    free.set()

    def draw(state: MonitorState) -> None:
        states.append(state)
        free.wait(60)

    ours, keyboard = os.pipe()
    try:
        async with anyio.create_task_group() as watching:
            watching.start_soon(MonitorClient(robot, "left", ours, draw).watch)
            await eventually_async(lambda: states and states[-1].sample is not None)
            held = bench.hold("stop", 1)
            os.write(keyboard, b" ")
            await eventually_async(lambda: states[-1].busy == "stop")
            seen = len(states)
            await eventually_async(lambda: len(states) > seen + 3)
            held.set()
            await eventually_async(lambda: states[-1].notice is not None)
            bench.emergency_stop = True
            await eventually_async(
                lambda: any("emergency stop pressed" in each.text for each in states[-1].events)
            )
            stops = len(bench.received("stop"))
            free.clear()
            os.write(keyboard, b"s")
            await eventually_async(lambda: len(bench.received("stop")) > stops)
            free.set()
            await eventually_async(lambda: states[-1].busy == "")
            stops = len(bench.received("stop"))
            os.write(keyboard, b"q")
    finally:
        os.close(ours)
        os.close(keyboard)
    notice = states[-1].notice
    assert notice is not None
    assert (notice.text, notice.severity) == ("stopped: the arm stands", "good")
    assert states[-1].measured_rate > 0.0
    assert bench.received("rpc_heartbeat") == ()
    assert stops >= 2
    assert len(bench.received("stop")) == stops, "leaving stops nothing"


async def test_what_was_typed_before_the_arm_is_shown_resumes_nothing(bench: Bench) -> None:
    """As a line that was pasted behind the command: an R in it moved a paused arm."""
    robot = aioduco.connect(bench.host, bench.port, heartbeat=None, lag_limit=None)
    states: list[MonitorState] = []
    ours, keyboard = os.pipe()
    try:
        os.write(keyboard, b"r")
        async with anyio.create_task_group() as watching:
            watching.start_soon(MonitorClient(robot, "left", ours, states.append).watch)
            await eventually_async(lambda: states and states[-1].notice is not None)
            assert bench.received("resume") == ()
            await eventually_async(lambda: states[-1].sample is not None)
            os.write(keyboard, b"r")
            await eventually_async(lambda: bench.received("resume"))
            os.write(keyboard, b"q")
    finally:
        os.close(ours)
        os.close(keyboard)


@for_each("confirmed", [False, True])
async def test_a_stop_that_is_not_confirmed_is_an_error_at_the_end(confirmed: bool) -> None:
    """The screen that says so is gone then, and the command ended as if all were well."""
    told: list[StopUnconfirmed] = []
    states: list[MonitorState] = []
    ours, keyboard = os.pipe()

    async def watch(client: MonitorClient) -> None:
        try:
            await client.watch()
        except StopUnconfirmed as error:
            told.append(error)

    try:
        with Bench() as bench:
            robot = aioduco.connect(
                bench.host, bench.port, heartbeat=None, lag_limit=None, stop_timeout=0.1
            )
            bench.answer("stop", -1)
            async with anyio.create_task_group() as watching:
                watching.start_soon(watch, MonitorClient(robot, "left", ours, states.append))
                await eventually_async(lambda: states and states[-1].sample is not None)
                os.write(keyboard, b"s")
                await eventually_async(lambda: states[-1].notice is not None)
                if confirmed:
                    bench.answer("stop", 4)
                    os.write(keyboard, b"s")
                os.write(keyboard, b"q")
    finally:
        os.close(ours)
        os.close(keyboard)
    assert len(told) == (not confirmed)


# -- in a terminal -------------------------------------------------------------------------------


def moving(sim: Simulator, robot: aioduco.sync.Robot, to: float) -> aioduco.sync.Task:
    task = robot.motion.movej2.start((to, *HOME[1:]), v=0.05, a=2.0)
    wait_until_it_moves(sim)
    return task


@pytest.mark.slow
def test_in_a_terminal_it_shows_the_arm_and_stops_it() -> None:
    with (
        ready_arm() as sim,
        aioduco.sync.connect(
            sim.host, sim.port, heartbeat=30.0, call_timeout=30.0, clock=sim.clock
        ) as robot,
        terminal("monitor", at(sim), command=COMMAND) as shown,
    ):
        shown.until_it_shows(b"standing, no task")
        task = moving(sim, robot, 3.0)
        shown.until_it_shows(b"moving, task RUNNING")
        shown.press(b"p")
        shown.until_it_shows(b"paused: the arm stands")
        assert not sim.moving
        shown.press(b"r")
        wait_until_it_moves(sim)
        shown.press(b" ")
        shown.until_it_shows(b"stopped: the arm stands")
        with pytest.raises(aioduco.TaskStopped):
            task.wait()
        assert not sim.moving
        task = moving(sim, robot, -1.0)
        shown.press(b"p")
        shown.until_it_shows(b"paused: the arm stands")
        shown.press(b"r")
        shown.until_it_shows(b"resumed")
        shown.press(b"q")
        assert shown.exit_code() == 0
        sim.speed = 10.0
        assert task.wait() is Outcome.FINISHED, "leaving stops nothing"
        heartbeat = robot.heartbeat
        assert heartbeat is not None
        assert heartbeat.state is HeartbeatState.BEATING


@pytest.mark.slow
@pytest.mark.usefixtures("hangups")
@pytest.mark.parametrize("number", ENDS)
def test_a_signal_ends_it_and_stops_nothing(bench: Bench, number: signal.Signals) -> None:
    with terminal("monitor", f"{bench.host}:{bench.port}", command=COMMAND) as shown:
        shown.until_it_shows(b"standing, no task")
        os.killpg(shown.program.pid, number)
        shown.until_it_shows(b"nothing was stopped")
        assert shown.exit_code() == 128 + number
        assert b"Traceback" not in shown.seen, shown.seen.decode()
        assert bench.received("stop") == ()


@pytest.mark.linux("SIGHUP")
async def test_a_closed_terminal_ends_it_although_it_cannot_be_drawn_on(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port, heartbeat=None, lag_limit=None)
    ours, keyboard = os.pipe()

    def draw(state: MonitorState) -> None:
        if state.sample is not None:
            os.close(keyboard)
            raise OutputFailed(OSError(errno.EIO, "Input/output error"))

    try:
        with anyio.fail_after(60):
            told = await MonitorClient(robot, "left", ours, draw).watch()
    finally:
        os.close(ours)
    assert told is signal.SIGHUP
    assert bench.received("stop") == ()


@pytest.mark.slow
@pytest.mark.linux("SIGHUP")
def test_a_terminal_that_is_closed_ends_the_command(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)  # what is left unwritten is dropped
    words = ("monitor", f"{bench.host}:{bench.port}")
    with terminal(*words, command=COMMAND) as shown:
        shown.until_it_shows(b"standing, no task")
        shown.close()
        eventually(lambda: shown.program.poll() is not None, timeout=60)
        assert shown.program.returncode == 128 + signal.SIGHUP


@pytest.mark.slow
def test_it_needs_a_terminal_and_a_controller() -> None:
    answer = run("monitor")
    assert answer.exit_code == 2
    assert "aioduco status --json" in answer.stderr
    with terminal("monitor", "127.0.0.1:1", command=COMMAND) as shown:
        shown.until_it_shows(b"cannot connect to 127.0.0.1:1")
        assert shown.exit_code() == 1
