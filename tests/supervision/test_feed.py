"""The feed of the state: its age, its subscribers, its waits; and the events from changes."""

from __future__ import annotations

import asyncio
import logging
import re
import sys
import threading
import time
from collections import deque
from typing import Any

import anyio
import numpy as np
import pytest
from client.bench import Bench
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st
from wire.lanes import noted

import aioduco
from aioduco import HeartbeatState, OperationMode, RobotState, SafetyState
from aioduco._wire.owner_loop import OwnerLoop
from aioduco.errors import FeedOverflow, RobotStateError
from aioduco.supervision import events as changes
from aioduco.supervision.events import Event
from aioduco.supervision.loop_watchdog import Liveness, LoopWatchdog, blocking_calls, keep_alives
from aioduco.supervision.state_feed import Policy, Subscription
from aioduco.testing import DropReply, FaultProxy, eventually, eventually_async

ACTIONS = st.lists(st.booleans(), max_size=60)


@given(size=st.integers(1, 8), actions=ACTIONS)
def test_drop_oldest_keeps_the_newest_in_order(size: int, actions: list[bool]) -> None:
    buffer = Subscription[int]("drop_oldest", size, OwnerLoop())
    model: deque[int] = deque(maxlen=size)
    given_, taken = 0, 0
    for put in actions:
        if put:
            buffer.give(given_)
            model.append(given_)
            given_ += 1
        elif buffer.ready:
            assert buffer.take() == model.popleft()
            taken += 1
        assert len(buffer._items) == len(model)
        assert given_ == taken + len(buffer._items) + buffer.dropped  # none is lost uncounted


@given(size=st.integers(1, 4), actions=ACTIONS)
def test_every_one_comes_or_the_gap_is_told(size: int, actions: list[bool]) -> None:
    buffer = Subscription[int]("every", size, OwnerLoop())
    given_, expected, told = 0, 0, 0
    for put in actions:
        if put:
            buffer.give(given_)
            given_ += 1
        elif buffer.ready:
            try:
                value = buffer.take()
            except FeedOverflow:
                told = buffer.dropped
                expected = given_  # goes on behind the gap
            else:
                assert value == expected
                expected += 1
    assert (buffer.dropped > told) <= buffer.ready


@given(values=st.lists(st.integers(), min_size=1))
def test_latest_is_the_newest(values: list[int]) -> None:
    buffer = Subscription[int]("latest", 5, OwnerLoop())
    for value in values:
        buffer.give(value)
    assert buffer.take() == values[-1]
    assert buffer.dropped == len(values) - 1
    with pytest.raises(IndexError):
        buffer.take()


@for_each("policy, size", [("newest", 4), ("every", 0), ("every", 1.5)])
def test_bad_buffers_are_refused(policy: Policy, size: int) -> None:
    with pytest.raises(aioduco.ParameterError):
        Subscription[int](policy, size, OwnerLoop())


async def test_it_begins_when_it_is_used(bench: Bench, robot: aioduco.Robot) -> None:
    assert not bench.received("getRobotStatus")
    before = time.monotonic()
    sample = await robot.feed.latest()
    assert before <= sample.received_at <= time.monotonic()
    assert sample.sequence == 0
    assert sample.states.robot is RobotState.ENABLE
    assert sample.io.digital_inputs == (True,) * 16
    assert 0 <= sample.age < time.monotonic() - before + 0.001
    with pytest.raises(ValueError, match="read-only"):
        sample.status.joint_speeds[0] = 1.0


async def test_the_rate_is_held_and_measured(bench: Bench) -> None:
    async with aioduco.connect(bench.host, bench.port, state_rate=100.0) as robot:
        with robot.feed.subscribe("every", size=1000) as samples:
            numbers = []
            async for sample in samples:
                numbers.append(sample.sequence)
                if len(numbers) == 40:
                    break
        assert numbers == list(range(numbers[0], numbers[0] + 40))
        # A machine that is busy just now holds no rate: what is measured of late comes to it.
        await eventually_async(
            lambda: robot.feed.statistics().measured_rate == pytest.approx(100.0, rel=0.3),
            timeout=60.0,
            what=lambda: str(robot.feed.statistics()),
        )
        assert robot.feed.statistics().failures == 0


async def _until_stale(robot: aioduco.Robot, ages: list[float]) -> None:
    while True:
        asked = time.monotonic()
        ages.append(asked - (await robot.feed.latest(max_age=0.1)).received_at)


