"""Paths and waypoints on a simulated arm, in asyncio and without, and from the command line."""

from __future__ import annotations

import asyncio
import gc
import re
import signal
import struct
import subprocess
import threading
import warnings
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import anyio
import numpy as np
import pytest
from cli_runner import CliRunner
from client.bench import Bench
from for_each import for_each
from moments import RUNS_AGAIN
from numpy.typing import NDArray
from patient import COMMAND_LINE, patient_queue

import aioduco
import aioduco.sync
from aioduco import Tolerances
from aioduco.cli.app import app
from aioduco.cli.record import playable
from aioduco.envelope import Envelope, Zone
from aioduco.kinematics import arm
from aioduco.recording import read
from aioduco.recording.container import DATA_END, MAGIC
from aioduco.recording.playback import (
    RecordedOutput,
    RecordedPath,
    WaypointFile,
    play,
    player,
    read_envelope,
    recorded_path,
    run_waypoints,
)
from aioduco.recording.playback.sample_times import RecordedGap, gaps_in_words
from aioduco.sim import Simulator
from aioduco.testing import eventually_async
from recording.playback.recorded import FAR, HOME, nod, write

Array = NDArray[np.float64]


@pytest.fixture(scope="module", autouse=True)
def _patient() -> Iterator[None]:
    with patient_queue():
        yield


#: a busy machine is late, and no matter of what is tested here
PATIENT = Tolerances(path=0.0, goal=5e-3, goal_time=30.0)


@asynccontextmanager
async def led(**options: Any) -> AsyncIterator[tuple[Simulator, aioduco.Robot]]:
    """A simulated arm that is brought up, and the robot that leads it, by the arm's time."""
    async with (
        Simulator(**options) as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
    ):
        await robot.bring_up()
        yield sim, robot


class Log:
    """Where the arm is after each cycle of a simulator."""

    def __init__(self, sim: Simulator) -> None:
        self.rows: list[tuple[float, ...]] = []
        sim.observe(self._see)

    def _see(self, snapshot: Any, _: object) -> None:
        self.rows.append((snapshot.time, *snapshot.q))

    def taken(self) -> tuple[Array, Array]:
        """Times [s] and joints [rad] so far; it begins anew."""
        rows, self.rows = np.array(self.rows), []
        return rows[:, 0], rows[:, 1:]


def apart(first: tuple[Array, Array], second: tuple[Array, Array]) -> float:
    """Largest distance of two motions [rad], each at its time since its begin."""
    (t1, q1), (t2, q2) = first, second
    begins = [t[int(np.argmax(np.abs(q - q[0]).max(axis=1) > 1e-3))] for t, q in (first, second)]
    grid = t1[t1 < t1[-1] - 0.1]

    def largest(shift: float) -> float:
        at = grid - begins[0] + begins[1] + shift
        return max(
            float(np.abs(np.interp(grid, t1, q1[:, k]) - np.interp(at, t2, q2[:, k])).max())
            for k in range(6)
        )

    # Their begins are known to some milliseconds only: by when 1 mrad was passed.
    return min(largest(shift) for shift in np.arange(-0.01, 0.01, 0.0005))


