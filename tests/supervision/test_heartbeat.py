"""The heartbeat runs beside the event loop, and stops when the loop hangs."""

from __future__ import annotations

import asyncio
import itertools
import logging
import math
import statistics
import subprocess
import sys
import textwrap
import threading
import time
from types import SimpleNamespace
from typing import cast

import anyio
import pytest
from client.bench import HOME, Bench

import aioduco
from aioduco import HeartbeatState
from aioduco._process.platform import boot_time
from aioduco._wire.connection import Connection
from aioduco._wire.endpoint import Endpoint
from aioduco._wire.own_connection import OwnConnection
from aioduco.supervision import heartbeat as heartbeats
from aioduco.supervision.gate import Gate
from aioduco.supervision.heartbeat import Heartbeat
from aioduco.supervision.loop_watchdog import Liveness
from aioduco.supervision.opening_and_closing import until_beating
from aioduco.testing import Cut, FaultProxy, Place, eventually, eventually_async


def beats(bench: Bench) -> int:
    return len(bench.received("rpc_heartbeat"))


def state(robot: aioduco.Robot) -> HeartbeatState:
    figures = robot.heartbeat
    assert figures is not None
    return figures.state


def stalls(robot: aioduco.Robot) -> int:
    figures = robot.heartbeat
    assert figures is not None
    return figures.stalls


async def test_beats_three_times_per_heartbeat_time(bench: Bench) -> None:
    def steady() -> bool:
        """Whether the latest beats came over one connection, a third of the time apart."""
        calls = bench.received("rpc_heartbeat")[-10:]
        gap = statistics.median(b.at - a.at for a, b in itertools.pairwise(calls))
        return len({call.thread for call in calls}) == 1 and gap == pytest.approx(0.1, rel=0.3)

    async with aioduco.connect(bench.host, bench.port, heartbeat=0.3) as robot:
        await eventually_async(lambda: beats(bench) >= 10)
        # A machine that is busy just now is late, and a beat that is late is sent anew; once it is
        # not, the beats come in time.
        await eventually_async(steady, timeout=60.0)
        await eventually_async(lambda: state(robot) is HeartbeatState.BEATING)
    calls = bench.received("rpc_heartbeat")
    assert {call.args for call in calls} == {(300,)}
    others = {c.thread for c in bench.received() if c.method != "rpc_heartbeat"}
    assert calls[-1].thread not in others  # nothing else goes over it


async def test_no_heartbeat_on_request(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port, heartbeat=None) as robot:
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert robot.heartbeat is None
        assert robot.statistics().heartbeat is None
        await robot.rearm_heartbeat()
    assert beats(bench) == 0


async def test_a_short_stall_of_the_loop_does_not_stop_the_beat(bench: Bench) -> None:
    async with aioduco.connect(
        bench.host, bench.port, heartbeat=0.2, loop_stall_limit=20.0
    ) as robot:
        before = beats(bench)
        # Blocks the event loop meanwhile. One beat that a busy machine delays is found lost.
        eventually(lambda: beats(bench) >= before + 6 and state(robot) is HeartbeatState.BEATING)


async def test_a_beat_whose_time_has_passed_does_not_rearm() -> None:
    now = boot_time()
    gate = Gate(0.5, 2.0, now)
    gate.beaten(now - 10.0)  # the heartbeat has an answer of which the gate does not know yet
    answered = cast("Heartbeat", SimpleNamespace(state=HeartbeatState.BEATING))
    assert not await until_beating(answered, gate, 0.0)
    gate.beaten(now + 60.0)
    assert await until_beating(answered, gate, 0.0)