async def test_an_old_sample_is_never_returned(proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port, heartbeat=None) as robot:
        await robot.feed.latest()
        for name in ("get_robot_state", "getRobotStatus", "getRobotIOStatus"):
            proxy.on(name, DropReply(), times=None)
        ages: list[float] = []
        with pytest.raises(aioduco.StaleState, match="does not answer"):
            await _until_stale(robot, ages)
        assert max(ages, default=0.0) <= 0.1
        for soon in (1e-6, 0.001):
            with pytest.raises(aioduco.StaleState, match="the newest is"):
                await robot.feed.latest(max_age=soon)


@pytest.mark.slow
async def test_a_loop_that_is_held_up_is_not_taken_for_a_controller_that_does_not_answer(
    bench: Bench,
) -> None:
    """The answer came while the loop did not run: it is taken when it runs again."""
    async with aioduco.connect(bench.host, bench.port) as robot:
        begin = time.monotonic()

        def hold_up() -> None:
            while time.monotonic() < begin + 1.5:
                pass

        asyncio.get_running_loop().call_soon(hold_up)
        assert await robot.feed.latest(max_age=1.0)


async def test_subscribers_do_not_hold_each_other_up(robot: aioduco.Robot) -> None:
    with (
        robot.feed.subscribe("latest") as slow,
        robot.feed.subscribe("drop_oldest", size=2) as medium,
        robot.feed.subscribe("every", size=200) as quick,
    ):
        seen = 0
        async for _ in quick:
            seen += 1
            if seen == 10:
                break
        assert quick.dropped == 0
        assert slow.dropped == 9
        assert medium.dropped == 8
        assert (await anext(slow)).sequence == (await anext(medium)).sequence + 1
        assert robot.feed.statistics().dropped == 17
    assert robot.feed.statistics().subscribers == 0


async def test_a_predicate_that_must_be_awaited_does_not_count_as_true(
    robot: aioduco.Robot,
) -> None:
    async def asked(_: object) -> bool:
        return False

    def reading(_: object) -> Any:
        return robot.io.get_standard_digital_in(3)

    for wrong in (asked, reading):
        with pytest.raises(aioduco.ParameterError, match="a function that returns at once"):
            await robot.wait_for(wrong, timeout=5.0)  # type: ignore[arg-type]  # on purpose


@pytest.mark.parametrize("wrong", [3, None, "moving", [True]])
async def test_what_is_no_predicate_is_refused(robot: aioduco.Robot, wrong: Any) -> None:
    with pytest.raises(aioduco.ParameterError, match="predicate"):
        await robot.wait_for(wrong, timeout=1.0)


async def test_wait_for(bench: Bench, robot: aioduco.Robot) -> None:
    async with anyio.create_task_group() as tasks:

        async def wait() -> None:
            sample = await robot.wait_for(lambda s: s.status.collision, timeout=10.0)
            assert sample.status.collision

        tasks.start_soon(wait)
        await robot.feed.latest()
        bench.collision = True
    with pytest.raises(TimeoutError):
        await robot.wait_for(lambda s: s.status.emergency_stop, timeout=0.1)


async def test_waiting_ends_with_the_robot(bench: Bench) -> None:
    robot = aioduco.connect(bench.host, bench.port)
    await robot.open()
    raised: list[BaseException] = []

    async with anyio.create_task_group() as tasks:
        waiting = robot.wait_for(lambda _: False)
        tasks.start_soon(noted, raised, aioduco.RobotStateError, waiting)
        await robot.feed.latest()
        await robot.aclose()
    assert len(raised) == 1


async def test_waiting_ends_with_the_block_of_the_subscription(robot: aioduco.Robot) -> None:
    """A reader in another task waited for ever, also when the robot was closed."""
    raised: list[BaseException] = []
    with anyio.fail_after(10.0):
        async with anyio.create_task_group() as tasks:
            with robot.events.subscribe() as events, robot.feed.subscribe("latest") as samples:
                tasks.start_soon(noted, raised, aioduco.RobotStateError, anext(events))
                await anext(samples)
        with pytest.raises(aioduco.RobotStateError, match="its block has ended"):
            [sample async for sample in samples]
    assert "its block has ended" in str(raised[0])


# -- events ------------------------------------------------------------------------------------


async def some(events: Subscription[Event], *kinds: type[Event]) -> dict[type[Event], Any]:
    """Events until each of the kinds has been seen."""
    seen: dict[type[Event], Any] = {}
    with anyio.fail_after(10.0):
        while not set(kinds) <= set(seen):
            event = await anext(events)
            seen[type(event)] = event
    return seen


