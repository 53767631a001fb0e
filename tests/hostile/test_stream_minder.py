"""A failure of the task that watches a stream stops the arm, and the program is told."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import anyio
import pytest
from adversity.arm import idle, ready, unrest

import aioduco
from aioduco.errors import WorkerFailed
from aioduco.sim import Simulator
from aioduco.streaming.session import Session
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.testing import eventually_async, no_leaks

RATE = 200


class Fault(Exception):
    """A defect of the package."""


class Failing:
    """Makes parts of a stream's supervision fail, once it is told to."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, parts: str) -> None:
        self.now = anyio.Event()
        hear, touch = Session._receive, Session._touch

        async def failing_hear(link: Any) -> bool:
            heard: list[bool] = []

            async def listen() -> None:
                heard.append(await hear(link))
                tasks.cancel_scope.cancel()

            async with anyio.create_task_group() as tasks:
                tasks.start_soon(listen)
                await self.now.wait()
                tasks.cancel_scope.cancel()
            if heard:
                return heard[0]
            raise Fault("the minder")

        def failing_touch(session: Session) -> None:
            if self.now.is_set():
                raise Fault("the keep-alive")
            touch(session)

        if parts in ("minder", "both"):
            monkeypatch.setattr(Session, "_receive", staticmethod(failing_hear))
        if parts in ("keep-alive", "both"):
            monkeypatch.setattr(Session, "_touch", failing_touch)


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with no_leaks(), ready() as sim:
        yield sim


#: each pair of what fails, of a kind of stream, and of where its worker runs
PAIRS = [
    (parts, kind, ("process", "thread")[(one + other) % 2])
    for one, parts in enumerate(["minder", "keep-alive", "both"])
    for other, kind in enumerate(["servo", "speed"])
]


@pytest.mark.parametrize(("parts", "kind", "run_in"), PAIRS)
async def test_the_robot_is_stopped_when_what_looks_after_its_stream_fails(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch, run_in: Any, parts: str, kind: str
) -> None:
    options = WorkerOptions(run_in=run_in, timeout=20.0)
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        here = await robot.state.get_actual_joints_position()
        failing = Failing(monkeypatch, parts)
        if kind == "servo":
            stream: Any = robot.servo.joints(v=1.0, a=5.0, rate=RATE, options=options)
        else:
            stream = robot.speed.joints(v=1.0, a=5.0, rate=RATE, options=options)

        async def program() -> None:
            async with stream:
                number = 0
                while True:
                    # speeds up to 0.2 rad/s, then goes on at that
                    speed = min(0.2, number / RATE * 2.0)
                    way = number / RATE * 0.1
                    point = [0.0] * 6 if kind == "speed" else list(here)
                    point[0] += speed if kind == "speed" else way * min(1.0, number / RATE)
                    await stream.send(point)
                    number += 1
                    if sim.moving and number > RATE // 2:
                        failing.now.set()

        stops = robot.statistics().stops
        with (
            pytest.raises(WorkerFailed, match=r"looks after it failed.*Fault"),
            anyio.fail_after(30),
        ):
            await program()
        assert robot.statistics().stops > stops
        await eventually_async(lambda: idle(sim) and not sim.moving, what=lambda: unrest(sim))
        monkeypatch.undo()
        # the robot goes on
        assert await robot.motion.movej2(here, v=1.0, a=4.0)
