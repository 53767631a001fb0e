"""A profile as a file, and how a simulator plays it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from for_each import for_each

from aioduco._wire.rpc import Op
from aioduco.errors import ParameterError
from aioduco.models.enums import RobotState
from aioduco.models.pose import Pose
from aioduco.sim import ArmProfile, Estimate, Simulator
from sim.conftest import Connect, Started, advance_until, standing_time

from .made import READY, exact, hidden_geometry

GOOD = """
model = "gcr5_910"
single_precision = true

[geometry]
d2 = { value = 0.1411, low = 0.1410, high = 0.1412 }
theta3 = 0.002

[times]
enable = 0.7
"""


def profile_file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_is_read_and_written_alike(tmp_path: Path) -> None:
    profile = ArmProfile.load(profile_file(tmp_path, GOOD))
    assert profile.values["geometry"]["d2"] == Estimate(0.1411, 0.1410, 0.1412)
    assert profile.value("times", "enable", 0.3) == 0.7
    assert profile.value("times", "disable", 0.1) == 0.1
    profile.save(tmp_path / "again.toml")
    assert ArmProfile.load(tmp_path / "again.toml") == profile


@for_each(
    "old, new, line, what",
    [
        ('"gcr5_910"', '"ur5e"', 2, "model is 'ur5e', but must be one of gcr3_618"),
        ("single_precision = true", "single_precision = 1", 3, "true or false"),
        ("d2 =", "d7 =", 6, "one of a1"),
        ("value = 0.1411", "value = 0.2411", 6, "geometry.d2 is 0.2411, but must be from 0.1305"),
        ("low = 0.1410", "low = 0.2", 6, "in order: low, value, high"),
        ("low =", "least =", 6, "a table with value, low and high"),
        ("theta3 = 0.002", 'theta3 = "much"', 7, "a finite number"),
        ("enable = 0.7", "enable = -1", 10, "from 0 to 60 s"),
        ("[times]", "[time]", 9, "one of model, sources"),
        ("[times]", "[time]", 9, ": did you mean 'times'?"),
        ("enable =", "enabel =", 10, ": did you mean 'enable'?"),
        ("enable = 0.7", "enable = true", 10, "a finite number"),
        ("enable = 0.7", "enable =", 10, "line 10"),
    ],
)
def test_errors_have_the_file_and_the_line(
    tmp_path: Path, old: str, new: str, line: int, what: str
) -> None:
    assert old in GOOD
    path = profile_file(tmp_path, GOOD.replace(old, new))
    with pytest.raises(ParameterError) as caught:
        ArmProfile.load(path)
    assert "arm.toml" in str(caught.value)
    assert f"line {line}" in str(caught.value)
    assert what in str(caught.value)


def test_a_gain_that_contradicts_the_lag_is_refused(tmp_path: Path) -> None:
    text = 'model = "gcr5_910"\n[drives]\nlag2 = 0.02\ngain2 = 60\n'
    with pytest.raises(ParameterError, match=r"line 4: drives\.gain2 is 60.0.*at most 1/lag2"):
        ArmProfile.load(profile_file(tmp_path, text))


def test_a_simulator_takes_no_profile_of_another_model(tmp_path: Path) -> None:
    path = profile_file(tmp_path, GOOD)
    with pytest.raises(ParameterError, match="that of the profile, gcr5_910"):
        Simulator("gcr7_910", profile=path)
    with pytest.raises(ParameterError, match="a readable TOML file"):
        Simulator(profile=tmp_path / "missing.toml")


def test_poses_are_those_of_the_profiles_table_and_lines_lead_to_them(started: Started) -> None:
    profile = hidden_geometry(np.random.default_rng(1))
    arm = profile.arm
    sim, wire = started(profile=profile, joints=READY, speed=20)
    here = Pose(*wire.get_flange_pose())
    assert here.matrix == pytest.approx(arm.fkine(READY), abs=1e-6)
    goal = Pose(here.x, here.y + 0.05, here.z - 0.03, *here[3:])
    answer = wire.movel(list(goal), 0.3, 1.0, 0.0, [], "", "", True, Op(), False)
    assert answer == 4

    def is_there() -> bool:
        reached = Pose(*wire.get_flange_pose())
        return reached.almost_equal(goal, position=1e-6, rotation=1e-5)

    sim.wait_until(is_there)  # the arm still settles when its task has ended


def test_solutions_of_a_corrected_arm_reach_the_pose() -> None:
    random = np.random.default_rng(2)
    arm = hidden_geometry(random).arm
    for _ in range(20):
        q = READY + random.uniform(-0.4, 0.4, 6)
        flange = arm.fkine(q)
        assert arm.ikine(flange, q) == pytest.approx(q, abs=1e-7)
        for solution in arm.ikine_all(flange):
            assert arm.fkine(solution) == pytest.approx(flange, abs=1e-8)


def test_times_lag_load_and_friction_are_played(connect: Connect) -> None:
    six = range(1, 7)
    profile = ArmProfile(
        "gcr5_910",
        {
            "drives": {f"lag{i}": exact(0.02) for i in six},
            "times": {"power_on": exact(0.9)},
            "load": {"mass": exact(2.0), "z": exact(0.05)},
            "friction": {"dry1": exact(3.0), "viscous1": exact(5.0)},
        },
    )
    with Simulator(profile=profile, joints=READY, speed=math.inf) as sim:
        wire = connect(sim)
        with standing_time(sim):
            begin = sim.time
            wire.power_on(False)
            advance_until(sim, lambda: wire.get_robot_state()[0] == RobotState.DISABLE)
            assert 0.9 <= sim.time - begin < 1.0
        wire.enable(True)
        goal = READY.copy()
        goal[0] += 1.0
        with standing_time(sim):
            wire.movej2(goal.tolist(), 0.5, 5.0, 0.0, False, Op(), False)
            advance_until(sim, lambda: sim.joints[0] > READY[0] + 0.4)
            status = wire.getRobotStatus()
            trailing = status.jointExpectPosition[0] - status.jointActualPosition[0]
            assert trailing == pytest.approx(0.5 * 0.02, rel=0.02)
            assert wire.get_actual_joints_torque()[0] == pytest.approx(3.0 + 0.5 * 5.0, abs=0.3)


@pytest.mark.parametrize("read", ["get_actual_joints_position", "get_flange_pose"])
def test_readings_are_updated_in_the_profiles_period(started: Started, read: str) -> None:
    profile = ArmProfile("gcr5_910", {"readings": {"period": exact(0.4)}})
    sim, wire = started(profile=profile, joints=READY)
    with standing_time(sim):
        wire.movej2((READY + 0.5).tolist(), 0.2, 1.0, 0.0, False, Op(), False)
        advance_until(sim, lambda: sim.joints[0] > READY[0] + 0.05)
        values = []
        for _ in range(50):
            values.append(tuple(getattr(wire, read)()))
            sim.advance(1)
    assert len(set(values)) <= 2  # those of one period have one value, though the arm moves