async def test_an_error_that_comes_again_is_a_new_one(bench: Bench, robot: aioduco.Robot) -> None:
    bench.errors = ["joint 3: overload"]
    with robot.events.subscribe() as events:
        await eventually_async(lambda: bool(bench.received("get_last_error")))
        bench.errors = ["joint 3: overload"] * 2
        changed = (await some(events, changes.ErrorsChanged))[changes.ErrorsChanged]
    assert (changed.added, changed.severity) == (("joint 3: overload",), "warning")


async def test_a_second_reader_of_one_subscription_is_told_and_the_first_goes_on(
    robot: aioduco.Robot,
) -> None:
    with robot.events.subscribe() as events:
        async with anyio.create_task_group() as group:
            group.start_soon(anext, events)
            await anyio.wait_all_tasks_blocked()
            with pytest.raises(aioduco.RobotStateError, match="subscribe once for each"):
                await anext(events)
            robot.events.tell(changes.CollisionReset(0.0))


async def test_events_of_the_state(bench: Bench, robot: aioduco.Robot) -> None:
    with robot.events.subscribe() as events:
        assert repr(robot.events) == "<Events 1 subscribers>"
        await eventually_async(lambda: bool(bench.received("get_last_error")))
        bench.collision = True
        bench.states = [4, 0, 9, 0]
        bench.errors = ["Joint 4 检测到碰撞"]
        seen = await some(
            events,
            changes.CollisionDetected,
            changes.SafetyStateChanged,
            changes.RobotStateChanged,
            changes.ModeChanged,
            changes.ErrorsChanged,
        )
        safety = seen[changes.SafetyStateChanged]
        assert (safety.before, safety.after) == (SafetyState.RUN, SafetyState.STOP0)
        mode = seen[changes.ModeChanged]
        assert mode.after is OperationMode.MANUAL
        errors = seen[changes.ErrorsChanged]
        assert errors.added == ("Joint 4 检测到碰撞",)
        bench.collision = False
        bench.emergency_stop = True
        await some(events, changes.CollisionReset, changes.EmergencyStopPressed)
        bench.emergency_stop = False
        await some(events, changes.EmergencyStopReleased)


@pytest.mark.slow
async def test_events_of_the_lines(proxy: FaultProxy) -> None:
    async with aioduco.connect(proxy.host, proxy.port, heartbeat=1.0, call_timeout=1.0) as robot:
        with robot.events.subscribe() as events:
            await robot.feed.latest()
            proxy.refuse()
            proxy.cut()
            seen = await some(events, changes.ConnectionGone, changes.HeartbeatChanged)
            beat = seen[changes.HeartbeatChanged]
            assert beat.after is HeartbeatState.LOST
            proxy.accept()
            seen = await some(events, changes.ConnectionBack, changes.HeartbeatChanged)
            back = seen[changes.ConnectionBack]
            assert back.seconds > 0
            beat = seen[changes.HeartbeatChanged]
            assert beat.after is HeartbeatState.BEATING


def blocks_told(caplog: pytest.LogCaptureFixture) -> list[float]:
    """How long the loop was blocked, of each block that the log tells [s]."""
    return [
        float(seconds)
        for record in caplog.records
        if record.name == "aioduco.supervision.loop_watchdog"
        for seconds in re.findall(r"for (-?[\d.]+) s", record.getMessage())
    ]


def block_the_loop(seconds: float) -> None:
    time.sleep(seconds)


@pytest.mark.parametrize(("lag", "period"), [(None, 0.1), (0.25, 0.1), (0.05, 0.02)])
def test_a_loop_that_runs_is_never_late_by_its_lag_limit(lag: float | None, period: float) -> None:
    """With one every 0.1 s, a limit of 0.05 s gave ten warnings a second of a busy computer."""
    assert keep_alives(1.0, lag_limit=lag).period == pytest.approx(period)


