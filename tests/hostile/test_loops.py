"""A robot works on its own event loop only: on another one nothing is sent."""

from __future__ import annotations

import asyncio
import gc
import threading
from collections.abc import Callable, Coroutine, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any

import anyio
import anyio.lowlevel
import pytest
import trio
import uvloop
from client.bench import HOME, Bench

import aioduco
from aioduco import WrongLoop
from aioduco._wire.lane import WireLane
from aioduco.testing import eventually, eventually_async

#: s after which a call that hangs has failed the test
PATIENCE = 30.0

GUARDS = pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])

#: makes an event loop
NewLoop = Callable[[], asyncio.AbstractEventLoop]

#: what is awaited of a robot with a motion under way, by name
USES: dict[str, Callable[[aioduco.Robot, aioduco.Task], Any]] = {
    "await a motion": lambda robot, _: _awaited(robot.motion.movej2(HOME, v=1.0, a=1.0)),
    "start a motion": lambda robot, _: robot.motion.movej2(HOME, v=1.0, a=1.0).start(),
    "a block": lambda robot, _: _entered(robot.motion.movej2(HOME, v=1.0, a=1.0)),
    "a read": lambda robot, _: robot.state.get_robot_state(),
    "a command": lambda robot, _: robot.io.set_standard_digital_out(1, True),
    "power on": lambda robot, _: robot.system.power_on(),
    "stop": lambda robot, _: robot.stop(),
    "pause": lambda robot, _: robot.pause(),
    "resume": lambda robot, _: robot.resume(),
    "abort": lambda robot, _: robot.abort(),
    "bring up": lambda robot, _: robot.bring_up(),
    "recover": lambda robot, _: robot.recover(),
    "rearm": lambda robot, _: robot.rearm_heartbeat(),
    "wait for": lambda robot, _: robot.wait_for(lambda _: True),
    "latest": lambda robot, _: robot.feed.latest(),
    "samples": lambda robot, _: _first(robot.feed.subscribe),
    "events": lambda robot, _: _first(robot.events.subscribe),
    "a stream": lambda robot, _: _entered(robot.servo.joints(v=1.0, a=1.0)),
    "await the task": lambda _, task: _awaited(task),
    "wait for the task": lambda _, task: task.wait(),
    "states of the task": lambda _, task: anext(aiter(task)),
    "cancel the task": lambda _, task: task.cancel(),
    "end the task": lambda _, task: task.end(),
    "pause the task": lambda _, task: task.pause(),
    "resume the task": lambda _, task: task.resume(),
    "cancel an await of the task": lambda _, task: task._on_wait_cancelled(),
    "open": lambda robot, _: robot.open(),
    "close": lambda robot, _: robot.aclose(),
}


async def _awaited(one: Any) -> Any:
    return await one


async def _entered(one: Any) -> Any:
    async with one as entered:
        return entered


async def _first(subscribe: Callable[[], Any]) -> Any:
    with subscribe() as subscription:
        return await anext(subscription)


@pytest.fixture(params=[asyncio.new_event_loop, uvloop.new_event_loop], ids=["asyncio", "uvloop"])
def new_loop(request: pytest.FixtureRequest) -> NewLoop:
    made: NewLoop = request.param
    return made


@pytest.fixture(scope="module", autouse=True)
def _pipe_for_signals() -> None:
    """The first loop of libuv opens a pipe that the process keeps: no leak of what is tested."""
    run(uvloop.new_event_loop, anyio.lowlevel.checkpoint)


