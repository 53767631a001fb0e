"""Force control against physics: cycle by cycle, then by the wire."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aioduco._wire.rpc import Op
from aioduco.kinematics import Arm, arm
from aioduco.models.enums import SafetyState, TaskState
from aioduco.sim.cycle import SensedState
from aioduco.sim.force.control import AdmittanceLaw, ForceControl
from aioduco.sim.force.sensor import ForceAxes
from aioduco.sim.physics.world import World
from aioduco.sim.planner.mover import Mover
from aioduco.sim.planner.segments import line_move
from aioduco.sim.scene import Rod, Table, mjcf_of
from aioduco.sim.simulator import Simulator

from .conftest import Connect, Program, let_pass

Vector = NDArray[np.float64]
CYCLE = 0.001
FIVE = arm("gcr5_910")
READY = np.radians([0, 0, 90, 0, -90, 0])
POSE = FIVE.fkine(READY)  # the flange looks down
DOWN = POSE[:3, :3]
ZEROS = np.zeros(6)
Z = (False, False, True, False, False, False)
PRESS = (0.0, 0.0, -20.0, 0.0, 0.0, 0.0)
DAMPING = (1000.0,) * 3 + (57.0,) * 3
CAP = (0.05,) * 3 + (0.2,) * 3
NOTHING = (0.0,) * 6


def table(
    gap: float, stiffness: float | None = None, below: float = 0.0, model: Arm = FIVE
) -> Table:
    """So far below the flange, or below a tool of some length [m, N/m]."""
    x, y, z = model.fkine(READY)[:3, 3].tolist()
    return Table(at=(x, y, z - below - gap), stiffness=stiffness)


class Cell:
    """An arm in its surroundings, whose force control presses along z of the tool."""

    def __init__(
        self,
        *things: Table,
        model: Arm = FIVE,
        probe: float = 0.0,
        target: tuple[float, ...] = PRESS,
        **law: Any,
    ) -> None:
        tool = mjcf_of([Rod(length=probe, mass=0.2)], free=False) if probe else None
        tip = np.eye(4)
        tip[2, 3] = probe
        self.world = World(model, CYCLE, READY, scene=mjcf_of(things), tool=tool)
        self.mover = Mover(model, READY, CYCLE)
        self.control = ForceControl(model, CYCLE)
        self.control.sensor = self.control.sensor.tared(self.world.wrench, DOWN)
        usual = {"direction": Z, "damping": DAMPING, "cap": CAP, "band": NOTHING}
        self.control.law = AdmittanceLaw(
            target=target, axes=ForceAxes(tip, np.eye(4)), **{**usual, **law}
        )
        self.control.start(self.mover.setpoint)
        self.time = 0.0
        self.forces: list[list[float]] = []
        self.tips: list[Vector] = []

    def run(self, seconds: float = math.inf) -> Vector:
        """Go on for some time, or as long as the motion lasts; the readings of the sensor."""
        begun = len(self.forces)
        cycles = 0
        while self.mover.moving if seconds == math.inf else cycles < round(seconds / CYCLE):
            cycles += 1
            self.time += CYCLE
            world = self.world
            sensed = SensedState(self.time, 0.0, world.q, world.qd, world.wrench, ZEROS)
            point, outcome = self.control.tick(self.mover.tick().setpoint, sensed, compliant=True)
            assert outcome is None
            world.step(point)
            self.forces.append(self.control.sensor.reading(world.wrench))
            self.tips.append(world.arm.fkine(world.q)[:3, 3])
        return np.array(self.forces[begun:])


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [5_000.0, 100_000.0, None])
def test_pressing_settles_at_the_target(stiffness: float | None) -> None:
    cell = Cell(table(0.005, stiffness))
    pressed = cell.run(2.5)
    # Within 5 % of 20 N from a second and a half on, and no blow as it touches.
    assert pressed[1500:, 2] == pytest.approx(-20.0, abs=1.0)
    assert pressed[:, 2].min() > -22.0
    assert np.abs(pressed[1500:, :2]).max() < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gcr3_618", "gcr30_1100"])
def test_small_and_large_arms_press(name: str) -> None:
    model = arm(name)
    cell = Cell(table(0.003, 20_000.0, model=model), model=model)
    assert cell.run(1.5)[1000:, 2] == pytest.approx(-20.0, abs=1.0)


@pytest.mark.slow
def test_sliding_along_the_table_keeps_the_pressure() -> None:
    cell = Cell(table(0.003, below=0.1), probe=0.1)
    cell.run(1.5)
    goal = POSE.copy()
    goal[0, 3] += 0.08
    goal[2, 3] += 0.0016  # the path rises, the table does not
    tip = cell.control.axes.tip
    cell.mover.append(1, lambda q: line_move(FIVE, q, goal, 0.05, 0.5, tool=tip))
    sliding = cell.run()
    # 1 N for the slope: 1 mm/s at 1000 N s/m; the rest is friction, which bends the arm.
    assert sliding[:, 2] == pytest.approx(-20.0, abs=3.0)
    assert sliding[200:-200, 2] == pytest.approx(-20.0, abs=2.0)
    assert np.abs(sliding[200:-200, :2]).max() > 5.0  # it does rub
    way = cell.tips[-1] - cell.tips[0]
    assert way[:2] == pytest.approx([0.08, 0.0], abs=2e-3)
    assert np.ptp([at[2] for at in cell.tips[1500:]]) < 1e-3


@pytest.mark.slow
def test_a_hand_moves_what_gives_way_and_nothing_else() -> None:
    cell = Cell(target=NOTHING, direction=(True, True, True, False, False, False))
    pushed = 20.0
    cell.world.push([0.0, pushed, 0.0, 0.0, 0.0, 0.0])
    cell.run(1.0)
    let_go = cell.tips[-1]
    cell.world.push(NOTHING)
    cell.run(0.5)
    moved = cell.tips[-1] - cell.tips[0]
    assert moved[1] == pytest.approx(pushed / 1000.0, rel=0.05)
    assert moved[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert cell.tips[-1] == pytest.approx(let_go, abs=1e-3)  # it stays where it was left
    end = FIVE.fkine(cell.world.q)
    assert end[:3, :3] == pytest.approx(DOWN, abs=1e-3)


# -- by the wire ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def simulator() -> Iterator[Simulator]:
    # Not as fast as it can: a program that waits for its turn must not find the arm far away.
    with Simulator(speed=10.0, scene=[table(0.03, 30_000.0)]) as sim:
        yield sim


@pytest.fixture
def robot(simulator: Simulator, connect: Connect) -> Program:
    """A program whose arm stands above the table, without force control."""
    program = connect(simulator)
    program.stop(True)
    assert program.power_off(True) == TaskState.FINISHED
    program.bring_up()
    assert program.to(*READY) == TaskState.FINISHED
    settle(simulator, program)
    done(program, program.fc_force_set_value([True] * 6, [0.0] * 6))
    done(program, program.fc_guard_deact())
    return program


def settle(sim: Simulator, program: Program) -> None:
    sim.wait_until(lambda: not program.robotmoving())


def done(program: Program, id_: int, state: int = TaskState.FINISHED) -> None:
    """A call without `block` has ended in this state."""
    assert program.ended(id_) == state


def config(program: Program, force: float, tool: str = "") -> None:
    target = [0.0, 0.0, -force, 0.0, 0.0, 0.0]
    done(program, program.fc_config(Z, target, DAMPING, CAP, NOTHING, tool, "", 0))


def until(program: Program, force: float, within: float, timeout: int = 20_000) -> None:
    """Motions end when the table presses back like this for a tenth of a second."""
    middle, spread = [0.0, 0.0, -force, 0.0, 0.0, 0.0], [1e3, 1e3, within, 1e3, 1e3, 1e3]
    done(program, program.fc_wait_ft(middle, spread, True, 100, timeout))
    done(program, program.fc_wait_logic([0, 0, 1]))


@pytest.mark.slow
def test_press_release_and_press_again(simulator: Simulator, robot: Program) -> None:
    config(robot, 20.0)
    done(robot, robot.fc_start())
    assert robot.fc_mode_is_active()
    for _ in range(2):
        until(robot, 20.0, 1.0)
        assert robot.fc_move(True) == TaskState.FINISHED
        settle(simulator, robot)
        assert robot.fc_get_ft()[2] == pytest.approx(-20.0, abs=1.0)
        assert robot.get_tcp_force()[2] == pytest.approx(20.0, abs=1.0)
        pressed = robot.get_tcp_pose()
        done(robot, robot.fc_wait_logic([0, 0, 0]))
        done(robot, robot.fc_stop())
        assert not robot.fc_mode_is_active()
        # It is planned from where the arm is: straight up again.
        above = [*pressed[:2], pressed[2] + 0.02, *pressed[3:]]
        assert robot.line(above) == TaskState.FINISHED
        settle(simulator, robot)
        assert robot.get_tcp_pose()[:3] == pytest.approx(above[:3], abs=1e-3)
        assert robot.fc_get_ft()[2] == pytest.approx(0.0, abs=0.2)
        done(robot, robot.fc_start())
    done(robot, robot.fc_stop())


@pytest.mark.slow
def test_a_guard_trips_and_is_recovered_from(simulator: Simulator, robot: Program) -> None:
    config(robot, 60.0)
    limits = [500.0, 500.0, 40.0, 50.0, 50.0, 50.0]
    done(robot, robot.fc_guard_act(Z, limits, "", "", 0, 1))
    done(robot, robot.fc_start())
    assert robot.fc_move(True) == TaskState.ERROR
    assert simulator.view.safety is SafetyState.STOP0
    assert "force guard" in robot.get_last_error()[-1]
    assert not robot.fc_mode_is_active()
    assert abs(robot.fc_get_ft()[2]) < 45.0
    assert robot.fc_move(True) == TaskState.ILLEGAL
    done(robot, robot.fc_start(), TaskState.ILLEGAL)
    assert robot.power_off(True) == TaskState.FINISHED
    robot.bring_up()
    # The sensor was tared while it pressed: free, it reads the pressure the other way round.
    assert robot.to(*READY) == TaskState.FINISHED
    settle(simulator, robot)
    assert robot.fc_get_ft()[2] == pytest.approx(40.0, abs=10.0)
    done(robot, robot.fc_force_set_value(Z, NOTHING))
    assert robot.fc_get_ft()[2] == pytest.approx(0.0, abs=0.1)
    config(robot, 20.0)
    done(robot, robot.fc_start())
    until(robot, 20.0, 1.0)
    assert robot.fc_move(True) == TaskState.FINISHED


def test_a_stop_ends_the_motion_and_the_arm_stands(simulator: Simulator, robot: Program) -> None:
    config(robot, 20.0)
    done(robot, robot.fc_start())
    id_ = robot.fc_move(False)
    simulator.wait_until(lambda: robot.get_tcp_pose()[2] < POSE[2, 3] - 0.002)
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.get_noneblock_taskstate(id_) == TaskState.STOPPED
    settle(simulator, robot)
    there = robot.get_tcp_pose()
    assert robot.fc_mode_is_active()
    let_pass(simulator, 1.0)
    assert robot.get_tcp_pose()[:3] == pytest.approx(there[:3], abs=1e-4)
    done(robot, robot.fc_stop())


@pytest.mark.slow
def test_a_motion_ends_where_a_position_is_reached(simulator: Simulator, robot: Program) -> None:
    config(robot, 20.0)
    here = robot.get_tcp_pose()
    z_alone = [0.0, 0.0, 0.002, 0.0, 0.0, 0.0]
    done(robot, robot.fc_start())
    done(robot, robot.fc_wait_pos([0, 0, -0.01, 0, 0, 0], z_alone, False, 0, 10_000))
    done(robot, robot.fc_wait_logic([1, 0, 0]))
    assert robot.fc_move(True) == TaskState.FINISHED
    settle(simulator, robot)
    assert robot.get_tcp_pose()[2] == pytest.approx(here[2] - 0.008, abs=0.002)
    assert robot.line(here) == TaskState.INTERRUPT  # skipped
    assert robot.get_tcp_pose()[2] == pytest.approx(here[2] - 0.008, abs=0.002)
    done(robot, robot.fc_stop())
    assert robot.line(here) == TaskState.FINISHED


@pytest.mark.slow
def test_a_motion_ends_at_a_speed_or_in_time(simulator: Simulator, robot: Program) -> None:
    config(robot, 20.0)
    done(robot, robot.fc_start())
    spread = [9.0, 9.0, 0.002, 9.0, 9.0, 9.0]
    done(robot, robot.fc_wait_vel([0, 0, -0.02, 0, 0, 0], spread, True, 50, 10_000))
    done(robot, robot.fc_wait_logic([0, 1, 0]))
    assert robot.fc_move(True) == TaskState.FINISHED
    until(robot, 500.0, 1.0, timeout=300)
    assert robot.fc_move(True) == TaskState.ERROR
    assert "in time" in robot.get_last_error()[-1]
    settle(simulator, robot)
    done(robot, robot.fc_stop())


@pytest.mark.slow
def test_motions_give_way_too(simulator: Simulator, robot: Program) -> None:
    """A line that ends below the table presses on it, instead of breaking something."""
    config(robot, 20.0)
    done(robot, robot.fc_start())
    here = robot.get_tcp_pose()
    through = [*here[:2], here[2] - 0.06, *here[3:]]
    until(robot, 25.0, 15.0)
    assert robot.movel(through, 0.02, 0.5, 0.0, [], "", "", True, Op(), False) == 5
    settle(simulator, robot)
    assert robot.get_tcp_pose()[2] > here[2] - 0.04
    done(robot, robot.fc_stop())


def free(robot: Program) -> None:
    """The arm gives way along every axis, and turns about none."""
    on = [True] * 3 + [False] * 3
    done(robot, robot.fc_config(on, NOTHING, DAMPING, CAP, NOTHING, "", "", 0))
    done(robot, robot.fc_start())


def lift(sim: Simulator, robot: Program, seconds: float) -> float:
    """Push upwards with 15 N for some simulated time; how far it went up [m]."""
    before, begin = robot.get_tcp_pose()[2], sim.time
    sim.push([0.0, 0.0, 15.0, 0.0, 0.0, 0.0])
    sim.wait_until(lambda: sim.time > begin + seconds)
    sim.push(NOTHING)
    return robot.get_tcp_pose()[2] - before


@pytest.mark.slow
def test_a_paused_arm_gives_way_to_nothing(simulator: Simulator, robot: Program) -> None:
    free(robot)
    id_ = robot.fc_move(False)
    assert lift(simulator, robot, 0.5) > 0.004
    assert robot.pause(True) == TaskState.FINISHED
    assert lift(simulator, robot, 0.5) < 0.001
    assert robot.resume(True) == TaskState.FINISHED
    assert lift(simulator, robot, 0.5) > 0.004
    assert robot.get_noneblock_taskstate(id_) == TaskState.RUNNING
    assert robot.stop(True) == TaskState.FINISHED
    done(robot, robot.fc_stop())


@pytest.mark.slow
def test_velocities_give_way_and_hand_guiding_is_left_alone(
    simulator: Simulator, robot: Program
) -> None:
    free(robot)
    here = robot.get_tcp_pose()
    id_ = robot.speedl([0.02, 0.0, 0.0, 0.0, 0.0, 0.0], 0.5, 1000, False)
    assert lift(simulator, robot, 0.5) > 0.004
    assert robot.get_noneblock_taskstate(id_) == TaskState.RUNNING
    assert robot.stop(True) == TaskState.FINISHED
    settle(simulator, robot)
    assert math.dist(robot.get_tcp_pose()[:2], here[:2]) > 0.005
    # It is where its offset has led it; in hand guiding, that offset must not lead it on.
    there, begin = robot.get_tcp_pose(), simulator.time
    robot.teach_mode(False)
    simulator.wait_until(lambda: simulator.time > begin + 1.0)
    assert robot.get_tcp_pose()[:3] == pytest.approx(there[:3], abs=1e-3)
    assert robot.end_teach_mode(True) == TaskState.FINISHED
    done(robot, robot.fc_stop())
