"""Variations: each kind is drawn by its seed, whatever else is varied."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from aioduco.errors import ParameterError
from aioduco.kinematics import arm
from aioduco.sim import Simulator
from aioduco.sim.scene import Box
from aioduco.testing.preflight.variation import KINDS, Variation

from .trying import tried


def test_a_seed_makes_the_same_variation_whatever_else_is_varied() -> None:
    every = Variation.of(KINDS, 7)
    assert every == Variation.of(KINDS, 7) != Variation.of(KINDS, 8)
    for kind in KINDS:
        alone = Variation.of((kind,), 7)
        assert getattr(alone, kind) == getattr(every, kind)
        assert [one for one in KINDS if getattr(alone, one)] == [kind]
    assert Variation.of((), 7) == Variation(7)


def test_what_cannot_be_varied_is_refused() -> None:
    with pytest.raises(ParameterError, match='"start", "latency"'):
        Variation.of(("colour",), 0)


def test_a_start_stays_within_the_limits() -> None:
    limited = arm("gcr5_910")
    started = Variation.of(("start",), 3).started(limited.upper, limited)
    assert all(one <= most for one, most in zip(started, limited.upper, strict=True))


PICKS = """
import aioduco.sync
from aioduco.devices.grippers import DigitalGripper
from aioduco.kinematics import arm
from aioduco.models.gripper_models import gripper_model
from aioduco.sim import Simulator
from aioduco.sim.scene import Box, Table
from aioduco.sim.simulator import READY

frame = arm("gcr5_910").fkine(READY)
at = (frame[:3, 3] + gripper_model("parallel").length * frame[:3, 2]).tolist()
part = Box(at=at, size=(0.03, 0.03, 0.04), mass=0.3, name="part")
tray = Table(at=(*at[:2], at[2] - 0.02), size=(0.4, 0.4))
with Simulator(gripper="parallel", scene=[part, tray]) as sim:
    with aioduco.sync.connect(sim.host, sim.port) as robot:
        robot.bring_up()
        with aioduco.sync.Gripper(
            robot, DigitalGripper, 1, holds=1, opened=2, shut=3, travel_time=3.0, timeout=20.0
        ) as gripper:
            if not gripper.close().holding:
                raise SystemExit("nothing there")
"""


CELL = [
    Box(at=(0.5, 0.1, 0.03), size=(0.04, 0.04, 0.06), mass=0.3, name="near"),
    Box(at=(0.5, 0.2, 0.03), size=(0.04, 0.04, 0.06), mass=0.3, name="far"),
]


def test_a_fault_of_a_part_is_applied_to_the_cell() -> None:
    with Simulator(gripper="robotiq_2f85", scene=CELL, speed=math.inf) as sim:
        world = sim._running().world
        assert world.hand is not None
        pads = world.hand.pads
        friction = world.model.geom_friction[pads, 0].copy()

        def wrong(kind: str) -> None:
            Variation(parts=kind, part=0.7, extent=0.5).apply(sim)

        wrong("slipping")
        sim.wait_until(lambda: np.allclose(world.model.geom_friction[pads, 0], 0.5 * friction))
        wrong("heavy")
        sim.wait_until(lambda: sim.part_mass("far") == pytest.approx(1.3))
        wrong("worn")
        sim.wait_until(lambda: world.model.body_pos[world.tool_body, 2] == -0.0015)
        wrong("stuck")
        sim.wait_until(lambda: bool(world.data.eq_active.any()))
        wrong("missing")
        sim.wait_until(lambda: sim.where("far").pose.x > 900.0)
        assert sim.part_mass("near") == pytest.approx(0.3)
    for kind in ("slipping", "heavy", "worn", "stuck", "missing", "dropped"):
        with Simulator() as bare:
            Variation(parts=kind, part=0.7, extent=0.5).apply(bare)


@pytest.mark.slow
def test_a_program_that_trusts_its_part_is_found_out(tmp_path: Path) -> None:
    seed = next(n for n in range(100) if Variation.of(("parts",), n).parts == "missing")
    usual = tried(tmp_path, PICKS)
    assert usual.ok, usual.findings
    report = tried(tmp_path, PICKS, vary=("parts",), seed=seed)
    assert not report.ok
    assert "nothing there" in report.findings[0].text
