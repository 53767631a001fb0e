"""What the controller answers to commands, cycle by cycle, without a clock."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from for_each import for_each

from aioduco.models.enums import OperationMode, SafetyState, TaskState
from aioduco.sim.cabinet.axis_schemes import Axis, SimulatedExternalAxes
from aioduco.sim.controller.motion_queue import CAPACITY
from aioduco.sim.controller.motion_settings import OptimizationSwitches

from .fakes import CYCLE, Bench, FakeMover, FakeRun, impossible, leg


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def ready() -> Bench:
    return Bench().enabled()


def state(bench: Bench, id_: int) -> TaskState:
    return bench.controller.tasks.state(id_)


# -- power ---------------------------------------------------------------------------------------


def test_power_on_and_enable_go_through_the_states_of_the_manual(bench: Bench) -> None:
    seen = [bench.state]
    for name in ("power_on", "enable"):
        id_ = bench.controller.power.request(name)
        assert bench.ended(id_) == 4
        seen.append(bench.state)
    assert seen == [[4, 0, 4, 1], [5, 0, 5, 1], [6, 0, 5, 1]]


def test_changes_wait_for_each_other(bench: Bench) -> None:
    ids = [bench.controller.power.request(name) for name in ("power_on", "enable", "disable")]
    assert [bench.ended(id_) for id_ in ids] == [4, 4, 4]
    assert bench.state == [5, 0, 5, 1]


def test_what_is_done_already_is_finished_at_once(ready: Bench) -> None:
    begin = ready.cycle
    ready.power("power_on", "enable")
    assert ready.cycle - begin < 5
    assert ready.state == [6, 0, 5, 1]


@pytest.mark.parametrize("name", ["enable", "disable"])
def test_without_power_there_is_nothing_to_enable(bench: Bench, name: str) -> None:
    assert bench.ended(bench.controller.power.request(name)) == 7


def test_the_brakes_are_on_until_the_robot_is_enabled(bench: Bench) -> None:
    bench.controller.power.request("power_on")
    id_ = bench.controller.power.request("enable")
    brakes = []

    def note() -> bool:
        brakes.append(bench.drive is None or bench.drive.brake)
        return state(bench, id_).ended

    bench.until(note)
    assert all(brakes[:-1])
    bench.tick()
    assert bench.drive is not None
    assert not bench.drive.brake


def test_disable_stops_what_moves_before_the_brakes_fall(ready: Bench) -> None:
    move = ready.controller.move("movej2", leg(1.0, 1000))
    ready.tick(100)
    disable = ready.controller.power.request("disable")
    ready.until(lambda: state(ready, move).ended)
    assert state(ready, move) is TaskState.STOPPED
    assert ready.state[0] == 6
    assert ready.ended(disable) == 4
    assert ready.state == [5, 0, 5, 1]
    assert ready.drive is not None
    assert ready.drive.brake


def test_shutdown_halts_without_power(ready: Bench) -> None:
    id_ = ready.controller.power.request("shutdown")
    ready.tick(10)
    halted = [ready.controller.halted]
    assert ready.ended(id_) == 4
    halted.append(ready.controller.halted)
    assert halted == [False, True]
    assert ready.state[0] == 4


@pytest.mark.usefixtures("real_power")
def test_how_long_changes_of_power_take(bench: Bench) -> None:
    times = {}
    for name in ("power_on", "enable", "disable", "power_off", "restart"):
        begin = bench.time
        assert bench.ended(bench.controller.power.request(name)) == 4
        times[name] = bench.time - begin
    usual = {"power_on": 0.5, "enable": 0.3, "disable": 0.1, "power_off": 0.2, "restart": 1.7}
    assert times == pytest.approx(usual, abs=0.005)


def test_restart_starts_and_initialises_and_ends_without_power(ready: Bench) -> None:
    id_ = ready.controller.power.request("restart")
    seen: list[int] = []

    def note() -> bool:
        if ready.state[0] not in seen:
            seen.append(ready.state[0])
        return state(ready, id_).ended

    ready.until(note)
    assert seen == [6, 4, 0, 1]
    assert ready.state == [4, 0, 4, 1]


def test_vibration_control_is_on_when_the_controller_has_started(ready: Bench) -> None:
    other = OptimizationSwitches(speed=True, vibration=False)
    ready.controller.optimization = other
    ready.power("power_off")
    assert ready.controller.optimization == other
    ready.power("restart")
    assert ready.controller.optimization == OptimizationSwitches()


# -- motions -------------------------------------------------------------------------------------


@pytest.mark.parametrize("power", [[], ["power_on"], ["power_on", "enable", "disable"]])
def test_a_motion_of_a_robot_that_is_not_enabled_is_illegal(bench: Bench, power: list[str]) -> None:
    bench.power(*power)
    id_ = bench.controller.move("movej2", leg(1.0))
    assert state(bench, id_) is TaskState.ILLEGAL
    assert "not enabled" in bench.controller.view().errors[-1]


def test_motions_run_one_after_the_other(ready: Bench) -> None:
    first = ready.controller.move("movej2", leg(1.0))
    second = ready.controller.move("movej2", leg(2.0))
    ready.tick(5)
    assert (state(ready, first), state(ready, second)) == (TaskState.RUNNING, TaskState.IDLE)
    assert ready.state == [6, 2, 5, 1]
    assert ready.ended(first) == 4
    assert ready.q[0] == pytest.approx(1.0)
    assert ready.ended(second) == 4
    assert ready.q[0] == pytest.approx(2.0)
    assert ready.state == [6, 0, 5, 1]


def test_who_waits_for_a_motion_that_may_blend_is_answered_in_time(ready: Bench) -> None:
    """Not at its end: only then the motion comes with which it blends."""
    controller = ready.controller
    tasks = controller.tasks

    def move(*, blends: bool = True) -> int:
        return controller.move("movel", leg(1.0, 10, blends=blends))

    controller.read_ahead = 50, 1
    first = move()
    ready.until(lambda: tasks.answer(first).ended)
    assert (tasks.answer(first), state(ready, first)) == (TaskState.INTERRUPT, TaskState.RUNNING)
    assert controller.motion.mover.progress == pytest.approx(0.5)
    second = move(blends=False)
    assert (ready.ended(first), ready.ended(second)) == (5, 4)
    assert tasks.answer(second) is TaskState.FINISHED
    # The controller cannot know whether another motion will come.
    alone = move()
    ready.until(lambda: tasks.answer(alone).ended)
    assert (tasks.answer(alone), state(ready, alone)) == (TaskState.INTERRUPT, TaskState.RUNNING)
    assert ready.ended(alone) == 4
    # By number: as many as that are known to the controller, the running one included.
    controller.read_ahead = 0, 1
    row = [move() for _ in range(3)]
    ready.tick(2)
    assert [tasks.answer(id_).ended for id_ in row] == [True, False, False]
    ready.until(lambda: tasks.answer(row[1]).ended)
    assert state(ready, row[0]) is TaskState.INTERRUPT
    assert state(ready, row[1]) is TaskState.RUNNING


def test_who_waits_for_a_motion_that_is_stopped_or_paused_is_told_so(ready: Bench) -> None:
    controller = ready.controller
    controller.read_ahead = 50, 1
    id_ = controller.move("movel", leg(1.0, 10, blends=True))
    ready.tick(4)
    controller.pause()
    ready.tick(20)
    assert controller.tasks.answer(id_) is TaskState.PAUSED
    controller.stop()
    assert ready.ended(id_) == 3
    assert controller.tasks.answer(id_) is TaskState.STOPPED


@pytest.mark.parametrize(
    ("code", "ends"), [("unreachable", 6), ("singular", 6), ("limits", 6), ("parameter", 8)]
)
def test_a_motion_that_cannot_be_planned_says_why(ready: Bench, code: str, ends: int) -> None:
    id_ = ready.controller.move("movel", impossible(code))
    assert int(state(ready, id_)) == ends
    assert ready.controller.view().errors[-1] == "out of reach"
    ready.tick()
    assert ready.state == [6, 0, 5, 1]


def test_motions_behind_one_that_cannot_be_planned_are_dropped(ready: Bench) -> None:
    runs = ready.controller.move("movej2", leg(1.0, 50))
    fails = ready.controller.move("movel", impossible())
    behind = [ready.controller.move("movej2", leg(3.0)) for _ in range(2)]
    assert ready.ended(runs) == 4
    assert ready.ended(fails) == 6
    assert [int(state(ready, id_)) for id_ in behind] == [5, 5]
    ready.tick(100)
    assert ready.q[0] == pytest.approx(1.0)
    assert ready.ended(ready.controller.move("movej2", leg(2.0))) == 4


def test_a_full_queue_takes_no_more(ready: Bench) -> None:
    ids = [ready.controller.move("movej2", leg(1.0, 1000)) for _ in range(CAPACITY + 1)]
    assert state(ready, ids[-2]) is TaskState.IDLE
    assert state(ready, ids[-1]) is TaskState.ILLEGAL


# -- stop, abort, pause, resume ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("how", "count", "ends"),
    [
        ("stop", 1, TaskState.STOPPED),
        ("stop", 3, TaskState.STOPPED),
        ("abort", 2, TaskState.INTERRUPT),
    ],
)
def test_all_motions_end_when_the_arm_stands(
    ready: Bench, how: str, count: int, ends: TaskState
) -> None:
    ids = [ready.controller.move("movej2", leg(1.0, 1000)) for _ in range(count)]
    ready.tick(10)
    stop = getattr(ready.controller, how)()
    assert ready.state == [6, 1, 5, 1]
    assert state(ready, stop) is TaskState.RUNNING
    assert not any(state(ready, id_).ended for id_ in ids)
    assert ready.ended(stop) == 4
    assert [state(ready, id_) for id_ in ids] == [ends] * count
    assert ready.state == [6, 0, 5, 1]


def test_stop_is_accepted_in_every_state(bench: Bench) -> None:
    def stops() -> None:
        assert bench.ended(bench.controller.stop()) == 4

    stops()
    bench.controller.press_emergency_stop()
    stops()
    bench.controller.release_emergency_stop()
    bench.controller.power.request("power_off")
    for name in ("power_on", "enable"):
        id_ = bench.controller.power.request(name)
        bench.tick(10)
        stops()
        assert bench.ended(id_) == 4
    stops()
    bench.controller.move("movej2", leg(1.0, 100))
    bench.controller.pause()
    stops()
    bench.controller.collide(1)
    stops()


def test_stop_drops_the_changes_of_power_that_wait(bench: Bench) -> None:
    on, enable = (bench.controller.power.request(name) for name in ("power_on", "enable"))
    bench.tick()
    bench.controller.stop()
    assert state(bench, enable) is TaskState.STOPPED
    assert bench.ended(on) == 4
    assert bench.state[0] == 5


@pytest.mark.parametrize("how", ["stop", "abort"])
def test_a_motion_after_a_stop_waits_until_the_arm_stands(ready: Bench, how: str) -> None:
    first = ready.begun()
    stop = getattr(ready.controller, how)()
    after, last = (ready.controller.move("movej2", leg(joint)) for joint in (1.0, 2.0))
    assert ready.controller.busy
    while not ready.controller.tasks.state(stop).ended:
        assert state(ready, after) is TaskState.IDLE
        ready.tick()
    assert ready.controller.tasks.state(first).ended
    assert (ready.ended(after), ready.ended(last)) == (4, 4)
    assert ready.q[0] == 2.0
    assert ready.controller.idle


def test_what_comes_as_a_stop_ends_is_behind_the_motions_that_wait(ready: Bench) -> None:
    """Between the stop's last cycle and the next one, in which they begin."""
    ready.begun()
    stop = ready.controller.stop()
    after = ready.controller.move("movej2", leg(1.0))
    assert ready.ended(stop) == 4
    last = ready.controller.move("movej2", leg(2.0))
    run: Any = FakeRun(ready.controller, 3)
    assert state(ready, ready.controller.run_program(run)) is TaskState.ILLEGAL
    assert (ready.ended(after), ready.ended(last)) == (4, 4)
    assert ready.q[0] == 2.0


