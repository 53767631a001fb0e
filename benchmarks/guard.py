"""How soon a stop is with the controller when things go badly, and how late an end is noticed.

Three tables. The first: from the call of a stop to the controller's handler, while the pool is
blocked, while the event loop works in bursts, and just after every connection broke. The clock
starts in the thread that stops, when it calls: what it waited before, to get to run in a busy
program, is not counted, nor is its wait for the answer. The second: from the death of the program,
or of its guard, or from the beginning of a hang of the event loop, until the controller is told to
stop, or stops by itself since the heartbeat is over. Both are measured with and without the guard.
The third: from the end of a motion until the program knows of it, beside the loops that
applications write. It is kept as a result of its own, `supervision.json`.

The controller is a process of its own with trivial handlers; all read CLOCK_MONOTONIC. It gives no
slack: it stops as soon as the heartbeat time is over. One that gives slack stops so much later.
"""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import threading
import time
from typing import TYPE_CHECKING, Any

import anyio
from _common import (
    ServerProcess,
    arguments,
    print_table,
    scheduling,
    spread,
    write_results,
)

import aioduco
from aioduco._wire import rpc
from aioduco._wire.lane import WireLane
from aioduco.models.enums import TaskState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.supervision.settings import GuardKind

HOST = "127.0.0.1"
HEARTBEAT = 0.5
#: what the controller of these figures gives beyond the heartbeat time [s]
SLACK = 0.0
STALL_LIMIT = 0.6
#: what is compared
KINDS: dict[str, GuardKind | None] = {"without guard": None, "with guard": "process"}
#: turns in which the stops with a guard and without one are measured
TURNS = 5
#: s of work, and of rest after it
BURST = 0.015

#: joints, speed and acceleration of a move from zero; its time is what the client expects
SPEED, ACCELERATION = 1.0, 100.0
MOVEL: tuple[Any, ...] = ([0.5, 0, 0.5, 0, 0, 0], 0.1, 1.0, 0.0, [], "", "", False, rpc.Op(), False)

Figures = dict[str, Any]


class Desk:
    """A robot, a lane beside it that reads the controller's times, and the controller's process."""

    def __init__(self, robot: aioduco.Robot, lane: WireLane, server: ServerProcess) -> None:
        self.robot = robot
        self.lane = lane
        self.server = server
        self.random = random.Random(1)

    async def duration(self) -> float:
        """Choose how long the next motion takes, and tell the controller."""
        seconds = self.random.uniform(0.2, 0.6)
        await self.lane.rpc.set_system_value_double("duration", seconds)
        return seconds

    async def end(self, task_id: int) -> float:
        """When a task ended in the controller."""
        return (await self.lane.rpc.get_system_value_list(str(task_id)))[0]

    async def reached(self) -> list[float]:
        """When stops reached the controller's handler, since this was last asked."""
        return await self.lane.rpc.get_system_value_list("stops")

    async def stops(self, count: int, send: Callable[[], Awaitable[float]]) -> list[float]:
        """Seconds from each call to the handler. `send` returns when it called."""
        await self.reached()
        late: list[float] = []
        for _ in range(count):
            await anyio.sleep(self.random.uniform(0.0005, 0.003))
            begin = await send()
            reached = await self.reached()
            # a stop that was repeated counts when it first came
            late.append(min(at for at in reached if at >= begin) - begin)
        return late

    async def stop(self) -> float:
        begin = time.monotonic()
        await self.robot._supervisor.stop_channel.stop(2.0)
        return begin

    async def stop_now(self) -> float:
        """`stop_now` from another thread, since the loop's own may be at work."""
        begun: list[float] = []
        done = threading.Event()

        def call() -> None:
            begun.append(time.monotonic())
            self.robot.stop_now()
            done.set()

        threading.Thread(target=call).start()
        while not done.is_set():  # noqa: ASYNC110  # the bell would be what is measured
            await anyio.sleep(0.001)
        return begun[0]

    async def broken(self) -> float:
        """Every connection breaks just before the stop."""
        self.server.ask("drop")
        return await self.stop()


async def work() -> None:
    """Bursts of work on the event loop, half of the time."""
    while True:
        until = time.monotonic() + BURST
        while time.monotonic() < until:
            pass
        await anyio.sleep(BURST)


