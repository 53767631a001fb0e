"""Only a program that moves the arm has it stopped when it ends or hangs."""

from __future__ import annotations

import os
import signal
import time

import pytest
from client.bench import HOME, Bench, under_way

import aioduco
from aioduco import HeartbeatState
from aioduco.supervision.heartbeat import HeartbeatMachine
from aioduco.supervision.loop_watchdog import Liveness
from aioduco.supervision.settings import GuardKind
from aioduco.testing import eventually, eventually_async

from .programs import frozen, guard_of, running, started

MOVE = f"await robot.motion.movej2({HOME}, v=1.0, a=1.0).start()"
#: a motion that has ended, and of which nothing is left
MOVED = (
    f"await robot.motion.movej2({HOME}, v=1.0, a=1.0)\n"
    "        while robot._supervisor.stop_coordinator.liveness.moves: await anyio.sleep(0.001)"
)
BEAT = 0.2


@pytest.mark.linux("the guard's process")
@pytest.mark.slow
@pytest.mark.parametrize("deed", ["pass", MOVED], ids=["looked on", "moved before"])
async def test_a_killed_program_that_moves_nothing_stops_nobodys_arm(
    bench: Bench, deed: str
) -> None:
    with started(bench.host, bench.port, deed, heartbeat=60.0) as onlooker:
        bench.motion_time = 600.0
        async with aioduco.connect(bench.host, bench.port) as mover:
            task = await mover.motion.movej2(HOME, v=1.0, a=1.0).start()
            onlooker.end(signal.SIGKILL)
            await eventually_async(lambda: not running(onlooker.guard), timeout=30.0)
            assert bench.stops == 0
            assert not task.done


@pytest.mark.linux("the guard's process")
def test_a_killed_program_that_moves_has_its_arm_stopped(bench: Bench) -> None:
    bench.motion_time = 600.0
    with started(bench.host, bench.port, MOVE, heartbeat=60.0) as mover:
        mover.end(signal.SIGKILL)
        eventually(lambda: not running(mover.guard), timeout=30.0)
        assert bench.stops >= 1
        assert not bench.moving()


@pytest.mark.slow
@pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])
@pytest.mark.parametrize("moves", [False, True], ids=["looks on", "moves"])
async def test_a_hung_program_has_only_its_own_motion_stopped(
    bench: Bench, guard: GuardKind | None, moves: bool
) -> None:
    async with aioduco.connect(
        bench.host, bench.port, guard=guard, heartbeat=2.0, loop_stall_limit=1.5
    ) as robot:
        heart = robot._supervisor.heartbeat
        assert heart is not None
        if moves:
            await under_way(bench, robot)
        eventually(lambda: heart.state is HeartbeatState.STALLED, timeout=30.0)  # blocks the loop
        if moves:
            eventually(lambda: bench.stops >= 1, timeout=30.0)
    assert (bench.stops >= 1) is moves


@pytest.mark.linux("the guard's process")
@pytest.mark.slow
@pytest.mark.parametrize("heartbeat", [BEAT, None])
def test_a_guard_that_was_frozen_at_its_programs_death_stops_nobody_elses_motion(
    bench: Bench, heartbeat: float | None
) -> None:
    """With a heartbeat, the controller has stopped the arm long ago; without one, nobody has."""
    bench.motion_time = 600.0
    with started(bench.host, bench.port, MOVE, heartbeat=heartbeat) as mover:
        os.kill(mover.guard, signal.SIGSTOP)
        eventually(lambda: frozen(mover.guard), timeout=30.0)
        frozen_at = time.monotonic()
        beats = len(bench.received("rpc_heartbeat"))
        mover.end(signal.SIGKILL)
        # Twice the heartbeat time, and some more for the beat that was on its way.
        eventually(lambda: time.monotonic() - frozen_at > 3 * BEAT, timeout=30.0)
        os.kill(mover.guard, signal.SIGCONT)
        eventually(lambda: not running(mover.guard), timeout=30.0)
    assert bench.stops == (0 if heartbeat else 1)
    # A beat would have the controller wait for the next one, and stop the arm when none comes.
    assert len(bench.received("rpc_heartbeat")) <= beats + 1