@pytest.mark.slow
async def test_a_loop_that_hangs_again_while_it_is_rearmed_is_told_as_such(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    async with aioduco.connect(
        bench.host, bench.port, heartbeat=60.0, loop_stall_limit=1.0
    ) as robot:
        loop, never = asyncio.get_running_loop(), threading.Event()

        def hang(milliseconds: int) -> None:
            loop.call_soon_threadsafe(eventually, lambda: stalls(robot) == 2)
            never.wait(1.5)  # the controller's time for an answer

        bench.answer("rpc_heartbeat", hang)
        with caplog.at_level(logging.CRITICAL, "aioduco"):
            eventually(lambda: stalls(robot) == 1)  # blocks the event loop
            with pytest.raises(aioduco.HeartbeatLost, match=r"hung again.*rearm_heartbeat"):
                await robot.rearm_heartbeat(timeout=60.0)


@pytest.mark.slow
async def test_a_hung_loop_stops_the_beat_until_rearmed(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    limit = 2.0  # a busy machine does not hold up a loop for so long, a loop that hangs is
    async with aioduco.connect(
        bench.host, bench.port, heartbeat=1.5, loop_stall_limit=limit
    ) as robot:
        with caplog.at_level(logging.CRITICAL, "aioduco"):
            eventually(lambda: state(robot) is HeartbeatState.STALLED)  # blocks the event loop
        stalled = beats(bench)
        # The loop runs again, and still there is no beat: several times that between two pass.
        with anyio.move_on_after(1.5):
            await eventually_async(lambda: beats(bench) > stalled, timeout=5)
        assert beats(bench) == stalled
        with pytest.raises(aioduco.HeartbeatLost, match=r"the event loop hung.*rearm_heartbeat"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert "movej2" not in bench.commands
        await robot.stop()  # a stop is never refused
        await robot.rearm_heartbeat()
        assert state(robot) is HeartbeatState.BEATING
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
        figures = robot.heartbeat
        assert figures is not None
        assert figures.stalls == 1
        # late by the stall limit, less the time to the keep-alive that was due
        assert robot.statistics().longest_stall > 0.8 * limit


class Line(Connection):
    """A connection that notes what it is to call, and answers all of it."""

    def __init__(self, noted: list[object]) -> None:
        super().__init__(Endpoint("192.0.2.1", 7003))
        self._noted = noted

    def call(self, name: str, *_: object) -> object:
        self._noted.append(name)
        return 0


def test_a_keep_alive_that_was_due_before_the_robot_was_opened_is_not_late() -> None:
    life = Liveness()
    life.touch(life.ran - 60.0)
    assert life.longest_stall < 60.0


def test_a_hung_loop_is_reported_before_the_arm_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    """A program that sees its arm stand would otherwise move it, and not be told why it stood."""
    noted: list[object] = []
    life = Liveness()
    life.moves = True
    own = OwnConnection(Endpoint("192.0.2.1", 7003, 1.0))
    monkeypatch.setattr(own, "ready", lambda _: Line(noted))
    heartbeat = Heartbeat(own, 30.0, life, 0.05, lambda h: noted.append(h.state))
    heartbeat.start()
    eventually(lambda: "stop" in noted)
    heartbeat.end()
    assert heartbeat.join(30.0)
    assert noted[noted.index("stop") - 1] is HeartbeatState.STALLED


@pytest.mark.slow
async def test_a_lost_heartbeat_is_reported_and_comes_back(
    bench: Bench, proxy: FaultProxy, caplog: pytest.LogCaptureFixture
) -> None:
    async with aioduco.connect(proxy.host, proxy.port, heartbeat=2.0) as robot:
        await eventually_async(lambda: beats(bench) >= 2)
        proxy.on("rpc_heartbeat", Cut(Place.BEFORE_REQUEST), times=None)
        await eventually_async(lambda: state(robot) is HeartbeatState.LOST)
        with pytest.raises(aioduco.HeartbeatLost, match="does not answer it"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        proxy.clear()
        await eventually_async(lambda: state(robot) is HeartbeatState.BEATING)
        await robot.motion.movej2(HOME, v=1.0, a=1.0)
    messages = [record.getMessage() for record in caplog.records]
    assert any("no heartbeat was answered for 2 s" in message for message in messages)
    assert any("answered again" in message for message in messages)


def test_one_beat_without_an_answer_is_repeated_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time is the test's own."""
    now, sent = 100.0, list[float]()

    def pass_by(seconds: float) -> bool:
        nonlocal now
        now += seconds
        return False

    def call(name: str, _: object, timeout: float) -> None:
        assert name == "rpc_heartbeat"
        sent.append(now)
        if len(sent) == 3:
            pass_by(timeout)
            raise aioduco.CallTimeout("it is silent")
        if len(sent) == 5:
            heartbeat.end()

    monkeypatch.setattr(heartbeats, "boot_time", lambda: now)
    monkeypatch.setattr(heartbeats, "time", SimpleNamespace(monotonic=lambda: now))
    own = OwnConnection(Endpoint("192.0.2.1", 7003, 1.0))
    monkeypatch.setattr(own, "ready", lambda _: SimpleNamespace(call=call))
    heartbeat = Heartbeat(own, 3.0, Liveness(), math.inf, lambda _: None)
    monkeypatch.setattr(heartbeat._nudge, "wait", pass_by)
    heartbeat.start()
    assert heartbeat.join(30.0)
    assert sent == pytest.approx([100.0, 101.0, 102.0, 103.0, 104.0])
    figures = heartbeat.statistics()
    assert figures.state is HeartbeatState.BEATING
    assert (figures.missed, figures.losses) == (1, 0)


async def test_leaving_ends_the_heartbeat_at_once(bench: Bench) -> None:
    gate = bench.hold("rpc_heartbeat", None)
    gate.set()
    async with aioduco.connect(bench.host, bench.port, heartbeat=60.0):
        gate.clear()
        before = time.monotonic()
    # Neither the next beat, 20 s off, nor one that hangs is waited for.
    assert time.monotonic() - before < 10
    await eventually_async(lambda: bench.connections == 0)


FORGOTTEN = """
    import asyncio
    import aioduco

    async def main():
        robot = aioduco.connect({host!r}, {port}, heartbeat=0.2)
        await robot.open()
        await robot.motion.movej2([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0).start()
        {end}

    asyncio.run(main())
"""


KEPT = """
    import asyncio
    import atexit
    import threading
    import aioduco

    guards = []
    ends, held = threading.Event(), threading.Event()

    def hold():
        ends.wait()
        with guards.pop():
            held.set()
            threading.Event().wait()

    def at_exit():
        ends.set()
        held.wait()

    async def main():
        robot = aioduco.connect({host!r}, {port}, heartbeat=0.2)
        await robot.open()
        guards.append(robot._supervisor.heartbeat._own.connection._guard)
        raise SystemExit(0)

    atexit.register(at_exit)
    threading.Thread(target=hold, daemon=True).start()
    asyncio.run(main())
"""


ON_A_THREAD = """
    import asyncio
    import atexit
    import threading
    import aioduco

    moves, told = threading.Event(), threading.Event()

    async def main():
        robot = aioduco.connect({host!r}, {port})
        await robot.open()
        motion = robot.motion.movej2([0, 0, 1.5, 0, -1.5, 0], v=1.0, a=1.0)
        task = await motion.start()
        moves.set()
        await task.wait()
        try:
            await motion.start()
        except aioduco.RobotStateError as exc:
            print(exc)
        finally:
            told.set()

    atexit.register(told.wait)
    threading.Thread(target=asyncio.run, args=(main(),), daemon=True).start()
    moves.wait()
"""


@pytest.mark.slow
def test_a_loop_on_a_thread_moves_nothing_when_the_interpreter_has_stopped_the_arm(
    bench: Bench,
) -> None:
    """It runs on until the process has ended, which a handler of the program may hold up."""
    bench.motion_time = 30.0
    script = textwrap.dedent(ON_A_THREAD.format(host=bench.host, port=bench.port))
    ended = subprocess.run(
        [sys.executable, "-c", script], check=True, capture_output=True, text=True, timeout=60
    )
    assert "movej2 was not sent: the program ends" in ended.stdout
    assert bench.commands[-1] == "stop"


@pytest.mark.slow
def test_a_lock_of_a_thread_that_has_ended_holds_up_no_end(bench: Bench) -> None:
    """As the interpreter ends, its daemons end wherever they are."""
    script = textwrap.dedent(KEPT.format(host=bench.host, port=bench.port))
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, timeout=30)


@pytest.mark.slow
@pytest.mark.parametrize("end", ["return", "raise SystemExit(3)", "1 / 0"])
def test_a_program_that_ends_without_closing_beats_no_more(bench: Bench, end: str) -> None:
    """The heartbeat's thread must not keep a finished program, and its arm, alive."""
    bench.motion_time = 30.0
    script = textwrap.dedent(FORGOTTEN.format(host=bench.host, port=bench.port, end=end))
    subprocess.run([sys.executable, "-c", script], check=False, capture_output=True, timeout=30)
    eventually(lambda: bench.connections == 0)
    assert beats(bench) > 0
