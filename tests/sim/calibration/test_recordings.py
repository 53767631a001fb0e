"""From a simulated arm to a recording, and from the recording to a profile."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import AsyncMock, MagicMock, Mock

import anyio
import numpy as np
import pytest
from anyio.lowlevel import checkpoint
from cli_runner import CliRunner

import aioduco.sync
from aioduco.cli import measuring
from aioduco.cli.app import app
from aioduco.cli.measuring import Extent
from aioduco.errors import (
    CalibrationError,
    ParameterError,
    RecordingError,
    TaskError,
    TaskFailed,
    TaskInterrupted,
    TaskStopped,
    TaskUnknown,
)
from aioduco.recording.run import read
from aioduco.sim import ArmProfile, Simulator
from aioduco.sim.calibration import calibrate, evidence, profile_of
from aioduco.sim.calibration.evidence import read_evidence

from .made import (
    MODEL,
    READY,
    configurations,
    empty,
    exact,
    hidden_geometry,
    poses_of,
    turns,
)


@pytest.mark.slow
@pytest.mark.timeout(900)  # it moves in simulated time, which a busy computer slows down
async def test_an_arm_that_is_moved_and_recorded_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measuring, "_STILL", 0.1)
    monkeypatch.setattr(measuring, "_SPEEDS", (0.8,))
    truth = hidden_geometry(np.random.default_rng(1))
    drives = {f"lag{i}": exact(0.004 * i) for i in range(1, 7)}
    truth = ArmProfile(MODEL, {**truth.values, "drives": drives}, single_precision=True)
    path = tmp_path / "run.mcap"
    told: list[str] = []
    with Simulator(profile=truth, joints=READY, speed=6, cycle=0.002) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
        extent = Extent(reach=0.3, poses=12, rounds=1, changes=1, lapses=0)
        await measuring.measure(sim.host, sim.port, path, extent, told.append)
        assert sim.joints == pytest.approx(READY, abs=1e-3)
    assert told[0] == "poses: 12 configurations"
    outcome = CliRunner().invoke(
        app, ["calibrate", str(path), "-o", str(tmp_path / "arm.toml")], catch_exceptions=False
    )
    assert outcome.exit_code == 0, outcome.output
    assert "left out: heartbeat" in outcome.output
    found = ArmProfile.load(tmp_path / "arm.toml")
    assert found.single_precision is True
    for name, (value, _, _) in truth.values["geometry"].items():
        most = 1e-4 if name[:-1] in ("a", "d") else math.radians(0.01)
        assert abs(found.values["geometry"][name].value - value) < most, name
    for name, (value, _, _) in drives.items():
        assert abs(found.values["drives"][name].value - value) < 1e-3, name


@pytest.mark.slow
@pytest.mark.timeout(300)
async def test_corners_and_a_heartbeat_that_ends_are_recorded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hidden = {"joint_reach": 0.8, "joint_share": 0.5, "line_reach": 0.9, "line_share": 0.6}
    slack = exact(0.6)  # of this computer's time, as are the heartbeats
    truth = ArmProfile(
        MODEL, {"blends": {n: exact(v) for n, v in hidden.items()}, "heartbeat": {"slack": slack}}
    )
    monkeypatch.setattr(measuring, "_STILL", 0.1)
    monkeypatch.setattr(measuring, "_FORGOTTEN", 1.8)
    monkeypatch.setattr(measuring, "_updates", AsyncMock())  # it reads as fast as it can
    path, told = tmp_path / "run.mcap", list[str]()
    with Simulator(profile=truth, joints=READY, speed=4) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
        extent = Extent(reach=0.25, poses=0, rounds=0, changes=0, lapses=1)
        await measuring.measure(sim.host, sim.port, path, extent, told.append)
        assert sim.joints == pytest.approx(READY, abs=1e-3)
    # and the arm stopped
    assert told[-2:] == ["corners of lines", "a heartbeat that ends, 1 of 1"]
    run = read_evidence(path)
    count = 2 * len(measuring._RADII)
    assert [each.kind for each in run.corners] == ["joint"] * count + ["line"] * count
    assert [announced for _, announced in run.beats] == [0.5]
    # The other robot's heartbeat runs out at rest, before the way to the slow turn.
    moves = [call.begin for call in evidence._calls(read(path)) if call.function == "movej2"]
    moving = run.motions.time[np.abs(run.motions.wanted_speed).max(axis=1) > 1e-3]
    assert moves[-3] - moving[moving < moves[-3]].max() >= 1.8
    # A busy computer stops the arm later, and reads fewer samples than the estimates need.
    found = calibrate(path).profile.values
    assert all(each.high >= slack.value for each in found.get("heartbeat", {}).values())
    for name, (_, low, high) in found.get("blends", {}).items():
        assert low <= hidden[name] <= high, name


@pytest.mark.cases(4)
@pytest.mark.parametrize("ended", [TaskFailed, TaskInterrupted, TaskStopped, TaskUnknown])
async def test_only_lines_that_fail_are_left_out(
    ended: type[TaskError], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a stop by another program, the arm went on to the next motion by itself."""
    monkeypatch.setattr(measuring, "_STILL", 0.0)
    robot, moves = Mock(), list[object]()
    robot.state.get_tcp_pose = AsyncMock(return_value=aioduco.Pose(0.4, 0.1, 0.5, 0.0, 0.0, 0.0))
    robot.motion.movej2.side_effect = lambda *_, **__: checkpoint()

    async def run(*motions: Any) -> None:
        moves.append(motions)
        if robot.motion.movel.called:
            raise ended("movel", 7, "ended")
        for motion in motions:
            await motion

    robot.motion.run = run
    go = measuring._corners(robot, np.array(READY), Extent(), lambda _: None)
    if ended is TaskFailed:
        await go
        assert robot.motion.movej2.call_args.args == (list(READY),)
    else:
        with pytest.raises(ended):
            await go
        assert len(moves) == 2 * len(measuring._RADII) + 1
        assert robot.motion.movej2.call_count == 4 * len(measuring._RADII)


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("times", "stopped", "error"),
    [
        ((5.0, 105.0), None, (aioduco.RobotStateError, "stood still for 92 s")),
        ((5.0, 6.0), TaskStopped("movej2", 7, "was stopped"), (TaskStopped, "was stopped")),
    ],
    ids=["the program stood still", "stopped before the heartbeat had run out"],
)
async def test_an_arm_whose_heartbeat_ended_is_not_turned_again(
    times: tuple[float, float],
    stopped: TaskStopped | None,
    error: tuple[type[aioduco.DucoError], str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in {"_STILL": 0.0, "_FORGOTTEN": 0.0, "_ANNOUNCED": 60.0}.items():
        monkeypatch.setattr(measuring, name, value)
    monkeypatch.setattr(measuring, "boot_time", Mock(side_effect=times))
    robot, move, slow = MagicMock(), AsyncMock(), AsyncMock(side_effect=stopped)
    robot.motion.movej2.side_effect = (move(), Mock(start=AsyncMock(return_value=slow())))
    robot._supervisor.rpc.send = AsyncMock()
    with pytest.raises(error[0], match=error[1]):
        await measuring._lapses(robot, np.array(READY), Extent(lapses=2), lambda _: None)
    assert robot.motion.movej2.call_count == 2


async def test_an_arm_that_is_not_enabled_is_not_moved(tmp_path: Path) -> None:
    with Simulator(joints=READY) as sim:
        with pytest.raises(aioduco.RobotStateError, match="not enabled"):
            await measuring.measure(
                sim.host, sim.port, tmp_path / "run.mcap", Extent(), lambda _: None
            )
        assert sim.joints == pytest.approx(READY, abs=1e-6)


async def test_an_error_of_a_motion_that_is_read_meanwhile_is_told_as_itself() -> None:
    """In a group it ended the command by a traceback."""

    async def fail() -> None:
        raise aioduco.RobotStateError("the arm was stopped")

    for action, look in ((fail, checkpoint), (anyio.sleep_forever, fail)):
        with pytest.raises(aioduco.RobotStateError, match="the arm was stopped"):
            await measuring._during(action(), look, 0.0)


async def test_an_arm_stays_where_it_stood_when_the_program_stood_still(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in a computer that slept: it went on by itself, and no heartbeat was given any more."""

    async def stand_still(robot: aioduco.Robot, *_: object) -> None:
        robot._supervisor.gate.hang()

    monkeypatch.setattr(measuring, "_poses", stand_still)
    with Simulator(joints=READY) as sim:
        async with aioduco.connect(sim.host, sim.port) as robot:
            await robot.bring_up()
        with pytest.raises(aioduco.RobotStateError, match="the event loop hung"):
            await measuring.measure(
                sim.host, sim.port, tmp_path / "run.mcap", Extent(), lambda _: None
            )
        assert not sim.tasks


@pytest.mark.slow
def test_the_name_of_the_recording_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The name that was asked for was told, and an older recording would have been calibrated."""
    for step in ("_poses", "_turns", "_updates", "_corners", "_changes", "_lapses"):
        monkeypatch.setattr(measuring, step, AsyncMock())
    (tmp_path / "run.mcap").touch()
    with Simulator(joints=READY) as sim:
        with aioduco.sync.connect(sim.host, sim.port) as robot:
            robot.bring_up()
        words = ["check", f"{sim.host}:{sim.port}", "--motions", str(tmp_path / "run.mcap")]
        outcome = CliRunner().invoke(app, [*words, "--yes"])
    assert f"`aioduco calibrate {tmp_path / 'run-1.mcap'}`" in " ".join(outcome.output.split())


@pytest.mark.slow
def test_the_motions_are_asked_for(tmp_path: Path) -> None:
    with Simulator(joints=READY) as sim:
        words = ["check", f"{sim.host}:{sim.port}", "--motions", str(tmp_path / "run.mcap")]
        outcome = CliRunner().invoke(app, words, input="n\n")
    assert outcome.exit_code == 3
    told = " ".join(outcome.output.split())
    assert "every joint turns by up to 29 degrees" in told
    assert "up and aside by 100 mm" in told
    assert "the heartbeat ends in a slow turn of the last joint, 2 times" in told
    assert not (tmp_path / "run.mcap").exists()


def test_a_file_that_is_no_recording_is_said(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(b"no")
    with pytest.raises(RecordingError, match="MCAP"):
        calibrate(path)


@pytest.mark.slow
def test_what_the_simulator_does_not_play_is_left_out_and_said(tmp_path: Path) -> None:
    """A drive that trails by more was written to a file that no simulator took."""
    lag = np.array([0.06, 0.01, 0.01, 0.01, 0.01, 0.01])
    motions = turns(np.random.default_rng(1), lag, 0.6 / lag, np.full(6, 2e-3))
    found = profile_of([replace(empty(), motions=motions)])
    assert {"lag1", "gain1"}.isdisjoint(found.profile.values["drives"])
    assert [text.partition(":")[0] for text in found.missing if "does not play: 0 to" in text] == [
        "drives, lag1", *(f"noise, joint{i}" for i in range(1, 7))
    ]  # fmt: skip
    found.profile.save(tmp_path / "arm.toml")
    assert ArmProfile.load(tmp_path / "arm.toml").values.keys() == {"drives"}


def test_recordings_of_two_arms_are_refused() -> None:
    one, two = empty("one.mcap"), replace(empty("two.mcap"), arm="GCR10 1300")
    with pytest.raises(CalibrationError, match="of different arms"):
        profile_of([one, two])


def test_a_recording_counts_once() -> None:
    """A copy, such as one with an index, made the intervals narrower than the data are."""
    random = np.random.default_rng(4)
    run = replace(empty("run.mcap"), poses=poses_of(ArmProfile(MODEL), configurations(random, 12)))
    with pytest.raises(CalibrationError, match=r"run-indexed\.mcap says the same as run\.mcap"):
        profile_of([run, replace(run, name="run-indexed.mcap")])


@pytest.mark.slow
def test_a_model_that_is_not_known_is_asked_for() -> None:
    random = np.random.default_rng(2)
    run = replace(empty(), arm="", poses=poses_of(ArmProfile(MODEL), configurations(random, 30)))
    with pytest.raises(CalibrationError, match="give --model"):
        profile_of([run])
    assert profile_of([run], model="GCR5-910").profile.model == MODEL
    for wrong in ("ur5e", "", 5):
        with pytest.raises(ParameterError, match="one of gcr3_618"):
            profile_of([run], model=wrong)  # type: ignore[arg-type]  # a number is tried, too


@pytest.mark.slow
def test_several_recordings_count_together() -> None:
    random = np.random.default_rng(3)
    truth = hidden_geometry(random)
    runs = [
        replace(empty(f"{i}.mcap"), poses=poses_of(truth, configurations(random, 9)))
        for i in range(3)
    ]
    with pytest.raises(
        CalibrationError, match=r"nothing about the arm: record .*check HOST --motions"
    ):
        profile_of(runs[:1])
    found = profile_of(runs)
    assert found.profile.sources == ("0.mcap", "1.mcap", "2.mcap")
    assert "27 of 27 poses" in str(found)
