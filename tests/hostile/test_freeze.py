"""Processes of a program are frozen, suspended and killed: no standing arm begins to move by that.

The whole matrix, some six hundred runs, is run by `.ci/freeze-matrix`, which states the rule; here
is a part of it. Verdicts are by the arm's positions alone, and a busy machine makes a run longer or
has it begun anew, but does not change its verdict.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from aioduco.testing import eventually

from .freeze import clock, processes
from .freeze.arm import Seen
from .freeze.cells import HOME, Cell, Draw, cells
from .freeze.judge import BREAKS, ERROR, GOES_ON, HOLDS, Line, Way, goes_on_by_design, judge
from .freeze.matrix import trials
from .freeze.trial import PATIENT

pytestmark = pytest.mark.linux("signals that stop processes, and a clock that goes on meanwhile")

#: at a time; most of a run is waiting
_JOBS = 6

_CELLS = [
    Cell("motion", "all", "3", guarded=True),
    Cell("motion", "program", "killed", guarded=False),
    Cell("servo", "program", "0.3", guarded=False),
    Cell("servo", "worker", "3", guarded=True),
    Cell("servo", "all", "3", guarded=False),
    Cell("servo", "all", "killed", guarded=False),
    Cell("speed", "all-but-guard", "1", guarded=True),
    Cell("track", "worker", "1", guarded=False),
    Cell("realtime", "worker", "3", guarded=False),
    Cell("plan", "all", "3", guarded=True),
    Cell("jog", "all", "3", guarded=False),
    Cell("force", "program", "3", guarded=True),
    *(
        [
            Cell("servo", "all", "suspended", guarded=False),
            Cell("speed", "all", "suspended", guarded=True),
            Cell("play", "all", "suspended", guarded=False),
        ]
        if not clock.why_not()
        else []
    ),
]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_no_standing_arm_begins_to_move_by_a_freeze() -> None:
    results = trials([(cell, 1) for cell in _CELLS], _JOBS, PATIENT)
    failed = [str(result) for result in results if result.verdict.kind in (BREAKS, ERROR)]
    assert not failed, f"{len(failed)} of {len(_CELLS)}:\n" + "\n".join(failed)


def seen(*speeds: tuple[float, float]) -> Seen:
    """What is seen of an arm whose joint 1 has these speeds for these times [rad/s, s]."""
    steps = np.concatenate([np.full(round(seconds / 0.004), speed) for speed, seconds in speeds])
    joints = np.tile(HOME, (len(steps), 1))
    joints[:, 0] += np.cumsum(steps) * 0.004
    times = np.arange(len(steps)) * 0.004
    return np.column_stack([times, times, joints])


def judged(cell: Cell, *speeds: tuple[float, float], said: tuple[Line, ...] = ()) -> str:
    """The verdict about an arm that is frozen after 2 s and thawed after 5 s."""
    return judge(cell, 0, Way(seen(*speeds)), (2.0, 5.0), said).kind


ALL = Cell("servo", "all", "3", guarded=False)
STOPPED = ((0.3, 2.0), (0.0, 3.02))


def test_an_arm_that_stands_holds() -> None:
    assert judged(ALL, *STOPPED, (0.0, 4.5)) == HOLDS
    assert judged(ALL, *STOPPED, (0.001, 1.0), (0.0, 3.5)) == HOLDS


def test_a_standing_arm_that_moves_is_found_whenever_it_does() -> None:
    assert judged(ALL, *STOPPED, (0.3, 0.02), (0.0, 4.5)) == BREAKS
    assert judged(ALL, *STOPPED, (0.0, 4.0), (0.3, 0.5)) == BREAKS
    assert judged(ALL, *STOPPED, (0.3, 0.5), (-0.3, 0.5), (0.0, 3.5)) == BREAKS


def test_a_moving_arm_must_come_to_rest_in_time_and_stay() -> None:
    assert judged(ALL, (0.3, 5.0), (0.3, 2.0), (0.0, 2.5)) == HOLDS
    assert judged(ALL, (0.3, 5.0), (0.3, 3.2), (0.0, 1.3)) == BREAKS
    assert judged(ALL, (0.3, 5.0), (0.3, 4.5)) == BREAKS
    assert judged(ALL, (0.3, 5.0), (0.3, 0.5), (0.0, 1.0), (0.1, 1.0), (0.0, 2.0)) == BREAKS


def test_an_arm_may_go_on_if_no_limit_has_passed() -> None:
    short = Way(seen((0.3, 2.3), (0.3, 1.5)))
    program = Cell("servo", "program", "0.3", guarded=False)
    assert judge(program, 0, short, (2.0, 2.3), ()).kind == GOES_ON
    for scene, frozen in ("servo", "worker"), ("speed", "program"):
        passed = Cell(scene, frozen, "0.3", guarded=False)
        assert judge(passed, 0, Way(seen((0.3, 7.0))), (2.0, 2.3), ()).kind == BREAKS


def test_an_arm_may_move_if_its_program_ran_all_the_time_and_commands_it() -> None:
    guard = Cell("motion", "guard", "3", guarded=True)
    moved = (*STOPPED, (0.0, 1.0), (0.3, 3.5))
    before, meanwhile = Line(1.0, "command"), Line(4.0, "command")
    told = Line(5.5, "told", "GuardLost")
    assert judged(guard, *moved, said=(before, meanwhile)) == GOES_ON
    assert judged(guard, *moved, said=(before,)) == BREAKS
    assert judged(guard, *moved, said=(before, meanwhile, told)) == BREAKS
    assert judged(ALL, *moved, said=(before, meanwhile)) == BREAKS


def test_a_simulator_that_fell_behind_is_found() -> None:
    late = seen((0.3, 3.0))
    late[400:, 0] += 0.5
    assert Way(late).late(1.0, 2.0) == pytest.approx(0.5, abs=0.01)
    assert Way(late).late(0.0, 1.0) == pytest.approx(0.004, abs=0.001)


def test_long_freezes_go_on_by_design_only_beside_a_frozen_guard() -> None:
    for cell in cells():
        for seed in (1, 2):
            draw = Draw.of(cell, seed)
            if goes_on_by_design(cell, draw.variant, draw.seconds):
                assert cell.how == "0.3" or (cell.how, cell.frozen) == ("1", "guard")


@pytest.mark.slow
@pytest.mark.skipif(bool(clock.why_not()), reason=clock.why_not())
def test_the_clock_of_a_suspended_program_stands_still_and_its_waits_go_on(tmp_path: Path) -> None:
    code = """