@pytest.mark.slow
async def test_the_event_loop_runs_while_a_path_is_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes a second for a path of five minutes: the heartbeat was lost, the arm stopped."""
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    looked, loop = set(), asyncio.get_running_loop()

    def look(name: str, done: Callable[..., Any], *args: Any, **options: Any) -> Any:
        ran = threading.Event()
        loop.call_soon_threadsafe(ran.set)
        assert ran.wait(10.0), name
        looked.add(name)
        return done(*args, **options)

    of_play = {"check_path": player, "fastest": player, "JointTrajectory": recorded_path}
    for name, module in of_play.items():
        monkeypatch.setattr(module, name, partial(look, name, getattr(module, name)))
    async with led(joints=HOME) as (_, robot):
        await play(robot, path, tolerances=PATIENT)
    assert looked == of_play.keys()


@pytest.mark.slow
async def test_the_replayed_joints_are_the_recorded_ones_at_each_moment(tmp_path: Path) -> None:
    """A motion of the controller, its recording and that recording's replay, by the arm's time."""
    with Simulator(speed=0.25, joints=HOME) as sim:
        log = Log(sim)
        async with aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot:
            await robot.bring_up()
            log.taken()
            await robot.motion.movej2(FAR, v=1.0, a=3.0)
            times, joints = log.taken()

            def done(at: Array) -> Array:
                return np.column_stack(
                    [np.interp(at + times[0], times, joints[:, k]) for k in range(6)]
                )

            run = read(write(tmp_path / "run.mcap", done, seconds=times[-1] - times[0] + 0.3))
            path = RecordedPath.of(run)
            for _ in range(3):
                await robot.motion.movej2(HOME, v=1.0, a=3.0)
                log.taken()
                result = await play(robot, path, through="realtime", tolerances=PATIENT)
                replayed = log.taken()
                if not result.statistics.drained:
                    break  # else a busy machine let the queue run dry: the arm waited on its way
    assert result.statistics.drained == 0
    assert apart((times, joints), replayed) < 1e-3
    assert np.abs(result.goal_error).max() < 1e-3


@pytest.mark.slow
async def test_outputs_are_set_as_they_were(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write(tmp_path / "run.mcap", outputs={0.8: {3: True}, 1.2: {3: False}, 1.4: {5: True}})
    path = RecordedPath.of(read(file), end=1.5)
    async with led(joints=HOME) as (sim, robot):
        changed: list[tuple[int, bool]] = []
        set_out = robot.io.set_standard_digital_out

        async def seen(num: int, value: bool) -> None:
            changed.append((num, value))
            await set_out(num, value)

        monkeypatch.setattr(type(robot.io), "set_standard_digital_out", lambda _, *a: seen(*a))
        await play(robot, path, outputs=True, through="servoj", tolerances=PATIENT)
        assert changed == [(3, True), (3, False), (5, True)]
        assert sim.get_digital_output(5)
        assert not sim.get_digital_output(3)
        assert path.at(np.array([path.duration]))[0] == pytest.approx(
            list(await robot.state.get_actual_joints_position()), abs=6e-3
        )


async def test_no_output_is_set_before_the_arm_is_led(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that changes as the path begins was set though no stream was opened."""
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    path = replace(path, outputs=(RecordedOutput(0.0, 3, True),))

    async def refused(*_: Any, **__: Any) -> Any:
        await anyio.wait_all_tasks_blocked()
        raise aioduco.RobotStateError("it is a test")

    monkeypatch.setattr(player, "follow", refused)
    async with led(joints=HOME) as (sim, robot):
        with pytest.raises(aioduco.RobotStateError, match="it is a test"):
            await play(robot, path, outputs=True)
        assert not sim.get_digital_output(3)


