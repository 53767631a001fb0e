"""Faults of networks, cancellations and deaths: a typed error and a standing arm."""

from __future__ import annotations

import os
import signal
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from typing import Literal

import anyio
import numpy as np
import pytest

import aioduco
from aioduco.errors import (
    DucoError,
    StreamError,
    StreamLost,
    StreamRefused,
    StreamStarved,
    StreamStopped,
    WorkerFailed,
)
from aioduco.sim import Simulator
from aioduco.streaming.shared.options import WorkerOptions
from aioduco.streaming.stream import Stream
from aioduco.testing import (
    ApplicationError,
    Cancelled,
    Cut,
    DropReply,
    DropRequest,
    Ending,
    Fault,
    FaultProxy,
    Garbage,
    HalfOpen,
    Place,
    Resources,
    WrongMethod,
    WrongSeqid,
    cancel_at,
    eventually_async,
    no_leaks,
)
from aioduco.testing.cancel import How

from .robot_motions import KINDS, START

PROCESS = WorkerOptions(timeout=0.2)
THREAD = WorkerOptions(run_in="thread", timeout=0.2)
#: for which a machine that stands still for a moment is no lost connection
PATIENT = WorkerOptions(run_in="thread", timeout=5.0)
workers = pytest.mark.parametrize("run_in", ["process", "thread"])


@pytest.fixture
def proxy(sim: Simulator) -> Iterator[FaultProxy]:
    with FaultProxy(sim.host, sim.port) as proxy:
        yield proxy


@pytest.fixture
async def robot(proxy: FaultProxy) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(proxy.host, proxy.port, unanswered_timeout=0.5) as robot:
        await robot.recover()
        await robot.motion.movej2(START, v=3.0, a=20.0)
        yield robot


async def run(
    robot: aioduco.Robot,
    kind: str,
    options: WorkerOptions,
    count: int = 2000,
    after_each: Callable[[Stream], Awaitable[None]] | None = None,
) -> None:
    """Go on along the first joint, evenly, until something happens."""
    speeds = KINDS[kind].feed is KINDS["speedj"].feed
    async with KINDS[kind].open(robot, options) as stream:
        for n in range(count):
            await stream.send([0.1, 0, 0, 0, 0, 0] if speeds else [2e-4 * n, *START[1:]])
            if speeds:
                await anyio.sleep(0.005)
            if after_each is not None:
                await after_each(stream)


async def see_it_stand(sim: Simulator) -> None:
    await eventually_async(lambda: not sim.moving)
    before = sim.joints.array
    await sim.wait_until_async(lambda: not sim.moving and sim.time > 0, timeout=0.2)
    assert np.abs(sim.joints.array - before).max() < 1e-4
    assert not [task for task in sim.tasks if task.name.startswith(("servo", "speed", "track"))]


# -- the network -------------------------------------------------------------------------------

FAULTS: list[tuple[Fault, type[StreamError]]] = [
    (Cut(Place.BEFORE_REPLY), StreamLost),
    (Cut(Place.IN_REQUEST), StreamLost),
    (Cut(Place.IN_REPLY, Ending.CLOSE), StreamLost),
    (Cut(Place.AFTER_REPLY, Ending.CLOSE), StreamLost),
    (HalfOpen(1.0), StreamLost),
    (DropReply(), StreamLost),
    (Garbage(), StreamLost),
    (WrongSeqid(), StreamLost),
    (WrongMethod(), StreamLost),
    (ApplicationError(6, "no"), StreamRefused),
]


@pytest.mark.cases(1)
@pytest.mark.parametrize(("fault", "error"), FAULTS, ids=lambda f: str(f)[:24])
async def test_a_fault_on_the_wire_in_mid_stream(
    robot: aioduco.Robot,
    sim: Simulator,
    proxy: FaultProxy,
    fault: Fault,
    error: type[StreamError],
    caplog: pytest.LogCaptureFixture,
) -> None:
    proxy.on("servoj", fault, skip=100)
    # An answer may be late on a busy machine: it counts as lost only where none comes at all.
    options = THREAD if isinstance(fault, HalfOpen | DropReply) else PATIENT
    async with no_leaks():
        with pytest.raises(error) as caught:
            await run(robot, "servoj", options)
    assert caught.value.statistics is not None
    await see_it_stand(sim)
    # no stop is needed where a busy machine's first call got no answer in time
    assert proxy.calls("stop") or not proxy.calls("servoj")
    if isinstance(fault, DropReply):  # that may take a minute, in which something is to be read
        await eventually_async(lambda: "that was not answered, for up to 0.5 s" in caplog.text)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "fault"),
    [
        ("servoj", Cut(Place.BEFORE_REPLY)),
        ("speedj", HalfOpen()),
        ("joint_position", Cut(Place.BEFORE_REPLY)),
        ("joint_position", HalfOpen()),
        ("track joints", Cut(Place.BEFORE_REPLY)),
    ],
    ids=str,
)
async def test_a_lost_connection_of_each_kind(
    robot: aioduco.Robot, sim: Simulator, proxy: FaultProxy, kind: str, fault: Fault
) -> None:
    proxy.on(KINDS[kind].calls, fault, skip=5)
    with pytest.raises(StreamLost):
        await run(robot, kind, PROCESS)
    await see_it_stand(sim)


