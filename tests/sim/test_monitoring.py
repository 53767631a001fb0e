"""What the controller watches in each cycle: short ways to an answer give that of the long one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aioduco.kinematics import arm
from aioduco.kinematics.forward import frames
from aioduco.models.enums import OperationMode
from aioduco.sim.controller.monitoring import LEVELS, CollisionDetector, Standstill
from aioduco.sim.controller.state_machine import DEVIATION, _deviation
from aioduco.sim.cycle import SensedState

from .fakes import Bench, leg

SIX = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(np.array)
SCALE = st.sampled_from([1e-3, 2e-3, 5e-3, 0.05, 0.1, 0.2, 0.3, 1.0, 50.0])
EFFORT = np.array([100.0, 80.0, 60.0, 20.0, 15.0, 10.0])


@given(direction=SIX, scale=SCALE)
def test_whether_the_arm_turns_is_told_by_its_fastest_joint(
    direction: np.ndarray, scale: float
) -> None:
    speeds, none = direction * scale, np.zeros(6)
    watch = Standstill()
    still = watch.tick(SensedState(1.0, 0.0, none, speeds, none, none), commanded=True)
    fastest = np.abs(speeds).max()
    assert watch.turning == (fastest > 0.1)
    assert still == (fastest <= 2e-3)


@given(direction=SIX, scale=SCALE, level=st.sampled_from([1, 2, 3, 4, 5]))
def test_a_collision_is_at_the_joint_with_the_largest_share(
    direction: np.ndarray, scale: float, level: int
) -> None:
    watch = CollisionDetector(EFFORT)
    watch.level = level
    watch.update(0.0, np.zeros(6))
    found = watch.update(1e6, direction * scale)  # so late that nothing of before is left
    shares = np.abs(watch.torque) / EFFORT
    assert found == (int(shares.argmax()) + 1 if shares.max() > LEVELS[level] else 0)


@given(direction=SIX, scale=SCALE)
def test_a_deviation_is_that_of_one_joint(direction: np.ndarray, scale: float) -> None:
    away = direction * scale
    told = _deviation(away, np.zeros(6))
    if np.abs(away).max() > DEVIATION:
        assert told == f"joint {int(np.abs(away).argmax()) + 1}: position deviation"
    else:
        assert told == ""


def test_a_deviation_that_is_no_number_is_one() -> None:
    q = np.zeros(6)
    q[3] = np.nan
    assert _deviation(q, np.zeros(6)) == "joint 4: position deviation"


def test_frames_of_one_configuration_are_those_of_many() -> None:
    geometry = arm("gcr5_910").geometry
    many = np.random.default_rng(1).uniform(-6.0, 6.0, (50, 6))
    each = np.array([frames(geometry, q) for q in many])
    np.testing.assert_allclose(each, frames(geometry, many), atol=1e-15)


def test_a_view_is_the_same_while_nothing_changes_and_a_new_one_when_something_does() -> None:
    bench = Bench().enabled()
    controller = bench.controller
    bench.tick(600)  # until it counts as standing
    before = controller.view()
    bench.tick(5)
    assert controller.view() is before

    controller.set_speed(40.0)
    assert controller.view().speed == 40.0
    controller.note_error("strange")
    assert controller.view().errors == ("strange",)
    controller.switch_mode(OperationMode.MANUAL)
    assert controller.view().mode is OperationMode.MANUAL
    controller.switch_mode(OperationMode.AUTO)
    assert before.speed == 100.0
    assert before.errors == ()

    id_ = controller.move("movej2", leg(0.1))
    moving = controller.view()
    assert moving.moving
    assert not moving.standing
    assert bench.ended(id_) == 4
    bench.tick(600)
    assert controller.view()._replace(speed=100.0, errors=()) == before

    controller.press_emergency_stop()
    pressed = controller.view()
    assert pressed.emergency_stop
    assert pressed.error == 1
    for number in range(25):
        controller.note_error(str(number))
    assert controller.view().errors == tuple(map(str, range(5, 25)))
