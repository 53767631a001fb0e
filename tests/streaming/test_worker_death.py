"""Worker, program or connection ends in any way: the arm comes to rest, nothing is left."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import anyio
import anyio.lowlevel
import numpy as np
import pytest
from anyio.abc import TaskGroup
from hostile.programs import running

from aioduco.api.streams.servo import Servo
from aioduco.errors import WorkerFailed
from aioduco.streaming.session import Session
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.testing import eventually, eventually_async, no_leaks

from .conftest import HERE, Controller, came_to_rest, shared_files

RATE = 500
ACCELERATION = 5.0

PROGRAM = """
import sys
import anyio
from aioduco.api.streams.servo import Servo
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import WorkerOptions

here = [0.0, -0.1, 0.2, 0.3, 0.4, 0.5]

async def main(host, port, run_in):
    stream = Servo(StreamEndpoint(host, int(port), stall_limit=15.0)).joints(
        v=1.0, a=5.0, rate=500, options=WorkerOptions(run_in=run_in, away_limit=20.0)
    )
    async with stream:
        number = 0
        while True:
            # speeds up to 0.4 rad/s, then goes on at that
            way = 5e-6 * number**2 if number < 80 else 0.032 + 8e-4 * (number - 80)
            await stream.send([angle + way for angle in here])
            if number == 200:
                print(stream.pid, flush=True)
            number += 1

anyio.run(main, *sys.argv[1:])
"""


@contextmanager
def started(controller: Controller) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A program in the middle of a stream, and its worker's process, which is to end by itself."""
    server = controller.server
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, server.host, str(server.port), "process"],
        stdout=subprocess.PIPE,
        text=True,
        # a group of its own, so that a test can send it what a terminal would
        process_group=0,
    ) as program:
        try:
            assert program.stdout is not None
            worker = int(program.stdout.readline())
            assert running(worker)
            yield program, worker
            eventually(lambda: not running(worker), what="the worker's process is gone")
            assert decelerated(controller)
        finally:
            program.kill()


def decelerated(controller: Controller) -> bool:
    """Whether what was sent came to rest from 0.4 rad/s at the limit of acceleration.

    That takes 40 ticks. Where a busy machine missed some of them, a place is not that of the next
    tick, and only the way tells how the speed fell.
    """
    places = np.array(controller.points())[:, 0]
    asked = (places - HERE[0] - 0.032) / 8e-4  # whole numbers, while the worker follows
    begin = np.flatnonzero((asked > 0) & (np.abs(asked - asked.round()) > 1e-6))[0] - 1
    slowing = places[begin : places.argmax() + 1]
    if len(slowing) > 40:
        assert np.abs(np.diff(slowing, n=2)).max() * RATE**2 <= ACCELERATION * (1 + 1e-6)
    return bool(places[-1] == places[-2] and slowing[-1] - slowing[0] > 0.6 * 0.016)


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_a_program_killed_in_mid_stream(controller: Controller, how: signal.Signals) -> None:
    with started(controller) as (program, worker):
        shared = shared_files(program.pid, worker)
        program.send_signal(how)
    eventually(lambda: controller.server.connections == 0)
    assert controller.names()[-1] == "stop"
    assert not any(file.exists() for file in shared)


@pytest.mark.slow
def test_a_program_that_hangs_starves_its_stream(controller: Controller) -> None:
    with started(controller) as (program, _):
        program.send_signal(signal.SIGSTOP)
    assert controller.names()[-1] == "stop"