@pytest.mark.parametrize(
    ("end", "state_"),
    [("stop", 3), ("abort", 5), ("press_emergency_stop", 6), ("disable", 3), ("power_off", 3)],
)
def test_a_motion_that_waits_for_a_stop_ends_by_the_next_one(
    ready: Bench, end: str, state_: int
) -> None:
    ready.begun()
    ready.controller.stop()
    after = ready.controller.move("movej2", leg(1.0))
    ready.tick()
    act = getattr(ready.controller, end, None)
    act() if act else ready.controller.power.request(end)
    assert ready.ended(after) == state_
    at = ready.q.copy()
    ready.tick(300)
    assert (ready.q == at).all()


def test_a_motion_that_waits_for_a_stop_pauses_before_it_begins(ready: Bench) -> None:
    ready.begun()
    stop = ready.controller.stop()
    after = ready.controller.move("movej2", leg(1.0))
    ready.controller.pause()
    assert ready.ended(stop) == 4
    at = ready.q.copy()
    ready.tick(300)
    assert (ready.q == at).all()
    assert not ready.controller.tasks.state(after).ended
    ready.controller.resume()
    assert ready.ended(after) == 4


def test_a_pause_ends_with_the_motions_that_waited(ready: Bench) -> None:
    """Those that wait for a later stop begin by themselves."""
    ready.begun()
    ready.controller.stop()
    paused = ready.controller.move("movej2", leg(1.0))
    ready.controller.pause()
    assert ready.ended(ready.controller.stop()) == 4
    assert ready.ended(paused) == 3
    ready.begun()
    ready.controller.stop()
    assert ready.ended(ready.controller.move("movej2", leg(1.0))) == 4


