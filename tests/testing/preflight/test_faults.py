"""Each planted fault is found, at its line, and nothing else is."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from cli_runner import CliRunner

from aioduco.cli.app import app
from aioduco.sim.scene import Box, Rod, Table, Thing
from aioduco.testing.preflight import PreflightSettings, preflight
from aioduco.testing.preflight.findings import KINDS

from .trying import tried

PROGRAMS = Path(__file__).parent / "programs"
CELLS: dict[str, list[Thing]] = {
    "box": [Box(at=(0.35, 0.35, 0.4), size=(0.2, 0.2, 0.8), name="box")],
    "table": [Table(at=(0.5, 0.1405, 0.3), name="table")],
    "part": [
        Rod(length=0.1, radius=0.01, mass=0.1),
        Box(at=(0, 0, 0.1), size=(0.04, 0.04, 0.04), mass=0.1, name="part"),
    ],
}


def planted(text: str) -> list[tuple[int, str]]:
    marked = enumerate(text.splitlines(), 1)
    return [(number, line.split("# FAULT ")[1]) for number, line in marked if "# FAULT " in line]


def cell(text: str, what: str) -> list[Thing] | None:
    named = re.search(f"^# {what} (.*)$", text, re.MULTILINE)
    return CELLS[named[1]] if named else None


def test_fourteen_kinds_are_planted() -> None:
    kinds = [kind for path in PROGRAMS.glob("*.py") for _, kind in planted(path.read_text("utf-8"))]
    assert len(set(kinds)) == 14
    assert set(kinds) <= set(KINDS)


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", sorted(path.stem for path in PROGRAMS.glob("*.py")))
def test_a_planted_fault_is_found_at_its_line(name: str) -> None:
    path = PROGRAMS / f"{name}.py"
    text = path.read_text("utf-8")
    settings = PreflightSettings(scene=cell(text, "SCENE"), tool=cell(text, "TOOL"), timeout=110)
    report = preflight(path, (), settings, quiet=True)
    found = [(finding.line, finding.kind) for finding in report.findings]
    assert sorted(found) == planted(text), "\n".join(map(str, report.findings))
    assert {finding.file for finding in report.findings} == {str(path)}
    assert not report.ok


@pytest.mark.slow
def test_an_arm_that_a_collision_with_an_allowed_thing_stops_is_a_finding() -> None:
    """It ends the program, as on a real arm."""
    settings = PreflightSettings(scene=CELLS["box"], allowed=("box",), timeout=110)
    report = preflight(PROGRAMS / "scene_collision.py", (), settings, quiet=True)
    (found,) = report.findings
    assert (found.kind, found.line) == ("collision", 16)
    assert "检测到碰撞" in found.text


SWEEPS = """
import aioduco.sync
with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    robot.motion.movel(robot.state.get_tcp_pose().shifted(x=0.1), v=0.2, a=0.5)
"""


def test_a_tool_without_a_name_is_the_tool(tmp_path: Path) -> None:
    """What it touched was none of the arm's contacts, unless it was hard enough to stop the arm."""
    (path := tmp_path / "sweeps.py").write_text(SWEEPS)
    scene = [
        Box(at=(0.58, 0.1405, 0.28), size=(0.1, 0.2, 0.06), name="shelf"),
        Box(at=(0.56, 0.1405, 0.36), size=(0.04, 0.1, 0.1), mass=0.05, name="cup"),
    ]
    settings = PreflightSettings(scene=scene, tool=[Rod(length=0.1, radius=0.01)], timeout=110)
    (found,) = preflight(path, (), settings, quiet=True).findings
    assert (found.kind, found.text) == ("collision of the tool", "the tool touches cup")


COMPUTES = """
import asyncio, time
import aioduco

def compute():
    until = time.monotonic() + 2.0
    while time.monotonic() < until:
        pass

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await asyncio.to_thread(compute)

asyncio.run(main())
"""


@pytest.mark.slow
def test_a_program_that_waits_for_its_own_thread_does_not_hang(tmp_path: Path) -> None:
    """Its time is the wall clock's meanwhile, once the thread has computed for long."""
    report = tried(tmp_path, COMPUTES)
    assert report.ok, report.findings
    assert report.duration > 2.0


