"""How late the end of a motion is noticed, and how soon a stop is with the controller.

The controller is a process of its own with trivial handlers; both sides read CLOCK_MONOTONIC.
Beside this package's poller stand the loops that applications write, and beside its stop lane
the ways that share a connection or a pool.
"""

from __future__ import annotations

import os
import random
import time
from typing import TYPE_CHECKING, Any

import anyio
from _common import ServerProcess, arguments, print_table, spread, write_results

import aioduco
from aioduco._wire import rpc
from aioduco._wire.lane import WireLane
from aioduco.models.enums import TaskState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

HOST = "127.0.0.1"
#: joints, speed and acceleration of a move from zero; its time is what the client expects
SPEED, ACCELERATION = 1.0, 100.0

Figures = dict[str, Any]

SCHEDULING = {os.SCHED_OTHER: "normal", os.SCHED_FIFO: "real-time (chrt -f)"}


class Bench:
    """A robot, and a lane beside it that sets the controller up and reads its times."""

    def __init__(self, robot: aioduco.Robot, lane: WireLane) -> None:
        self.robot = robot
        self.lane = lane
        self.random = random.Random(1)

    async def duration(self) -> float:
        """Choose how long the next motion takes, and tell the controller."""
        seconds = self.random.uniform(0.2, 0.6)
        await self.lane.rpc.set_system_value_double("duration", seconds)
        return seconds

    async def end(self, task_id: int) -> float:
        """When a task ended in the controller."""
        return (await self.lane.rpc.get_system_value_list(str(task_id)))[0]


# -- (a) the end of a motion -------------------------------------------------------------------


async def followed(bench: Bench, motion: aioduco.MotionCommand) -> float:
    task = await motion.start()
    await task
    assert task.ended_at is not None
    return task.ended_at - await bench.end(task.id)


async def expected(bench: Bench) -> float:
    """A joint move: its end can be computed from where the arm is."""
    seconds = await bench.duration()
    way = (seconds - SPEED / ACCELERATION) * SPEED
    return await followed(bench, bench.robot.motion.movej2([way] * 6, SPEED, ACCELERATION))


async def slowed(bench: Bench) -> float:
    """A joint move that takes twice as long as computed: the speed slider is at a half."""
    seconds = await bench.duration()
    way = (seconds / 2 - SPEED / ACCELERATION) * SPEED
    return await followed(bench, bench.robot.motion.movej2([way] * 6, SPEED, ACCELERATION))


async def unexpected(bench: Bench) -> float:
    """A move along a line: its end cannot be computed."""
    await bench.duration()
    return await followed(bench, bench.robot.motion.movel([0.5, 0, 0.5, 0, 0, 0], 0.1, 1.0))


async def blocking(bench: Bench) -> float:
    """The controller's own blocking call: the earliest possible notice, but it cannot be left."""
    await bench.duration()
    task_id = await bench.lane.within(None).speed(1.0)
    return time.monotonic() - await bench.end(task_id)


def loop(pause: float) -> Callable[[Bench], Awaitable[float]]:
    """The loop that applications write: ask, sleep, ask again."""

    async def polled(bench: Bench) -> float:
        await bench.duration()
        task_id = int(await bench.lane.call("movel", MOVEL))
        state = -1
        while state != TaskState.FINISHED:
            await anyio.sleep(pause)
            state = await bench.lane.rpc.get_noneblock_taskstate(task_id)
        return time.monotonic() - await bench.end(task_id)

    return polled


async def ends(bench: Bench, count: int) -> dict[str, Figures]:
    cases: dict[str, Callable[[Bench], Awaitable[float]]] = {
        "aioduco, end expected (movej2)": expected,
        "aioduco, end not expected (movel)": unexpected,
        "aioduco, expected too early (speed at 50 %)": slowed,
        "blocking call": blocking,
        "ask, sleep 10 ms": loop(0.01),
        "ask, sleep 50 ms": loop(0.05),
    }
    late: dict[str, list[float]] = {name: [] for name in cases}
    asked = dict.fromkeys(cases, 0)
    # In turn: whatever else the machine does meanwhile meets all of them alike.
    for _ in range(count):
        for name, case in cases.items():
            polls, others = bench.robot.statistics().polls, bench.lane.statistics().calls
            late[name].append(await case(bench))
            # A motion also takes a call before it and one after it; beside the robot, its start.
            own = bench.lane.statistics().calls - others - (2 if "aioduco" in name else 3)
            asked[name] += bench.robot.statistics().polls - polls + own
    return {
        name: spread(late[name]) | {"polls_each": round(asked[name] / count, 1), "motions": count}
        for name in cases
    }