@pytest.mark.slow
def test_ctrl_c_ends_the_program_and_its_stream_in_order(controller: Controller) -> None:
    with started(controller) as (program, _):
        # A terminal sends it to every process of the group; the worker is in none of them.
        os.killpg(program.pid, signal.SIGINT)
        program.wait(10)
    assert "stop" not in controller.names()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "told"),
    [
        (signal.SIGKILL, "SIGKILL"),
        (signal.SIGSTOP, "SIGKILL"),  # it stands still, and is killed for that
        pytest.param(
            getattr(signal, "SIGRTMIN", 34) + 1,
            "signal {number}",
            marks=pytest.mark.linux("real-time signals"),
        ),
    ],
)
async def test_a_worker_killed_in_mid_stream_is_an_error_and_the_robot_is_stopped(
    controller: Controller, monkeypatch: pytest.MonkeyPatch, number: int, told: str
) -> None:
    monkeypatch.setattr(Session, "_end_timeout", 0.5)
    stream = Servo(controller.endpoint).joints(v=1.0, a=5.0, rate=RATE)

    async def program() -> None:
        async with stream:
            await stream.send(HERE)
            assert stream.pid is not None
            os.kill(stream.pid, number)
            while number != signal.SIGSTOP:
                await stream.send(HERE)

    async with no_leaks():
        with pytest.raises(WorkerFailed, match=f"killed by {told.format(number=number)}"):
            await program()
    assert controller.stops == ["stop"]


def on_the_way(number: int) -> list[float]:
    """A set-point of a way that speeds up to 0.4 rad/s, then goes on at that."""
    way = 5e-6 * number**2 if number < 80 else 0.032 + 8e-4 * (number - 80)
    return [angle + way for angle in HERE]


async def test_a_worker_told_to_end_by_the_system_decelerates(controller: Controller) -> None:
    stream = controller.servo.joints(v=1.0, a=ACCELERATION, rate=RATE)

    async def program() -> None:
        async with stream:
            for n in range(400):
                if n == 200:
                    assert stream.pid is not None
                    os.kill(stream.pid, signal.SIGTERM)
                await stream.send(on_the_way(n))
            await stream.ended()

    with pytest.raises(WorkerFailed, match="by a signal"):
        await program()
    assert came_to_rest(controller, RATE, ACCELERATION, stream.statistics().missed)
    assert decelerated(controller)
    assert controller.names()[-1] == "stop"


@pytest.mark.slow
@pytest.mark.parametrize("run_in", ["process", "thread"])
async def test_one_stream_after_the_other_leaves_nothing(
    controller: Controller, run_in: str
) -> None:
    options = WorkerOptions(run_in=run_in)  # type: ignore[arg-type]
    count = 40 if run_in == "thread" else 3
    async with no_leaks():
        for _ in range(count):
            async with controller.servo.joints(v=1.0, a=5.0, options=options) as stream:
                await stream.send(HERE)
    await eventually_async(lambda: controller.server.connections == 0)


async def test_a_thread_worker_ends_with_its_face_gone(controller: Controller) -> None:
    """A worker whose program side is closed without a word behaves as if the program had died."""
    stream = controller.servo.joints(
        v=1.0, a=ACCELERATION, rate=RATE, options=WorkerOptions(run_in="thread")
    )

    async def program() -> None:
        async with stream:
            for n in range(150):
                await stream.send(on_the_way(n))
            link = stream._session._link
            assert link is not None
            link.shutdown(2)
            with anyio.fail_after(10):
                await stream.ended()

    with pytest.raises(WorkerFailed, match="lost sight of the program"):
        await program()
    assert controller.names()[-1] == "stop"


@pytest.mark.slow
@pytest.mark.timeout(30)
async def test_sending_with_one_set_point_ahead_lets_the_event_loop_run(
    controller: Controller,
) -> None:
    """Also while a worker that stands still takes no set-point, and when it is killed then."""
    stream = controller.servo.joints(v=1.0, a=5.0, rate=RATE, ahead=1)
    sent = 0

    async def kill_it_when_nothing_is_sent_any_more() -> None:
        before = -1
        while sent != before:
            before = sent
            for _ in range(20):
                await anyio.lowlevel.checkpoint()
        assert stream.pid is not None
        os.kill(stream.pid, signal.SIGKILL)

    async def program(tasks: TaskGroup) -> None:
        nonlocal sent
        async with stream:
            await stream.send(HERE)
            assert stream.pid is not None
            os.kill(stream.pid, signal.SIGSTOP)
            tasks.start_soon(kill_it_when_nothing_is_sent_any_more)
            while True:
                await stream.send(HERE)
                sent += 1

    async with no_leaks(), anyio.create_task_group() as tasks:
        with pytest.raises(WorkerFailed, match="killed by SIGKILL"):
            await program(tasks)