async def test_the_time_until_a_robot_is_open_is_not_taken_for_a_blocked_loop(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    robot = aioduco.connect(bench.host, bench.port, heartbeat=None, lag_limit=0.15)
    robot._supervisor._liveness.stamp -= 60.0  # as if it had been named a minute ago
    async with robot:
        with robot.events.subscribe() as events:
            await robot.feed.latest()
            block_the_loop(0.5)
            await some(events, changes.LoopBlocked)
    told = blocks_told(caplog)
    assert told
    assert all(0.0 < seconds < 30.0 for seconds in told)


def test_a_block_lasts_until_a_robot_that_is_still_open_has_a_keep_alive(
    caplog: pytest.LogCaptureFixture,
) -> None:
    left, kept = Liveness(), Liveness()
    kept.ran -= 60.0
    watchdog = LoopWatchdog(threading.get_ident())
    for life in (left, kept):
        watchdog.add(life, 0.02, lambda seconds, where: None)
    try:
        time.sleep(0.1)  # meanwhile the watchdog waits for the end of the block
        assert not watchdog.remove(left)
        time.sleep(0.1)
        kept.touch(time.monotonic())
        eventually(lambda: bool(blocks_told(caplog)))
    finally:
        watchdog.remove(kept)
        assert watchdog.join(5.0)
    assert all(0.0 < seconds < 30.0 for seconds in blocks_told(caplog))


async def test_what_blocks_the_loop_is_named(
    bench: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    async with aioduco.connect(bench.host, bench.port, lag_limit=0.15) as robot:
        with robot.events.subscribe() as events:
            await robot.feed.latest()
            block_the_loop(0.5)
            # a busy machine blocks it besides, anywhere
            async for event in events:
                if isinstance(event, changes.LoopBlocked) and "block_the_loop" in event.where:
                    assert event.seconds > 0.3
                    assert event.where.startswith(f"{__file__}:")
                    assert "\n" not in event.where
                    break
        await eventually_async(lambda: "block_the_loop" in caplog.text)


def test_of_a_busy_loop_one_line_is_told_and_the_calls_are_for_debugging() -> None:
    """The program's line is the innermost within the loop; of asyncio's own calls none is."""
    seen: list[tuple[str, str]] = []

    def look() -> int:
        seen.append(blocking_calls(sys._getframe()))
        return 0

    async def program() -> None:
        sorted([1], key=lambda _: look())
        seen.append(blocking_calls(sys._getframe().f_back))

    async def main() -> None:
        await asyncio.create_task(program())

    asyncio.run(main())
    (line, stack), (outer_line, outer_stack) = seen
    assert line.startswith(f"{__file__}:")
    assert ", in look: seen.append(" in line
    assert "in program" in stack
    assert outer_line == "", "what started the loop does not block it"
    assert "asyncio" in outer_stack
    assert blocking_calls(None) == ("", "")


def test_a_line_that_was_typed_at_a_prompt_is_of_the_program() -> None:
    seen: list[tuple[str, str]] = []
    typed: dict[str, Any] = {"look": lambda: seen.append(blocking_calls(sys._getframe().f_back))}
    text = "async def program():\n    look()"
    for prompt in ("<console>", "<stdin>", "<python-input-3>", "<ipython-input-4-5a>", "<string>"):
        exec(compile(text, prompt, "exec"), typed)
        asyncio.run(typed["program"]())
        line = "" if prompt == "<string>" else f"{prompt}:2, in program"
        assert seen.pop()[0] == line


@pytest.mark.parametrize("line", ["", "a.py:3, in work: solve()"])
def test_a_block_is_one_line_of_the_log(line: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    LoopWatchdog(0)._report(0.36, line, '  File "x", line 1, in y\n')
    eventually(lambda: len(caplog.records) == 2)
    warning, debug = caplog.records
    assert (warning.levelname, debug.levelname) == ("WARNING", "DEBUG")
    assert "\n" not in warning.getMessage()
    assert (line or "busy") in warning.getMessage()
    assert "in y" in debug.getMessage()


async def test_forces_are_read_when_they_are_asked_for(bench: Bench) -> None:
    bench.answer("get_tcp_force", [1.0, 2.0, -30.0, 0.1, 0.2, 0.3])
    bench.answer("get_ext_torque", [])
    async with aioduco.connect(bench.host, bench.port) as robot:
        sample = await robot.feed.latest()
        with pytest.raises(RobotStateError, match=r"feed\.forces = True"):
            _ = sample.forces
        with pytest.raises(aioduco.ParameterError, match="True or False"):
            robot.feed.forces = "off"  # type: ignore[assignment]
        robot.feed.forces = True
        sample = await robot.feed.latest()
        assert sample.forces.tool.tolist() == [1.0, 2.0, -30.0, 0.1, 0.2, 0.3]
        # What was not sent is not a number, and the rest comes all the same.
        assert np.isnan(sample.forces.external_torques).all()
        pressed = await robot.feed.wait_for(lambda each: each.forces.tool[2] < -20, timeout=30.0)
        assert pressed.forces.age < 30.0
        assert sample.forces.sequence < pressed.forces.sequence