MOVEL: tuple[Any, ...] = ([0.5, 0, 0.5, 0, 0, 0], 0.1, 1.0, 0.0, [], "", "", False, rpc.Op(), False)

# -- (b) the stop ------------------------------------------------------------------------------


async def stops(bench: Bench, send: Callable[[], Awaitable[object]], count: int) -> list[float]:
    """Seconds from the call to the controller's handler."""
    await bench.lane.rpc.get_system_value_list("stops")
    called: list[float] = []
    for _ in range(count):
        await anyio.sleep(bench.random.uniform(0.0005, 0.002))
        called.append(time.monotonic())
        await send()
    reached = await bench.lane.rpc.get_system_value_list("stops")
    assert len(reached) == count, (len(reached), count)
    return [at - begin for begin, at in zip(called, reached, strict=True)]


async def stopping(bench: Bench, count: int) -> dict[str, Figures]:
    figures: dict[str, Figures] = {}

    def add(name: str, seconds: list[float]) -> None:
        figures[name] = spread(seconds) | {"stops": len(seconds)}

    robot = bench.robot
    add("robot.stop(), pool idle", await stops(bench, robot.stop, count))
    async with anyio.create_task_group() as tg:
        for _ in range(8):
            tg.start_soon(robot.io.set_standard_digital_out, 1, True)
        while robot.statistics().lanes["call"].busy < 4:  # noqa: ASYNC110  # figures ring no bell
            await anyio.sleep(0.001)
        add("robot.stop(), every pool thread in a call", await stops(bench, robot.stop, count))
        assert robot.statistics().lanes["call"].busy == 4

        async def now() -> None:
            robot.stop_now()

        add("robot.stop_now(), every pool thread in a call", await stops(bench, now, count))
        add("a fresh connection for each", await stops(bench, fresh(bench), count))
        tg.cancel_scope.cancel()
    async with anyio.create_task_group() as tg:
        for _ in range(4):
            tg.start_soon(calls, robot)

        async def through_the_pool() -> None:
            await robot._supervisor.calls.rpc.stop(False)

        add("through the pool of 4, calls of 50 ms", await stops(bench, through_the_pool, 50))
        tg.cancel_scope.cancel()
    return figures


def fresh(bench: Bench) -> Callable[[], Awaitable[None]]:
    """What an application does that has no connection for it: connect, stop, close."""

    async def send() -> None:
        lane = WireLane("fresh", bench.lane.host, bench.lane.port)
        await lane.open()
        await lane.rpc.stop(False)
        await lane.aclose()

    return send


async def calls(robot: aioduco.Robot) -> None:
    while True:
        await robot.io.set_tool_digital_out(1, True)


# -- all of it ---------------------------------------------------------------------------------


async def measure(port: int, quick: bool) -> dict[str, Any]:
    lane = WireLane("bench", HOST, port)
    await lane.open()
    try:
        async with aioduco.connect(HOST, port, call_timeout=600.0) as robot:
            bench = Bench(robot, lane)
            return {
                "stop": await stopping(bench, 300 if quick else 3000),
                "end": await ends(bench, 15 if quick else 100),
                # A machine that does other things needs `chrt -f 5` for figures of its own.
                "scheduling": SCHEDULING.get(os.sched_getscheduler(0), "other"),
            }
    finally:
        await lane.aclose()


def main() -> None:
    options = arguments(__doc__, "supervision")
    with ServerProcess("supervision_server.py") as server:
        results = anyio.run(measure, server.endpoints["rpc"], options.quick)
    for key, title, count in (
        ("stop", "From the call of a stop to the controller's handler [µs]", "stops"),
        ("end", "From the end of a motion to its notice [µs]", "motions"),
    ):
        columns = [key, "p50", "p99", "p99.9", "max", count]
        columns += ["polls each"] if key == "end" else []
        rows = [
            [name, *(f[p] for p in ("p50_us", "p99_us", "p99.9_us", "max_us")), f[count]]
            + ([f["polls_each"]] if key == "end" else [])
            for name, f in results[key].items()
        ]
        print_table(title, columns, rows)
    if options.save:
        print("written:", write_results("supervision", results).name)


if __name__ == "__main__":
    main()
