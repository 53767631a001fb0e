"""A program that moves the arm and prints what it is told.

    python -m hostile.cable.program HOST PORT SCENE HEARTBEAT GUARD STREAM

SCENE is one of `SCENES`. HEARTBEAT is in seconds, 0 for none. GUARD is "process" or "". STREAM is
the time for which a stream goes on after "ready" [s].

It says "ready" when the network may fail, and goes on when it has read a line; "told" for every
return and every exception that reaches it; "left" when it has left the robot.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Coroutine
from typing import Any

import anyio
import anyio.to_thread

import aioduco
from aioduco.supervision.settings import GuardKind

from .lines import say

#: where the motions lead to; far from every singularity and limit [rad]
_LEFT = (0.4, 0.0, 1.57, 0.0, -1.57, 0.0)
#: amplitude of the stream's sine [rad], and its frequency [Hz]
_AMPLITUDE, _FREQUENCY = 0.2, 0.5
#: time that a stream has been going on when the network may fail [s]
_WARM = 0.8


async def _go() -> None:
    say("ready")
    await anyio.to_thread.run_sync(sys.stdin.readline, abandon_on_cancel=True)


async def sent(robot: aioduco.Robot, _stream: float) -> None:
    """The network fails just before the motion is sent."""
    await _go()
    say("told", str(await robot.motion.movej2(_LEFT, v=0.3, a=4.0)))


async def running(robot: aioduco.Robot, _stream: float) -> None:
    """It fails while the arm moves."""
    task = await robot.motion.movej2(_LEFT, v=0.1, a=4.0).start()
    await _go()
    say("told", str(await task))


async def stream(robot: aioduco.Robot, seconds: float) -> None:
    """It fails while set-points lead the arm along a sine."""
    first, *others = await robot.state.get_actual_joints_position()
    ready = False
    async with robot.servo.joints(v=1.0, a=5.0, rate=250) as stream:
        try:
            async for tick in stream.ticks():
                swing = (1 - math.cos(2 * math.pi * _FREQUENCY * tick.time)) / 2
                await stream.send([first + _AMPLITUDE * swing, *others])
                if not ready and tick.time >= _WARM:
                    ready = True
                    say("ready")
                if tick.time >= _WARM + seconds:
                    break
        except Exception as exc:
            # In the block already: what a program does here, it does before the block is left.
            _told(exc)
            raise
    say("told", "left the stream")


SCENES: dict[str, Callable[[aioduco.Robot, float], Coroutine[Any, Any, None]]] = {
    "sent": sent,
    "running": running,
    "stream": stream,
}


def _told(exc: BaseException) -> None:
    say("told", f"{type(exc).__name__}: {exc}")


async def main(
    host: str, port: int, scene: str, heartbeat: float | None, guard: GuardKind | None, time: float
) -> None:
    try:
        async with aioduco.connect(host, port, heartbeat=heartbeat, guard=guard) as robot:
            await robot.bring_up()
            try:
                await SCENES[scene](robot, time)
            except Exception as exc:
                _told(exc)
                raise
    except Exception as exc:
        _told(exc)
    say("left")


if __name__ == "__main__":
    _, given_host, given_port, given_scene, beat, kind, given_time = sys.argv
    given_guard: GuardKind | None = "process" if kind == "process" else None
    given = (given_host, int(given_port), given_scene, float(beat) or None, given_guard)
    anyio.run(main, *given, float(given_time))