async def latencies(desk: Desk, count: int) -> dict[str, list[float]]:
    late: dict[str, list[float]] = {}

    async def add(name: str, send: Callable[[], Awaitable[float]]) -> None:
        late[name] = await desk.stops(count, send)

    await desk.stops(3, desk.stop)  # the turn before has broken the lane's connection
    await add("idle", desk.stop)
    async with anyio.create_task_group() as tasks:
        for _ in range(68):
            tasks.start_soon(desk.robot.io.set_standard_digital_out, 1, True)
        while desk.robot.statistics().lanes["call"].waiting < 64:  # noqa: ASYNC110
            await anyio.sleep(0.001)
        await add("pool blocked, 64 calls waiting", desk.stop)
        tasks.cancel_scope.cancel()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(work)
        await add("loop in bursts of 15 ms: stop()", desk.stop)
        await add("loop in bursts of 15 ms: stop_now()", desk.stop_now)
        tasks.cancel_scope.cancel()
    await add("every connection broken just before", desk.broken)
    return late


async def compared(
    lane: WireLane, server: ServerProcess, cores: set[int], count: int
) -> dict[str, dict[str, Figures]]:
    """Take turns, so that whatever else the machine does meets all alike.

    One robot is open at a time: what another one does in this program would count.
    """
    late: dict[str, dict[str, list[float]]] = {name: {} for name in KINDS}
    for _ in range(TURNS):
        for name, guard in KINDS.items():
            async with aioduco.connect(
                HOST, lane.port, guard=guard, call_timeout=600.0, heartbeat=60.0, lag_limit=None
            ) as robot:
                seat = robot._supervisor.guard
                if seat is not None and seat.pid is not None:
                    # beside the program, not on its core alone: it is to be free of it
                    for thread in os.listdir(f"/proc/{seat.pid}/task"):  # noqa: PTH208
                        os.sched_setaffinity(int(thread), cores)
                found = await latencies(Desk(robot, lane, server), count // TURNS)
            for case, times in found.items():
                late[name].setdefault(case, []).extend(times)
    return {
        name: {case: spread(found) | {"stops": len(found)} for case, found in cases.items()}
        for name, cases in late.items()
    }


# -- the end of a motion -----------------------------------------------------------------------


async def followed(desk: Desk, motion: aioduco.MotionCommand) -> float:
    task = await motion.start()
    await task
    assert task.ended_at is not None
    return task.ended_at - await desk.end(task.id)


async def expected(desk: Desk) -> float:
    """A joint move: its end can be computed from where the arm is."""
    seconds = await desk.duration()
    way = (seconds - SPEED / ACCELERATION) * SPEED
    return await followed(desk, desk.robot.motion.movej2([way] * 6, SPEED, ACCELERATION))


async def slowed(desk: Desk) -> float:
    """A joint move that takes twice as long as computed: the speed slider is at a half."""
    seconds = await desk.duration()
    way = (seconds / 2 - SPEED / ACCELERATION) * SPEED
    return await followed(desk, desk.robot.motion.movej2([way] * 6, SPEED, ACCELERATION))


async def unexpected(desk: Desk) -> float:
    """A move along a line: its end cannot be computed."""
    await desk.duration()
    return await followed(desk, desk.robot.motion.movel([0.5, 0, 0.5, 0, 0, 0], 0.1, 1.0))


async def blocking(desk: Desk) -> float:
    """The controller's own blocking call: the earliest possible notice, but it cannot be left."""
    await desk.duration()
    task_id = await desk.lane.within(None).speed(1.0)
    return time.monotonic() - await desk.end(task_id)


def loop(pause: float) -> Callable[[Desk], Awaitable[float]]:
    """The loop that applications write: ask, sleep, ask again."""

    async def polled(desk: Desk) -> float:
        await desk.duration()
        task_id = int(await desk.lane.call("movel", MOVEL))
        state = -1
        while state != TaskState.FINISHED:
            await anyio.sleep(pause)
            state = await desk.lane.rpc.get_noneblock_taskstate(task_id)
        return time.monotonic() - await desk.end(task_id)

    return polled


async def ends(desk: Desk, count: int) -> dict[str, Figures]:
    cases: dict[str, Callable[[Desk], Awaitable[float]]] = {
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
            polls, others = desk.robot.statistics().polls, desk.lane.statistics().calls
            late[name].append(await case(desk))
            # A motion also takes a call before it and one after it; beside the robot, its start.
            own = desk.lane.statistics().calls - others - (2 if "aioduco" in name else 3)
            asked[name] += desk.robot.statistics().polls - polls + own
    return {
        name: spread(late[name]) | {"polls_each": round(asked[name] / count, 1), "motions": count}
        for name in cases
    }


# -- deaths ------------------------------------------------------------------------------------

PROGRAM = """
import anyio, json, os, sys, time, aioduco
host, port, guard, heartbeat, limit = json.loads(sys.argv[1])
async def main():
    async with aioduco.connect(
        host, port, guard=guard, heartbeat=heartbeat, loop_stall_limit=limit, lag_limit=None
    ) as robot:
        await robot.registers.set_system_value_double("duration", 60.0)
        await robot.motion.movej2([0.0] * 6, v=1.0, a=1.0).start()
        seat = robot._supervisor.guard
        print(json.dumps(seat.pid if seat else None), flush=True)
        what = await anyio.to_thread.run_sync(sys.stdin.readline)
        print(json.dumps(time.monotonic()), flush=True)
        if what == "hang\\n":
            time.sleep(limit + 3 * heartbeat)
        await anyio.sleep_forever()
anyio.run(main)
"""


class Victim:
    """A program in a process of its own that moves the arm."""

    def __init__(self, port: int, guard: GuardKind | None) -> None:
        options = json.dumps([HOST, port, guard, HEARTBEAT, STALL_LIMIT])
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.guard: int | None = json.loads(self._line())

    def _line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline()

    def tell(self, what: str) -> float:
        """Have it do something; when it began."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{what}\n")
        self.process.stdin.flush()
        begin: float = json.loads(self._line())
        return begin

    def end(self) -> None:
        self.process.kill()
        self.process.communicate()


async def deaths(
    lane: WireLane, port: int, guard: GuardKind | None, count: int
) -> dict[str, Figures]:
    def program(victim: Victim) -> float:
        begin = time.monotonic()
        victim.process.kill()
        return begin

    def guardian(victim: Victim) -> float:
        assert victim.guard is not None
        # Frozen first: it is the heartbeat's end that is measured, not the program's own stop.
        victim.process.send_signal(signal.SIGSTOP)
        begin = time.monotonic()
        os.kill(victim.guard, signal.SIGKILL)
        return begin

    def hang(victim: Victim) -> float:
        return victim.tell("hang")

    cases: dict[str, Callable[[Victim], float]] = {
        "program killed": program,
        f"event loop hangs, limit {STALL_LIMIT:g} s": hang,
    }
    if guard is not None:
        cases["guard killed, program frozen"] = guardian
    rng = random.Random(2)
    late: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(count):
        for name, case in cases.items():
            victim = await anyio.to_thread.run_sync(Victim, port, guard)
            try:
                # at any moment between two beats
                await anyio.sleep(rng.uniform(0.0, HEARTBEAT))
                await lane.rpc.get_system_value_list("stops")
                begin = case(victim)
                late[name].append(await told(lane, begin) - begin)
            finally:
                victim.end()
    return {name: spread(seconds) | {"times": len(seconds)} for name, seconds in late.items()}


async def told(lane: WireLane, begin: float) -> float:
    """When the controller was first told to stop after `begin`, or stopped by itself."""
    with anyio.fail_after(30.0):
        while True:
            after = [at for at in await lane.rpc.get_system_value_list("stops") if at >= begin]
            if after:
                return min(after)
            await anyio.sleep(0.005)


# -- all of it ---------------------------------------------------------------------------------


async def measure(server: ServerProcess, cores: set[int], quick: bool) -> dict[str, Any]:
    port = server.endpoints["0"]
    results: dict[str, Any] = {
        "heartbeat_s": HEARTBEAT,
        "slack_s": SLACK,
        "scheduling": scheduling(),
        "stop": {},
        "death": {},
    }
    lane = WireLane("bench", HOST, port)
    await lane.open()
    try:
        results["stop"] = await compared(lane, server, cores, 300 if quick else 1000)
        async with aioduco.connect(HOST, port, call_timeout=600.0) as robot:
            results["end"] = await ends(Desk(robot, lane, server), 15 if quick else 100)
        for name, guard in KINDS.items():
            results["death"][name] = await deaths(lane, port, guard, 2 if quick else 20)
    finally:
        await lane.aclose()
    return results


def main() -> None:
    options = arguments(__doc__, "guard")
    cores = os.sched_getaffinity(0)  # before the program is kept to some of them
    with ServerProcess("controller.py") as server:
        results = anyio.run(measure, server, cores, options.quick)
    for key, title, unit, count in (
        ("stop", "From the call of a stop to the controller's handler [µs]", 1.0, "stops"),
        ("death", "From the event until the controller is told to stop [ms]", 1e-3, "times"),
    ):
        rows = [
            [case, name, *(round(f[p] * unit, 1) for p in ("p50_us", "p99_us", "max_us")), f[count]]
            for name, cases in results[key].items()
            for case, f in cases.items()
        ]
        print_table(title, [key, "", "p50", "p99", "max", count], sorted(rows, key=str))
    end = results.pop("end")
    columns = ["end", *next(iter(end.values()))]
    rows = [[name, *figures.values()] for name, figures in end.items()]
    print_table("From the end of a motion to its notice [µs]", columns, rows)
    if options.save:
        print("written:", write_results("guard", results).name)
        both = {"scheduling": results["scheduling"], "end": end}
        print("written:", write_results("supervision", both).name)


if __name__ == "__main__":
    main()