import threading, time
def times():
    clocks = time.CLOCK_MONOTONIC, time.CLOCK_MONOTONIC_RAW, time.CLOCK_BOOTTIME
    return [time.clock_gettime(clock) for clock in clocks]
def waited(wait):
    wait()
    ends.append(times())
ends, begin = [], times()
print("ready", flush=True)
event = threading.Thread(target=waited, args=(lambda: threading.Event().wait(1.0),))
event.start()
waited(lambda: time.sleep(1.0))
event.join()
for each in ends:
    print(*(end - start for start, end in zip(begin, each)))
"""
    with (
        clock.StandingClock(clock.compiled(tmp_path)) as standing,
        subprocess.Popen(
            [sys.executable, "-c", code],
            env={**os.environ, **standing.environment, processes.MARK: (mark := str(tmp_path))},
            stdout=subprocess.PIPE,
            text=True,
        ) as program,
    ):
        assert program.stdout is not None
        assert program.stdout.readline() == "ready\n"
        assert processes.roles_of(mark, program.pid) == {program.pid: "program"}
        processes.freeze([program.pid])
        begin = clock.now()
        eventually(lambda: clock.now() > begin + 2.0)
        standing.stand(stood := clock.now() - begin)
        processes.thaw([program.pid])
        lines = program.stdout.readlines()
    assert len(lines) == 2
    for line in lines:
        monotonic, raw, boot = map(float, line.split())
        assert monotonic == pytest.approx(raw, abs=0.5)
        assert monotonic == pytest.approx(boot - stood, abs=0.5)
        assert monotonic > 1.0 - 0.01  # a wait ends by the clock that stood still


def test_all_processes_of_a_run_are_killed_frozen_ones_too(tmp_path: Path) -> None:
    os.mkfifo(fifo := tmp_path / "fifo")
    # A child that opens a pipe with one end is not yet the program that it is to become, and the
    # process that starts it waits for that where no signal but the last reaches it.
    code = f"""
import os
opened = (os.POSIX_SPAWN_OPEN, 0, {str(fifo)!r}, os.O_RDONLY, 0)
os.posix_spawn("/bin/sleep", ["sleep", "1000"], os.environ, file_actions=[opened], setsid=True)
"""
    mark = str(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-c", code], env={**os.environ, processes.MARK: mark}
    ) as program:
        try:
            eventually(lambda: len(processes.of_run(mark)) == 2)
            eventually(lambda: processes.states_of(program.pid) == {"D"})
            processes.freeze(processes.of_run(mark))
        finally:
            processes.kill(mark)
        assert program.wait() == -signal.SIGKILL
    assert not processes.of_run(mark)