@pytest.mark.slow
async def test_no_network_at_all(robot: aioduco.Robot, sim: Simulator, proxy: FaultProxy) -> None:
    """Nobody can stop the arm then, but the heartbeat's end does."""
    error: list[DucoError] = []

    async def program() -> None:
        try:
            await run(robot, "servoj", WorkerOptions(timeout=5.0))
        except StreamError as exc:
            error.append(exc)

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(program)
        await eventually_async(lambda: sim.joints[0] > 5e-3)
        proxy.refuse()
        proxy.cut()
        await eventually_async(lambda: bool(error), timeout=15)
        await eventually_async(lambda: not sim.moving)
        proxy.clear()
    assert isinstance(error[0], StreamLost)
    assert "it is not known that the arm stands" in str(error[0])


@pytest.mark.slow
@pytest.mark.parametrize("what", ["its connection", "its worker"])
async def test_leaving_says_that_the_arm_is_not_known_to_stand(
    sim: Simulator, proxy: FaultProxy, what: str
) -> None:
    # a cut connection is seen at once: an answer that is late before it is no loss
    patient = WorkerOptions(timeout=5.0)

    async def follow(robot: aioduco.Robot) -> None:
        async with robot.servo.joints(v=1.0, a=8.0, options=patient) as stream:
            await stream.send(START)
            await stream.send([5e-3, *START[1:]])
            # a worker that has sent nothing has moved nothing, and there is nothing to say
            await eventually_async(lambda: sim.joints[0] > 1e-3)
            proxy.refuse()
            proxy.cut()
            if what == "its worker":
                assert stream.pid is not None
                os.kill(stream.pid, signal.SIGKILL)
            await stream.ended()

    async def program() -> None:
        async with aioduco.connect(
            *(proxy.host, proxy.port),
            stop_timeout=0.3,
            standstill_timeout=0.3,
            unanswered_timeout=0.3,
        ) as robot:
            await robot.recover()
            await robot.motion.movej2(START, v=3.0, a=20.0)
            with pytest.raises(StreamLost if what == "its connection" else WorkerFailed):
                await follow(robot)

    with pytest.raises(aioduco.StopUnconfirmed):
        await program()
    proxy.clear()


@pytest.mark.slow
async def test_without_a_heartbeat_a_stream_ends(sim: Simulator, proxy: FaultProxy) -> None:
    """The controller stops the arm then, and the next set-point would set it moving again."""
    async with aioduco.connect(proxy.host, proxy.port, heartbeat=2.0) as robot:
        await robot.recover()
        await robot.motion.movej2(START, v=3.0, a=20.0)

        async def program() -> None:
            # whichever is seen first: no answer here, a refusal, or the task that it stopped
            with pytest.raises((StreamStarved, StreamRefused, StreamStopped)):
                await run(robot, "servoj", PATIENT, count=20_000)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(program)
            await eventually_async(lambda: sim.joints[0] > 5e-3)
            proxy.on("rpc_heartbeat", DropRequest(), times=None)
        await see_it_stand(sim)
        proxy.clear()


# -- deaths ------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["servoj", "speedj", "joint_position", "track joints"])
async def test_a_worker_that_is_killed(robot: aioduco.Robot, sim: Simulator, kind: str) -> None:
    async def kill_under_way(stream: Stream) -> None:
        if sim.joints[0] > 5e-3:
            assert stream.pid is not None
            os.kill(stream.pid, signal.SIGKILL)
            await stream.ended()

    options = WorkerOptions(timeout=5.0)
    async with no_leaks():
        with pytest.raises(WorkerFailed, match="killed by SIGKILL"):
            await run(robot, kind, options, after_each=kill_under_way)
    await see_it_stand(sim)


# -- cancellation ------------------------------------------------------------------------------


def losses(robot: aioduco.Robot) -> int:
    assert robot.heartbeat is not None
    return robot.heartbeat.losses


@pytest.mark.slow
@pytest.mark.parametrize("how", ["scope", "task"])
@workers
async def test_cancelled_at_any_await(
    robot: aioduco.Robot, sim: Simulator, run_in: Literal["process", "thread"], how: How
) -> None:
    """Entering, sending one by one, playing an array, leaving."""

    async def program() -> None:
        opened = robot.servo.joints(v=1.0, a=8.0, ahead=4, options=WorkerOptions(run_in=run_in))
        async with opened as stream:
            for n in range(8):
                await stream.send([start + 2e-5 * n * n, *START[1:]])
            await stream.play([[start + 2e-5 * n * n, *START[1:]] for n in range(8, 24)])

    start = 0.0
    at, step = 1, 2 if run_in == "thread" else 11
    run: Cancelled | None = None
    while run is None or run.struck:
        await eventually_async(lambda: not sim.moving)
        start = sim.joints[0]
        before, lost = Resources.now(), losses(robot)
        run = await cancel_at(program, at, how=how)
        assert not sim.view.moving, run
        assert run.error is None
        assert not robot._supervisor.stop_coordinator.streams
        # A heartbeat that was lost meanwhile, on a busy machine, goes over a new connection.
        await eventually_async(
            lambda before=before, lost=lost: (  # type: ignore[misc]
                losses(robot) > lost or not Resources.now().beyond(before)
            ),
            what=lambda before=before: str(Resources.now().beyond(before)),  # type: ignore[misc]
        )
        at += step
    assert at > 15