def test_no_motion_is_taken_while_a_fault_stops_the_arm(ready: Bench) -> None:
    ready.begun()
    ready.controller.fault(SafetyState.STOP2, "a fault")
    assert state(ready, ready.controller.move("movej2", leg(1.0))) is TaskState.ILLEGAL


def test_a_motion_that_waits_for_a_stop_excludes_what_it_excludes_anyway(ready: Bench) -> None:
    ready.begun()
    ready.controller.stop()
    jog = ready.controller.jog("move_jog", leg(1.0))
    assert state(ready, jog) is TaskState.IDLE
    assert state(ready, ready.controller.jog("move_jog", leg(1.0))) is TaskState.ILLEGAL
    assert ready.ended(jog) == 4


def test_pause_keeps_the_motions_and_resume_ends_them(ready: Bench) -> None:
    first = ready.controller.move("movej2", leg(1.0, 100))
    second = ready.controller.move("movej2", leg(2.0, 100))
    ready.tick(10)
    pause = ready.controller.pause()
    assert ready.state == [6, 4, 5, 1]
    assert ready.ended(pause) == 4
    assert ready.state == [6, 3, 5, 1]
    assert (state(ready, first), state(ready, second)) == (TaskState.PAUSED, TaskState.IDLE)
    at = ready.q.copy()
    ready.tick(200)
    assert (ready.q == at).all()
    assert ready.ended(ready.controller.resume()) == 4
    assert state(ready, first) is TaskState.RUNNING
    assert (ready.ended(first), ready.ended(second)) == (4, 4)


