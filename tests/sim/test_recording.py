"""Tracks that are recorded and replayed, and what gives way in hand guiding (manual 1.3.5)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from aioduco.models.enums import ProgramState, TaskState
from aioduco.models.pose import Pose
from aioduco.sim.cabinet.project import CAPACITY, RecordedTrack
from aioduco.sim.controller.recorder import BY_POSITION, BY_TIME, Recorder
from aioduco.sim.simulator import READY, Simulator

from .conftest import Aside, Program, advance_until, let_pass, standing_time
from .fakes import Bench

pytestmark = pytest.mark.usefixtures("real_cycle")

START = [0.2, *READY[1:]]
END = [0.4, 0.05, *READY[2:]]
ELSEWHERE = [-0.2, *READY[1:]]


@pytest.fixture
def program(cell: Simulator, program: Program) -> Program:
    """A program whose arm stands ready, with nothing recorded."""
    program.set_hand_teach_parameter(0, [1] * 6, [1] * 6, 0, [True] * 6)
    cell.cabinet.project.tracks.clear()
    program.to(*START)
    return program


def record(program: Program, mode: int, interval: float, v: float = 0.5) -> None:
    id_ = program.start_record_track("t", mode, "", "", interval)
    assert program.get_noneblock_taskstate(id_) == TaskState.FINISHED
    program.to(*END, v=v)
    assert program.stop_record_track() == TaskState.FINISHED


# -- recording -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_points_by_position(cell: Simulator, program: Program) -> None:
    record(program, BY_POSITION, 0.0)
    track = cell.cabinet.project.tracks["t"]
    ways = np.abs(np.diff(track.joints, axis=0)).sum(axis=1)
    assert track.joints[0] == pytest.approx(START, abs=2e-3)
    # 0.25 rad of all joints together, 5° of them from point to point
    assert len(ways) == math.floor(0.25 / math.radians(5.0))
    assert ways == pytest.approx(math.radians(5.0), abs=2e-3)


@pytest.mark.slow
def test_points_by_time(cell: Simulator, program: Program) -> None:
    before = cell.time
    record(program, BY_TIME, 0.0, 0.1)
    track = cell.cabinet.project.tracks["t"]
    # A busy machine may let some cycles pass before the first point and after the last.
    assert len(track.joints) in range(2, math.floor((cell.time - before) / 0.25) + 2)
    turned = np.diff(track.joints, axis=0)[:, 0]
    assert turned[len(turned) // 2] == pytest.approx(0.1 * 0.25, rel=0.05)


@pytest.mark.slow
def test_poses_are_the_tools_in_the_work_object(cell: Simulator, program: Program) -> None:
    tool, wobj = Pose(0.0, 0.0, 0.1, 0.0, 0.0, 0.0), Pose(0.3, 0.1, 0.0, 0.0, 0.0, 0.5)
    program.set_tool_data("gripper", list(tool), [0.0] * 4, [])
    program.set_wobj("table", list(wobj))
    program.start_record_track("t", BY_TIME, "gripper", "table", 0.0)
    let_pass(cell, 0.1)
    program.stop_record_track()
    track = cell.cabinet.project.tracks["t"]
    expected = wobj.inverse() @ Pose.from_matrix(cell.arm.fkine(track.joints[0])) @ tool
    assert Pose(*track.poses[0]).almost_equal(expected)
    assert (track.tool, track.wobj) == ("gripper", "table")
    program.set_tool_data("none", [0.0] * 6, [0.0] * 4, [])
    program.set_wobj("none", [0.0] * 6)


@pytest.mark.slow
def test_a_full_track_ends_its_recording_and_pauses_what_runs(
    cell: Simulator, program: Program
) -> None:
    id_ = program.to(*ELSEWHERE, v=0.05, block=False)
    program.start_record_track("t", BY_TIME, "", "", 0.001)
    cell.wait_until(lambda: program.get_noneblock_taskstate(id_) == TaskState.PAUSED)
    assert len(cell.cabinet.project.tracks["t"].joints) == CAPACITY
    assert program.get_robot_state()[1] == ProgramState.PAUSED
    assert "the recorded track is full" in program.get_last_error()
    assert program.stop_record_track() == TaskState.FINISHED
    program.stop(True)


WRONG: list[tuple[tuple[Any, ...], int]] = [
    (("t", 2, "", "", 0.0), 0),
    (("t", 0, "", "", -1.0), 0),
    (("", 0, "", "", 0.0), 0),
    (("../t", 0, "", "", 0.0), 0),
    (("..", 0, "", "", 0.0), 0),
    (("t" * 256, 0, "", "", 0.0), 0),
    (("t", 0, "nothing", "", 0.0), TaskState.ILLEGAL),
    (("t", 0, "", "nothing", 0.0), TaskState.ILLEGAL),
]


@pytest.mark.parametrize(("args", "answer"), WRONG)
def test_wrong_recordings(program: Program, args: tuple[Any, ...], answer: int) -> None:
    id_ = program.start_record_track(*args)
    assert (id_ if id_ == 0 else program.get_noneblock_taskstate(id_)) == answer
    assert program.get_files_list("") == {}


def test_one_recording_at_a_time(program: Program) -> None:
    program.start_record_track("t", BY_POSITION, "", "", 0.0)
    second = program.start_record_track("u", BY_POSITION, "", "", 0.0)
    assert program.get_noneblock_taskstate(second) == TaskState.ILLEGAL
    assert program.stop_record_track() == TaskState.FINISHED
    assert program.get_files_list("track") == {"t": 1}
    assert program.stop_record_track() == TaskState.FINISHED


def test_a_recorder_of_a_standing_arm() -> None:
    recorder, kept = Recorder(), list[RecordedTrack]()
    recorder.start(RecordedTrack("", ""), BY_POSITION, 0.1, tuple, kept.append)
    assert not any(recorder.tick(0.001 * n, np.zeros(6)) for n in range(100))
    recorder.stop()
    assert len(kept[0].joints) == 1
    assert not recorder.tick(1.0, np.ones(6))


def test_a_restart_ends_the_recording() -> None:
    bench, kept = Bench().enabled(), list[RecordedTrack]()
    bench.controller.recorder.start(RecordedTrack("", ""), BY_TIME, 0.01, tuple, kept.append)
    bench.tick(15)
    bench.power("power_off")
    assert not kept
    bench.power("restart")
    assert len(kept[0].joints) >= 2
    assert not bench.controller.recorder.active


# -- replay --------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("mode", [0, 1])
def test_a_replay_goes_to_the_start_and_through_the_points(
    cell: Simulator, program: Program, aside: Aside, mode: int
) -> None:
    record(program, BY_POSITION, 1.0)
    track = cell.cabinet.project.tracks["t"]
    program.to(*ELSEWHERE)
    passed = [math.inf, math.inf]
    run = aside(cell, lambda p: p.replay("t", 50, mode))
    while not run.done():
        cell.wait_until(lambda: run.done() or cell.moving)
        for place, point in enumerate((track.joints[0], track.joints[-1])):
            off = float(np.abs(cell.joints.array - point).max())
            passed[place] = min(passed[place], off)
    assert run.result(10) == TaskState.FINISHED
    assert passed[0] < 0.05
    assert cell.joints.almost_equal(track.joints[-1], 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("mode", [0, 1])
def test_its_speed_is_a_share(cell: Simulator, program: Program, mode: int) -> None:
    record(program, BY_POSITION, 1.0)
    peaks = []
    for percent in (5, 10):
        program.to(*START)
        # The replay is recorded, too: in the controller's time, however busy this machine is.
        program.start_record_track("fast", BY_TIME, "", "", 0.02)
        assert program.replay("t", percent, mode) == TaskState.FINISHED
        program.stop_record_track()
        seen = cell.cabinet.project.tracks["fast"]
        if mode == 0:
            peaks.append(np.abs(np.diff(seen.joints, axis=0)).max() / 0.02)
        else:
            way = np.diff(np.array(seen.poses)[:, :3], axis=0)
            peaks.append(np.linalg.norm(way, axis=1).max() / 0.02)
    whole = min(cell.arm.velocity) if mode == 0 else 1.0
    assert peaks == pytest.approx([0.05 * whole, 0.1 * whole], rel=0.05)


@pytest.mark.slow
def test_a_replay_in_a_work_object_moves_with_it(cell: Simulator, program: Program) -> None:
    program.set_wobj("table", [0.0] * 6)
    program.start_record_track("t", BY_POSITION, "", "table", 1.0)
    program.line([*_tip(program)[:2], _tip(program)[2] - 0.05, *_tip(program)[3:]])
    program.stop_record_track()
    end = np.array(_tip(program))
    program.set_wobj("table", [0.02, 0.0, 0.0, 0.0, 0.0, 0.0])
    assert program.replay("t", 50, 1) == TaskState.FINISHED
    moved = np.array(_tip(program)) - end
    assert moved[:2] == pytest.approx([0.02, 0.0], abs=1e-3)
    program.set_wobj("none", [0.0] * 6)


@pytest.mark.slow
@pytest.mark.parametrize("mode", [0, 1])
def test_pause_and_stop_act_on_a_replay(
    cell: Simulator, program: Program, aside: Aside, mode: int
) -> None:
    record(program, BY_POSITION, 1.0)
    run = aside(cell, lambda p: p.replay("t", 2, mode))
    cell.wait_until(lambda: cell.view.program is ProgramState.RUNNING)
    assert program.pause(True) == TaskState.FINISHED
    assert program.get_robot_state()[1] == ProgramState.PAUSED
    with standing_time(cell):
        program.resume(False)
        advance_until(cell, program.robotmoving)
        stopping = program.stop(False)
    assert run.result(10) == TaskState.STOPPED
    cell.wait_until(lambda: program.get_noneblock_taskstate(stopping) == TaskState.FINISHED)
    assert not cell.moving
    assert program.to(*START) == TaskState.FINISHED


def test_wrong_replays(cell: Simulator, program: Program) -> None:
    record(program, BY_POSITION, 0.0)
    for args in (("nothing", 50, 0), ("t", 0, 0), ("t", 101, 0), ("t", 50, 2)):
        assert program.replay(*args) == TaskState.PARAMETER_MISMATCH
    program.disable(True)
    assert program.replay("t", 50, 0) == TaskState.ILLEGAL
    cell.cabinet.project.tracks["gone"] = RecordedTrack("gone", "", [tuple(START)], [(0.0,) * 6])
    program.enable(True)
    assert program.replay("gone", 50, 1) == TaskState.ILLEGAL


# -- hand guiding --------------------------------------------------------------------------------


def push(cell: Simulator, program: Program, force: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Guide by hand: how the tip has moved and turned, and the joints have."""
    tip, q = np.array(_tip(program)), cell.joints.array
    assert program.teach_mode(True) == TaskState.FINISHED
    cell.push([*force, 0.0, 0.0, 0.0])
    let_pass(cell, 0.3)
    cell.push([0.0] * 6)
    assert program.end_teach_mode(True) == TaskState.FINISHED
    return np.array(_tip(program)) - tip, np.abs(cell.joints.array - q)