@pytest.mark.slow
async def test_an_output_that_a_controller_sets_slowly_is_set_though_the_path_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its call was cancelled as the path ended: play() returned, and the output was not set."""
    path = RecordedPath.of(read(write(tmp_path / "run.mcap", outputs={1.4: {5: True}})))
    ended, follow = anyio.Event(), player.follow

    async def followed(*args: Any, **options: Any) -> Any:
        result = await follow(*args, **options)
        ended.set()
        return result

    monkeypatch.setattr(player, "follow", followed)
    async with led(joints=HOME) as (sim, robot):
        set_out = robot.io.set_standard_digital_out

        async def slowly(_: object, num: int, value: bool) -> None:
            await ended.wait()
            await set_out(num, value)

        monkeypatch.setattr(type(robot.io), "set_standard_digital_out", slowly)
        await play(robot, path, outputs=True, through="servoj", tolerances=PATIENT)
        assert sim.get_digital_output(5)


@pytest.mark.slow
async def test_an_output_that_is_refused_brings_the_arm_to_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def slowly(times: Array) -> Array:
        return nod(times, 0.2, 5.0)

    file = write(tmp_path / "run.mcap", slowly, seconds=6.0, outputs={1.0: {3: True}})
    path = RecordedPath.of(read(file))

    async def refuse(*_: object) -> None:
        raise aioduco.Refused("set_standard_digital_out", -1, "it is a test")

    async with led(joints=HOME) as (sim, robot):
        monkeypatch.setattr(type(robot.io), "set_standard_digital_out", refuse)
        with pytest.raises(aioduco.Refused, match="it is a test"):
            await play(robot, path, outputs=True, through="servoj", tolerances=PATIENT)
        assert not await robot.state.robotmoving()
        assert np.abs(sim.joints.array - HOME).max() < 0.4


@pytest.mark.slow
async def test_what_speaks_against_it_is_said_and_nothing_is_sent(tmp_path: Path) -> None:
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    other = RecordedPath.of(read(write(tmp_path / "other.mcap", arm="GCR10 1300")))
    async with led(joints=FAR) as (sim, robot):
        with pytest.raises(aioduco.FirstPointTooFar, match=r"joint 1 is 0\.5000 rad"):
            await play(robot, path)
        with pytest.raises(aioduco.PathRefused, match="it is for a GCR10 1300"):
            await play(robot, other)
        with pytest.raises(aioduco.PathRefused, match="accel"):
            await play(robot, RecordedPath.of(read(tmp_path / "run.mcap"), speed=6.0))
        tip = await robot.state.get_flange_pose()
        robot.envelope = Envelope("gcr5_910", Zone.sphere(tip.position, 0.05, name="post"))
        with pytest.raises(aioduco.PathRefused, match="'post'") as error:
            await play(robot, path, approach=0.3)
        assert error.value.findings[0].startswith("envelope at 1.")
        assert not robot.tasks
        assert np.abs(sim.joints.array - FAR).max() < 1e-6


@pytest.mark.parametrize("name", ["through", "tolerances", "feedback", "options"])
async def test_a_wrong_argument_is_found_before_the_approach(tmp_path: Path, name: str) -> None:
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    wrong: dict[str, Any] = {name: 3}
    async with led(joints=FAR) as (sim, robot):
        with pytest.raises(aioduco.ParameterError, match=f"{name} is 3, .*nothing was sent"):
            await play(robot, path, approach=0.3, **wrong)
        assert np.abs(sim.joints.array - FAR).max() < 1e-6


def wait_a_while(sim: Simulator) -> None:
    begin = sim.time
    sim.wait_until(lambda: sim.time > begin + 0.5, timeout=30)


@pytest.mark.slow
def test_an_interrupt_leaves_a_standing_arm(tmp_path: Path, totals: Counter[str]) -> None:
    """So does a kill: the stream's worker brakes."""
    file = write(tmp_path / "run.mcap", lambda t: nod(t, 0.2, 20.0), seconds=21.0)
    for number, status in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)):
        for _ in range(1 + RUNS_AGAIN):
            if interrupted(file, number, status):
                break
            totals["streams starved and run again"] += 1
        else:
            raise AssertionError("the stream never had the time that it needs")


def interrupted(file: Path, number: signal.Signals, status: int) -> bool:
    """Play a file and end that amid a motion; whether the machine was quick enough to play it."""
    with Simulator(joints=HOME) as sim:
        command: list[str] = [*COMMAND_LINE, "play", str(file), sim.host]
        command += ["--port", str(sim.port), "--yes", "--no-rehearse"]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as played:

            def moves() -> bool:
                return bool(abs(sim.joints.array - HOME).max() > 0.02)

            sim.wait_until(lambda: moves() or played.poll() is not None, timeout=300)
            played.send_signal(number)
            if played.wait(60) == 1:
                return False  # its stream was starved
            assert played.returncode == status
        sim.wait_until(lambda: not sim.moving, timeout=30)
        stood = sim.joints.array
        assert 0.01 < np.abs(stood - HOME).max() < 0.45
        wait_a_while(sim)
        assert np.abs(sim.joints.array - stood).max() < 1e-3
        return True


