"""Processes of a program are frozen, suspended and killed: no standing arm begins to move.

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
from for_each import for_each

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
    Cell("servo", "worker", "3", guarded=True),
    Cell("speed", "all-but-guard", "1", guarded=True),
    Cell("realtime", "worker", "3", guarded=False),
    Cell("jog", "all", "3", guarded=False),
    Cell("force", "program", "3", guarded=True),
    *(
        [
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


ALL = Cell("servo", "all", "3", guarded=False)
GUARD = Cell("motion", "guard", "3", guarded=True)
STOPPED = ((0.3, 2.0), (0.0, 3.02))
MOVED = (*STOPPED, (0.0, 1.0), (0.3, 3.5))
BEFORE, MEANWHILE = Line(1.0, "command"), Line(4.0, "command")
TOLD = Line(5.5, "told", "GuardLost")


@for_each(
    "verdict, cell, speeds, said",
    [
        (HOLDS, ALL, (*STOPPED, (0.0, 4.5)), ()),
        (HOLDS, ALL, (*STOPPED, (0.001, 1.0), (0.0, 3.5)), ()),
        # an arm that stood moves, at once or later, and also if it comes back
        (BREAKS, ALL, (*STOPPED, (0.3, 0.02), (0.0, 4.5)), ()),
        (BREAKS, ALL, (*STOPPED, (0.0, 4.0), (0.3, 0.5)), ()),
        (BREAKS, ALL, (*STOPPED, (0.3, 0.5), (-0.3, 0.5), (0.0, 3.5)), ()),
        # one that moves must come to rest in time, and stay
        (HOLDS, ALL, ((0.3, 7.0), (0.0, 2.5)), ()),
        (BREAKS, ALL, ((0.3, 8.2), (0.0, 1.3)), ()),
        (BREAKS, ALL, ((0.3, 9.5),), ()),
        (BREAKS, ALL, ((0.3, 5.5), (0.0, 1.0), (0.1, 1.0), (0.0, 2.0)), ()),
        # a program that ran all the time, and was not told, may command it
        (GOES_ON, GUARD, MOVED, (BEFORE, MEANWHILE)),
        (BREAKS, GUARD, MOVED, (BEFORE,)),
        (BREAKS, GUARD, MOVED, (BEFORE, MEANWHILE, TOLD)),
        (BREAKS, ALL, MOVED, (BEFORE, MEANWHILE)),
    ],
)
def test_the_verdict_about_an_arm(
    verdict: str, cell: Cell, speeds: tuple[tuple[float, float], ...], said: tuple[Line, ...]
) -> None:
    """Of one that is frozen after 2 s and thawed after 5 s."""
    assert judge(cell, 0, Way(seen(*speeds)), (2.0, 5.0), said).kind == verdict


def test_an_arm_may_go_on_if_no_limit_has_passed() -> None:
    way = Way(seen((0.3, 7.0)))
    verdicts = {
        ("servo", "program"): GOES_ON,
        ("servo", "worker"): BREAKS,
        ("speed", "program"): BREAKS,
    }
    for (scene, frozen), kind in verdicts.items():
        short = Cell(scene, frozen, "0.3", guarded=False)
        assert judge(short, 0, way, (2.0, 2.3), ()).kind == kind


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
