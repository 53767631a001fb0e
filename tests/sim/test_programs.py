"""Programs of the controller (manual 1.3.4): how they run, and what acts on them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each

from aioduco._wire import idl
from aioduco.models.enums import ProgramState, TaskState
from aioduco.sim.cabinet.script import BLENDING, ProgramError, read
from aioduco.sim.controller.programs import ProgramRun
from aioduco.sim.controller.tasks import TaskTable
from aioduco.sim.refusal import Pending
from aioduco.sim.simulator import READY, Simulator

from .conftest import (
    OUT_OF_RANGE,
    Aside,
    Connect,
    Program,
    Started,
    advance_until,
    let_pass,
    standing_time,
)

LEFT, RIGHT = [0.3, *READY[1:]], [-0.3, *READY[1:]]
FAR = [2.0, *READY[1:]]
heard: list[Any] = []


def ask() -> Generator[list[Any], Any, None]:
    """A program that decides by what it reads."""
    heard[:] = [(yield ["get_standard_digital_in", 3])]
    while not (yield ["get_standard_digital_in", 3]):
        yield ["sleep", 0.01]
    heard.append((yield ["movej2", LEFT, 1.0, 5.0]))
    heard.append((yield ["get_global_speed"]))


def broken() -> Generator[list[Any], Any, None]:
    yield ["sleep", 0.01]
    raise KeyError("a bug")


def wrong_op() -> Generator[list[Any], Any, None]:
    yield ["movej2", LEFT, 1.0, 5.0, 0.0, True, 5]


PROGRAMS: dict[str, Any] = {
    "pick": [
        ["movej2", LEFT, 1.0, 5.0],
        ["set_standard_digital_out", 3, True],
        ["movej2", RIGHT, 1.0, 5.0],
    ],
    "blend": [
        ["movej2", LEFT, 1.0, 5.0, 0.05],
        ["movej2", RIGHT, 1.0, 5.0, 0.05],
        ["movej2", list(READY), 1.0, 5.0],
        ["set_standard_digital_out", 4, True],
    ],
    "far": [["movej2", FAR, 0.2, 5.0], ["set_standard_digital_out", 5, True]],
    "wait": [["sleep", 1000.0], ["set_standard_digital_out", 6, True]],
    "behind": [["movej2", LEFT, 1.0, 5.0, 0.0, False]],
    "unreachable": [["movel", [5.0, 0, 0, 0, 0, 0], 0.1, 1.0]],
    "refused": [["set_servo_config", 1, 1, 1, 1, True]],
    "wrong": [["movej2", [0.0], 1.0, 1.0]],
    "itself": [["run_program", "itself"]],
    "stops": [["stop"], ["set_standard_digital_out", 7, True]],
    "trigger": [
        ["movej2", list(READY), 1.0, 5.0, 0.0, True, None, True],
        ["movej2", LEFT, 1.0, 5.0, 0.0, True, {"time_or_dist_1": 1, "trig_io_1": 8,
                                              "trig_value_1": True}],
    ],
    "ask": ask,
    "broken": broken,
    "wrong op": wrong_op,
    "parts/a": [],
}  # fmt: skip


@pytest.fixture(scope="module")
def cell() -> Iterator[Simulator]:
    """One simulator for all: each test leaves it enabled, at rest and without a program."""
    with Simulator(speed=math.inf, programs=PROGRAMS) as sim:
        yield sim


@pytest.fixture
def program(cell: Simulator, program: Program) -> Program:
    for num in range(1, 17):
        cell.signals.standard_out[num] = False
    return program


def running(cell: Simulator) -> bool:
    return cell.view.program is ProgramState.RUNNING


def test_a_program_runs_to_its_end(cell: Simulator, program: Program) -> None:
    assert program.run_program("pick", True) == TaskState.FINISHED
    assert cell.joints.almost_equal(RIGHT, 2e-3)
    assert cell.get_digital_output(3)
    assert program.get_robot_state() == [6, 0, 5, 1]
    assert program.get_last_error() == []


def test_each_motion_with_a_blend_radius_is_read_ahead() -> None:
    """The radius of a spiral is that of its end."""
    radii = {"r", "rad"}
    moves = {
        name
        for name, function in idl.functions().items()
        if "op" in function.parameters and radii & set(function.parameters)
    }
    assert moves - {"move_spiral"} == BLENDING


@pytest.mark.slow
def test_its_motions_blend(cell: Simulator, program: Program) -> None:
    seen: list[str] = []
    program.to(*READY)
    id_ = program.run_program("blend", False)
    assert program.get_noneblock_taskstate(id_) in (TaskState.IDLE, TaskState.RUNNING)
    cell.wait_until(lambda: program.get_noneblock_taskstate(id_) == TaskState.FINISHED)
    for known in range(id_ + 1, id_ + 4):
        task = cell._running().controller.tasks.get(known)
        assert task is not None
        seen.append(f"{task.name} {task.state.name}")
    assert seen == ["movej2 INTERRUPT", "movej2 INTERRUPT", "movej2 FINISHED"]
    assert cell.get_digital_output(4)


def test_a_motion_that_it_does_not_wait_for_is_a_part_of_it(
    cell: Simulator, program: Program
) -> None:
    program.to(*RIGHT)
    assert program.run_program("behind", True) == TaskState.FINISHED
    assert cell.joints.almost_equal(LEFT, 2e-3)


def test_a_program_gets_answers(cell: Simulator, program: Program) -> None:
    program.to(*READY)
    cell.set_digital_input(3, False)
    id_ = program.run_program("ask", False)
    cell.wait_until(lambda: heard == [False])
    cell.set_digital_input(3, True)
    cell.wait_until(lambda: program.get_noneblock_taskstate(id_) == TaskState.FINISHED)
    assert heard == [False, TaskState.FINISHED, 100]


def test_triggers_are_mappings_or_none(cell: Simulator, program: Program) -> None:
    program.to(*RIGHT)
    assert program.run_program("trigger", True) == TaskState.FINISHED
    assert cell.get_digital_output(8)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["far", "wait"])
def test_pause_and_resume_act_on_it(cell: Simulator, program: Program, name: str) -> None:
    program.to(*READY)
    id_ = program.run_program(name, False)
    cell.wait_until(lambda: running(cell))
    assert program.pause(True) == TaskState.FINISHED
    assert program.get_robot_state()[1] == ProgramState.PAUSED
    assert program.get_noneblock_taskstate(id_) == TaskState.PAUSED
    let_pass(cell, 1.0)
    assert not cell.moving
    assert program.resume(True) == TaskState.FINISHED
    assert program.get_noneblock_taskstate(id_) == TaskState.RUNNING
    assert running(cell)
    program.stop(True)
    assert program.get_noneblock_taskstate(id_) == TaskState.STOPPED


ENDS: list[tuple[str, Callable[[Simulator, Program], Any], TaskState]] = [
    ("stop", lambda _, p: p.stop(True), TaskState.STOPPED),
    ("abort", lambda _, p: p.abort(True), TaskState.INTERRUPT),
    ("disable", lambda _, p: p.disable(True), TaskState.STOPPED),
    ("emergency stop", lambda s, _: s.emergency_stop(), TaskState.ERROR),
    ("collision", lambda s, _: s.collide(2), TaskState.ERROR),
]


@pytest.mark.parametrize("name", ["far", "wait"])
@pytest.mark.parametrize(("end", "state"), [row[1:] for row in ENDS], ids=[r[0] for r in ENDS])
def test_what_ends_motions_ends_it(
    cell: Simulator,
    program: Program,
    aside: Aside,
    name: str,
    end: Callable[[Simulator, Program], Any],
    state: TaskState,
) -> None:
    program.to(*READY)
    run = aside(cell, lambda p: p.run_program(name, True))
    cell.wait_until(lambda: running(cell))
    end(cell, program)
    assert run.result(20) == state
    cell.release_emergency_stop()
    cell.wait_until(lambda: not cell.moving)  # brakes stop a moving arm, but not at once
    assert cell.view.program is ProgramState.STOPPED
    assert not cell.get_digital_output(5)
    assert not cell.get_digital_output(6)


def test_a_popup_and_a_change_of_mode_pause_it(cell: Simulator, program: Program) -> None:
    id_ = program.run_program("wait", False)
    cell.wait_until(lambda: running(cell))
    program.log_error("look here")
    cell.wait_until(lambda: program.get_noneblock_taskstate(id_) == TaskState.PAUSED)
    program.stop(True)
    program.run_program("wait", False)
    assert program.switch_mode(0) == TaskState.FINISHED
    assert program.get_robot_state() == [6, 3, 5, 0]
    assert program.stop(True) == TaskState.FINISHED
    assert program.get_robot_state() == [6, 0, 5, 0]
    assert program.switch_mode(2) == OUT_OF_RANGE
    assert program.switch_mode(1) == TaskState.FINISHED
    assert program.get_robot_state() == [6, 0, 5, 1]


@pytest.mark.slow
def test_a_lost_heartbeat_ends_it(cell: Simulator, connect: Connect) -> None:
    program = connect(cell)
    program.power_off(True)
    program.bring_up()
    id_ = program.run_program("wait", False)
    program.rpc_heartbeat(200)
    # Beats are counted by the wall clock: no time of the simulation is too long for this.
    cell.wait_until(lambda: bool(cell.view.errors), timeout=math.inf)
    assert program.get_noneblock_taskstate(id_) == TaskState.STOPPED
    assert "heartbeat lost" in program.get_last_error()[-1]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("unreachable", "'unreachable': movel ended with ERROR"),
        ("refused", "set_servo_config is not simulated"),
        ("wrong", "'wrong': movej2 ended with ILLEGAL"),
        ("itself", "'itself': run_program ended with ILLEGAL"),
        ("broken", "'broken': KeyError('a bug')"),
        ("wrong op", "'wrong op': movej2: op is 5, but must be a mapping of the fields of Op"),
    ],
)
def test_what_goes_wrong_in_it_is_its_end(program: Program, name: str, message: str) -> None:
    assert program.run_program(name, True) == TaskState.ERROR
    assert any(message in error for error in program.get_last_error())
    assert program.get_robot_state() == [6, 0, 5, 1]


def test_a_program_can_stop_itself(cell: Simulator, program: Program) -> None:
    assert program.run_program("stops", True) == TaskState.STOPPED
    assert not cell.get_digital_output(7)


def test_an_unknown_program_is_a_wrong_parameter(program: Program) -> None:
    for name in ("", "nothing", "../pick", "/project/program/pick", "program/pick"):
        assert program.run_program(name, True) == TaskState.PARAMETER_MISMATCH


def test_it_has_the_arm_to_itself(cell: Simulator, program: Program) -> None:
    program.run_program("wait", False)
    assert program.run_program("pick", True) == TaskState.ILLEGAL
    assert program.to(*READY) == TaskState.ILLEGAL
    assert program.set_standard_digital_out(9, True, True) == TaskState.FINISHED
    program.stop(True)
    with standing_time(cell):
        id_ = program.to(*FAR, v=0.2, block=False)
        advance_until(cell, lambda: program.get_noneblock_taskstate(id_) == TaskState.RUNNING)
        assert program.run_program("pick", True) == TaskState.ILLEGAL
        assert program.get_noneblock_taskstate(id_) == TaskState.RUNNING
    program.disable(True)
    assert program.run_program("pick", True) == TaskState.ILLEGAL


def test_programs_are_files_of_the_project(program: Program) -> None:
    names = program.get_files_list(program.get_current_project() + "program")
    flat = [name for name in PROGRAMS if "/" not in name]
    assert names == {**dict.fromkeys(flat, 1), "parts": 0}
    assert program.get_files_list("program/parts") == {"a": 1}


# -- where programs come from ----------------------------------------------------------------------


def test_a_folder_of_programs(tmp_path: Path, started: Started) -> None:
    (tmp_path / "out.json").write_text(json.dumps([["set_standard_digital_out", 1, True]]))
    (tmp_path / "notes.txt").write_text("no program")
    sim, program = started(programs=tmp_path)
    assert program.get_files_list("program") == {"out": 1}
    assert program.run_program("out", True) == TaskState.FINISHED
    assert sim.get_digital_output(1)


def test_links_out_of_the_folder_are_refused(tmp_path: Path) -> None:
    (tmp_path / "secret.json").write_text("[]")
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "link.json").symlink_to(tmp_path / "secret.json")
    with pytest.raises(ValueError, match="leads out of"):
        read(folder)


@for_each(
    "content, message",
    [
        ("{", "is no JSON"),
        ("[" * 100_000, "is no JSON"),
        ('{"a": 1}', "must be a list of calls"),
        ("[3]", "call 1: 3 is no call"),
        ('[["stop"], ["jump"]]', "call 2: there is no function 'jump'"),
        ('[["stop", true, 3]]', "stop takes 1 arguments, not 2"),
        ('[["sleep", -1]]', "sleep takes a time"),
        ('[["movej2", [], 1, 1, 0, true, {"jump": 1}]]', "Op has no 'jump'"),
        ('[["movej2", [], 1, 1, 0, true, 5]]', "movej2: op is 5, but must be a mapping"),
        ('[["movej2", null, 1, 1]]', "movej2: joints_list is None, but must be a list"),
        ('[["movej2", [0, "1"], 1, 1]]', r"movej2: joints_list\[1\] is '1', but must be a finite"),
        ('[["movej2", [], NaN, 1]]', "movej2: v is nan, but must be a finite number"),
        (f'[["movej2", [], 1{"0" * 400}, 1]]', "movej2: v is 10+, but must be a finite number"),
        ('[["write_word_reg", 1, 1.5]]', "value is 1.5, but must be a whole number"),
        ('[["set_system_value_str", "a", 3]]', "value is 3, but must be a text"),
    ],
)
def test_a_file_that_is_no_program(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / "wrong.json").write_text(content)
    with pytest.raises(ValueError, match=message):
        Simulator(programs=tmp_path)


def test_a_program_needs_a_name() -> None:
    with pytest.raises(ValueError, match="empty"):
        Simulator(programs={"": []})


# -- one call in a cycle ---------------------------------------------------------------------------


def test_one_call_in_a_cycle_and_sleeping_keeps_time() -> None:
    calls: list[str] = []

    def make(name: str, _values: tuple[Any, ...]) -> int:
        calls.append(name)
        return 0

    script: list[list[Any]] = [["getQueueSize"], ["sleep", 0.005], ["robotmoving"]]
    steps = ProgramRun("timed", script, make, TaskTable())
    made = []
    for _ in range(12):
        over = steps.go_on(0.001)
        made.append(len(calls))
        if over:
            break
    assert made == [1, 1, 1, 1, 1, 1, 2, 2]


def test_a_motion_that_is_answered_early_is_waited_for_by_what_moves_nothing() -> None:
    tasks, made = TaskTable(), list[tuple[str, int]]()

    def make(name: str, values: tuple[Any, ...]) -> int:
        made.append((name, tasks.new(name)))
        if name == "movel":
            assert values[7] is True  # block
            raise Pending(made[-1][1])
        return 0

    line = ["movel", [0.0] * 6, 0.1, 1.0, 0.05, [], "", "", False]
    steps = ProgramRun("blends", [line, line, ["robotmoving"]], make, tasks)
    for known in (1, 2):
        for _ in range(3):
            assert not steps.go_on(0.001)
        assert len(made) == known
        tasks.pass_on(made[-1][1])
    for _, id_ in made.copy():
        assert not steps.go_on(0.001)
        assert len(made) == 2
        tasks.set(id_, TaskState.INTERRUPT)
    assert not steps.go_on(0.001)
    assert made[-1][0] == "robotmoving"
    assert steps.go_on(0.001)


@pytest.mark.parametrize(("part", "count", "known"), [(0, 1, 2), (0, 3, 4), (50, 3, 1)])
def test_how_far_a_program_is_read_ahead(
    part: int, count: int, known: int, connect: Connect
) -> None:
    moves = [["movej2", goal, 1.0, 2.0, 0.01] for goal in (LEFT, RIGHT) * 3]
    with Simulator(programs={"blends": [["set_blend_ahead", part, count], *moves]}) as sim:
        robot = connect(sim)
        robot.power_on(True)
        robot.enable(True)
        robot.run_program("blends", False)
        sim.wait_until(lambda: sim.moving)
        sim.wait_until(lambda: sim.joints[0] > 0.02)
        assert sum(task.name == "movej2" for task in sim.tasks) == known
        sim.wait_until(lambda: sim.joints[0] > 0.3 * (0.01 * part + 0.04))
        assert sum(task.name == "movej2" for task in sim.tasks) == (known if not part else 2)


def test_a_generator_that_yields_nonsense() -> None:
    def nonsense() -> Generator[list[Any], Any, None]:
        yield []

    steps = ProgramRun("nonsense", nonsense, lambda _name, _values: 0, TaskTable())
    with pytest.raises(ProgramError, match="is no call"):
        steps.go_on(0.001)