def test_resuming_before_the_arm_stands_interrupts_the_pause(ready: Bench) -> None:
    id_ = ready.begun(100)
    pause = ready.controller.pause()
    ready.controller.resume()
    assert state(ready, pause) is TaskState.INTERRUPT
    assert ready.ended(id_) == 4


def test_pause_and_resume_of_a_standing_arm_change_nothing(ready: Bench) -> None:
    assert ready.ended(ready.controller.pause()) == 4
    assert ready.state == [6, 0, 5, 1]
    assert ready.ended(ready.controller.resume()) == 4
    assert ready.ended(ready.controller.move("movej2", leg(1.0))) == 4


def test_switching_the_mode_pauses_and_stop_clears_it(ready: Bench) -> None:
    ready.begun()
    ready.controller.switch_mode(OperationMode.MANUAL)
    ready.until(lambda: ready.state == [6, 3, 5, 0])
    assert ready.ended(ready.controller.stop()) == 4
    assert ready.state == [6, 0, 5, 0]
    ready.controller.move("movej2", leg(1.0, 100))
    ready.tick(2)
    assert ready.state == [6, 5, 5, 0]  # a teach task


def test_the_program_state_may_lag_behind() -> None:
    bench = Bench().enabled()
    bench.controller.program_lag = 0.05
    assert bench.state[1] == 0
    for _ in range(2):
        assert bench.ended(bench.controller.move("movej2", leg(0.1))) == TaskState.FINISHED
        assert bench.state[1] == 1
        bench.tick(45)
        assert bench.state[1] == 1
    bench.tick(10)
    assert bench.state == [6, 0, 5, 1]