def waypoints() -> WaypointFile:
    kept = WaypointFile.new(arm="GCR5 910")
    kept.add("home", HOME)
    kept.add("past", (HOME + FAR) / 2)
    kept.add("there", FAR)
    return WaypointFile(
        kept.text.replace('name = "past"', 'name = "past"\nblend_mm = 20').replace(
            'name = "there"', 'name = "there"\nmotion = "line"\noutputs = { 3 = true }'
        )
    )


@pytest.mark.slow
async def test_waypoints_that_are_not_reached_are_told_of_by_the_error_alone() -> None:
    """No motion behind the one that was not sent warns that it was never awaited."""
    # between the first two waypoints, and near none of them
    middle = arm("gcr5_910").fkine(0.75 * HOME + 0.25 * FAR)[:3, 3]
    file = waypoints()
    file.add("behind", HOME)
    async with led(speed=10, joints=HOME) as (_, robot):
        robot.envelope = Envelope(
            "gcr5_910", Zone.sphere(middle, 0.005, bodies=["flange"], name="post")
        )
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            with pytest.raises(aioduco.EnvelopeViolated, match="post"):
                await run_waypoints(robot, file)
            gc.collect()
        assert [str(each.message) for each in said] == []


@pytest.mark.parametrize("ended", [aioduco.Robot.stop, aioduco.Robot.pause])
@pytest.mark.parametrize(
    ("function", "sent"), [("get_robot_type", 0), ("cal_fkine", 0), ("set_standard_digital_out", 3)]
)
async def test_a_stop_or_a_pause_while_the_arm_stands_ends_waypoints(
    ended: Callable[[aioduco.Robot], Awaitable[object]], function: str, sent: int
) -> None:
    """They were asked for before it: what is done meanwhile does not make them newer."""
    answers = {
        "get_robot_type": ["GCR5 910", "", ""],
        "cal_fkine": [0.5, 0.1, 0.6, 3.1, 0, -1.5],
        "set_standard_digital_out": 4,
    }
    file = waypoints()
    file.add("behind", HOME)
    with Bench() as bench:
        for name, answer in answers.items():
            bench.answer(name, answer)
        gate = bench.hold(function, answers[function])
        async with (
            aioduco.connect(bench.host, bench.port) as robot,
            anyio.create_task_group() as tasks,
        ):

            async def run() -> None:
                with pytest.raises(aioduco.TaskStopped):
                    await run_waypoints(robot, file)

            tasks.start_soon(run)
            await eventually_async(lambda: bool(bench.received(function)))
            await ended(robot)
            gate.set()
        assert len(bench.received("movej2")) + len(bench.received("movel")) == sent


@pytest.mark.parametrize("function", ["get_robot_type", "get_actual_joints_position"])
async def test_a_pause_while_the_arm_stands_ends_a_path(tmp_path: Path, function: str) -> None:
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")))
    answers = {"get_robot_type": ["GCR5 910", "", ""], "get_actual_joints_position": list(FAR)}
    with Bench() as bench:
        bench.answer("get_robot_type", answers["get_robot_type"])
        gate = bench.hold(function, answers[function])
        async with aioduco.connect(bench.host, bench.port) as robot:
            begun = asyncio.ensure_future(play(robot, path, approach=0.5))
            await eventually_async(lambda: bool(bench.received(function)))
            await robot.pause()
            gate.set()
            with pytest.raises(aioduco.TaskStopped):
                await begun


@pytest.mark.slow
async def test_an_arm_goes_through_waypoints() -> None:
    async with led(speed=10, joints=HOME) as (sim, robot):
        assert await run_waypoints(robot, waypoints()) == 3
        assert sim.joints.almost_equal(FAR, 1e-3)
        assert sim.get_digital_output(3)
        other = WaypointFile(waypoints().text.replace("GCR5 910", "GCR10 1300"))
        with pytest.raises(aioduco.PathRefused, match="GCR10 1300"):
            await run_waypoints(robot, other)
        with pytest.raises(aioduco.PathRefused, match="no waypoint"):
            await run_waypoints(robot, WaypointFile.new())
        with pytest.raises(aioduco.ParameterError, match="speed"):
            await run_waypoints(robot, waypoints(), speed=2.0)