ENDS = """
import asyncio, aioduco
HOME, THERE = [0, 0, 1.6, 0, -1.5, 0], [0.3, 0, 1.6, 0, -1.5, 0]

async def main():
    async with aioduco.connect("192.0.2.1") as robot:
        await robot.bring_up()
        for goal in [HOME, THERE] * 3:
            async with asyncio.timeout(8.0):  # the motion takes 0.8 s
                await robot.motion.movej2(goal, v=1.0, a=2.0)
            async with asyncio.timeout(8.0):
                await robot.stop()

asyncio.run(main())
"""


@pytest.mark.slow
def test_motions_and_stops_take_the_time_of_the_arm(tmp_path: Path) -> None:
    """Until their end was polled, up to half a minute passed: time-outs of seconds ended them."""
    (path := tmp_path / "ends.py").write_text(ENDS)
    report = preflight(path, (), PreflightSettings(timeout=110), quiet=True)
    assert report.ok, report.findings


ON_PURPOSE = """
import contextlib, time
import aioduco.sync

with aioduco.sync.connect("192.0.2.1") as robot:
    robot.bring_up()
    begin = time.monotonic()
    robot.sleep(40.0)
    assert 40.0 <= time.monotonic() - begin < 45.0
    begin = time.monotonic()
    with contextlib.suppress(TimeoutError):
        robot.wait_for(lambda sample: sample.io.input(1), timeout=4.0)
    assert time.monotonic() - begin < 20.0
"""


@pytest.mark.slow
def test_a_wait_with_an_end_is_no_endless_one(tmp_path: Path) -> None:
    """It was one after three seconds, in which half an hour of the program passed."""
    (path := tmp_path / "waits.py").write_text(ON_PURPOSE)
    report = preflight(path, (), PreflightSettings(patience=20.0, timeout=110), quiet=True)
    assert report.ok, report.findings


WAITS = """
import concurrent.futures, contextlib, queue, threading, time
import aioduco.sync

never, fired, condition = threading.Event(), threading.Event(), threading.Condition()
idle = threading.Thread(target=never.wait, daemon=True)

def get():
    with contextlib.suppress(queue.Empty):
        queue.Queue().get(timeout=2.0)

def wait_for():
    with condition:
        condition.wait_for(never.is_set, 2.0)

def timer():
    threading.Timer(2.0, fired.set).start()
    fired.wait()

def pool():
    with concurrent.futures.ThreadPoolExecutor() as pool, contextlib.suppress(TimeoutError):
        done = pool.submit(time.sleep, 2.0)
        next(concurrent.futures.as_completed([done], 1.0))
    assert done.done()

with aioduco.sync.connect("192.168.1.10"):
    idle.start()
    for call in (
        *(lambda: never.wait(2.0), lambda: threading.Semaphore(0).acquire(timeout=2.0)),
        *(lambda: idle.join(2.0), get, wait_for, timer, pool),
    ):
        begin = time.monotonic()
        call()
        assert 1.99 < time.monotonic() - begin < 10.0, (call, time.monotonic() - begin)
"""


def test_waits_of_threads_end_at_their_time(tmp_path: Path) -> None:
    report = tried(tmp_path, WAITS)
    assert report.ok, report.findings


#: what the two programs below have a thread compute
COMPUTING = """
import time

def wall():  # which no preflight replaces
    return time.clock_gettime(time.CLOCK_MONOTONIC)

def computes():
    begin = time.thread_time()
    while time.thread_time() - begin < 0.1:
        pass
"""

IN_THREADS = """
import asyncio
import anyio.to_thread
import aioduco

async def main():
    async with aioduco.connect("192.168.1.10"):
        for threads in (
            lambda call: asyncio.to_thread(call),
            lambda call: anyio.to_thread.run_sync(call),
            lambda call: asyncio.get_running_loop().run_in_executor(None, call),
        ):
            for call, shortest in ((computes, 0.0), (lambda: time.sleep(3.0), 3.0)):
                begin, real = time.monotonic(), wall()
                await threads(call)
                took, real = time.monotonic() - begin, wall() - real
                assert shortest <= took < shortest + real + 0.5, (call, took, real)

asyncio.run(main())
"""


def test_what_a_thread_computes_for_a_loop_takes_no_more_than_its_time(tmp_path: Path) -> None:
    report = tried(tmp_path, COMPUTING + IN_THREADS)
    assert report.ok, report.findings


