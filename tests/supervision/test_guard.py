"""The guard sends beats from another process, and stops the arm when the program ends."""

from __future__ import annotations

import asyncio
import errno
import gc
import os
import signal
import subprocess
import sys
import threading
from collections.abc import AsyncIterator
from typing import NoReturn

import pytest
from api.desk import Desk
from client.bench import HOME, Bench, under_way
from for_each import for_each
from hostile.programs import guard_of, running

import aioduco
from aioduco import HeartbeatState
from aioduco.supervision.concurrency import DaemonThread
from aioduco.supervision.guard import client
from aioduco.supervision.guard.client import GuardLink
from aioduco.supervision.guard.guarded import GuardClient
from aioduco.supervision.guard.messages import (
    Alive,
    Beat,
    Done,
    LogMessage,
    Message,
    Rearm,
    Release,
    Watch,
    pack,
    unpack,
)
from aioduco.supervision.settings import GuardKind
from aioduco.testing import (
    ApplicationError,
    Cut,
    FaultProxy,
    Place,
    eventually,
    eventually_async,
)

from .test_heartbeat import state

pytestmark = pytest.mark.linux("the guard's process")
MOVE = f"motion.movej2({HOME}, v=1.0, a=1.0)"


@pytest.fixture
async def robot(bench: Bench) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(bench.host, bench.port, guard="process", heartbeat=0.3) as robot:
        yield robot


@for_each(
    "message",
    [
        Watch(1, 2, "robot", 7003, None, 1.0, 3.0, 2.0),
        Alive(1, 12.5, True, [["end_teach_mode", [False]]]),
        Rearm(1),
        Release(1, 2),
        Done(2, ""),
        LogMessage(30, "the arm was not seen to stop"),
        Beat(1, "beating", 3, 0, 0, 0, 0.33, "", False, 12.5),
    ],
)
def test_messages_survive_the_way(message: Message) -> None:
    assert unpack(pack(message)) == message


@for_each("packet", [b"", b"{}", b"[]", b'["Nothing"]', b'["Rearm"]', b"\xff"])
def test_what_is_no_message_is_refused(packet: bytes) -> None:
    with pytest.raises(ValueError, match="no message"):
        unpack(packet)


async def test_a_thread_for_blocking_calls_has_the_name_that_it_was_given() -> None:
    thread = DaemonThread("aioduco-reader")
    try:
        name, _ = await thread.run(lambda: threading.current_thread().name)
    finally:
        thread.end()
    assert name == "aioduco-reader"