def test_the_global_speed_outlives_a_power_cycle(ready: Bench) -> None:
    ready.controller.set_speed(30)
    ready.power("power_off", "power_on", "enable")
    assert FakeMover.latest is not None
    assert FakeMover.latest.fraction == pytest.approx(0.3)
    assert ready.controller.view().speed == 30


# -- safety --------------------------------------------------------------------------------------


def test_the_emergency_stop_cuts_the_power_at_once(ready: Bench) -> None:
    ids = [ready.controller.move("movej2", leg(1.0, 1000)) for _ in range(2)]
    ready.tick(10)
    ready.controller.press_emergency_stop()
    assert [state(ready, id_) for id_ in ids] == [TaskState.ERROR] * 2
    ready.tick()
    assert ready.drive is not None
    assert ready.drive.brake
    view = ready.controller.view()
    assert (ready.state, view.emergency_stop, view.error) == ([4, 0, 9, 1], True, 1)
    assert view.errors[-1] == "emergency stop pressed"


def test_power_comes_back_only_after_release_and_power_off(ready: Bench) -> None:
    ready.controller.press_emergency_stop()
    change = ready.controller.power.request
    assert ready.ended(change("power_on")) == 7
    assert ready.ended(change("power_off")) == 4
    assert ready.ended(change("power_on")) == 7
    ready.controller.release_emergency_stop()
    assert ready.ended(change("power_on")) == 7
    for number in range(25):
        ready.controller.note_error(str(number))
    assert ready.controller.view().errors == tuple(map(str, range(5, 25)))
    ready.power("power_off", "power_on", "enable")
    assert ready.state == [6, 0, 5, 1]
    assert ready.controller.view().errors == ()
    assert ready.ended(ready.controller.move("movej2", leg(1.0))) == 4


@for_each("name", ["power_on", "enable", "disable"])
def test_the_emergency_stop_ends_a_change_that_was_to_end_with_power(name: str) -> None:
    bench = Bench()
    bench.power(*{"power_on": [], "enable": ["power_on"], "disable": ["power_on", "enable"]}[name])
    id_ = bench.controller.power.request(name)
    bench.tick(5)
    bench.controller.press_emergency_stop()
    assert state(bench, id_) is TaskState.ERROR
    bench.tick(1000)
    assert bench.state == [4, 0, 9, 1]


def test_a_collision_stops_with_power_and_names_the_joint(ready: Bench) -> None:
    id_ = ready.begun()
    ready.controller.collide(4)
    assert ready.ended(id_) == 6
    view = ready.controller.view()
    assert (ready.state, view.collision_axis) == ([6, 0, 7, 1], 4)
    assert view.errors[-1] == "Joint 4 检测到碰撞"
    assert state(ready, ready.controller.move("movej2", leg(1.0))) is TaskState.ILLEGAL


def test_resetting_the_collision_takes_back_the_flag_and_not_the_stop(ready: Bench) -> None:
    ready.controller.collide(2)
    ready.tick()
    ready.controller.reset_collision()
    assert ready.controller.view().collision_axis == 0
    assert ready.state == [6, 0, 7, 1]
    ready.power("power_off", "power_on", "enable")
    assert ready.ended(ready.controller.move("movej2", leg(1.0))) == 4


