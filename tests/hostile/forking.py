"""A program that moves the arm, forks in the middle of it, and leaves its robot; again and again.

    python forking.py HOST PORT GUARD LOOP CHILD...

GUARD is "process" or "". LOOP is "asyncio" or "uvloop". CHILD is what the forked child does: one of
`CHILDREN`. For each of them the program opens a robot, which is recorded to CHILD.mcap, and writes
one line of JSON: the child's exit code, and what came of its own motions.
"""

from __future__ import annotations

import asyncio
import faulthandler
import gc
import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from typing import Any

import anyio
import uvloop

import aioduco

HOME = (0.0, 0.0, 1.5, 0.0, -1.5, 0.0)
#: a starved machine is not what is tested
PATIENT: dict[str, Any] = {"heartbeat": 20.0, "loop_stall_limit": 15.0}
#: codes with which children end
CODE, DEFECT = 7, 9


def leave(_robot: aioduco.Robot) -> None:
    """sys.exit in the middle of the block: what the program opened is torn down in the child."""
    sys.exit(CODE)


def vanish(_robot: aioduco.Robot) -> None:
    """os._exit: nothing is torn down."""
    os._exit(CODE)


def use(robot: aioduco.Robot) -> None:
    """Try what there is, on a loop of the child's own and without one."""
    (task,) = robot.tasks

    async def tries() -> None:
        uses: list[Callable[[], Any]] = [
            robot.stop,
            robot.pause,
            robot.motion.movej2(HOME, v=1.0, a=1.0).start,
            robot.state.get_robot_state,
            robot.recover,
            robot.feed.latest,
            task.wait,
            task.cancel,
        ]
        for one in uses:
            try:
                await one()
            except aioduco.WrongProcess:
                continue
            os._exit(DEFECT)
        await robot.aclose()

    asyncio.run(tries())
    try:
        robot.stop_now()
    except aioduco.WrongProcess:
        os._exit(CODE)
    os._exit(DEFECT)


def forget(robot: aioduco.Robot) -> None:
    """Let go of everything, and end the interpreter in the ordinary way, `atexit` included."""
    del robot
    gc.collect()
    sys.exit(CODE)


CHILDREN = {one.__name__: one for one in (leave, vanish, use, forget)}


def live_on(end: int) -> None:
    """A child that outlives its parent: it ends when the other end of a pipe is closed."""
    os.read(end, 1)
    os._exit(CODE)


def work(robot: aioduco.Robot) -> None:
    """What a process of `multiprocessing` does."""
    try:
        robot.stop_now()
    except aioduco.WrongProcess:
        sys.exit(CODE)
    sys.exit(DEFECT)


async def with_child(robot: aioduco.Robot, child: str) -> int:
    """Have the child, and see its end. Returns its exit code."""
    if child == "multiprocessing":
        process = multiprocessing.get_context("fork").Process(target=work, args=(robot,))
        process.start()
        await anyio.wait_readable(process.sentinel)
        process.join()
        return process.exitcode or 0
    number = os.fork()
    if number == 0:
        CHILDREN[child](robot)
    ended = os.pidfd_open(number)
    await anyio.wait_readable(ended)
    os.close(ended)
    _, status = os.waitpid(number, 0)  # noqa: ASYNC222  # it has ended
    return os.waitstatus_to_exitcode(status)


async def main(host: str, port: int, guard: str, child: str) -> None:
    told: dict[str, Any] = {}
    kind: Any = guard or None
    record = f"{child}.mcap"
    async with aioduco.connect(host, port, guard=kind, record=record, **PATIENT) as robot:
        async with robot.motion.movej2(HOME, v=1.0, a=1.0) as task:
            if child == "live_on":
                if os.fork() == 0:
                    live_on(int(os.environ["AIODUCO_TEST_PIPE"]))
            else:
                told["child"] = await with_child(robot, child)
        told["task"] = str((await task).value)
        told["again"] = str((await robot.motion.movej2(HOME, v=1.0, a=1.0)).value)
        # on its way when the robot is left: leaving stops it
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    sys.stdout.write(json.dumps(told) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    # whoever waits in vain for this program ends it by SIGABRT, and reads where it was
    faulthandler.enable()
    _, given_host, given_port, given_guard, given_loop, *given_children = sys.argv
    factory = uvloop.new_event_loop if given_loop == "uvloop" else asyncio.new_event_loop
    with asyncio.Runner(loop_factory=factory) as runner:
        for one in given_children:
            runner.run(main(given_host, int(given_port), given_guard, one))
