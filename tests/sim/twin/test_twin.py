"""A twin beside a robot: what it reports, records and does, and how it ends."""

from __future__ import annotations

import asyncio
import dataclasses
import gc
import json
import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import anyio
import anyio.lowlevel
import pytest
from cli_runner import CliRunner
from example_modules import example
from recording.mcap_records import HEAD, channel

import aioduco
import aioduco.sync
from aioduco import Joints
from aioduco.cli.app import app
from aioduco.errors import ParameterError, RobotStateError, TaskStopped
from aioduco.kinematics import arm as arm_of
from aioduco.recording import read
from aioduco.sim import Simulator
from aioduco.sim.twin import Cause, Quantity, TwinLimits, judge, learn
from aioduco.sim.twin.data import TwinSample
from aioduco.sim.twin.recorded import items
from aioduco.supervision.events import TwinDiverged
from aioduco.testing import eventually_async

from .arms import ARM, READY

THERE = Joints(0.5, 0.2, 1.3, 0.1, -1.4, 0.3)
#: narrow enough for half a kilogram; times and tracking are those of a busy computer
LIMITS = dataclasses.replace(TwinLimits.of(ARM), mass=0.15, force=3.0, delay=1e3, path=1e3)


@pytest.fixture
async def sim() -> AsyncIterator[Simulator]:
    async with Simulator(joints=READY) as running:
        yield running


@pytest.fixture
async def robot(sim: Simulator) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(
        sim.host, sim.port, state_rate=125.0, loop_stall_limit=30.0, lag_limit=None
    ) as connected:
        await connected.bring_up()
        yield connected


@pytest.mark.slow
async def test_a_payload_is_an_event_and_in_the_recording(
    sim: Simulator, robot: aioduco.Robot, tmp_path: Path
) -> None:
    with robot.events.subscribe() as events:
        async with robot.record(tmp_path / "run.mcap"), robot.twin(LIMITS) as twin:
            await eventually_async(lambda: twin.figures.mass is not None)
            assert twin.figures.mass == pytest.approx(0.0, abs=1e-3)
            sim.load(0.5)
            async for event in events:
                if isinstance(event, TwinDiverged):
                    break
            assert isinstance(event, TwinDiverged)
            assert (event.quantity, event.cause, event.action) == ("torque", "payload", "report")
            assert event.estimate["mass [kg]"] == pytest.approx(0.5, abs=0.2)
            assert event.since <= event.at
            assert list(twin.divergences) == [event]
            assert twin.running
            assert twin.error is None
            await eventually_async(lambda: twin.statistics().samples > 20)
        assert twin.over
    run = read(tmp_path / "run.mcap")
    assert run.arrays("/twin")["mass"].max() > 0.15
    (written,) = [each.data for each in run.messages("/events") if "Twin" in each.data["event"]]
    assert written["what"]["cause"] == "payload"


async def test_the_path_of_a_motion_right_after_its_start_is_judged(robot: aioduco.Robot) -> None:
    async with robot.twin(LIMITS) as twin:
        task = await robot.motion.movej2(THERE, v=0.02, a=1.0).start()
        await eventually_async(lambda: twin.figures.path is not None, 10.0)
        assert not task.done


@pytest.mark.slow
async def test_a_blocking_motion_is_this_programs(robot: aioduco.Robot, tmp_path: Path) -> None:
    """Its call ends with it: it was another program's until then, for which the arm was stopped."""
    async with robot.record(tmp_path / "run.mcap"), robot.twin() as twin:
        await robot.blocking.movej2(THERE, v=1.0, a=2.0)
        await eventually_async(lambda: THERE.almost_equal(Joints.of(twin.joints or READY), 0.01))
    assert [each for each in twin.divergences if each.quantity == "path"] == []
    judged = judge(tmp_path / "run.mcap")
    assert [each for each in judged if each.quantity is Quantity.PATH] == []


@pytest.mark.slow
async def test_a_recording_is_judged_with_the_tool_that_was_set_before_it(
    robot: aioduco.Robot, tmp_path: Path
) -> None:
    """A line was rehearsed with the flange, so that another program had led the arm elsewhere."""
    await robot.frames.set_tool_data("long", [0, 0, 0.15, 0, 0.3, 0], [0.5, 0, 0, 0.05])
    async with robot.record(tmp_path / "run.mcap") as recording:
        await eventually_async(lambda: recording.statistics().written > 20)
        here = await robot.state.get_tcp_pose()
        await robot.motion.movel(here @ aioduco.Pose(0, 0, -0.05, 0, 0, 0.6), v=0.1, a=0.5)
    judged = judge(tmp_path / "run.mcap")
    assert [each for each in judged if each.quantity is Quantity.PATH] == []