BY_POOLS = """
from concurrent.futures import ThreadPoolExecutor
import aioduco.sync

def goes():
    robot.motion.movej2((0.3, 0.0, 1.5, 0.0, -1.5, 0.0), v=1.0, a=2.0)

with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    for call, shortest in ((computes, 0.0), (goes, 0.1), (lambda: time.sleep(3.0), 3.0)):
        begin, real = time.monotonic(), wall()
        with ThreadPoolExecutor(1) as pool:
            pool.submit(call).result()
            waits = [pool.submit(time.sleep, 1.0) for _ in range(2)]
        took, real = time.monotonic() - begin, wall() - real
        assert shortest + 2.0 <= took < shortest + 2.0 + real + 2.0, (call, took, real)
"""


def test_what_a_thread_computes_for_a_program_takes_no_more_than_its_time(tmp_path: Path) -> None:
    """A motion in a pool took as long as the computer simulated, 15 s."""
    report = tried(tmp_path, COMPUTING + BY_POOLS)
    assert report.ok, report.findings


LIMITED = """
import time
import aioduco.sync

with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    task = robot.motion.movej2.start((3.0, 0.0, 1.5, 0.0, -1.5, 0.0), v=0.1, a=1.0)
    begin = time.monotonic()
    try:
        task.wait(timeout=0.5)
    except TimeoutError:
        pass
    else:
        raise AssertionError("a motion of half a minute has ended")
    assert 0.4 < time.monotonic() - begin < 20.0
    task.cancel()
    with robot.events.subscribe() as events:
        begin = time.monotonic()
        try:
            while True:
                events.next(timeout=0.5)
        except TimeoutError:
            pass
        assert time.monotonic() - begin < 20.0
"""


@pytest.mark.slow
def test_a_wait_with_a_time_limit_takes_no_more_than_that(tmp_path: Path) -> None:
    report = tried(tmp_path, LIMITED)
    assert report.ok, report.findings


SLEEPS = """
import time
import aioduco.sync

with aioduco.sync.connect("192.168.1.10"):
    for _ in range(10_000):
        time.sleep(0.0005)
"""


@pytest.mark.slow
def test_short_sleeps_of_a_program_that_polls_do_not_hang(tmp_path: Path) -> None:
    """One in some thousands waited for the clock, which waited for it."""
    assert tried(tmp_path, SLEEPS).ok


NOBODY_GETS = """
import asyncio, sys, threading, aioduco

def in_thread():
    1 / 0                                   # 5

def in_callback():
    1 / 0                                   # 8

async def in_task():
    1 / 0                                   # 11

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        for target in (lambda: sys.exit(1), in_thread):
            thread = threading.Thread(target=target)
            thread.start()
            thread.join()
        asyncio.get_running_loop().call_soon(in_callback)
        await robot.state.get_robot_state()
        asyncio.create_task(in_task())
        await robot.state.get_robot_state()

asyncio.run(main())
"""


@pytest.mark.slow
def test_an_error_that_nobody_gets_is_a_finding(tmp_path: Path) -> None:
    report = tried(tmp_path, NOBODY_GETS)
    assert [(each.kind, each.line, each.text) for each in report.findings] == [
        ("error", line, "ZeroDivisionError: division by zero") for line in (5, 8, 11)
    ]


CALLS = """
import asyncio
import aioduco

async def go(robot, x):
    try:
        await robot.motion.movel((x, 0.0, 0.5, 3.14, 0.0, 0.0), v=0.2, a=0.5)
    except aioduco.DucoError:
        pass

async def main():
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await go(robot, 5.0)
        await robot.motion.movej2((0.0, -0.3, 1.8, 0.0, -1.57, 0.0), v=1.0, a=1.0)
        await go(robot, -5.0)

asyncio.run(main())
"""


@pytest.mark.slow
def test_a_fault_in_a_function_is_shown_with_each_line_that_calls_it(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(CALLS, encoding="utf-8")
    done = CliRunner().invoke(app, ["preflight", str(program), "--quiet"])
    assert done.exit_code == 1, done.output
    for line in (14, 16):
        assert f"{program}:7: unreachable: " in done.output
        assert f"(called from {program}:{line})" in done.output.replace("\n", "")
    # before the table, which may be longer than the terminal
    assert done.output.index("unreachable") < done.output.index("what the program did")
    assert "found: 2 problems" in done.output
