"""The same inputs give the same motion, bit for bit, on the fast clock."""

from __future__ import annotations

import math
from typing import Any

import pytest

from aioduco.sim import Simulator, assembly
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint

from .conftest import a_program, let_pass

FINISHED = 4
POSE = [0.492, 0.1945, 0.442, math.pi, 0.0, -math.pi / 2]
FAR = [5.0, 0.0, 0.0, 0.0, 0.0, 0.0]
LINE: tuple[Any, ...] = (0.5, 3.0, 0.02, [], "", "")
#: joint moves, a blend, an output on the way, a load, a line that nobody can follow
SCRIPT: list[list[Any]] = [
    ["movej2", [0.4, 0.2, 1.4, 0.1, -1.4, 0.3], 3.0, 15.0],
    ["movel", POSE, *LINE, False],
    ["movel", [POSE[0] + 0.05, *POSE[1:]], *LINE],
    ["set_standard_digital_out", 3, True],
    ["set_load_data", [2.0, 0.0, 0.02, 0.05]],
    ["speedj", [0.5, 0.0, 0.0, 0.0, 0.0, -0.5], 5.0, 200],
    ["movel", FAR, *LINE],
]


class Traced(World):
    """A world that notes each step: what was to be, and what came of it."""

    steps: list[bytes]

    def step(self, setpoint: JointSetPoint) -> None:
        super().step(setpoint)
        now = self.reading()
        parts = (setpoint.q, setpoint.qd, now.q, now.qd, now.qdd, now.torque, now.wrench)
        self.steps.append(b"".join(part.tobytes() for part in parts))


def traced(monkeypatch: pytest.MonkeyPatch) -> tuple[list[bytes], tuple[str, ...]]:
    """Every step that the arm makes, and the error list at the end."""
    steps: list[bytes] = []
    monkeypatch.setattr(Traced, "steps", steps, raising=False)
    monkeypatch.setattr(assembly, "World", Traced)
    with Simulator(speed=math.inf, programs={"all": SCRIPT}) as sim, a_program(sim) as program:
        still(sim)
        for call in (program.power_on, program.enable):
            assert call(True) == FINISHED
            still(sim)
        ends = program.run_program("all", True)
        still(sim)
        assert ends != FINISHED  # its last line cannot be followed
        assert sim.get_digital_output(3)
        return steps, sim.view.errors


def still(sim: Simulator) -> None:
    """Let the arm come to rest, so that the next call finds it as the one before left it.

    Calls come over the network, at whatever instant; nothing happens meanwhile where they come
    one after the other, each to an arm that rests.
    """
    sim.wait_until(lambda: not sim.moving)
    let_pass(sim, 0.4)


@pytest.mark.slow
def test_a_program_moves_the_arm_the_same_way_each_time(monkeypatch: pytest.MonkeyPatch) -> None:
    first, errors = traced(monkeypatch)
    again, errors_again = traced(monkeypatch)
    assert len(first) > 2000
    assert again == first
    assert errors_again == errors
    assert any("movel" in text for text in errors)
