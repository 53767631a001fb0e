"""The program under test: it moves the arm, prints what it is told, and then commands nothing.

    python -m hostile.freeze.program PORT SCENE GUARD VARIANT PLAN

SCENE is one of `SCENES`. GUARD is "guarded" or "none". VARIANT is 0 or 1. PLAN is the file of the
plan, for the scene "plan".

It says "command" before each command that moves the arm, "pause" before it does nothing for a
moment, "told" for the first exception that reaches it, and "left" when it has left the robot; each
with the time that goes on while a computer is suspended.
"""

from __future__ import annotations

import itertools
import pickle
import sys
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import anyio

import aioduco
from aioduco.streaming.stream import Stream
from aioduco.supervision.settings import GuardKind

from .cells import FAR, PAUSE, SPEED, turned
from .clock import now

#: how hard the arm moves [rad/s²]
_HARD = 0.8
#: way of a short motion [rad]
_SHORT = 0.15


def say(what: str, text: str = "") -> None:
    """Write a line."""
    sys.stdout.write(f"{now():.6f} {what} {text}\n")
    sys.stdout.flush()


class _Ears:
    """Says the first exception that passes."""

    def __init__(self) -> None:
        self._told = False

    @contextmanager
    def __call__(self) -> Iterator[None]:
        try:
            yield
        except BaseException as exc:
            if not self._told:
                self._told = True
                say("told", f"{type(exc).__name__}: {' '.join(str(exc).split())}")
            raise


hearing = _Ears()


def ramp(time: float) -> float:
    """The angle at a time after the begin: at `SPEED`, after a second [rad]."""
    return SPEED * (time - 0.5) if time > 1.0 else SPEED * time**2 / 2


def timed(interval: float) -> tuple[list[float], list[list[float]]]:
    """Times of the whole way, and where the arm is at each."""
    times = [n * interval for n in range(int(FAR / SPEED / interval))]
    return times, [turned(ramp(time)) for time in times]


async def motion(robot: aioduco.Robot, variant: int) -> None:
    """Joint motions, one awaited after the other: long ones, or short ones with pauses."""
    if variant:
        for n in itertools.count(1):
            say("command")
            await robot.motion.movej2(turned(FAR * (n % 2)), v=SPEED, a=_HARD)
    for n in itertools.count(1):
        say("command")
        await robot.motion.movej2(turned(_SHORT * n), v=SPEED, a=_HARD)
        say("pause")
        await anyio.sleep(PAUSE)


async def servo(robot: aioduco.Robot, variant: int) -> None:
    """Each set-point is a step from the one before; or it is where the arm should be by now."""
    rate, by_time = (50, True) if variant else (100, False)
    await _stream(
        robot.servo.joints(v=1.0, a=_HARD, rate=rate, latest=by_time, max_step=FAR), rate, by_time
    )


async def _stream(stream: Stream, rate: float, by_time: bool) -> None:
    async with stream:
        with hearing():
            say("command")
            number = 0
            async for tick in stream.ticks(rate):
                number += 1
                await stream.send(turned(ramp(tick.time if by_time else number / rate)))


async def speed(robot: aioduco.Robot, variant: int) -> None:
    """A stream of speeds; the controller ends it after a shorter or a longer time without one."""
    async with robot.speed.joints(v=1.0, a=_HARD, dead_man=(0.2, 0.5)[variant]) as stream:
        with hearing():
            say("command")
            async for _ in stream.ticks():
                await stream.send([SPEED, 0, 0, 0, 0, 0])


async def realtime(robot: aioduco.Robot, variant: int) -> None:
    """The realtime queue: of positions, or of speeds."""
    # The queue and its time-out are longer than by default, since a busy machine is late; and it
    # is looked at less often, which takes less of the machine.
    patient: dict[str, Any] = {"depth": 100, "com_lost_time": 0.1, "period": 0.02}
    patient |= {"v": 1.0, "a": _HARD}
    if not variant:
        rate = 100
        await _stream(
            robot.realtime.stream("joint_position", source_rate=rate, upsample="cubic", **patient),
            rate,
            by_time=False,
        )
        return
    async with robot.realtime.stream("joint_velocity", latest=True, **patient) as stream:
        with hearing():
            say("command")
            async for _ in stream.ticks(100):
                await stream.send([SPEED, 0, 0, 0, 0, 0])


async def track(robot: aioduco.Robot, variant: int) -> None:
    """The track pool, which lasts for seconds or for tenths of a second."""
    low, high = (50, 200) if variant else (20, 60)
    async with robot.track.stream("joints", speed=SPEED, acc=_HARD, low=low, high=high) as stream:
        with hearing():
            say("command")
            for n in itertools.count(1):
                await stream.send(turned(0.006 * n))


async def play(robot: aioduco.Robot, variant: int) -> None:
    """A path with times: an array into a servo stream, or a trajectory by servoj."""
    if variant:
        times, points = timed(0.1)
        say("command")
        await robot.motion.follow_joint_trajectory(
            aioduco.JointTrajectory(points, times), v=1.0, a=2.0, through="servoj"
        )
        return
    times, points = timed(0.01)
    async with robot.servo.joints(v=1.0, a=_HARD, rate=100) as stream:
        with hearing():
            say("command")
            await stream.play(points, times)


async def plan(robot: aioduco.Robot, variant: int, planned: bytes) -> None:
    """A plan, in a scene that is watched and changes beside it."""
    from .planned import change, scene  # noqa: PLC0415 - only this program needs MuJoCo

    watched = scene()

    async def changes() -> None:
        for n in itertools.count(1):
            await anyio.sleep(2.0)
            change(watched, n)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(changes)
        with hearing():
            say("command")
            through: Any = "servoj" if variant else "auto"
            await robot.motion.execute(pickle.loads(planned), watch=watched, through=through)
        tasks.cancel_scope.cancel()


async def jog(robot: aioduco.Robot, variant: int) -> None:
    """A jog without a step: awaited, or for as long as a block lasts."""
    say("command")
    slow = aioduco.Jog.joint(1, 1, vel=50)
    if variant:
        await robot.motion.move_jog(slow, time=None)
    async with robot.motion.move_jog(slow, time=60.0):
        with hearing():
            await anyio.sleep_forever()


async def force(robot: aioduco.Robot, variant: int) -> None:
    """A motion under force control; or nothing but that, away from where nothing presses."""
    z = (False, False, True, False, False, False)
    away = (0.0, 0.0, 0.0 if variant else 50.0, 0.0, 0.0, 0.0)
    await robot.force.fc_config(z, away, (500.0,) * 6, (0.06,) * 6)
    await robot.force.fc_start()
    say("command")
    if variant:
        await robot.motion.movej2(turned(FAR), v=SPEED, a=_HARD)
    else:
        await robot.force.fc_move()


async def main(port: int, scene: str, guarded: bool, variant: int, *more: bytes) -> int:
    scenes: dict[str, Callable[..., Awaitable[None]]] = {
        each.__name__: each
        for each in (motion, servo, speed, realtime, track, play, plan, jog, force)
    }
    try:
        with hearing():
            guard: GuardKind | None = "process" if guarded else None
            async with aioduco.connect("127.0.0.1", port, guard=guard) as robot:
                with hearing():
                    await scenes[scene](robot, variant, *more)
    except Exception:
        return 1
    finally:
        say("left")
    return 0


if __name__ == "__main__":
    _, _port, _scene, _guard, _variant, _file = sys.argv
    _plan = [Path(_file).read_bytes()] if _scene == "plan" else []
    sys.exit(anyio.run(main, int(_port), _scene, _guard == "guarded", int(_variant), *_plan))
