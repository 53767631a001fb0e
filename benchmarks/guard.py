"""How soon a stop is with the controller when things go badly, and how late an end is noticed.

Three tables. From the call of a stop to the controller's handler, in the thread that calls: while
the pool is blocked, while the event loop works in bursts, and just after every connection broke.
From the death of the program or of its guard, or from a hang of the event loop, until the
controller is told to stop, or stops by itself since the heartbeat is over. Both with the guard and
without. And from the end of a motion until the program knows of it, beside the loops that
applications write; kept as a result of its own, `supervision.json`.

The controller has trivial handlers and gives no slack: it stops as soon as the heartbeat time is
over. All clocks are CLOCK_MONOTONIC.
"""

from __future__ import annotations

import json
import os
import random
import signal
import time
from collections import defaultdict
from functools import partial
from subprocess import DEVNULL
from typing import TYPE_CHECKING, Any

import anyio
from _common import CORES, in_turns, parser, report, spread
from _processes import CONTROLLER, HOST, Program, ServerProcess, first_stop, guard_of, open_lane
from streaming import load

import aioduco
from aioduco._wire import rpc
from aioduco.models.enums import TaskState
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco._wire.lane import WireLane
    from aioduco.supervision.settings import GuardKind

HEARTBEAT = 0.5
STALL_LIMIT = 0.6
KINDS: dict[str, GuardKind | None] = {"without guard": None, "with guard": "process"}
#: turns in which the stops with a guard and without one are measured
TURNS = 5

#: joints, speed and acceleration of a move from zero; its time is what the client expects
SPEED, ACCELERATION = 1.0, 100.0
MOVEL: tuple[Any, ...] = ([0.5, 0, 0.5, 0, 0, 0], 0.1, 1.0, 0.0, [], "", "", False, rpc.Op(), False)

Figures = dict[str, dict[str, float]]
Times = dict[str, list[float]]


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

    async def stop(self) -> float:
        begin = time.monotonic()
        await self.robot._supervisor.stop_channel.stop(2.0)
        return begin

    async def stop_now(self) -> float:
        """`stop_now` from another thread, since the loop's own may be at work."""

        def call() -> float:
            begin = time.monotonic()
            self.robot.stop_now()
            return begin

        return await anyio.to_thread.run_sync(call)

    async def broken(self) -> float:
        """Every connection breaks just before the stop."""
        self.server.ask("drop")
        return await self.stop()


def spreads(late: Times, count: str) -> Figures:
    return {case: spread(times, count) for case, times in late.items()}


async def stops(desk: Desk, count: int, send: Callable[[], Awaitable[float]]) -> list[float]:
    """Seconds from each call to the handler. `send` returns when it called."""
    late: list[float] = []
    for _ in range(count):
        await anyio.sleep(desk.random.uniform(0.0005, 0.003))
        begin = await send()
        late.append(await first_stop(desk.lane, begin) - begin)
    return late


async def latencies(desk: Desk, late: Times, count: int) -> None:
    """Stop so often in each case; the times are added to those of the turns before."""
    await stops(desk, 3, desk.stop)  # the turn before has broken the lane's connection
    late["idle"] += await stops(desk, count, desk.stop)
    async with anyio.create_task_group() as tasks:
        for _ in range(68):
            tasks.start_soon(desk.robot.io.set_standard_digital_out, 1, True)
        await eventually_async(lambda: desk.robot.statistics().lanes["call"].waiting >= 64)
        late["pool blocked, 64 calls waiting"] += await stops(desk, count, desk.stop)
        tasks.cancel_scope.cancel()
    async with load(busy=True):
        late["loop in bursts of 15 ms: stop()"] += await stops(desk, count, desk.stop)
        late["loop in bursts of 15 ms: stop_now()"] += await stops(desk, count, desk.stop_now)
    late["every connection broken just before"] += await stops(desk, count, desk.broken)