def test_stop1_stops_first_and_cuts_the_power_then(ready: Bench) -> None:
    id_ = ready.begun()
    ready.controller.fault(SafetyState.STOP1, "safety limit")
    assert ready.state == [6, 1, 8, 1]
    assert ready.ended(id_) == 6
    ready.tick(2)
    assert ready.state == [4, 0, 8, 1]


def test_the_graver_of_two_safety_stops_holds(ready: Bench) -> None:
    for category in (SafetyState.STOP2, SafetyState.STOP0, SafetyState.STOP1):
        ready.controller.fault(category, category.name)
    assert ready.state[2] == SafetyState.STOP0


def test_a_fault_during_a_stop_decides_how_the_motion_ends(ready: Bench) -> None:
    id_ = ready.begun()
    ready.controller.stop()
    ready.controller.collide(1)
    assert ready.ended(id_) == 6


def test_a_joint_far_from_its_set_point_cuts_the_power(ready: Bench) -> None:
    id_ = ready.begun(1000)
    ready.q = ready.q + np.array([0.0, 0.0, 0.19, 0.0, 0.0, 0.0])
    ready.tick()
    assert state(ready, id_) is TaskState.RUNNING
    ready.q = ready.q + np.array([0.0, 0.0, 0.21, 0.0, 0.0, 0.0])
    ready.tick()
    assert state(ready, id_) is TaskState.ERROR
    assert ready.state == [4, 0, 9, 1]
    assert ready.controller.view().errors[-1] == "joint 3: position deviation"


def test_enabling_starts_where_the_brakes_hold_the_arm(ready: Bench) -> None:
    ready.power("disable")
    ready.q = ready.q + 0.7
    ready.power("enable")
    ready.tick(2)
    assert ready.drive is not None
    assert not ready.drive.brake
    assert ready.drive.setpoint.q == pytest.approx([0.7] * 6)


# -- heartbeat -----------------------------------------------------------------------------------


def test_a_lost_heartbeat_stops_everything_and_the_next_program_may_move(ready: Bench) -> None:
    id_ = ready.controller.move("movej2", leg(1.0, 4000))
    ready.controller.heartbeat.beat(ready.time, 200)
    ready.tick(150)
    ready.controller.heartbeat.beat(ready.time, 200)
    ready.tick(190)
    assert state(ready, id_) is TaskState.RUNNING
    assert ready.ended(id_) == 3
    assert ready.controller.view().errors == ("heartbeat lost: all tasks were stopped",)
    ready.controller.heartbeat.beat(ready.time, 200)
    ready.tick(1000)  # nothing moves: no error, but it has ended
    assert not ready.controller.heartbeat.lost(math.inf)
    assert len(ready.controller.view().errors) == 1
    assert ready.state == [6, 0, 5, 1]
    assert ready.ended(ready.controller.move("movej2", leg(1.0))) == 4


def test_a_lost_heartbeat_stops_what_waits_for_the_end_of_force_control(ready: Bench) -> None:
    ready.controller.force.start()
    ready.controller.heartbeat.beat(ready.time, 200)
    ready.tick(200)
    ready.controller.force.stop()
    id_ = ready.controller.move("movej2", leg(1.0))
    ready.tick()
    assert not ready.controller.heartbeat.lost(math.inf)
    assert ready.ended(id_) == 3


def test_an_axis_that_begins_as_idle_time_ends_has_the_speed_of_its_cycle(ready: Bench) -> None:
    """Where nothing happens, several cycles pass at once; a command comes in the last of them."""
    axes = SimulatedExternalAxes({"rail": [Axis(0.0, 1.0, 1.0, 2.0)]})
    ready.controller.external_axes = axes
    ready.tick()
    ready.cycle += 3
    assert FakeMover.latest is not None
    FakeMover.latest.axes = {0: 1e-6}
    ready.tick()
    (state,) = axes.states()
    assert state.speed == pytest.approx(1e-6 / CYCLE)