@pytest.mark.parametrize("code", [errno.EPERM, errno.ENOSYS, errno.EINVAL])
def test_a_guard_without_priority_asks_for_short_slices_whatever_the_reason(
    monkeypatch: pytest.MonkeyPatch, code: int
) -> None:
    """A sandbox may refuse the call by any error; the guard has to start all the same."""
    from aioduco.supervision.guard import process  # noqa: PLC0415  # not on Windows

    slices: list[int] = []

    def refuse(*_: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(os, "sched_getscheduler", lambda _: os.SCHED_OTHER)
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(process, "shorten_slice", slices.append)
    process._raise_priority()
    assert slices == [process._SLICE]


async def test_the_guard_beats_and_ends_with_its_robots(bench: Bench, robot: aioduco.Robot) -> None:
    _, pid = guard_of(robot)
    await eventually_async(lambda: len(bench.received("rpc_heartbeat")) >= 4)
    assert state(robot) is HeartbeatState.BEATING
    task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
    await robot.stop()
    with pytest.raises(aioduco.TaskStopped):
        await task
    assert bench.commands == ["movej2", "stop"]
    await robot.aclose()
    eventually(lambda: not running(pid))


@pytest.mark.slow
async def test_one_guard_for_all_robots(bench: Bench) -> None:
    async with (
        aioduco.connect(bench.host, bench.port, guard="process") as one,
        aioduco.connect(bench.host, bench.port, guard="process") as other,
    ):
        _, pid = guard_of(one)
        assert guard_of(other)[1] == pid
        await one.aclose()
        assert running(pid)
        await other.stop()
        assert bench.commands == ["stop"]
    eventually(lambda: not running(pid))


@pytest.mark.filterwarnings("ignore::ResourceWarning")
async def test_the_guard_beats_no_more_for_a_robot_that_was_dropped(bench: Bench) -> None:
    """The controller would take the beats for a sign of life of whatever moves the arm then.

    A call that this controller answered with an error does not keep the robot alive.
    """
    with Bench() as other:
        async with aioduco.connect(other.host, other.port, guard="process", heartbeat=0.3):
            robot = aioduco.connect(bench.host, bench.port, guard="process", heartbeat=0.3)
            await robot.open()
            supervisor = robot._supervisor
            del robot
            gc.collect()
            counts: list[tuple[int, ...]] = [(0, 0)]

            def one_beats_alone() -> bool:
                now = tuple(len(each.received("rpc_heartbeat")) for each in (bench, other))
                if now[0] != counts[0][0]:  # a busy machine's guard may be late to read it
                    counts[:] = [now]
                return now[1] > counts[0][1] + 6

            await eventually_async(one_beats_alone)
            await supervisor.aclose()


@pytest.mark.slow
async def test_the_guards_death_stops_the_arm_and_another_takes_over(
    bench: Bench, robot: aioduco.Robot
) -> None:
    guard, first = guard_of(robot)
    task = await under_way(bench, robot)
    os.kill(first, signal.SIGKILL)
    with pytest.raises(aioduco.TaskStopped):
        await task
    await eventually_async(lambda: guard.alive and state(robot) is HeartbeatState.BEATING)
    assert guard.pid != first
    bench.motion_time = 0.1
    await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.slow
@pytest.mark.parametrize("heartbeat", [0.3, None], ids=["heartbeat", "none"])
async def test_another_guard_is_tried_until_it_can_be_started(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, heartbeat: float | None
) -> None:
    """Each error meanwhile says that, and why there is none yet."""
    async with aioduco.connect(
        bench.host, bench.port, guard="process", heartbeat=heartbeat
    ) as robot:
        guard, tries = kill_guard_for_good(robot, monkeypatch)
        await eventually_async(lambda: len(tries) >= 3)
        with pytest.raises(aioduco.DucoError, match=r"nother (guard )?is being started"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        if robot.heartbeat is not None:
            with pytest.raises(aioduco.HeartbeatLost, match=r"failed: .* EAGAIN"):
                await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert not bench.received("movej2")
        monkeypatch.undo()
        await eventually_async(lambda: guard.alive)
        if robot.heartbeat is not None:
            await eventually_async(lambda: state(robot) is HeartbeatState.BEATING)
        await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.slow
async def test_a_robot_that_is_closed_tries_no_other_guard(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with aioduco.connect(bench.host, bench.port, guard="process") as robot:
        guard, tries = kill_guard_for_good(robot, monkeypatch)
        await eventually_async(lambda: len(tries) >= 2)
    assert not guard.alive
    assert not any("guard" in task.get_name() for task in asyncio.all_tasks())


@pytest.mark.slow
async def test_a_guard_that_dies_while_it_takes_over_is_replaced_once_more(
    bench: Bench, robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    guards: list[GuardLink] = []
    acquire = client.shared.acquire

    def killed_at_once() -> GuardLink:
        link = acquire()
        guards.append(link)
        if len(guards) <= 2:
            os.kill(link.pid, signal.SIGKILL)
        return link

    monkeypatch.setattr(client.shared, "acquire", killed_at_once)
    _, first = guard_of(robot)
    os.kill(first, signal.SIGKILL)
    await eventually_async(lambda: len(guards) == 3 and state(robot) is HeartbeatState.BEATING)
    await robot.motion.movej2(HOME, v=1.0, a=1.0)


def kill_guard_for_good(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> tuple[GuardClient, list[None]]:
    """Kill the guard; no other can be started. Returns it, and a list of the attempts."""
    tries: list[None] = []

    def refuse() -> NoReturn:
        tries.append(None)
        raise aioduco.GuardLost("the guard's process could not be started: EAGAIN")

    monkeypatch.setattr(client.shared, "acquire", refuse)
    guard, pid = guard_of(robot)
    os.kill(pid, signal.SIGKILL)
    return guard, tries


@pytest.mark.slow
async def test_a_guard_that_hangs_does_not_hold_up_a_stop(
    bench: Bench, robot: aioduco.Robot
) -> None:
    _, pid = guard_of(robot)
    os.kill(pid, signal.SIGSTOP)
    try:
        await robot.stop()
        robot.stop_now()
        assert robot.statistics().stops == 2  # accepted; a busy machine repeats what is late
        assert bench.stops >= 2
        # its heart does not beat, so the controller stops the arm, and nothing is moved
        await eventually_async(lambda: state(robot) is HeartbeatState.LOST)
        with pytest.raises(aioduco.HeartbeatLost):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
    finally:
        os.kill(pid, signal.SIGCONT)


async def test_a_hung_loop_has_its_arm_stopped(bench: Bench) -> None:
    async with aioduco.connect(
        bench.host, bench.port, guard="process", heartbeat=60.0, loop_stall_limit=2.0
    ) as robot:
        bench.motion_time = 30.0
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        before = bench.stops
        eventually(lambda: bench.stops > before)  # the loop does not run
        await eventually_async(lambda: state(robot) is HeartbeatState.STALLED)
        with pytest.raises(aioduco.HeartbeatLost):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert await task.wait() is aioduco.Outcome.STOPPED
        await robot.rearm_heartbeat()
        bench.motion_time = 0.1
        await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.slow
async def test_a_hung_loop_without_a_heartbeat_has_its_arm_stopped(bench: Bench) -> None:
    """Each time that it hangs; and nothing has to be rearmed."""

    def hang_until_stop() -> None:
        eventually(lambda: not bench.moving())  # the loop does not run

    async with aioduco.connect(
        bench.host, bench.port, guard="process", heartbeat=None, loop_stall_limit=2.0
    ) as robot:
        for _ in range(2):
            task = await under_way(bench, robot)
            hang_until_stop()
            with pytest.raises(aioduco.TaskStopped) as told:
                await task
            assert str(told.value.__cause__).endswith("longer than 2 s (loop_stall_limit)")
            bench.motion_time = 0.1
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert not bench.received("rpc_heartbeat")
    assert bench.commands == 2 * ["movej2", "stop", "movej2"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("guard", "heartbeat"), [(None, 60.0), ("process", 60.0), ("process", None)], ids=str
)
async def test_a_hung_loop_has_its_hand_guiding_ended(
    guard: GuardKind | None, heartbeat: float | None
) -> None:
    """The stop may leave it on, and its program is killed next: nobody else would end it."""
    with Desk() as desk:
        desk.answer("stop", 4)
        async with aioduco.connect(
            desk.host, desk.port, guard=guard, heartbeat=heartbeat, loop_stall_limit=2.0
        ) as robot:
            await robot.motion.teach_mode().start()
            eventually(lambda: not desk.going_on)  # the loop does not run
            assert desk.commands == ["teach_mode", "stop", "end_teach_mode"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "end", [4, ApplicationError(6, "no such mode is on")], ids=["ended", "refused"]
)
@pytest.mark.parametrize(
    ("guard", "heartbeat"), [(None, 60.0), ("process", 60.0), ("process", None)], ids=str
)
async def test_a_hung_loop_has_its_realtime_queue_emptied(
    guard: GuardKind | None, heartbeat: float | None, end: object
) -> None:
    """Who starts the mode next would begin with what is left."""
    ended = ["end_realtime_mode", "clear_realtime_data_queue"]
    with Desk() as desk:
        for name in ("stop", "start_realtime_mode", ended[1]):
            desk.answer(name, 4)
        desk.answer(ended[0], end)
        async with aioduco.connect(
            desk.host, desk.port, guard=guard, heartbeat=heartbeat, loop_stall_limit=2.0
        ) as robot:
            await robot.realtime.start_realtime_mode(aioduco.RealtimeMode.TWIST)
            eventually(lambda: ended[1] in desk.commands)  # the loop does not run
            assert desk.commands == ["start_realtime_mode", "stop", *ended]


async def test_an_unknown_controller_is_told_as_without_a_guard() -> None:
    robot = aioduco.connect("127.0.0.1", 1, guard="process")
    with pytest.raises(aioduco.ConnectError, match=r"127\.0\.0\.1:1"):
        await robot.open()


@pytest.mark.slow
@pytest.mark.parametrize("cut", [False, True])
def test_a_killed_program_leaves_a_standing_arm(bench: Bench, proxy: FaultProxy, cut: bool) -> None:
    """Also if the guard's connection breaks as it sends the stop."""
    if cut:
        proxy.on("stop", Cut(Place.BEFORE_REQUEST))
    _kill_in_mid_motion(bench, proxy.host, proxy.port)
    assert len(proxy.calls("stop")) > bench.stops or not cut


@pytest.mark.slow
def test_hand_guiding_is_over_when_its_program_was_killed() -> None:
    """A stop may leave it on: the arm would give way to hands, and to a load that is set wrong."""
    with Desk() as desk:
        desk.answer("stop", 4)  # it leaves hand guiding on
        _kill_in_mid_motion(desk, desk.host, desk.port, "motion.teach_mode()")
        eventually(lambda: not desk.going_on)
        assert desk.commands == ["teach_mode", "stop", "end_teach_mode"]


def _kill_in_mid_motion(bench: Bench, host: str, port: int, motion: str = MOVE) -> None:
    bench.motion_time = 30.0
    program = f"""
import os, anyio, aioduco
async def main():
    robot = aioduco.connect({host!r}, {port}, guard="process", heartbeat=60.0)
    await robot.open()
    await robot.{motion}.start()
    if os.fork() == 0:
        # a forked child that lives on does not keep the guard waiting
        os.execv("/bin/sleep", ["sleep", "30"])
    os.kill(os.getpid(), 9)
anyio.run(main)
"""
    # a session of its own, so that the sleeper can be ended
    with subprocess.Popen([sys.executable, "-c", program], start_new_session=True) as child:
        assert child.wait() == -signal.SIGKILL
        try:
            eventually(lambda: bench.stops >= 1 and not bench.moving())
        finally:
            os.killpg(child.pid, signal.SIGKILL)
