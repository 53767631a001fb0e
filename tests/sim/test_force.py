"""Force control without physics: sensor, law, guard, conditions, tasks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from for_each import for_each
from numpy.typing import NDArray

from aioduco.kinematics import arm
from aioduco.models.enums import SafetyState, TaskState
from aioduco.models.pose import Pose
from aioduco.sim.controller.force_tasks import FC_MOVE
from aioduco.sim.controller.motion_queue import Following
from aioduco.sim.cycle import SensedState
from aioduco.sim.force.conditions import Condition, Conditions
from aioduco.sim.force.control import AdmittanceLaw, ForceControl, ForceGuard
from aioduco.sim.force.sensor import ForceAxes, ForceSensor
from aioduco.sim.planner.follower import StandingFollower
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.refusal import Rejected

from .fakes import CYCLE, HOME, Bench, leg

Vector = NDArray[np.float64]
FIVE = arm("gcr5_910")
READY = np.radians([0, 0, 90, 0, -90, 0])
DOWN = FIVE.fkine(READY)[:3, :3]
ZEROS = np.zeros(6)
X, Z, ALL, NONE = (
    tuple(flag == "1" for flag in text) for text in ("100000", "001000", "1" * 6, "0" * 6)
)
FLANGE = ForceAxes(np.eye(4), np.eye(4))
DAMPING = (1000.0,) * 3 + (57.0,) * 3
CAP = (0.05,) * 3 + (0.2,) * 3


def wrench(*force: float) -> Vector:
    return np.array([*force, *[0.0] * (6 - len(force))])


def law(direction: tuple[bool, ...] = Z, axes: ForceAxes = FLANGE, **other: Any) -> AdmittanceLaw:
    nothing = (0.0,) * 6
    usual = {"target": nothing, "damping": DAMPING, "cap": CAP, "band": nothing}
    return AdmittanceLaw(direction, axes=axes, **{**usual, **other})


class Arm:
    """Force control whose drives are where they are told to be."""

    def __init__(self, law: AdmittanceLaw | None, q: Vector = READY) -> None:
        self.control = ForceControl(FIVE, CYCLE)
        self.control.law = law
        self.rest = JointSetPoint.at_rest(q)
        self.control.start(self.rest)
        self.drives = self.rest
        self.points: list[JointSetPoint] = []
        self.time = 0.0

    def run(self, force: Vector, cycles: int, *, compliant: bool = True) -> Any:
        """Go on; what the last cycle came to."""
        outcome = None
        for _ in range(cycles):
            self.time += CYCLE
            sensed = SensedState(self.time, 0.0, self.drives.q, self.drives.qd, force, ZEROS)
            self.drives, outcome = self.control.tick(self.rest, sensed, compliant=compliant)
            self.points.append(self.drives)
            if outcome is not None:
                break
        return outcome

    @property
    def moved(self) -> Vector:
        """By what the flange was moved, in its frame at the start."""
        start = FIVE.fkine(self.rest.q)
        way: Vector = start[:3, :3].T @ (FIVE.fkine(self.drives.q)[:3, 3] - start[:3, 3])
        return way


# -- the sensor -------------------------------------------------------------------------------


def test_a_known_load_is_taken_out_in_every_orientation() -> None:
    sensor = ForceSensor().carrying(2.0, (0.0, 0.05, 0.1))
    for angles in ((0, 0, 90, 0, -90, 0), (10, 20, 60, 30, 40, 50)):
        turn = FIVE.fkine(np.radians(angles))[:3, :3]
        weight = turn.T @ [0.0, 0.0, -2.0 * 9.81]
        signal = np.concatenate([weight, np.cross([0.0, 0.05, 0.1], weight)])
        assert sensor.external(signal, turn) == pytest.approx([0.0] * 6, abs=1e-12)
        assert sensor.felt(signal) == pytest.approx(signal.tolist())
        push = sensor.external(signal + wrench(1, 2, 3, 4, 5, 6), turn)
        assert push == pytest.approx([1, 2, 3, 4, 5, 6])


def test_taring_sets_readings_and_takes_the_rest_for_a_force_from_outside() -> None:
    sensor = ForceSensor().carrying(1.0, (0.0, 0.0, 0.0))
    signal = wrench(3.0, -2.0, 25.0)
    tared = sensor.tared(signal, DOWN, Z, (0.0, 0.0, 5.0, 0.0, 0.0, 0.0))
    assert tared.reading(signal) == pytest.approx([3.0, -2.0, 5.0, 0.0, 0.0, 0.0])
    assert tared.external(signal, DOWN)[2] == pytest.approx(5.0)
    # Upside down the load weighs the other way round, which the reading shows, and force not.
    turned = signal - wrench(0.0, 0.0, 2 * 9.81)
    assert tared.reading(turned)[2] == pytest.approx(5.0 - 2 * 9.81)
    assert tared.external(turned, np.eye(3))[2] == pytest.approx(5.0)


def test_a_wrong_load_is_felt_as_a_force_once_the_hand_has_turned() -> None:
    heavy = ForceSensor().carrying(1.0, (0.0, 0.0, 0.0)).tared(wrench(0.0, 0.0, 2 * 9.81), DOWN)
    assert heavy.external(wrench(0.0, 0.0, 2 * 9.81), DOWN)[2] == pytest.approx(0.0)
    assert heavy.external(wrench(0.0, 0.0, -2 * 9.81), np.eye(3))[2] == pytest.approx(-2 * 9.81)


def test_forces_are_given_at_the_tip_and_along_the_axes() -> None:
    tip = Pose(0.0, 0.1, 0.2, 0.0, 0.0, math.pi / 2).matrix
    wobj = Pose(0.5, 0.5, 0.5, math.pi, 0.0, 0.0).matrix
    felt = [10.0, 20.0, 30.0, 0.0, 0.0, 0.0]
    about = np.cross([0.0, 0.1, 0.2], felt[:3])
    into = tip[:3, :3].T
    tool = ForceAxes(tip, wobj).seen(felt, DOWN)
    assert tool == pytest.approx([*into @ felt[:3], *into @ -about])
    into = wobj[:3, :3].T @ DOWN
    work = ForceAxes(tip, wobj, of_tool=False).seen(felt, DOWN)
    assert work == pytest.approx([*into @ felt[:3], *into @ -about])


# -- the law ----------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_speed_is_the_force_by_the_damping_up_to_the_cap() -> None:
    slow = Arm(law())
    slow.run(wrench(0, 0, 10.0), 500)
    before = slow.moved
    slow.run(wrench(0, 0, 10.0), 1000)
    assert slow.moved - before == pytest.approx([0.0, 0.0, 0.010], abs=1e-6)
    fast = Arm(law())
    fast.run(wrench(0, 0, -500.0), 500)
    before = fast.moved
    fast.run(wrench(0, 0, -500.0), 1000)
    assert fast.moved - before == pytest.approx([0.0, 0.0, -0.050], abs=1e-6)


def test_a_difference_from_the_target_within_the_dead_band_moves_nothing() -> None:
    target, band = (0.0, 0.0, -20.0, 0.0, 0.0, 0.0), (0.0, 0.0, 3.0, 0.0, 0.0, 0.0)
    within = Arm(law(target=target, band=band))
    within.run(wrench(0, 0, -17.5), 500)
    assert within.drives is within.rest
    within.run(wrench(0, 0, -16.5), 500)
    assert within.moved[2] > 0.001  # towards more force


def test_only_directions_that_are_on_give_way() -> None:
    still = Arm(law(X))
    still.run(wrench(0.0, 30.0, 30.0, 3.0, 3.0, 3.0), 200)
    assert still.drives is still.rest
    still.run(wrench(30.0, 30.0, 30.0, 3.0, 3.0, 3.0), 1000)
    assert still.moved == pytest.approx([still.moved[0], 0.0, 0.0], abs=1e-9)
    assert still.moved[0] > 0.02
    start, end = FIVE.fkine(still.rest.q), FIVE.fkine(still.drives.q)
    assert end[:3, :3] == pytest.approx(start[:3, :3], abs=1e-9)


@pytest.mark.slow
def test_a_torque_turns_the_tool_about_its_tip() -> None:
    tip = Pose(0.0, 0.0, 0.15, 0.0, 0.0, 0.0).matrix
    turning = Arm(law(ALL, ForceAxes(tip, np.eye(4))))
    turning.run(wrench(0.0, 0.0, 0.0, 0.0, 5.7, 0.0), 2000)
    start, end = FIVE.fkine(turning.rest.q) @ tip, FIVE.fkine(turning.drives.q) @ tip
    assert end[:3, 3] == pytest.approx(start[:3, 3], abs=1e-6)
    angle = Pose.from_matrix(np.linalg.inv(start) @ end).rotvec
    assert angle == pytest.approx([0.0, 0.1 * 2.0, 0.0], abs=0.003)


def test_directions_of_the_work_object_stay_where_they_are() -> None:
    wobj = Pose(0.0, 0.0, 0.0, 0.0, 0.0, math.pi / 4).matrix
    along = Arm(law(X, ForceAxes(np.eye(4), wobj, of_tool=False)))
    push = DOWN.T @ wobj[:3, :3] @ [20.0, 0.0, 0.0]
    along.run(wrench(*push), 1000)
    way = wobj[:3, :3].T @ DOWN @ along.moved
    assert way == pytest.approx([way[0], 0.0, 0.0], abs=1e-9)
    assert way[0] == pytest.approx(0.02, rel=0.02)


def test_set_points_are_smooth_and_fit_each_other() -> None:
    jerked = Arm(law(ALL))
    for force in (40.0, -40.0, 0.0):
        jerked.run(wrench(force, force, force, 0.05 * force, 0.0, 0.0), 150)
    jerked.run(ZEROS, 200, compliant=False)
    q = np.array([point.q for point in jerked.points])
    qd = np.array([point.qd for point in jerked.points])
    mean = (q[1:] - q[:-1]) / CYCLE
    assert np.abs(mean - 0.5 * (qd[1:] + qd[:-1])).max() < 0.01 * np.abs(qd).max()
    speeds = np.einsum("nij,nj->ni", FIVE.jacobian(q), qd)[:, :3]
    assert np.linalg.norm(np.diff(speeds, axis=0), axis=1).max() < 1.02 * 5.0 * CYCLE
    assert jerked.drives.qd == pytest.approx(ZEROS)
    assert not jerked.control.moving


def test_an_offset_is_carried_along_a_motion() -> None:
    pressed = Arm(law())
    pressed.run(wrench(0, 0, 20.0), 500)
    offset = pressed.moved
    speed = np.full(6, 0.05)
    for i in range(1, 400):
        pressed.rest = JointSetPoint(READY + speed * i * CYCLE, speed, ZEROS)
        pressed.run(ZEROS, 1)
    wanted, reached = FIVE.fkine(pressed.rest.q), FIVE.fkine(pressed.drives.q)
    # It stays where it is in the base, whatever the tool does; a little came as it faded.
    assert reached[:3, 3] - wanted[:3, 3] == pytest.approx(DOWN @ offset, abs=4e-4)
    assert reached[:3, :3] == pytest.approx(wanted[:3, :3], abs=1e-9)
    assert pressed.drives.qd == pytest.approx(speed, abs=0.02)


def test_joints_that_cannot_follow_slow_down_and_say_so() -> None:
    stretched = Arm(law(X, cap=(2.0,) * 6), np.radians([0, 30, 60, 0, -90, 0]))
    outcome = stretched.run(wrench(-5000.0), 5000)
    assert outcome.verdict == "failed"
    assert "force control" in outcome.message
    stretched.run(ZEROS, 2000)
    assert stretched.drives.qd == pytest.approx(ZEROS)
    speeds = np.abs([point.qd for point in stretched.points])
    assert (speeds <= 1.021 * np.array(FIVE.velocity)).all()
    steps = np.abs(np.diff([point.q for point in stretched.points], axis=0))
    assert (steps <= 1.03 * CYCLE * np.array(FIVE.velocity)).all()


# -- the guard --------------------------------------------------------------------------------


@for_each("force", [40.5, -40.5, math.nan])
def test_a_force_beyond_the_guard_is_told(force: float) -> None:
    guarded = Arm(law(NONE))
    guarded.control.guard = ForceGuard(Z, (10.0, 10.0, 40.0, 1.0, 1.0, 1.0), FLANGE)
    assert guarded.run(wrench(500.0, 500.0, math.copysign(39.5, force)), 5) is None
    outcome = guarded.run(wrench(0, 0, force), 1, compliant=False)
    assert outcome.verdict == "guard"
    assert "along z, but at most 40 N" in outcome.message


def test_the_guard_counts_the_load_or_not() -> None:
    for with_load, verdict in ((True, "guard"), (False, None)):
        carrying = Arm(law(NONE))
        carrying.control.sensor = ForceSensor().carrying(5.0, (0.0, 0.0, 0.0))
        carrying.control.guard = ForceGuard(Z, (40.0,) * 6, FLANGE, with_load)
        outcome = carrying.run(wrench(0, 0, 5.0 * 9.81), 3)
        assert (outcome and outcome.verdict) == verdict


# -- the conditions ---------------------------------------------------------------------------


class Clock:
    """Conditions, with the numbers that they look at."""

    def __init__(self, *logic: int) -> None:
        self.conditions = Conditions()
        self.values = {"pos": [0.0] * 6, "vel": [0.0] * 6, "ft": [0.0] * 6}
        self.logic = logic

    def set(self, what: Any, middle: float = 10.0, **other: Any) -> None:
        """On the first number, within 1; those left out are free."""
        values = {"absolute": True, "duration": 0.0, "timeout": 100.0, **other}
        spread = (1.0,) + (math.inf,) * 5
        self.conditions.set(what, Condition((middle,) + (0.0,) * 5, spread, **values))

    def begin(self, time: float = 0.0) -> None:
        self.conditions.begin(self.logic, time, lambda what: self.values[what])

    def at(self, time: float, **values: float) -> str | None:
        for what, value in values.items():
            self.values[what][0] = value
        return self.conditions.tick(time, lambda what: self.values[what])


def test_a_condition_holds_for_its_duration() -> None:
    clock = Clock(0, 0, 1)
    clock.set("ft", duration=0.1)
    clock.begin()
    assert clock.at(0.0, ft=9.5) is None
    assert clock.at(0.05, ft=10.5) is None
    assert clock.at(0.06, ft=12.0) is None  # it begins anew
    assert clock.at(0.10, ft=10.0) is None
    assert clock.at(0.199) is None
    assert clock.at(0.2) == "met"
    assert clock.at(0.3, ft=50.0) == "met"  # until fc_wait_logic
    clock.begin(0.3)
    assert clock.at(0.3) is None


@for_each("what", ["pos", "vel", "ft"])
def test_a_range_of_zero_takes_a_number_out_of_the_condition(what: Any) -> None:
    clock = Clock(*(1 if each == what else 0 for each in ("pos", "vel", "ft")))
    z_alone = (0.0, 0.0, 0.005, 0.0, 0.0, 0.0)
    middle = (0.0, 0.0, 0.05, 0.0, 0.0, 0.0)

    def wait(spread: tuple[float, ...]) -> None:
        condition = Condition(middle, spread, absolute=False, duration=0.0, timeout=9.0)
        clock.conditions.set(what, condition)
        clock.begin()

    wait(z_alone)
    clock.values[what] = [0.3, -0.2, 0.0, 0.1, 0.0, 0.4]  # far from the middle, but for z
    assert clock.at(0.1) is None
    clock.values[what][2] = 0.047
    assert clock.at(0.2) == "met"
    wait((0.0,) * 6)  # nothing counts, so nothing can hold
    assert clock.at(0.3) is None


def test_changes_count_from_the_beginning_and_angles_go_round() -> None:
    clock = Clock(1, 0, 0)
    clock.set("pos", 0.5, absolute=False)
    clock.values["pos"] = [2.0, 0.0, 0.0, 3.1, 0.0, 0.0]
    clock.conditions.set(
        "pos", Condition((0.5,) + (0.0,) * 5, (0.1,) * 6, absolute=False, duration=0.0, timeout=9.0)
    )
    clock.begin()
    assert clock.at(0.1) is None
    clock.values["pos"][3] = -3.1  # less than 0.1 further
    assert clock.at(0.2, pos=2.5) == "met"


@for_each(
    "logic, values, verdict",
    [
        ((1, 0, 1), {"pos": 10.0}, None),
        ((1, 0, 1), {"pos": 10.0, "ft": 10.0}, "met"),
        ((1, 0, 2), {"pos": 10.0}, "met"),
        ((1, 0, 2), {"ft": 10.0}, "met"),
        ((2, 2, 0), {"vel": 10.0}, "met"),
        ((1, 2, 1), {"pos": 10.0}, None),
        ((1, 2, 1), {"vel": 10.0}, "met"),
        ((0, 0, 0), {"pos": 10.0, "vel": 10.0, "ft": 10.0}, None),
    ],
)
def test_how_conditions_are_combined(
    logic: tuple[int, ...], values: dict[str, float], verdict: str | None
) -> None:
    clock = Clock(*logic)
    for what in ("pos", "vel", "ft"):
        clock.set(what)
    clock.begin()
    assert clock.at(1.0, **values) == verdict


def test_conditions_that_can_hold_no_more_are_late() -> None:
    clock = Clock(1, 0, 2)
    clock.set("pos", timeout=1.0)
    clock.set("ft", timeout=2.0)
    clock.begin(5.0)
    assert clock.at(6.0) is None
    assert clock.at(6.1) is None  # the force may still come
    assert clock.at(7.1) == "late"
    clock.begin(8.0)
    assert clock.at(8.9, pos=10.0) == "met"


def test_one_that_holds_as_its_time_ends_is_not_late() -> None:
    clock = Clock(1, 0, 1)
    clock.set("pos", timeout=1.0)
    clock.set("ft", timeout=3.0)
    clock.begin()
    assert clock.at(0.9, pos=10.0) is None
    assert clock.at(2.0) is None
    assert clock.at(2.5, ft=10.0) == "met"


def test_without_a_condition_nothing_is_looked_at() -> None:
    clock = Clock(0, 0, 1)
    clock.begin()
    assert clock.at(100.0) is None
    clock.set("ft")
    assert clock.at(100.0, ft=10.0) == "met"


# -- as tasks ---------------------------------------------------------------------------------


def started(direction: tuple[bool, ...] = Z) -> Bench:
    """A bench whose force control is on; its arm stands at zero, so that it gives way in none."""
    bench = Bench().enabled()
    bench.controller.force.control.law = law(NONE if direction == Z else direction)
    assert bench.ended(bench.controller.force.start()) == TaskState.FINISHED
    return bench


def fc_move(bench: Bench) -> int:
    following = Following.behind(FC_MOVE, lambda q: StandingFollower(FIVE, q, CYCLE))
    return bench.controller.follow(FC_MOVE, following)


def on_force(bench: Bench, timeout: float = 100.0) -> None:
    condition = Condition((10.0,) + (0.0,) * 5, (1.0,) * 6, True, 0.0, timeout)
    bench.controller.force.control.conditions.set("ft", condition)
    assert bench.ended(bench.controller.force.combine([0, 0, 1])) == TaskState.FINISHED


def test_fc_move_goes_on_until_it_is_stopped() -> None:
    bench = started()
    id_ = fc_move(bench)
    bench.tick(2000)
    assert bench.controller.tasks.state(id_) is TaskState.RUNNING
    assert bench.controller.moving
    assert bench.ended(bench.controller.stop()) == TaskState.FINISHED
    assert bench.controller.tasks.state(id_) is TaskState.STOPPED
    assert bench.controller.force.control.active


def test_conditions_end_the_motion_and_skip_those_behind_it() -> None:
    bench = started()
    on_force(bench)
    first, second = fc_move(bench), bench.controller.move("movej2", leg(0.1))
    bench.tick(50)
    bench.wrench = wrench(10.0)
    assert bench.ended(first) == TaskState.FINISHED
    assert bench.ended(second) == TaskState.INTERRUPT
    assert bench.ended(bench.controller.move("movej2", leg(0.1))) == TaskState.INTERRUPT
    assert bench.q == pytest.approx(HOME)
    bench.wrench = ZEROS
    on_force(bench)
    assert bench.ended(bench.controller.move("movej2", leg(0.1))) == TaskState.FINISHED


def test_a_motion_with_a_path_is_interrupted_by_the_conditions() -> None:
    bench = started()
    on_force(bench)
    id_ = bench.controller.move("movej2", leg(0.1, 1000))
    bench.tick(100)
    bench.wrench = wrench(10.0)
    assert bench.ended(id_) == TaskState.INTERRUPT
    assert 0.0 < bench.q[0] < 0.05


def test_conditions_that_time_out_end_the_motion_with_an_error() -> None:
    bench = started()
    on_force(bench, timeout=0.5)
    id_ = fc_move(bench)
    assert bench.ended(id_) == TaskState.ERROR
    assert bench.time < 2.0
    assert any("in time" in error for error in bench.controller.view().errors)
    assert bench.ended(fc_move(bench)) == TaskState.ERROR
    assert bench.ended(bench.controller.force.stop()) == TaskState.FINISHED
    assert bench.ended(bench.controller.move("movej2", leg(0.1))) == TaskState.FINISHED


def test_what_held_before_the_motion_counts_from_its_beginning() -> None:
    bench = started()
    condition = Condition((0.0,) * 6, (1.0,) * 6, True, 0.2, 100.0)
    bench.controller.force.control.conditions.set("ft", condition)
    bench.controller.force.combine([0, 0, 1])
    bench.tick(500)
    before = bench.time
    assert bench.ended(fc_move(bench)) == TaskState.FINISHED
    assert bench.time - before >= 0.2


def test_fc_stop_while_a_motion_runs_is_a_fault() -> None:
    bench = started()
    motion = bench.controller.move("movej2", leg(0.1, 1000))
    bench.tick(100)
    assert bench.ended(bench.controller.force.stop()) == TaskState.ERROR
    assert bench.ended(motion) == TaskState.ERROR
    bench.tick(10)
    assert bench.controller.safety is SafetyState.STOP2
    assert not bench.controller.force.control.active
    assert any("fc_stop" in error for error in bench.controller.view().errors)


def test_without_power_force_control_is_off() -> None:
    bench = started()
    bench.power("disable").tick()
    assert not bench.controller.force.control.active
    bench.enabled()
    assert not bench.controller.view().force_control


def test_the_sensor_is_tared_as_the_arm_is_enabled() -> None:
    bench = Bench()
    bench.wrench = wrench(1.0, 2.0, 3.0)
    bench.enabled()
    assert bench.controller.view().sensor.reading(bench.wrench) == pytest.approx([0.0] * 6)


def test_the_emergency_stop_of_the_guard_cuts_the_power() -> None:
    bench = started()
    id_ = fc_move(bench)
    bench.controller.force.control.guard = ForceGuard(Z, (40.0,) * 6, FLANGE)
    bench.tick(10)
    bench.wrench = wrench(0.0, 0.0, 41.0)
    bench.tick()
    assert bench.drive is not None
    assert bench.drive.brake
    assert bench.controller.safety is SafetyState.STOP0
    assert bench.ended(id_) == TaskState.ERROR
    bench.tick()
    assert not bench.controller.force.control.active


def test_what_comes_while_force_control_ends_waits() -> None:
    bench = started()
    ending = bench.controller.force.stop()
    after = bench.controller.move("movej2", leg(0.1))
    assert bench.controller.tasks.state(after) is TaskState.IDLE
    with pytest.raises(Rejected, match="under way"):
        bench.controller.force.start()
    assert bench.ended(ending) == TaskState.FINISHED
    assert bench.ended(after) == TaskState.FINISHED
    assert bench.ended(bench.controller.force.stop()) == TaskState.FINISHED


def test_the_sensor_is_tared_also_without_power() -> None:
    bench = Bench()
    bench.wrench = wrench(1.0, 2.0, 3.0)
    bench.tick()
    force = bench.controller.force
    assert bench.ended(force.tare(ALL, (0.0,) * 6)) == TaskState.FINISHED
    assert force.control.sensor.reading(bench.wrench) == pytest.approx([0.0] * 6)