async def compared(lane: WireLane, server: ServerProcess, count: int) -> dict[str, Figures]:
    """One robot is open at a time: what another one does in this program would count."""
    late: dict[str, Times] = {name: defaultdict(list) for name in KINDS}
    for name, guard in in_turns(TURNS, KINDS):
        async with aioduco.connect(
            HOST, lane.port, guard=guard, call_timeout=600.0, heartbeat=60.0, lag_limit=None
        ) as robot:
            if pid := guard_of(robot):
                # beside the program, not on its core alone: it is to be free of it
                for thread in os.listdir(f"/proc/{pid}/task"):  # noqa: PTH208
                    os.sched_setaffinity(int(thread), CORES)
            await latencies(Desk(robot, lane, server), late[name], count // TURNS)
    return {name: spreads(times, "stops") for name, times in late.items()}


async def followed(desk: Desk, motion: aioduco.MotionCommand) -> float:
    task = await motion.start()
    await task
    assert task.ended_at is not None
    return task.ended_at - await desk.end(task.id)


async def joint_move(desk: Desk, slower: float = 1.0) -> float:
    """A joint move, whose end can be computed from where the arm is.

    Args:
        desk: where it is made.
        slower: how many times the computed time it takes, as with a lower speed slider.
    """
    way = (await desk.duration() / slower - SPEED / ACCELERATION) * SPEED
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


async def polled(desk: Desk) -> float:
    """The loop that applications write: ask, sleep, ask again."""
    await desk.duration()
    task_id = int(await desk.lane.call("movel", MOVEL))
    state = -1
    while state != TaskState.FINISHED:
        await anyio.sleep(0.01)
        state = await desk.lane.rpc.get_noneblock_taskstate(task_id)
    return time.monotonic() - await desk.end(task_id)


async def ends(desk: Desk, count: int) -> Figures:
    cases: dict[str, Callable[[Desk], Awaitable[float]]] = {
        "aioduco, end expected (movej2)": joint_move,
        "aioduco, end not expected (movel)": unexpected,
        "aioduco, expected too early (speed at 50 %)": partial(joint_move, slower=2.0),
        "blocking call": blocking,
        "ask, sleep 10 ms": polled,
    }
    late: Times = {name: [] for name in cases}
    asked = dict.fromkeys(cases, 0)
    for name, case in in_turns(count, cases):
        polls, others = desk.robot.statistics().polls, desk.lane.statistics().calls
        late[name].append(await case(desk))
        # A motion also takes a call before it and one after it; beside the robot, its start.
        own = desk.lane.statistics().calls - others - (2 if "aioduco" in name else 3)
        asked[name] += desk.robot.statistics().polls - polls + own
    figures = spreads(late, "motions")
    for name, polls in asked.items():
        figures[name]["polls_each"] = round(polls / count, 1)
    return figures


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


class Victim(Program):
    """A program in a process of its own that moves the arm."""

    def __init__(self, port: int, guard: GuardKind | None) -> None:
        options = json.dumps([HOST, port, guard, HEARTBEAT, STALL_LIMIT])
        super().__init__("-c", PROGRAM, options, stderr=DEVNULL)
        self.guard: int | None = json.loads(self.line())

    def __exit__(self, *error: Any) -> None:
        self.kill()
        super().__exit__(*error)

    # each returns when it began

    def die(self) -> float:
        begin = time.monotonic()
        self.kill()
        return begin

    def hang(self) -> float:
        begin: float = json.loads(self.ask("hang"))
        return begin

    def lose_guard(self) -> float:
        assert self.guard is not None
        # Frozen first: it is the heartbeat's end that is measured, not the program's own stop.
        self.send_signal(signal.SIGSTOP)
        begin = time.monotonic()
        os.kill(self.guard, signal.SIGKILL)
        return begin


async def deaths(lane: WireLane, guard: GuardKind | None, count: int) -> Figures:
    cases: dict[str, Callable[[Victim], float]] = {
        "program killed": Victim.die,
        f"event loop hangs, limit {STALL_LIMIT:g} s": Victim.hang,
    }
    if guard is not None:
        cases["guard killed, program frozen"] = Victim.lose_guard
    rng = random.Random(2)
    late: Times = {name: [] for name in cases}
    for name, case in in_turns(count, cases):
        with await anyio.to_thread.run_sync(Victim, lane.port, guard) as victim:
            # at any moment between two beats
            await anyio.sleep(rng.uniform(0.0, HEARTBEAT))
            begin = case(victim)
            late[name].append(await first_stop(lane, begin) - begin)
    return spreads(late, "times")


async def measure(server: ServerProcess, quick: bool) -> dict[str, Any]:
    [port] = server.ports
    async with open_lane(port) as lane:
        stop = await compared(lane, server, 300 if quick else 1000)
        async with aioduco.connect(HOST, port, call_timeout=600.0) as robot:
            end = await ends(Desk(robot, lane, server), 15 if quick else 100)
        kinds, times = KINDS.items(), 2 if quick else 20
        death = {name: await deaths(lane, guard, times) for name, guard in kinds}
    return {"stop": stop, "death": death, "end": end}


def main() -> None:
    options = parser(__doc__).parse_args()
    with ServerProcess(CONTROLLER) as server:
        found = anyio.run(measure, server, options.quick)
    report(options, "supervision", {"end": found.pop("end")})
    report(options, "guard", {"heartbeat_s": HEARTBEAT, **found})


if __name__ == "__main__":
    main()
