"""How services and containers end programs: a signal to all their processes at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from client.bench import HOME, Bench, under_way

import aioduco
from aioduco.testing import eventually, eventually_async

from .programs import PROGRAM, frozen, guard_of, running, started

MOVE = f"await robot.motion.movej2({HOME}, v=1.0, a=1.0).start()"


@pytest.mark.usefixtures("hangups")
@pytest.mark.linux("the guard's process")
@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("first", ["guard", "program"])
def test_a_signal_to_program_and_guard_leaves_a_standing_arm(
    bench: Bench, number: signal.Signals, first: str
) -> None:
    """As systemd does by default (KillMode=control-group), here without a heartbeat."""
    bench.motion_time = 600.0
    with started(bench.host, bench.port, MOVE, heartbeat=None) as program:
        pids = [program.guard, program.process.pid]
        for pid in pids if first == "guard" else reversed(pids):
            os.kill(pid, number)
        program.process.wait(30.0)
        eventually(lambda: not running(program.guard), timeout=30.0)
    assert bench.stops >= 1
    assert not bench.moving()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
async def test_a_guard_that_is_told_to_end_stops_the_arm_and_goes_on(
    bench: Bench, number: signal.Signals
) -> None:
    """The program may be ending in an orderly way, and needs its stop for that."""
    async with aioduco.connect(bench.host, bench.port, guard="process", heartbeat=60.0) as robot:
        guard, pid = guard_of(robot)
        for round_ in (1, 2):
            task = await under_way(bench, robot)
            os.kill(pid, number)
            assert await task.wait() is aioduco.Outcome.STOPPED
            assert bench.commands == round_ * ["movej2", "stop"]
        await robot.stop()
        assert guard.pid == pid
        assert guard.losses == 0
    await eventually_async(lambda: not running(pid), timeout=30.0)


@pytest.mark.slow
async def test_a_guard_that_is_told_to_end_stops_nobody_elses_arm(bench: Bench) -> None:
    async with (
        aioduco.connect(bench.host, bench.port) as mover,
        aioduco.connect(bench.host, bench.port, guard="process", heartbeat=60.0) as onlooker,
    ):
        task = await under_way(bench, mover)
        os.kill(guard_of(onlooker)[1], signal.SIGTERM)
        await onlooker.aclose()  # the guard has come to the signal before it comes to an end
        assert bench.stops == 0
        assert not task.done


@pytest.mark.linux("the guard's process")
@pytest.mark.slow
def test_who_reads_a_programs_output_to_its_end_does_not_wait_for_the_guard(bench: Bench) -> None:
    code = PROGRAM.format(host=bench.host, port=bench.port, deed="pass", heartbeat=60.0)
    child = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    with child:
        assert child.stdout is not None
        guard = int(child.stdout.readline())
        os.kill(guard, signal.SIGSTOP)
        try:
            eventually(lambda: frozen(guard), timeout=30.0)
            child.kill()
            child.communicate(timeout=30.0)  # comes to the end although the guard lives
            assert running(guard)
        finally:
            os.kill(guard, signal.SIGCONT)
    eventually(lambda: not running(guard), timeout=30.0)


@pytest.mark.slow
async def test_what_the_guard_has_to_say_is_in_the_programs_log(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    async with aioduco.connect(
        bench.host, bench.port, guard="process", heartbeat=60.0, loop_stall_limit=0.1
    ):
        eventually(lambda: "the event loop has not run" in caplog.text, timeout=30.0)
    assert "the guard says" in caplog.text