def run(new_loop: Callable[[], Any], work: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
    """Run it as `asyncio.run` does, within a limit of time."""

    async def limited() -> Any:
        async with asyncio.timeout(PATIENCE):
            return await work()

    with asyncio.Runner(loop_factory=new_loop) as runner:
        return runner.run(limited())


async def refused(robot: aioduco.Robot, task: aioduco.Task, bench: Bench) -> None:
    """Every use is refused by the one error, and the controller hears of none."""
    before = len(bench.commands)
    for name, use in USES.items():
        with pytest.raises(WrongLoop) as caught:
            await use(robot, task)
        said = str(caught.value)
        assert "belongs to the event loop on which it was opened" in said, name
        assert "nothing was sent" in said
        assert "stop_now()" in said
    assert len(bench.commands) == before


class Elsewhere:
    """An event loop that runs on a thread of its own."""

    def __init__(self, new_loop: NewLoop) -> None:
        self.loop = new_loop()
        self._thread = threading.Thread(target=self.loop.run_forever)
        self._thread.start()

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Run it there, and wait for it."""
        return self.begin(work).result(PATIENCE)

    def begin(self, work: Coroutine[Any, Any, Any]) -> Future[Any]:
        """Begin to run it there."""
        return asyncio.run_coroutine_threadsafe(work, self.loop)

    def end(self) -> None:
        """End loop and thread."""
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join()
        self.loop.close()


@contextmanager
def elsewhere(new_loop: NewLoop, bench: Bench) -> Iterator[tuple[Elsewhere, aioduco.Robot]]:
    """A loop that runs elsewhere, and a robot that is opened and closed on it."""
    made = Elsewhere(new_loop)
    try:
        robot = aioduco.connect(bench.host, bench.port, loop_stall_limit=20.0)
        made.run(robot.open())
        yield made, robot
        made.run(robot.aclose())
    finally:
        made.end()


# Another loop


def test_a_robot_is_not_used_from_the_loop_of_another_thread(
    new_loop: NewLoop, bench: Bench
) -> None:
    bench.motion_time = 60.0
    with elsewhere(new_loop, bench) as (other, robot):
        task = other.run(robot.motion.movej2(HOME, v=1.0, a=1.0).start())
        run(new_loop, lambda: refused(robot, task, bench))
        # it goes on undisturbed on its own
        assert bench.moving()
        assert not task.done
        other.run(robot.stop())
        assert task.outcome is aioduco.Outcome.STOPPED
        bench.motion_time = 0.05
        finished = other.run(_awaited(robot.motion.movej2(HOME, v=1.0, a=1.0)))
        assert finished is aioduco.Outcome.FINISHED


def test_a_stop_may_be_sent_from_any_thread_and_any_loop(new_loop: NewLoop, bench: Bench) -> None:
    bench.motion_time = 60.0
    with elsewhere(new_loop, bench) as (other, robot):
        other.run(robot.motion.movej2(HOME, v=1.0, a=1.0).start())

        async def stop() -> None:
            robot.stop_now()

        run(new_loop, stop)
        eventually(lambda: not bench.moving())


def test_a_robot_whose_loop_is_idle_is_refused_and_goes_on(new_loop: NewLoop, bench: Bench) -> None:
    """As with fixtures of a module: the loop lives, and does not run."""
    bench.motion_time = 60.0
    own = new_loop()
    robot = aioduco.connect(bench.host, bench.port, heartbeat=None)
    own.run_until_complete(robot.open())
    task = own.run_until_complete(robot.motion.movej2(HOME, v=1.0, a=1.0).start())
    run(new_loop, lambda: refused(robot, task, bench))
    own.run_until_complete(robot.stop())
    bench.motion_time = 0.05
    own.run_until_complete(_awaited(robot.motion.movej2(HOME, v=1.0, a=1.0)))
    own.run_until_complete(robot.aclose())
    own.close()


def test_a_subscription_is_read_on_the_loop_of_its_robot(new_loop: NewLoop, bench: Bench) -> None:
    with elsewhere(new_loop, bench) as (other, robot):
        with pytest.raises(WrongLoop), robot.feed.subscribe():
            pass

        async def subscribed() -> Any:
            manager = robot.feed.subscribe()
            return manager, manager.__enter__()

        manager, subscription = other.run(subscribed())

        async def read() -> None:
            with pytest.raises(WrongLoop):
                await anext(subscription)

        run(new_loop, read)
        assert other.run(_awaited(anext(subscription))).sequence >= 0
        manager.__exit__(None, None, None)


# A loop that has ended


@GUARDS
def test_the_end_of_a_loop_stops_the_arm_and_another_loop_leaves_the_robot(
    new_loop: NewLoop, bench: Bench, guard: Any
) -> None:
    """`asyncio.run` twice on one robot: the first forgets to close it."""
    bench.motion_time = 60.0
    robot = aioduco.connect(bench.host, bench.port, guard=guard, heartbeat=None)
    tasks: list[aioduco.Task] = []

    async def first() -> None:
        await robot.open()
        tasks.append(await robot.motion.movej2(HOME, v=1.0, a=1.0).start())

    async def second() -> None:
        with pytest.raises(WrongLoop, match="closed=True"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        await robot.aclose()

    run(new_loop, first)
    assert bench.commands == ["movej2", "stop"]
    run(new_loop, second)
    assert not bench.moving()
    assert bench.commands.count("movej2") == 1
    assert tasks[0].outcome is aioduco.Outcome.UNKNOWN
    assert "closed" in repr(robot)


@pytest.mark.parametrize("answered", [True, False], ids=["answered", "not answered"])
def test_an_await_that_the_end_of_a_loop_cancels_ends_when_the_arm_stands_or_says_so(
    new_loop: NewLoop, bench: Bench, answered: bool
) -> None:
    """`loop.stop()` in `asyncio.run` cancels all tasks, in any order: the supervision's first."""
    bench.motion_time, bench.braking_time = 60.0, 0.3
    if not answered:
        bench.hold("stop")
    told: list[BaseException] = []
    moving: list[bool] = []

    async def main() -> None:
        own = asyncio.current_task()
        async with aioduco.connect(bench.host, bench.port, stop_timeout=0.3) as robot:
            task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
            others = asyncio.all_tasks() - {own}
            for one in (*others, own):
                assert one is not None
                asyncio.get_running_loop().call_soon(one.cancel)
            try:
                await task
            except BaseException as exc:
                told.append(exc)
                moving.append(bench.moving())
                raise

    with pytest.raises(asyncio.CancelledError if answered else aioduco.StopUnconfirmed):
        run(new_loop, main)
    assert moving == [not answered]
    assert isinstance(told[0], aioduco.StopUnconfirmed) is not answered


@GUARDS
def test_a_robot_is_left_on_another_loop_if_its_own_was_closed_in_the_middle(
    new_loop: NewLoop, bench: Bench, guard: Any
) -> None:
    """A loop that is thrown away with tasks on it, none of which is ever cancelled."""
    bench.motion_time = 60.0
    own = new_loop()
    robot = aioduco.connect(bench.host, bench.port, guard=guard, heartbeat=None)

    async def begin() -> None:
        await robot.open()
        await robot.motion.movej2(HOME, v=1.0, a=1.0).start()

    own.run_until_complete(begin())
    waiting = asyncio.all_tasks(own)
    own.close()
    assert bench.moving()
    run(new_loop, robot.aclose)
    assert not bench.moving()
    assert bench.commands[0] == "movej2"
    assert "stop" in bench.commands
    for task in waiting:
        # it is what is tested
        task._log_destroy_pending = False  # type: ignore[attr-defined]
    del task, waiting
    gc.collect()


def test_a_motion_that_a_closed_poller_is_given_is_stopped(new_loop: NewLoop, bench: Bench) -> None:
    bench.motion_time = 60.0

    async def main() -> None:
        async with aioduco.connect(bench.host, bench.port) as robot:
            robot._supervisor.stop_coordinator.follower._close()
            task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
            assert await task.wait() is aioduco.Outcome.UNKNOWN
            assert not bench.moving()
            assert bench.commands == ["movej2", "stop"]

    run(new_loop, main)


# No loop of asyncio's


@pytest.mark.parametrize("runner", [trio.run, lambda main: anyio.run(main, backend="trio")])
def test_trio_is_refused_in_plain_words(bench: Bench, runner: Callable[..., Any]) -> None:
    async def main() -> None:
        async with aioduco.connect(bench.host, bench.port):
            pytest.fail("it was opened")

    with pytest.raises(WrongLoop, match=r"aioduco needs asyncio.*nothing was sent.*asyncio\.run"):
        runner(main)
    assert bench.connections == 0


def test_trio_as_a_guest_of_asyncio_is_refused_too(bench: Bench) -> None:
    async def guest() -> None:
        async with aioduco.connect(bench.host, bench.port):
            pytest.fail("it was opened")

    async def host() -> None:
        loop = asyncio.get_running_loop()
        over: asyncio.Future[Any] = loop.create_future()
        trio.lowlevel.start_guest_run(
            guest, run_sync_soon_threadsafe=loop.call_soon_threadsafe, done_callback=over.set_result
        )
        with pytest.raises(WrongLoop, match="aioduco needs asyncio"):
            (await over).unwrap()

    run(asyncio.new_event_loop, host)
    assert bench.connections == 0


# Lanes


def test_a_lane_is_refused_to_another_loop_while_its_own_lives(
    new_loop: NewLoop, bench: Bench
) -> None:
    own = new_loop()
    lane = WireLane("test", bench.host, bench.port)
    own.run_until_complete(lane.open())

    async def use() -> None:
        with pytest.raises(WrongLoop, match="the lane belongs to the event loop"):
            await lane.rpc.stop(True)

    run(new_loop, use)
    assert bench.commands == []
    own.run_until_complete(lane.rpc.stop(True))
    own.run_until_complete(lane.aclose())
    own.close()


async def test_the_right_loop_is_asked_nothing(bench: Bench) -> None:
    """What the other tests refuse is done here."""
    bench.motion_time = 0.05
    async with aioduco.connect(bench.host, bench.port) as robot:
        task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
        assert await task is aioduco.Outcome.FINISHED
        await eventually_async(lambda: not bench.moving())
        assert (await robot.feed.latest()).sequence >= 0