@pytest.mark.slow
async def test_a_frozen_guard_goes_on_when_it_wakes(bench: Bench) -> None:
    async with aioduco.connect(
        bench.host, bench.port, guard="process", heartbeat=BEAT, loop_stall_limit=20.0
    ) as robot:
        _, guard = guard_of(robot)
        heart = robot._supervisor.heartbeat
        assert heart is not None
        os.kill(guard, signal.SIGSTOP)
        try:
            await eventually_async(lambda: heart.state is HeartbeatState.LOST, timeout=30.0)
        finally:
            os.kill(guard, signal.SIGCONT)
        await eventually_async(lambda: heart.state is HeartbeatState.BEATING, timeout=30.0)
        await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("heartbeat", "error"),
    [(None, aioduco.GuardLost), (0.3, aioduco.HeartbeatLost)],
    ids=["none", "heartbeat"],
)
async def test_without_a_guard_that_knows_of_it_nothing_is_moved(
    bench: Bench, heartbeat: float | None, error: type[Exception]
) -> None:
    async with aioduco.connect(
        bench.host, bench.port, guard="process", heartbeat=heartbeat
    ) as robot:
        guard, pid = guard_of(robot)
        os.kill(pid, signal.SIGKILL)
        eventually(lambda: not guard.alive, timeout=30.0)  # the loop cannot replace it meanwhile
        with pytest.raises(error, match="movej2 was not sent"):
            await robot.motion.movej2(HOME, v=1.0, a=1.0)
        assert not bench.received("movej2")
        await eventually_async(
            lambda: (
                guard.alive
                and (robot.heartbeat is None or robot.heartbeat.state is HeartbeatState.BEATING)
            ),
            timeout=30.0,
        )
        await robot.motion.movej2(HOME, v=1.0, a=1.0)


@pytest.mark.linux("the guard's process")
@pytest.mark.slow
async def test_another_guard_knows_what_moves(bench: Bench) -> None:
    """A guard that replaces another while the program moves the arm is told so, too."""
    code = (
        f"{MOVE}\n"
        "        first = robot._supervisor.guard.pid\n"
        "        import os; os.kill(first, 9)\n"
        "        while robot._supervisor.guard.pid in (None, first)"
        " or not robot._supervisor.guard.alive: await anyio.sleep(0.001)\n"
        f"        {MOVE}"
    )
    bench.motion_time = 600.0
    with started(bench.host, bench.port, code, heartbeat=None) as mover:
        before = bench.stops
        mover.end(signal.SIGKILL)
        await eventually_async(lambda: not running(mover.guard), timeout=30.0)
        assert bench.stops > before
        assert not bench.moving()


def test_a_motion_is_refused_if_no_guard_hears_of_it() -> None:
    said: list[bool] = []

    def deaf(_stamp: float, moves: bool, _modes: object) -> bool:
        said.append(moves)
        return False

    life = Liveness(deaf)
    with pytest.raises(aioduco.GuardLost, match="movel was not sent"):
        life.will_move("movel")
    # It may have been heard after all: it is taken back only when the arm was seen to stand.
    assert life.moves
    life.at_rest()
    assert said == [True, False]


def test_who_was_held_up_beats_after_a_new_keep_alive() -> None:
    heart = HeartbeatMachine(time=1.0, stall_limit=2.0, now=0.0)
    heart.beaten(0.0)
    heart.suspended(50.0)
    assert HeartbeatState(heart.state.value) is HeartbeatState.LOST
    assert not heart.may_beat(50.0, alive=49.9)  # given before, and read only now
    assert heart.may_beat(50.2, alive=50.1)
    heart.suspended(90.0)
    assert not heart.may_beat(92.1, alive=50.1)
    assert HeartbeatState(heart.state.value) is HeartbeatState.STALLED
