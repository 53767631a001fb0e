"""Offsets, circles, spirals and splines over the wire, and what they trigger."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from aioduco._wire.rpc import Op, PointOp
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.sim.simulator import READY, Simulator
from aioduco.sim.snapshot import SimulationSnapshot

from .conftest import Program, advance_until, standing_time

END = (True, Op(), False)


def tip(robot: Program, sim: Simulator) -> Pose:
    sim.wait_until(lambda: not sim.moving)
    return Pose.of(robot.get_tcp_pose())


def near(pose: Pose, goal: Pose) -> bool:
    return pose.almost_equal(goal, position=1e-3, rotation=3e-3)


@pytest.mark.slow
def test_spirals_and_circles_of_no_known_kind_are_refused(sim: Simulator, robot: Program) -> None:
    start = tip(robot, sim)
    centre, end = list(start.shifted(x=-0.05)), list(start)
    for turns, mode in ((math.nan, 1), (2.0, 2)):
        wrong: Any = (centre, end, turns, 0.0, 0.0, mode, 0.1, 1.0, [], "", "", *END)
        assert robot.move_spiral(*wrong) == TaskState.PARAMETER_MISMATCH
    side, far = list(start.shifted(x=0.05, y=0.05)), list(start.shifted(x=0.1))
    circle: Any = (side, far, 0.1, 1.0, 0.0, 0, [], "", "", *END)
    assert robot.move_circle(*circle) == TaskState.PARAMETER_MISMATCH  # by no mode 0


@pytest.mark.slow
def test_splines_go_through_their_poses(sim: Simulator, robot: Program) -> None:
    start = tip(robot, sim)
    goals = [start.shifted(x=0.05 * i, z=-0.04 * (i % 2)) for i in range(1, 4)]
    plain = [list(goal) for goal in goals]
    spline = (0.1, 1.0, "", "", True, Op(), 0.0, False)
    assert robot.spline(plain, *spline) == TaskState.FINISHED
    assert near(tip(robot, sim), goals[-1])
    # One that begins where the arm is: the manual warns of two splines with a point in common.
    assert robot.spline(plain[::-1], *spline) == TaskState.PARAMETER_MISMATCH
    assert robot.spline([], *spline) == TaskState.PARAMETER_MISMATCH
    assert robot.spline(plain * 20, *spline) == TaskState.PARAMETER_MISMATCH
    # The warning is about two splines: behind another motion the first pose may be the present.
    assert robot.tcp_move([0, 0, 0.01, 0, 0, 0], 0.1, 1.0, 0.0, "", True, Op(), False) == 4
    here = [round(number, 4) for number in tip(robot, sim)]
    assert robot.spline([here, *plain[:1]], *spline) == TaskState.FINISHED
    assert near(tip(robot, sim), goals[0])
    assert robot.tcp_move([0, 0, 0.01, 0, 0, 0], 0.1, 1.0, 0.0, "", True, Op(), False) == 4
    assert robot.spline([list(tip(robot, sim))], *spline) == TaskState.FINISHED


@pytest.mark.parametrize("function", ["movel", "movec", "move_circle", "move_spiral", "spiral 2"])
def test_paths_end_in_the_branch_of_the_joints_given(
    sim: Simulator, robot: Program, function: str
) -> None:
    """`q_near` does not choose a solution here: it verifies the one to which the path leads."""
    start = tip(robot, sim)
    side, far = (list(start.shifted(x=x, z=z)) for x, z in ((0.02, 0.03), (0.04, 0.0)))
    centre = list(start.shifted(x=0.02))

    def move(q_near: list[float]) -> int:
        rest = (q_near, "", "", True, Op(), False)
        match function:
            case "movel":
                return robot.movel(far, 0.2, 1.0, 0.0, *rest)
            case "movec":
                return robot.movec(side, far, 0.2, 1.0, 0.0, 0, *rest)
            case "move_circle":
                return robot.move_circle(side, far, 0.2, 1.0, 0.0, 1, *rest)
            case "move_spiral":
                return robot.move_spiral(centre, centre, 0.5, 0.0, 0.02, 0, 0.2, 1.0, *rest)
        return robot.move_spiral(centre, far, 0.5, 0.0, 0.0, 1, 0.2, 1.0, *rest)

    end = Pose.of(far if function != "move_circle" else start)
    mirrored = sim.arm.ikine_all(end.matrix)
    own = sim.arm.ikine(end.matrix, sim.joints)
    others = [q for q in mirrored if np.abs(q - own).max() > 0.5]
    assert len(others) == len(mirrored) - 1
    for q in others:
        assert move(list(q)) == TaskState.PARAMETER_MISMATCH
        assert near(tip(robot, sim), start)
    assert "branch" in robot.get_last_error()[-1]
    assert move(list(own + 0.1)) == TaskState.FINISHED  # joints nearby, not those of the target


@pytest.mark.slow
def test_points_of_a_spline_trigger_as_they_are_passed(sim: Simulator, robot: Program) -> None:
    start = tip(robot, sim)
    goals = [start.shifted(x=0.05 * i, z=-0.04 * (i % 2)) for i in range(1, 4)]
    middle = Op(time_or_dist_1=1, trig_io_1=2, trig_value_1=True)
    operations = (Op(), middle, Op())
    points = [PointOp(list(goal), op) for goal, op in zip(goals, operations, strict=True)]
    with first_moment(sim, lambda _: sim.signals.standard_out[2]) as set_at:
        id_ = robot.spline_op(points, 0.05, 1.0, "", "", False, Op(), 0.0, False)
    assert way_of(sim, set_at[0], start) == pytest.approx(goals[1].distance(start)[0], abs=2e-3)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(id_) == TaskState.FINISHED, 60.0)


def test_how_far_motions_are_read_ahead_has_a_range(sim: Simulator, robot: Program) -> None:
    for num in (0, 7):  # without effect
        assert robot.set_blend_ahead(50, num) == TaskState.FINISHED
    assert robot.set_blend_ahead(0, 3) == TaskState.FINISHED
    assert robot.set_blend_ahead(101, 1) == TaskState.PARAMETER_MISMATCH
    assert robot.set_blend_ahead(0, 4) == TaskState.PARAMETER_MISMATCH
    assert sim._running().controller.read_ahead == (0, 3)


# -- triggers ------------------------------------------------------------------------------------


def line(robot: Program, op: Op, way: float = 0.1, v: float = 0.05, *, block: bool = True) -> int:
    return robot.tcp_move([0, 0, way, 0, 0, 0], v, 1.0, 0.0, "", block, op, False)


@contextlib.contextmanager
def first_moment(
    sim: Simulator, holds: Callable[[SimulationSnapshot], bool]
) -> Iterator[list[SimulationSnapshot]]:
    """The state after the first cycle with which something holds: in the list, once it does."""
    found: list[SimulationSnapshot] = []

    def look(snapshot: SimulationSnapshot, _: Any) -> None:
        if not found and holds(snapshot):
            found.append(snapshot)

    sim.observe(look)
    yield found
    sim.wait_until(lambda: bool(found), 60.0)
    sim.observe(None)


def way_of(sim: Simulator, snapshot: SimulationSnapshot, start: Pose) -> float:
    return Pose.from_matrix(sim.arm.fkine(snapshot.q)).distance(start)[0]


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("op", "way"),
    [
        ({"time_or_dist_1": 2, "trig_dist_1": 0.03, "trig_io_1": 5, "trig_value_1": True}, 0.03),
        ({"time_or_dist_1": 1, "trig_time_1": 1025, "trig_io_1": 5, "trig_value_1": True}, 0.05),
        ({"time_or_dist_2": 2, "trig_dist_2": 0.02, "trig_io_2": 5, "trig_value_2": True}, 0.08),
        ({"time_or_dist_2": 1, "trig_time_2": 425, "trig_io_2": 5, "trig_value_2": True}, 0.08),
    ],
)
def test_triggers_by_time_and_distance(
    sim: Simulator, robot: Program, op: dict[str, Any], way: float
) -> None:
    start = tip(robot, sim)
    with first_moment(sim, lambda _: sim.signals.standard_out[5]) as set_at:
        line(robot, Op(**op), block=False)
    assert way_of(sim, set_at[0], start) == pytest.approx(way, abs=1e-3)


@pytest.mark.slow
def test_a_trigger_after_the_end(sim: Simulator, robot: Program) -> None:
    op = Op(time_or_dist_2=1, trig_time_2=-500, trig_io_2=101, trig_value_2=True)
    last: list[float] = []  # time at which the set-points or the arm moved

    def is_set(snapshot: SimulationSnapshot) -> bool:
        if snapshot.setpoint.qd.any() or np.abs(snapshot.known.qd).max() > 2e-3:
            last.append(snapshot.time)
        return sim.signals.bool_out[1]

    with first_moment(sim, is_set) as set_at:
        assert line(robot, op, 0.02) == TaskState.FINISHED
    # The motion has ended once the arm stands, too, for 20 ms: in some places it swings for longer.
    # To the cycle: a difference of two times is 0.5 but for its last bit.
    assert 500 <= round((set_at[0].time - last[-1]) * 1000) < 540
    later = Op(time_or_dist_2=2, trig_dist_2=-0.01, trig_io_2=7, trig_value_2=True)
    assert line(robot, later, 0.02) == TaskState.FINISHED
    assert not robot.get_standard_digital_out(7)
    assert line(robot, Op(), -0.02) == TaskState.FINISHED
    assert robot.get_standard_digital_out(7)


def test_the_way_after_a_motion_is_that_of_its_own_tool(robot: Program) -> None:
    for name, length in (("long", 0.1), ("used", 0.0)):
        tip = [0.0, 0.0, length, 0.0, 0.0, 0.0]
        assert robot.set_tool_data(name, tip, [0.0] * 4, [0.0] * 6) == TaskState.FINISHED
    later = Op(time_or_dist_2=2, trig_dist_2=-0.01, trig_io_2=7, trig_value_2=True)
    for step, op, fired in (
        ([0.0, 0.0, -0.02, 0.0, 0.0, 0.0], later, False),
        ([0.0, 0.0, 0.0, 0.3, 0.0, 0.0], Op(), False),  # about the tip of "long"
        ([0.0, 0.0, -0.02, 0.0, 0.0, 0.0], Op(), True),
    ):
        done = robot.tcp_move(step, 0.5, 2.0, 0.0, "long", True, op, False)
        assert done == TaskState.FINISHED
        assert robot.get_standard_digital_out(7) is fired


@pytest.mark.usefixtures("real_cycle")
@pytest.mark.parametrize("how", ["pause", "stop", "abort"])
@pytest.mark.parametrize("late", [0.0, 20.0])
def test_a_trigger_at_a_pause_or_stop_counts_from_standstill(
    sim: Simulator, robot: Program, how: str, late: float
) -> None:
    fired: list[float] = []
    stood: list[float] = []
    op = Op(time_or_dist_3=1, trig_time_3=-late, trig_io_3=8, trig_value_3=True)

    def look(now: SimulationSnapshot, _: Any) -> None:
        stood.clear() if now.setpoint.qd.any() else stood.append(now.time)
        if sim.signals.standard_out[8]:
            fired.append(now.time)

    with standing_time(sim):
        line(robot, op, 0.2, block=False)
        advance_until(sim, robot.robotmoving)
        assert not robot.get_standard_digital_out(8)
        sim.observe(look)
        id_ = getattr(robot, how)(False)
    sim.wait_until(lambda: bool(fired))
    sim.observe(None)
    sim.wait_until(lambda: robot.get_noneblock_taskstate(id_) == TaskState.FINISHED)
    assert fired[0] - stood[0] == pytest.approx(late / 1000.0, abs=0.004)


def test_an_event_goes_before_an_output(sim: Simulator, robot: Program) -> None:
    fired: list[float] = []
    sim.signals.events["weld"] = lambda: fired.append(sim.time)
    op = Op(*(1, 3, True, 100.0, 0.0, "weld"), *(2, 4, True, 0.0, 0.01, "weld"))
    assert line(robot, op, 0.05) == TaskState.FINISHED
    assert len(fired) == 2
    assert not robot.get_standard_digital_out(3)
    assert not robot.get_standard_digital_out(4)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [3, 4])
def test_triggers_of_kinds_that_no_manual_names_are_passed_over(
    sim: Simulator, robot: Program, strict: Program, kind: int
) -> None:
    """The vendor's own demos send Op(3, ...) and Op(4, 1, false, ...)."""
    op = Op(time_or_dist_1=kind, trig_io_1=1, trig_value_1=True)
    assert line(robot, op, 0.02) == TaskState.FINISHED
    assert not robot.get_standard_digital_out(1)
    assert sim.forgiven == {"kind of a trigger": 1}
    assert line(strict, op, 0.02) == TaskState.PARAMETER_MISMATCH