@pytest.mark.slow
def test_programs_that_wait(tmp_path: Path) -> None:
    path = RecordedPath.of(read(write(tmp_path / "run.mcap")), end=1.0)
    with (
        Simulator(joints=HOME) as sim,
        aioduco.sync.connect(sim.host, sim.port, clock=sim.clock) as robot,
    ):
        robot.bring_up()
        assert aioduco.sync.check_path_on(robot, path) == ()
        result = aioduco.sync.play(robot, path, through="servoj", tolerances=PATIENT)
        assert np.abs(result.goal_error).max() < 0.01
        assert aioduco.sync.check_waypoints_on(robot, waypoints()) == []


def run(*arguments: str, typed: str = "") -> Any:
    return CliRunner().invoke(app, list(arguments), input=typed)


@pytest.mark.slow
def test_play_checks_and_asks_before_an_arm_moves(tmp_path: Path) -> None:
    file = str(write(tmp_path / "run.mcap"))
    alone = run("play", file, "--check")
    assert (alone.exit_code, alone.stdout) == (0, "nothing speaks against it\n")
    quick = run("play", file, "--check", "--speed", "10")
    assert quick.exit_code == 1
    assert "speed at" in quick.stderr
    points = tmp_path / "points.toml"
    waypoints().save(points)
    for what in (file, str(points)):
        other = run("play", what, "--check", "--model", "gcr3_618")
        assert (other.exit_code, "GCR5 910, and this is a gcr3_618" in other.stderr) == (1, True)
    unknown = run("play", str(tmp_path / "none.mcap"), "--check")
    assert (unknown.exit_code, "none.mcap" in "".join(unknown.stderr.replace("│", "").split())) == (
        2,
        True,
    )
    data = (tmp_path / "run.mcap").read_bytes()
    end = data.rindex(struct.pack("<BQ", DATA_END, 4))
    (tmp_path / "cut.mcap").write_bytes(data[:end])
    cut = run("play", str(tmp_path / "cut.mcap"), "--check")
    assert "cut.mcap was cut off: it is played up to there\n" in cut.stdout
    (tmp_path / "empty.mcap").write_bytes(MAGIC)
    empty = run("play", str(tmp_path / "empty.mcap"), "--check")
    assert (empty.exit_code, "empty.mcap has no joints to follow" in empty.stderr) == (1, True)
    with Simulator(joints=FAR) as sim:
        to = (sim.host, "--port", str(sim.port), "--no-rehearse")
        assert run("play", file, *to, "--check").exit_code == 0
        declined = run("play", file, *to, typed="n\n")
        assert declined.exit_code == 3
        assert "joint 1 turns by 28.6° to the begin" in declined.stderr
        assert "nothing was sent that moves the arm" in declined.stderr
        assert np.abs(sim.joints.array - FAR).max() < 1e-6


@pytest.mark.slow
def test_a_file_for_any_arm_is_rehearsed_on_the_one_that_the_controller_reports(
    tmp_path: Path,
) -> None:
    """It was rehearsed on a GCR5, whichever arm was to play it."""
    file = write(tmp_path / "run.mcap", arm="")
    with Simulator("gcr10_1300", joints=HOME) as sim:
        declined = run("play", str(file), sim.host, "--port", str(sim.port), typed="n\n")
    assert declined.exit_code == 3, declined.output
    assert "on a simulated gcr10_1300" in declined.stdout


@pytest.mark.slow
def test_the_way_to_the_begin_is_rehearsed_from_where_the_arm_is(tmp_path: Path) -> None:
    """The rehearsal began at the path's begin: the arm hit what stood on its way there."""
    file, scene = write(tmp_path / "run.mcap"), tmp_path / "scene.xml"
    post = '<geom type="box" size=".03 .03 .6" pos="0 .35 .6"/>'
    scene.write_text(f"<mujoco><worldbody>{post}</worldbody></mujoco>")
    beside = [3.0, *HOME[1:]]
    with Simulator(joints=beside) as sim:
        to = (sim.host, "--port", str(sim.port), "--yes", "--scene", str(scene))
        ended = run("play", str(file), *to)
        assert sim.joints.almost_equal(beside, 1e-3)
        assert not sim.tasks
    assert ended.exit_code == 1, ended.output
    assert "touches a thing" in ended.stderr


