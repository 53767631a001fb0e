"""The same against the simulated arm, by a robot as programs have it."""

from __future__ import annotations

import subprocess
import sys
import time
from typing import TYPE_CHECKING, Any

import anyio
from streaming_arm import leftovers, runs
from streaming_load import HOST, RATE, Lateness, Noise, load, work_for

import aioduco
from aioduco.sim import Simulator

if TYPE_CHECKING:
    from aioduco.streaming.report import StreamStatistics

WAY = 0.05  # rad

PROGRAM = """
import sys
import anyio
import aioduco

async def main(port):
    async with aioduco.connect("127.0.0.1", int(port)) as robot:
        start = await robot.state.get_actual_joints_position()
        async with robot.servo.joints(v=1.0, a=5.0) as stream:
            for n in range(100_000):
                await stream.send([start[0] + 2e-4 * n, *start[1:]])
                if n == 400:
                    print(stream.pid, flush=True)

anyio.run(main, sys.argv[1])
"""


def sway(start: aioduco.Joints, seconds: float) -> list[list[float]]:
    """There and back on the first joint, a set-point each millisecond."""
    import numpy as np  # noqa: PLC0415  # only for this

    count = round(seconds * RATE)
    turns = np.linspace(0, 2 * np.pi * max(1, round(seconds / 4)), count)
    points = np.tile(np.array(start), (count, 1))
    points[:, 0] += WAY * (1 - np.cos(turns)) / 2
    return [list(map(float, point)) for point in points]


async def servo(robot: aioduco.Robot, seconds: float, noise: Noise) -> dict[str, Any]:
    start = await robot.state.get_actual_joints_position()
    async with load(True):
        with noise.beside():
            async with robot.servo.joints(v=1.0, a=20.0, rate=RATE, hold=5.0) as stream:
                for point in sway(start, seconds):
                    await stream.send(point)
    return figures(stream.statistics())


async def realtime(robot: aioduco.Robot, seconds: float) -> dict[str, Any]:
    start = await robot.state.get_actual_joints_position()
    async with load(True):
        opened = robot.realtime.stream("joint_position", v=1.0, a=20.0, depth=50, hold=5.0)
        async with opened as stream, anyio.create_task_group() as tasks:
            tasks.start_soon(stream.play, sway(start, seconds))
            await anyio.sleep(seconds / 2)
            work_for(0.3)
    found = stream.statistics()
    return figures(found) | {
        "drained": found.drained,
        "faults": len(await robot.state.get_last_error()),
    }


def figures(found: StreamStatistics) -> dict[str, Any]:
    lateness = Lateness()
    lateness.add(found.buckets["lateness"], found.ticks, found.missed)
    return row_of(lateness)


def row_of(lateness: Lateness) -> dict[str, Any]:
    row = lateness.figures()
    wanted = ("ticks", "missed", "late_p50_us", "late_p99_us", "late_p99.9_us", "late_max_us")
    return {name: row[name] for name in (*wanted, "beyond_2ms")}


async def killed(robot: aioduco.Robot, port: int) -> dict[str, Any]:
    """A program with a robot of its own is killed in mid stream; another one looks on."""
    before = leftovers()
    program = subprocess.Popen(  # noqa: ASYNC220  # it begins at once
        [sys.executable, "-c", PROGRAM, str(port)], stdout=subprocess.PIPE, text=True
    )
    assert program.stdout is not None
    worker = int(await anyio.to_thread.run_sync(program.stdout.readline))
    moving = await robot.state.robotmoving()
    program.kill()
    start = time.monotonic()
    program.communicate()
    while await robot.state.robotmoving() and time.monotonic() < start + 10:
        await anyio.lowlevel.checkpoint()
    stood = time.monotonic() - start
    while runs(worker) and time.monotonic() < start + 10:
        await anyio.lowlevel.checkpoint()
    places = [await robot.state.get_actual_joints_position() for _ in range(50)]
    stands = moving and abs(places[-1][0] - places[0][0]) < 1e-3
    return {
        "ms_to_standstill": round(stood * 1e3, 1),
        "stands": stands and not await robot.state.robotmoving(),
        "left": len(leftovers() - before),
    }


async def simulated(quick: bool) -> dict[str, dict[str, Any]]:
    """Against a simulated arm in a process of its own."""
    seconds = 2.0 if quick else 20.0
    # The stall is meant, so nobody needs to be warned of it.
    async with Simulator.spawn() as sim, aioduco.connect(HOST, sim.port, lag_limit=None) as robot:
        await robot.bring_up()
        noise = Noise()
        return {
            "servoj": await servo(robot, seconds, noise),
            "bare, beside servoj": row_of(noise.lateness),
            "realtime": await realtime(robot, seconds),
            "killed": await killed(robot, sim.port),
        }
