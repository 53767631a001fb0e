"""Rates and times out of range are refused by every function, and nothing is sent."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import anyio
import pytest

import aioduco
import aioduco.sync
from aioduco import Joints, ParameterError, Tolerances, WorkerOptions
from aioduco.api.force_stream import ForceStream
from aioduco.api.status_port import StatusPort
from aioduco.cli.stream_rate import examine
from aioduco.compat import DucoCobot
from aioduco.devices.bus import ModbusRtu, Port
from aioduco.devices.grippers import DigitalGripper, Robotiq, VacuumGripper
from aioduco.devices.teleoperation import JointTarget
from aioduco.integrations.fleet import FleetClient, FleetSettings
from aioduco.kinematics import arm
from aioduco.planning import Planner, Scene
from aioduco.sim import Simulator
from aioduco.streaming.ticks import Ticks
from aioduco.supervision.settings import ClosingSteps
from aioduco.testing import HalfOpen, Throttle
from aioduco.testing.preflight import PreflightSettings
from client.bench import HOME, Bench

NANOSECONDS = 1_700_000_000_000_000_000
#: values that are no rate and no time
NEVER: tuple[Any, ...] = (-1.0, math.nan, -math.inf, "1", True, 10**400, NANOSECONDS)
#: what a throttle and numpy take all the same
TAKEN = {("throttle", NANOSECONDS), ("time of a trajectory", True)}
THREAD = WorkerOptions(run_in="thread")


async def nothing(*_: Any) -> Any:
    """A port to which nothing is connected."""


def set_rate(robot: Any, rate: float) -> None:
    robot.feed.rate = rate


def device() -> ModbusRtu:
    return ModbusRtu(Port(nothing, nothing), 1)


#: timeouts of `connect`
TIMEOUTS = (
    *("call_timeout", "connect_timeout", "stop_timeout", "standstill_timeout"),
    *("unanswered_timeout", "loop_stall_limit"),
)


def connected(name: str, _: Any, value: Any) -> Any:
    options: dict[str, Any] = {name: value}
    return aioduco.connect("arm", **options)


async def planned(_: Any, timeout: Any) -> None:
    async with Planner(Scene("gcr5_910")) as planner:
        await planner.plan(HOME, Joints(*HOME), timeout=timeout)


#: what takes a rate or a time above 0, by name: called with an open robot and the value
ABOVE: dict[str, Callable[[Any, float], Any]] = {
    "ticks of a stream": lambda r, x: r.speed.joints(a=1.0).ticks(x),
    "ticks": lambda _, x: Ticks(x, lambda: None),
    "age of a sample": lambda r, x: r.feed.latest(max_age=x),
    "rate of the feed": set_rate,
    "wait for a sample": lambda r, x: r.feed.wait_for(bool, timeout=x),
    "wait for a state": lambda r, x: r.wait_for(bool, timeout=x),
    "deadline of a motion": lambda r, x: r.motion.movej2(HOME, 1.0, 1.0).start(deadline=x),
    "stop_now": lambda r, x: r.stop_now(x),
    "rearm_heartbeat": lambda r, x: r.rearm_heartbeat(timeout=x),
    "bring_up": lambda r, x: r.bring_up(timeout=x),
    "recover": lambda r, x: r.recover(timeout=x),
    "power_on": lambda r, x: r.system.power_on(timeout=x),
    "enable": lambda r, x: r.system.enable(timeout=x),
    "restart": lambda r, x: r.system.restart(timeout=x),
    "rate of a servo stream": lambda r, x: r.servo.joints(v=1.0, a=1.0, rate=x),
    "its source": lambda r, x: r.servo.joints(v=1.0, a=1.0, source_rate=x),
    "its hold": lambda r, x: r.servo.joints(v=1.0, a=1.0, hold=x),
    "rate of a speed stream": lambda r, x: r.speed.joints(a=1.0, rate=x),
    "its dead man": lambda r, x: r.speed.joints(a=1.0, dead_man=x),
    "period of a queue": lambda r, x: r.realtime.stream("twist", v=(1, 1), a=(1, 1), period=x),
    "period of a pool": lambda r, x: r.track.stream("joints", speed=1.0, acc=1.0, period=x),
    "hold of a pool": lambda r, x: r.track.stream("joints", speed=1.0, acc=1.0, hold=x),
    "answer of a worker": lambda _, x: WorkerOptions(timeout=x),
    "start of a worker": lambda _, x: WorkerOptions(connect_timeout=x),
    "absence of a worker": lambda _, x: WorkerOptions(away_limit=x),
    "closing steps": lambda _, x: ClosingSteps(stop=x),
    **{name: partial(connected, name) for name in TIMEOUTS},
    "state_rate": lambda _, x: aioduco.connect("arm", state_rate=x),
    "lag_limit": lambda _, x: aioduco.connect("arm", lag_limit=x),
    "heartbeat": lambda _, x: aioduco.connect("arm", heartbeat=x),
    "hold_limit": lambda _, x: aioduco.sync.connect("arm", hold_limit=x),
    "program_limit": lambda _, x: aioduco.sync.connect("arm", program_limit=x),
    "answer on the bus": lambda _, x: ModbusRtu(Port(nothing, nothing), 1, timeout=x),
    "poll of the bus": lambda _, x: ModbusRtu(Port(nothing, nothing), 1, poll=x),
    "poll of a gripper": lambda _, x: Robotiq(device(), poll=x),
    "end of its movement": lambda _, x: Robotiq(device(), timeout=x),
    "age of its state": lambda _, x: Robotiq(device(), max_age=x),
    "travel of a valve": lambda r, x: DigitalGripper(r, 1, travel_time=x),
    "vacuum": lambda r, x: VacuumGripper(r, 1, build_up=x),
    "the stream doctor": lambda _, x: examine("arm", seconds=x),
    "status port": lambda _, x: StatusPort("arm", timeout=x),
    "force stream": lambda _, x: ForceStream("arm", timeout=x),
    "the vendor's class": lambda _, x: DucoCobot("arm", timeout=x),
    "end of a preflight": lambda _, x: PreflightSettings(timeout=x),
    "its patience": lambda _, x: PreflightSettings(patience=x),
    "step of a joint target": lambda _, x: JointTarget(arm("gcr5_910")).by_joints(HOME, x, HOME),
    "state of a fleet": lambda _, x: FleetClient(FleetSettings("cell")).status(x),
    "stop of a fleet": lambda _, x: FleetClient(FleetSettings("cell")).stop(timeout=x),
    "throttle": lambda _, x: Throttle(x),
    "plan": planned,
    "time of a trajectory": lambda _, x: aioduco.JointTrajectory([HOME, HOME], [0.0, x]),
}
#: what takes a time from 0
FROM_ZERO: dict[str, Callable[[Any, float], Any]] = {
    "spin of a worker": lambda _, x: WorkerOptions(spin=x),
    "watch of a worker": lambda _, x: WorkerOptions(watch=x),
    "time for a goal": lambda _, x: Tolerances(goal_time=x),
    "wait in a simulator": lambda _, x: Simulator().wait_until(bool, timeout=x),
    "vibrations": lambda _, x: Simulator(vibration_time=x),
    "slack of a heartbeat": lambda _, x: Simulator(heartbeat_slack=x),
    "half open": lambda _, x: HalfOpen(x),
}
#: the same for programs that wait
BLOCKING_ABOVE: dict[str, Callable[[Any, float], Any]] = {
    "ticks of a stream": lambda r, x: r.speed.joints(a=1.0).ticks(x),
    "age of a sample": lambda r, x: r.feed.latest(max_age=x),
    "wait for a sample": lambda r, x: r.feed.wait_for(bool, timeout=x),
    "bring_up": lambda r, x: r.bring_up(timeout=x),
    "stop_now": lambda r, x: r.stop_now(x),
    "deadline of a motion": lambda r, x: r.motion.movej2.prepare(HOME, 1.0, 1.0).start(deadline=x),
}


async def carried_out(work: Callable[[Any, float], Any], robot: Any, value: float) -> None:
    """Call it, and await what it returns."""
    made = work(robot, value)
    if inspect.isawaitable(made):
        await made


async def test_what_is_no_time_is_refused(bench: Bench, robot: aioduco.Robot) -> None:
    """All in one test, which costs one robot: what is taken is listed."""
    tries = [(what, work, value) for what, work in ABOVE.items() for value in (0.0, *NEVER)]
    tries += [(what, work, value) for what, work in FROM_ZERO.items() for value in NEVER]
    taken: list[str] = []
    for what, work, value in tries:
        if (what, value) in TAKEN:
            continue
        try:
            with anyio.fail_after(5.0):
                await carried_out(work, robot, value)
        except ValueError as exc:
            if str(value) in str(exc) or "not nanoseconds" in str(exc):
                continue
        except Exception as exc:
            taken.append(f"{what}: {value}, and then {exc!r}")
            continue
        taken.append(f"{what}: {value}")
    assert taken == []
    assert not bench.commands


async def test_every_function_of_a_robot_that_waits_for_so_long_is_here(
    robot: aioduco.Robot,
) -> None:
    timed = {
        name
        for thing in (robot, robot.feed)
        for name, function in inspect.getmembers(thing, callable)
        if not name.startswith("_") and "timeout" in inspect.signature(function).parameters
    }
    assert timed == {"bring_up", "recover", "rearm_heartbeat", "stop_now", "wait_for"}


async def test_a_rate_that_is_refused_leaves_the_feed_as_it_is(robot: aioduco.Robot) -> None:
    rate = robot.feed.rate
    for value in (0.0, *NEVER, math.inf):
        with pytest.raises(ParameterError):
            robot.feed.rate = value
    assert robot.feed.rate == rate
    robot.feed.rate = 200.0
    assert (await robot.feed.latest()).states.robot is aioduco.RobotState.ENABLE


def test_what_is_no_time_is_refused_in_a_program_that_waits(bench: Bench) -> None:
    with aioduco.sync.connect(bench.host, bench.port) as robot:
        for work in BLOCKING_ABOVE.values():
            for value in (0.0, *NEVER):
                with pytest.raises(ParameterError, match=str(value)):
                    work(robot, value)
        task = robot.motion.movej2.start(HOME, 1.0, 1.0)
        with robot.events.subscribe() as events:
            for value in NEVER:
                with pytest.raises(ParameterError, match=str(value)):
                    events.next(value)
                with pytest.raises(ParameterError, match=str(value)):
                    task.wait(value)
                with pytest.raises(ParameterError, match=str(value)):
                    robot.sleep(value)
        robot.sleep(0)
        task.wait()
        assert task.wait(0) is aioduco.Outcome.FINISHED
