"""Faults of parts: dropped, missing, stuck together, slipping, heavier; and where a part is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from aioduco.errors import ParameterError
from aioduco.kinematics import arm
from aioduco.models.gripper_models import gripper_model
from aioduco.sim import Simulator
from aioduco.sim.console import Console
from aioduco.sim.physics.gripper import Hand
from aioduco.sim.physics.parts import PartPlace
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.scene import Box, Table, mjcf_of
from aioduco.sim.simulator import READY

GCR5 = arm("gcr5_910")
ZERO = np.zeros(6)


class Cell:
    """An arm with a gripper around a box, and another one on a table beside it."""

    def __init__(self, gripper: str = "robotiq_2f85", *, on: float = 0.0) -> None:
        model = gripper_model(gripper)
        tip = (GCR5.fkine(READY) @ np.array([0.0, 0.0, model.length, 1.0]))[:3]
        x, y, z = (float(part) for part in tip)
        low = z - on
        scene = [
            Box(at=(x, y, low), size=(0.04, 0.04, 0.06), mass=0.3, name="part"),
            Box(at=(x + 0.1, y, low), size=(0.04, 0.04, 0.06), mass=0.3, name="other"),
            Table(at=(x, y, low - 0.03), size=(0.4, 0.4), name="tray"),
        ]
        self.world = World(GCR5, 0.001, np.array(READY), scene=mjcf_of(scene), gripper=model)
        assert self.world.hand is not None
        self.hand = self.world.hand
        self.at = JointSetPoint(np.array(READY), ZERO, ZERO)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> bool:
        for _ in range(round(seconds * 1000)):
            self.world.step(self.at)
            if until():
                return True
        return False

    def where(self, name: str) -> PartPlace:
        return self.world.parts.where(name, self.world.positions)

    def grip(self) -> None:
        """Close the fingers, and lift what they hold."""
        self.hand.command((0.0,), 0.1, 60.0)
        assert self.run(2.0, lambda: self.hand.reading.caught == 1)
        self.run(0.1)
        frame = GCR5.fkine(READY)
        for _ in range(100):
            frame[2, 3] += 0.05 / 100
            self.at = JointSetPoint(GCR5.ikine(frame, self.at.q), ZERO, ZERO)
            self.run(0.01)
        self.run(0.2)


@pytest.fixture
def cell() -> Cell:
    return Cell()


@pytest.mark.slow
def test_where_a_part_is(cell: Cell) -> None:
    before = cell.where("part").pose.z
    cell.run(0.2)
    found = cell.where("part")
    assert (found.held, found.touches) == (False, ("tray",))
    cell.grip()
    found = cell.where("part")
    assert found.held
    assert "tray" not in found.touches
    assert found.pose.z == pytest.approx(before + 0.05, abs=0.01)
    with pytest.raises(ParameterError, match=r"one of the things that may move: \['other', 'part'"):
        cell.where("table")


@pytest.mark.slow
def test_a_dropped_part_falls_and_the_next_one_is_held(cell: Cell) -> None:
    cell.grip()
    cell.hand.drop(0.0)
    assert cell.run(2.0, lambda: cell.hand.reading.lost)
    cell.run(0.5)
    assert cell.where("part").touches == ("tray",)
    cell.hand.command((0.08,), 0.1, 60.0)
    cell.run(1.0)
    cell.at = JointSetPoint(np.array(READY), ZERO, ZERO)
    cell.world.parts.put("part", cell.where("other").pose)
    cell.world.parts.put("other", cell.where("part").pose.shifted(x=-0.1))
    cell.run(0.5)
    cell.grip()
    assert cell.where("other").held


def test_a_part_is_dropped_once_it_was_held_for_a_time(cell: Cell) -> None:
    cell.hand.drop(0.5)
    cell.hand.command((0.0,), 0.1, 60.0)
    assert cell.run(2.0, lambda: cell.hand.reading.caught == 1)
    begin = cell.world.data.time
    pads = cell.hand.pads
    assert cell.run(2.0, lambda: bool((cell.world.model.geom_friction[pads, 0] < 0.1).all()))
    assert cell.world.data.time - begin == pytest.approx(0.5, abs=0.01)


@pytest.mark.slow
def test_a_worse_grip_slips(cell: Cell) -> None:
    cell.hand.set_grip(0.02)
    cell.grip()
    assert not cell.where("part").held


@pytest.mark.parametrize("fault", [lambda hand: hand.drop(0.0), lambda hand: hand.set_grip(0.01)])
def test_a_cup_drops_and_slips(fault: Callable[[Hand], None]) -> None:
    cell = Cell("vacuum", on=0.03)
    cell.hand.command((0.0,), 0.0, 50.0)
    assert cell.run(1.0, lambda: cell.hand.reading.caught == 1)
    frame = GCR5.fkine(READY)
    frame[2, 3] += 0.05
    cell.at = JointSetPoint(GCR5.ikine(frame, READY), ZERO, ZERO)
    cell.run(0.5)
    assert cell.where("part").held
    fault(cell.hand)
    assert cell.run(1.0, lambda: cell.hand.reading.lost)
    cell.run(0.5)
    assert cell.where("part").touches == ("tray",)


@pytest.mark.slow
def test_two_stuck_parts_come_together(cell: Cell) -> None:
    cell.run(0.1)
    parts = cell.world.parts
    weld = parts.weld_of("part", "other")
    parts.stick(weld, stuck=True)
    low = cell.where("other").pose.z
    cell.grip()
    assert cell.where("other").pose.z > low + 0.02
    parts.stick(weld, stuck=False)
    cell.run(1.0)
    assert cell.where("other").touches == ("tray",)
    with pytest.raises(ParameterError, match="another thing"):
        parts.weld_of("part", "part")


def test_a_part_that_is_put_somewhere_sticks_as_it_lies_there(cell: Cell) -> None:
    parts = cell.world.parts
    there = cell.where("other").pose.shifted(z=0.06)
    parts.put("part", there)
    parts.stick(parts.weld_of("part", "other"), stuck=True)
    cell.run(0.2)
    found, below = cell.where("part").pose, cell.where("other").pose
    assert found[:3] == pytest.approx(there[:3], abs=5e-3)
    assert below[:2] == pytest.approx(there[:2], abs=5e-3)


@pytest.mark.slow
def test_a_heavier_part_weighs_more(cell: Cell) -> None:
    cell.world.parts.set_mass("part", 2.3)
    cell.run(0.1)
    free = cell.world.wrench[:3]
    cell.grip()
    gained = np.linalg.norm(cell.world.wrench[:3]) - np.linalg.norm(free)
    assert gained == pytest.approx(2.3 * 9.81, rel=0.1)


def test_a_worn_tool_is_shorter(cell: Cell) -> None:
    before = cell.world.data.geom("tool/left").xpos[2]
    cell.world.wear_tool(0.01)
    cell.run(0.01)
    assert cell.world.data.geom("tool/left").xpos[2] - before == pytest.approx(0.01, abs=1e-3)


def test_a_simulator_does_what_a_person_says() -> None:
    part = Box(at=(0.5, 0.1, 0.1), size=(0.04, 0.04, 0.06), mass=0.3, name="part")
    with Simulator(gripper="robotiq_2f85", scene=[part], speed=np.inf) as sim:
        console = Console(sim)
        assert console.answer("parts") == "part"
        sim.wait_until(lambda: sim.where("part").touches == ("the floor",))
        assert console.answer("put part 0.4 0.2 0.05") == "ok"
        sim.wait_until(lambda: abs(sim.where("part").pose.x - 0.4) < 1e-3)
        assert "not held; touches" in console.answer("where part")
        assert console.answer("remove part") == "ok"
        sim.wait_until(lambda: sim.where("part").pose.x > 999.0)
        assert (
            console.answer("drop-part") == "error: the gripper holds nothing: nothing was dropped"
        )
        assert console.answer("drop-part 0.5") == "ok"
        for line in ("grip 0.5", "mass part 2", "wear 0.01"):
            assert console.answer(line) == "ok"
        for line in (
            "grip 2",
            "mass part 0",
            "wear 1",
            "where tray",
            "stick part part",
            "put part 1",
        ):
            assert console.answer(line).startswith("error"), line
    with Simulator() as bare:
        for line in ("drop-part", "grip 1", "wear 0.001"):
            assert "there is no" in Console(bare).answer(line)