@pytest.mark.slow
def test_play_keeps_to_an_envelope(tmp_path: Path) -> None:
    file = str(write(tmp_path / "run.mcap"))
    kept = tmp_path / "cell.toml"
    waypoints().save(kept)
    wide, narrow = tmp_path / "wide.toml", tmp_path / "narrow.toml"
    wide.write_text("[[limit]]\nkind = 'plane'\npoint = [0, 0, -2.0]\nnormal = [0, 0, 1]\n")
    narrow.write_text("[[limit]]\nkind = 'joint_margin'\nleast = 5.0\nname = 'narrow'\n")
    for what in (file, str(kept)):
        assert run("play", what, "--check", "--envelope", str(wide)).exit_code == 0
        beyond = run("play", what, "--check", "--envelope", str(narrow))
        assert (beyond.exit_code, "narrow" in beyond.stderr) == (1, True)
    cell = tmp_path / "limits.toml"
    cell.write_text(f"arm = 'gcr5_910'\n{narrow.read_text()}")
    both = run("play", file, "--check", "--cell", str(cell), "--envelope", str(wide))
    assert (both.exit_code, "narrow" in both.stderr) == (1, True), "those of the cell hold, too"
    with Simulator(joints=FAR) as sim:
        to = (sim.host, "--port", str(sim.port), "--no-rehearse", "--yes")
        for what in (file, str(kept)):
            refused = run("play", what, *to, "--envelope", str(narrow))
            assert (refused.exit_code, "narrow" in refused.stderr) == (1, True)
        assert not sim.tasks
    # on a simulated arm, too
    slow = tmp_path / "slow.toml"
    slow.write_text("[[limit]]\nkind = 'tool_speed'\nmost = 0.001\n")
    ended = run("play", file, "--envelope", str(slow))
    assert (ended.exit_code, "envelope" in ended.stderr) == (1, True), ended.output