async def test_in_a_recording_a_mode_leads_the_arm_until_its_end(
    robot: aioduco.Robot, tmp_path: Path
) -> None:
    """The path of an arm under force control was judged: another program had moved it."""

    async def some_samples() -> None:
        at = time.monotonic() + 0.1
        await robot.wait_for(lambda sample: sample.received_at > at)

    async with robot.record(tmp_path / "run.mcap"):
        await robot.force.fc_config([True] * 6, [0] * 6, [1000] * 6, [0.1] * 6)
        await robot.force.fc_start()
        await some_samples()
        await robot.force.fc_stop()
        await some_samples()
    led = [each.led for each in items(read(tmp_path / "run.mcap")) if isinstance(each, TwinSample)]
    assert any(led)
    assert not led[-1]


@pytest.mark.slow
async def test_it_stops_the_arm_if_it_was_asked_to(sim: Simulator, robot: aioduco.Robot) -> None:
    async with robot.twin(LIMITS, action="stop"), anyio.create_task_group() as tasks:
        tasks.start_soon(push_when_it_moves, sim, robot)
        with pytest.raises(TaskStopped):
            await robot.motion.movej2(THERE, v=0.02, a=1.0)


async def push_when_it_moves(sim: Simulator, robot: aioduco.Robot) -> None:
    await robot.wait_for(lambda s: abs(s.status.joint_speeds).max() > 0.01)
    sim.push([0.0, 20.0, 0.0, 0.0, 0.0, 0.0])


@pytest.mark.slow
async def test_it_reports_only_otherwise(sim: Simulator, robot: aioduco.Robot) -> None:
    async with robot.twin(LIMITS) as twin:
        sim.push([0.0, 20.0, 0.0, 0.0, 0.0, 0.0])
        await eventually_async(lambda: len(twin.divergences) > 0)
        sim.push([0.0] * 6)
        await robot.motion.movej2([*READY[:5], 0.2], v=1.0, a=2.0)


async def test_it_begins_with_the_speed_of_the_controller(robot: aioduco.Robot) -> None:
    """At less than 100 % every motion was that of a delayed controller."""
    await robot.settings.speed(40.0)
    begin = await robot.twin()._settings()
    assert ("speed", (40.0,)) in begin.settings


@pytest.mark.slow
async def test_its_end_is_not_the_robots(robot: aioduco.Robot) -> None:
    async with robot.twin(LIMITS) as twin:
        assert twin._linked is not None
        twin._linked.popen.kill()
        await eventually_async(lambda: twin.over)
        assert "process has ended" in str(twin.error)
        await robot.state.get_robot_state()


@pytest.mark.slow
async def test_it_is_started_once_and_closing_the_robot_ends_it(sim: Simulator) -> None:
    async with aioduco.connect(sim.host, sim.port) as robot:
        twin = await robot.twin(LIMITS).start()
        with pytest.raises(RobotStateError, match="once"):
            await twin.start()
    assert twin.over
    assert twin.error is None


@pytest.mark.slow
async def test_two_tasks_cannot_both_start_it(robot: aioduco.Robot) -> None:
    twin = robot.twin(LIMITS)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(twin.start)
        await anyio.lowlevel.checkpoint()
        with pytest.raises(RobotStateError, match="started once"):
            await twin.start()
    await twin.stop()


async def test_what_makes_no_sense_is_refused(robot: aioduco.Robot) -> None:
    with pytest.raises(ParameterError, match="report"):
        robot.twin(action="power_off")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="TwinLimits"):
        robot.twin("limits.json")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="True or False"):
        robot.twin(commands="no")  # type: ignore[arg-type]
    another = dataclasses.replace(LIMITS, arm="gcr20_1100")
    with pytest.raises(ParameterError, match="gcr5_910"):
        await robot.twin(another).start()


