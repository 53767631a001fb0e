"""The rehearsal has the set-points of a simulator that gets the same commands."""

from __future__ import annotations

import math

import pytest
from for_each import for_each

from aioduco._wire.rpc import Op
from aioduco.compat import DucoCobot
from aioduco.models.pose import Pose
from aioduco.sim import Simulator
from aioduco.sim.twin.data import TwinCommand
from aioduco.sim.twin.predictor import AHEAD
from aioduco.sim.twin.rehearsal import CYCLE, Rehearsal

from .arms import ARM, READY, movej2

THERE = [0.6, 0.2, 1.3, 0.2, -1.3, 0.3]


def test_set_points_are_those_of_the_simulator() -> None:
    down = list(Pose.from_matrix(ARM.fkine(THERE)))
    down[2] -= 0.1
    motions = (movej2(*THERE), ("movel", (down, 0.2, 1.0, 0.0, THERE, "", "", False, Op(), False)))
    rehearsal, seen, apart, delays = Rehearsal(ARM), [], [], []
    with Simulator(cycle=CYCLE, joints=READY, speed=math.inf) as sim:
        client = DucoCobot(sim.host, sim.port)
        assert client.open() == 0
        assert client.power_on(True) == client.enable(True) == 4
        sim.lock_time()
        begun = sim.time
        sim.observe(lambda now, _: seen.append((now.time - begun, tuple(now.setpoint.q.tolist()))))
        rehearsal.begin(READY, 0.0)
        for function, arguments in motions:
            at = sim.time - begun + AHEAD
            rehearsal.advance(at)
            assert rehearsal.command(TwinCommand(at, function, arguments, True))
            getattr(client, function)(*arguments)
            sim.advance(10)
            while sim.moving:
                sim.advance(25)
            for time, q in seen:
                rehearsal.advance(time + AHEAD)
                match = rehearsal.match(q)
                assert match is not None
                apart.append(match.distance)
                if match.moving:
                    delays.append(match.delay)
            seen.clear()
        client.close()
    assert max(apart) < 1e-9
    assert len(apart) > 300
    assert max(delays) < AHEAD + 0.02


def test_a_setting_holds_for_the_next_begin() -> None:
    rehearsal = Rehearsal(ARM)
    assert rehearsal.command(TwinCommand(0.0, "speed", (50.0,), True)) is None
    rehearsal.begin(READY, 1.0)
    slow = duration(rehearsal)
    plain = Rehearsal(ARM)
    plain.begin(READY, 1.0)
    assert slow == pytest.approx(2.0 * duration(plain), rel=0.1)


def test_a_line_past_a_singularity_is_rehearsed_with_vibration_control_off() -> None:
    start, end = ((0.0, 0.3, 1.2, 0.0, bend, 0.0) for bend in (0.2, -0.2))
    to, near = list(Pose.from_matrix(ARM.fkine(end))), list[float]()
    line = (to, 0.1, 1.0, 0.0, near, "", "", False, Op(), False)
    rehearsal = Rehearsal(ARM)
    for setting in ("enable_singularity_control", "disable_vibration_control"):
        rehearsal.command(TwinCommand(0.0, setting, (), True))
    rehearsal.begin(start, 0.0)
    assert rehearsal.command(TwinCommand(0.1, "movel", line, True)), rehearsal.blind


@for_each(
    "function, arguments",
    [
        ("set_load_data", ([0.5, 0.0, 0.0, 0.05],)),
        ("set_tool_data", ("gripper", [0.0] * 6, [0.5, 0.0, 0.0, 0.05], [0.0] * 6)),
    ],
)
def test_a_load_is_set(function: str, arguments: tuple[object, ...]) -> None:
    """It failed, unseen: what loads the simulator's physics had got another argument."""
    rehearsal = Rehearsal(ARM)
    rehearsal.begin(READY, 0.0)
    assert rehearsal._run is not None
    assert rehearsal._run.call(function, arguments), rehearsal._run.reason


def duration(rehearsal: Rehearsal) -> float:
    assert rehearsal.command(TwinCommand(1.0, *movej2(*THERE, v=0.3), True))
    time = 1.0
    while not rehearsal.idle:
        time += 0.1
        rehearsal.advance(time)
    return time - 1.0


@for_each(
    "function, arguments",
    [
        ("servoj", ([0.0] * 6, 1.0, 1.0, False, 200.0, 25.0, 0.1, 0.04)),
        ("run_program", ("pick", False)),
        ("teach_mode", (False,)),
        ("switch_mode", (0,)),
        ("log_error", ("the gripper is empty",)),
    ],
)
def test_other_ways_to_move_make_it_blind(function: str, arguments: tuple[object, ...]) -> None:
    rehearsal = Rehearsal(ARM)
    rehearsal.begin(READY, 0.0)
    assert rehearsal.command(TwinCommand(0.5, function, arguments, True)) is None
    assert function in rehearsal.blind
    assert rehearsal.match(READY) is None


def test_a_tool_of_the_pendant_is_not_known() -> None:
    rehearsal = Rehearsal(ARM)
    rehearsal.begin(READY, 0.0)
    at = list(Pose.from_matrix(ARM.fkine(READY)))
    line = (at, 0.2, 1.0, 0.0, list(READY), "gripper of the pendant", "", False, Op(), False)
    assert rehearsal.command(TwinCommand(0.5, "movel", line, True)) is False
    assert "movel cannot be rehearsed" in rehearsal.blind