@for_each(
    "text, said",
    [
        ("[[limit]", "TOML"),
        ("speed = 1", "speed"),
        ("arm = 'gcr5_910'", "limit"),
        ("arm = 'gcr10_1300'\n[[limit]]\nkind = 'plane'", "gcr5_910"),
        ("[[limit]]\nkind = 'cone'", '"box", "sphere", "plane"'),
        ("[[limit]]\nkind = 'sphere'\nat = [0, 0, 0]", "radius"),
        ("[[limit]]\nkind = 'tool_speed'\nmost = -1", "most of limit 1"),
    ],
)
def test_a_file_of_limits_that_is_wrong_says_where(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "limits.toml"
    path.write_text(text)
    with pytest.raises(aioduco.ParameterError, match=said):
        read_envelope(path, arm="gcr5_910")


@pytest.mark.slow
def test_record_says_at_its_end_whether_a_file_can_be_played(tmp_path: Path) -> None:
    whole = write(tmp_path / "whole.mcap")
    assert playable(whole, 1000) == "it can be played: 1.60 s of motion"
    gap = write(tmp_path / "gap.mcap", without=(0.8, 0.91))
    assert re.search(r"; bridged: 0\.11 s are missing .* mrad$", playable(gap, 1000))
    many = [RecordedGap(float(at), 0.1 + at / 100, 0.01, at * 1e-4) for at in range(1, 6)]
    assert gaps_in_words(many[:1]) == str(many[0])
    assert gaps_in_words(many) == (
        "5 gaps of 0.65 s together, the longest 0.15 s from 5.00 s on; known to 0.5 mrad"
    )
    wide = write(tmp_path / "wide.mcap", without=(0.8, 1.2))
    assert "it cannot be played" in playable(wide, 1000)
    assert "--bridge" in playable(wide, 1000)
    fast = write(tmp_path / "fast.mcap", lambda times: nod(times, 0.5, 0.6))
    assert "it would be allowed at a speed factor (--speed)" in playable(fast, 1000)
    assert "--check" in playable(whole, 1_000_000)


@pytest.mark.slow
def test_a_gap_is_bridged_as_far_as_the_command_says(tmp_path: Path) -> None:
    gap = str(write(tmp_path / "gap.mcap", without=(0.8, 0.91)))
    done = run("play", gap, "--check")
    assert (done.exit_code, "bridged: 0.11 s are missing" in done.stdout) == (0, True), done.output
    done = run("play", gap, "--check", "--bridge", "0.003")
    assert (done.exit_code, "at most 3 mrad are bridged" in done.stderr) == (1, True), done.output


@pytest.mark.slow
def test_play_leads_a_simulated_arm_along_a_recording_and_records_it(tmp_path: Path) -> None:
    file = write(tmp_path / "run.mcap")
    again = tmp_path / "again-1.mcap"
    (tmp_path / "again.mcap").touch()
    done = run("play", str(file), "--to", "1.3", "--record", str(tmp_path / "again.mcap"))
    assert done.exit_code == 0, done.output
    assert f"recording to {again}" in done.stdout
    assert "played in" in done.stdout
    assert "mrad off at most" in done.stdout
    reached = RecordedPath.of(read(file), end=1.3).positions[-1]
    assert read(again).arrays("/joint_setpoints")["position"][-1] == pytest.approx(
        reached, abs=1e-3
    )
    kept = tmp_path / "cell.toml"
    waypoints().save(kept)
    done = run("play", str(kept))
    assert done.exit_code == 0, done.output
    assert "3 waypoints were reached" in done.stdout


def press_the_button(sim: Simulator) -> None:
    sim.emergency_stop()
    sim.wait_until(lambda: sim.view.emergency_stop, timeout=60)


def stop_by_another_program(sim: Simulator) -> None:
    with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as other:
        other.stop()


@pytest.mark.slow
@pytest.mark.parametrize("stop", [press_the_button, stop_by_another_program])
def test_teach_ends_when_the_arm_was_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stop: Callable[[Simulator], None]
) -> None:
    """It went on, and stored the place of an arm that no hand could move."""
    file = tmp_path / "points.toml"
    with Simulator(joints=HOME, speed=5) as sim:

        def person() -> Iterator[str]:
            yield "before"
            stop(sim)
            yield "after"

        hands = person()
        monkeypatch.setattr("builtins.input", lambda _: next(hands))
        done = run("teach", sim.host, "--port", str(sim.port), "-o", str(file), "--yes")
    assert (done.exit_code, "no hand guides it any more" in done.stderr) == (1, True), done.output
    assert [each.name for each in WaypointFile.read(file).waypoints] == ["before"]


@pytest.mark.slow
def test_teach_keeps_where_the_arm_is_guided_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "cell.toml"
    with Simulator(joints=HOME, speed=5) as sim:
        to = (sim.host, "--port", str(sim.port), "-o", str(file))
        declined = run("teach", *to, typed="n\n")
        assert (declined.exit_code, file.exists()) == (3, False)

        def person() -> Iterator[str]:
            yield "above the part"
            sim.push([0.0, 30.0, 0.0, 0.0, 0.0, 0.0])
            sim.wait_until(lambda: abs(sim.joints.array - HOME).max() > 0.05, timeout=60)
            sim.push([0.0] * 6)
            yield ""
            yield "q"

        hands = person()
        with monkeypatch.context() as patched:
            patched.setattr("builtins.input", lambda _: next(hands))
            done = run("teach", *to, "--yes")
        assert done.exit_code == 0, done.output
        assert "the arm stands" in done.stdout
        stood = sim.joints.array
        more = run("teach", *to, "--no-guide", typed="last\n")
        assert more.exit_code == 0, more.output
        assert not sim.tasks
    kept = WaypointFile.read(file)
    assert [each.name for each in kept.waypoints] == ["above the part", "p2", "last"]
    assert kept.arm == "GCR5 910"
    assert kept.waypoints[0].joints.almost_equal(HOME, 0.02)
    assert kept.waypoints[1].joints.distance(HOME) > 0.04
    assert kept.waypoints[2].joints.almost_equal(stood, 1e-4)