@pytest.mark.slow
def test_programs_that_wait_have_it_too() -> None:
    with Simulator(joints=READY) as sim:
        options: dict[str, Any] = {"heartbeat": None, "lag_limit": None, "state_rate": 125.0}
        with aioduco.sync.connect(sim.host, sim.port, **options) as robot:
            robot.bring_up()
            with robot.twin(LIMITS) as twin, robot.events.subscribe() as events:
                sim.load(0.5)
                found = next(each for each in events if isinstance(each, TwinDiverged))
            assert found.cause == "payload"
            assert twin.over


@pytest.mark.slow
async def test_the_example_runs(
    sim: Simulator, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = example("twin_beside_arm")
    # short ways: the arm moves in real time
    vars(program).update(LEFT=Joints(*READY[:5], 0.2), RIGHT=Joints(*READY[:5], 0.3))
    LIMITS.save(tmp_path / "limits.json")
    await program.main(sim.host, str(tmp_path / "limits.json"), sim.port)
    assert "divergences=0" in capsys.readouterr().out


@pytest.mark.slow
async def test_the_example_ends_with_its_own_error_alone(sim: Simulator) -> None:
    program, others = example("twin_beside_arm"), list[Any]()
    vars(program).update(LEFT=Joints(99, 0, 0, 0, 0, 0))
    asyncio.get_running_loop().set_exception_handler(lambda _, context: others.append(context))
    with pytest.raises(ParameterError):
        await program.main(sim.host, None, sim.port)
    gc.collect()
    assert not others


def test_a_recording_without_samples_is_not_judged(tmp_path: Path) -> None:
    """One of a tap, which has calls alone, was said to show nothing that parted."""
    path = tmp_path / "calls.mcap"
    path.write_bytes(HEAD + channel(1, "/commands"))
    told = CliRunner().invoke(app, ["twin", "--judge", str(path), "--arm", "gcr5_910"])
    assert (told.exit_code, "no samples" in told.output) == (1, True), told.output


@pytest.mark.slow
async def test_a_mounting_is_that_of_the_arm_which_is_there(tmp_path: Path) -> None:
    """By its name it was that of a GCR5, so that a larger one's tool seemed to be elsewhere."""
    model, path = "gcr10_1300", tmp_path / "run.mcap"
    limits = dataclasses.replace(TwinLimits.of(arm_of(model)), delay=1e3, path=1e3)
    async with (
        Simulator(model=model, joints=READY, mounting="wall") as sim,
        aioduco.connect(sim.host, sim.port, loop_stall_limit=30.0, lag_limit=None) as robot,
    ):
        await robot.bring_up()
        async with robot.record(path), robot.twin(limits, mounting="wall") as twin:
            await robot.motion.movej2(THERE, v=1.0, a=2.0)
            await eventually_async(lambda: twin.figures.position is not None)
            assert twin.figures.position == pytest.approx(0.0, abs=1e-3)
            assert not twin.divergences
    told = CliRunner().invoke(app, ["twin", "--judge", str(path), "--mounting", "wall"])
    assert (told.exit_code, told.output) == (0, "nothing parted\n")


@pytest.mark.slow
async def test_a_recording_is_learned_from_and_judged(
    sim: Simulator, robot: aioduco.Robot, tmp_path: Path
) -> None:
    async def work() -> None:
        for q in (THERE, READY, [-0.4, -0.2, 1.7, -0.3, -1.2, -0.5], READY):
            await robot.motion.movej2(q, v=0.6, a=2.0)

    good, bad, file = tmp_path / "good.mcap", tmp_path / "bad.mcap", tmp_path / "limits.json"
    async with robot.record(good):
        await work()
        await work()
    sim.load(0.5, (0.0, 0.0, 0.05))
    async with robot.record(bad):
        await work()
    limits = learn(good)
    assert limits.arm == "gcr5_910"
    assert limits.mass < 0.2
    bodily = (Quantity.TORQUE, Quantity.GEOMETRY)  # times are those of a busy computer
    assert [each for each in judge(good, limits) if each.quantity in bodily] == []
    found = [each for each in judge(bad, limits) if each.quantity in bodily]
    assert found[0].cause is Cause.PAYLOAD
    told = CliRunner().invoke(app, ["twin", "--learn", str(good), "--limits", str(file)])
    assert told.exit_code == 0, told.output
    assert TwinLimits.load(file) == limits
    told = CliRunner().invoke(app, ["twin", "--judge", str(bad), "--limits", str(file), "--json"])
    assert told.exit_code == 6, told.output
    causes = {json.loads(line)["cause"] for line in told.output.splitlines()}
    assert "payload" in causes