@pytest.mark.slow
def test_some_joints_give_way(cell: Simulator, program: Program) -> None:
    wanted = ([1, 0, 0, 0, 0, 0], [1] * 6, 0, [True] * 6)
    assert program.set_hand_teach_parameter(0, *wanted) == TaskState.FINISHED
    _, turned = push(cell, program, [30.0, 40.0, 30.0])
    assert turned[0] > 0.02
    assert max(turned[1:]) < 0.01


@pytest.mark.slow
def test_some_directions_give_way(cell: Simulator, program: Program) -> None:
    directions = [False, False, True, False, False, False]
    answer = program.set_hand_teach_parameter(1, [1] * 6, [1] * 6, 1, directions)
    assert answer == TaskState.FINISHED
    moved, _ = push(cell, program, [30.0, 30.0, 40.0])
    assert moved[2] > 0.01
    assert np.abs(moved[:2]).max() < 0.3 * moved[2]


@pytest.mark.slow
@pytest.mark.parametrize("frame", [2, 3])
def test_directions_of_tool_and_work_object(cell: Simulator, program: Program, frame: int) -> None:
    program.set_wobj("turned", [0.0, 0.0, 0.0, math.pi, 0.0, 0.0])
    directions = [False, False, True, False, False, False]
    answer = program.set_hand_teach_parameter(1, [1] * 6, [0, 0, 9, 0, 0, 0], frame, directions)
    assert answer == TaskState.FINISHED
    moved, _ = push(cell, program, [0.0, 30.0, 40.0])
    assert moved[2] > 0.01
    program.set_wobj("none", [0.0] * 6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "args",
    [
        (2, [1] * 6, [1] * 6, 0, [True] * 6),
        (0, [1] * 5, [1] * 6, 0, [True] * 6),
        (0, [1] * 6, [1] * 5, 0, [True] * 6),
        (0, [-1] * 6, [1] * 6, 0, [True] * 6),
        (0, [1] * 6, [1] * 6, 4, [True] * 6),
        (0, [1] * 6, [1] * 6, 0, [True] * 5),
    ],
)
def test_wrong_parameters_of_hand_guiding(program: Program, args: tuple[Any, ...]) -> None:
    assert program.set_hand_teach_parameter(*args) == TaskState.PARAMETER_MISMATCH


def _tip(program: Program) -> list[float]:
    return program.get_tcp_pose()
