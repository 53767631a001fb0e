"""What an arm does as lines of JSON, for a log that machines read.

    python log_to_json.py                      on a simulated arm
    python log_to_json.py 192.168.1.10         on a real one: it moves a little

Each line has a time, a kind and what happened: calls with their durations, events of the robot, and
the package's own log lines. Handlers are called by a thread of their own: a slow disk holds up no
call and no stop.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import logging
import sys
import time
from typing import Any

import anyio

import aioduco
from aioduco import Joints
from aioduco.models.trace import CallFinished, TraceEvent

HOME = Joints.deg(30, -15, 105, 0, -90, 0)


def line(kind: str, **fields: Any) -> None:
    """Write a line, whole: threads write theirs at the same time."""
    text = json.dumps({"time": time.time(), "kind": kind, **fields}, default=str)
    sys.stdout.write(text + "\n")


class JsonHandler(logging.Handler):
    """Log lines of the package as JSON."""

    def emit(self, record: logging.LogRecord) -> None:
        line("log", level=record.levelname, logger=record.name, message=record.getMessage())


def trace(event: TraceEvent) -> None:
    """A call that has ended; others are left out."""
    if isinstance(event, CallFinished):
        milliseconds = round(1000 * event.duration, 3)
        error = None if event.error is None else repr(event.error)
        line("call", function=event.function, milliseconds=milliseconds, error=error)


async def watch(robot: aioduco.Robot) -> None:
    """Events of the robot, as they are seen."""
    with robot.events.subscribe() as events:
        async for event in events:
            line("event", event=type(event).__name__, **dataclasses.asdict(event))


async def main(host: str, port: int) -> None:
    logging.getLogger("aioduco").addHandler(JsonHandler())
    async with (
        aioduco.connect(host, port, trace=trace) as robot,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(watch, robot)
        await robot.bring_up()
        task = await robot.motion.movej2(HOME, v=0.8, a=1.5).start()
        outcome = await task
        line("motion", name=task.name, outcome=outcome.value, seconds=task.duration)
        tasks.cancel_scope.cancel()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator() as sim:
            anyio.run(main, sim.host, sim.port)