def test_triggers_that_make_no_sense(strict: Program) -> None:
    assert line(strict, Op(time_or_dist_1=5)) == TaskState.PARAMETER_MISMATCH
    assert line(strict, Op(time_or_dist_1=1, trig_io_1=17)) == TaskState.PARAMETER_MISMATCH
    assert line(strict, Op(time_or_dist_1=1, trig_event_1="weld")) == TaskState.PARAMETER_MISMATCH
    nan = Op(time_or_dist_1=1, trig_io_1=1, trig_time_1=math.nan)
    assert line(strict, nan) == TaskState.PARAMETER_MISMATCH


@pytest.mark.slow
def test_a_trigger_by_distance_is_without_effect_on_a_joint_motion(robot: Program) -> None:
    op = Op(time_or_dist_1=2, trig_dist_1=0.01, trig_io_1=9, trig_value_1=True)
    assert robot.movej2([0.5, *READY[1:]], 1.0, 2.0, 0.0, True, op, False) == TaskState.FINISHED
    assert not robot.get_standard_digital_out(9)
    timed = Op(time_or_dist_1=1, trig_time_1=10, trig_io_1=9, trig_value_1=True)
    assert robot.movej2(READY, 1.0, 2.0, 0.0, True, timed, False) == TaskState.FINISHED
    assert robot.get_standard_digital_out(9)


@pytest.mark.slow
def test_a_trigger_later_than_the_motion_fires_at_its_end(robot: Program) -> None:
    for later in (
        {"time_or_dist_1": 1, "trig_time_1": 60_000},
        {"time_or_dist_1": 2, "trig_dist_1": 5.0},
    ):
        robot.set_standard_digital_out(9, False, True)
        assert line(robot, Op(**later, trig_io_1=9, trig_value_1=True), 0.02) == 4
        assert robot.get_standard_digital_out(9)
