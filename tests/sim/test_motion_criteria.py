"""Every motion with a path against its closed form, over the wire, by set-points and by the arm.

The criteria: the tool within 0.5 mm and 0.1° of its path; speed and acceleration at most 2 % above
what is asked for; durations within 2 % of the fastest that speed and acceleration allow; joints
within 2 mrad of their set-points while they move.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
import scipy

from aioduco._wire.rpc import Op
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix
from aioduco.sim.simulator import READY, Simulator

from .conftest import Program, a_program
from .cycles import Cycles

pytestmark = pytest.mark.usefixtures("real_cycle")

CYCLE = 0.001
DEVIATION, ANGLE = 0.5e-3, math.radians(0.1)
OVER = 1.02
TRACKING = 2e-3
SAMPLES = 10001  # of a path, so fine that what lies between them does not count
TOOL = Pose(0.02, -0.03, 0.1, 0.0, 0.3, 0.0)
BENCH = Pose(0.1, 0.2, -0.1, 0.0, 0.0, 0.7)
PLAIN = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
U = np.linspace(0.0, 1.0, SAMPLES)


@dataclass(frozen=True)
class Expected:
    """What a motion shall be.

    Attributes:
        positions: of the tool, dense [m]. Shape (n, 3).
        rotations: its orientations there. Shape (n, 3, 3).
        v: speed asked for [m/s].
        a: acceleration asked for [m/s²].
    """

    positions: Array
    rotations: Array
    v: float
    a: float


@dataclass(frozen=True)
class Case:
    """A motion: how it is asked for, and what it shall be; both from the tool's first pose."""

    name: str
    call: Callable[[Program, Pose, float], int]
    path: Callable[[Pose, float], Expected]
    frames: bool = False  # with a tool and a work object

    def __str__(self) -> str:
        return self.name


V, A = 0.25, 1.5
SLOW, SOFT = 0.12, 0.5  # a joint turns with the tool on a small circle
END: Any = (True, Op(), False)


def straight(start: Pose, end: Pose, v: float = V, a: float = A) -> Expected:
    turn = rotvec_from_matrix((start.rotation.T @ end.rotation)[None])[0]
    positions = start.position + U[:, None] * (np.array(end.position) - start.position)
    return Expected(positions, start.rotation @ matrix_from_rotvec(U[:, None] * turn), v, a)


def wound(
    start: Pose,
    r: float,
    angle: float,
    *,
    mode: int = 1,
    axial: float = 0.0,
    radius: float | None = None,
    turn: tuple[float, ...] = (0.0, 0.0, 0.0),
    pace: tuple[float, float] = (V, A),
) -> Expected:
    """About an upright axis at a distance r behind the start."""
    wide = r + ((r if radius is None else radius) - r) * U
    at = angle * U
    flat = np.stack([wide * np.cos(at) - r, wide * np.sin(at), axial * U], axis=1)
    about = np.array([0.0, 0.0, angle]) if mode == 2 else np.array(turn)
    rotations = matrix_from_rotvec(U[:, None] * about) @ start.rotation
    return Expected(start.position + flat, rotations, *pace)


def on_circle(start: Pose, r: float, angle: float) -> Pose:
    return start.shifted(x=r * (math.cos(angle) - 1.0), y=r * math.sin(angle))


def turned(start: Pose, turn: tuple[float, ...]) -> Pose:
    matrix = start.matrix
    matrix[:3, :3] = matrix_from_rotvec(np.array([turn]))[0] @ start.rotation
    return Pose.from_matrix(matrix)


TURN = (0.2, -0.3, 0.5)


def arc(mode: int) -> Case:
    def call(robot: Program, start: Pose, u: float) -> int:
        via, end = on_circle(start, u, 0.9), turned(on_circle(start, u, 2.5), TURN)
        return robot.movec(list(via), list(end), V, A, 0.0, mode, [], "", "", *END)

    turn = TURN if mode == 0 else (0.0, 0.0, 0.0)
    return Case(f"movec_{mode}", call, lambda s, u: wound(s, u, 2.5, mode=mode, turn=turn))


def circle(mode: int) -> Case:
    pace = (SLOW, SOFT)

    def call(robot: Program, start: Pose, u: float) -> int:
        first, second = (list(on_circle(start, 0.6 * u, angle)) for angle in (1.0, 2.0))
        return robot.move_circle(first, second, *pace, 0.0, mode, [], "", "", *END)

    def path(start: Pose, u: float) -> Expected:
        return wound(start, 0.6 * u, 2 * math.pi, mode=mode, pace=pace)

    return Case(f"move_circle_{mode}", call, path)


def spiral(mode: int) -> Case:
    def call(robot: Program, start: Pose, u: float) -> int:
        centre = list(Pose(start.x - u, start.y, start.z, 0.0, 0.0, 0.0))
        last = start.shifted(x=-0.4 * u, z=0.3 * u)
        numbers = (1.0, 0.3 * u, 0.6 * u) if mode == 0 else (1.0, 0.0, 0.0)
        return robot.move_spiral(centre, list(last), *numbers, mode, V, A, [], "", "", *END)

    def path(start: Pose, u: float) -> Expected:
        return wound(start, u, 2 * math.pi, axial=0.3 * u, radius=0.6 * u)

    return Case(f"move_spiral_{mode}", call, path)


def knots(start: Pose, u: float) -> list[Pose]:
    return [start.shifted(x=0.2 * u * math.sin(2.0 * i), y=0.8 * u * i) for i in range(1, 4)]


def through(start: Pose, u: float) -> Expected:
    points = np.array([start.position, *(pose.position for pose in knots(start, u))])
    chords = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    curve = scipy.interpolate.CubicSpline(chords / chords[-1], points, bc_type="natural")
    rotations = np.broadcast_to(start.rotation, (SAMPLES, 3, 3))
    return Expected(np.asarray(curve(U)), np.array(rotations), V, A)


def along(axes: Array, start: Pose, step: Pose) -> Pose:
    """Moved and turned in place, along and about given axes."""
    matrix = start.matrix
    matrix[:3, 3] += axes @ np.array(step.position)
    matrix[:3, :3] = axes @ step.rotation @ axes.T @ start.rotation
    return Pose.from_matrix(matrix)


def step(u: float) -> Pose:
    return Pose(0.5 * u, 1.2 * u, 0.3 * u, 0.1, 0.0, 0.4)


def pair(u: float) -> tuple[Pose, Pose]:
    first = Pose(0.3, 0.1, 0.2, 0.0, 0.5, 0.2)
    return first, first @ step(u)


def line_to(robot: Program, start: Pose, u: float) -> int:
    goal = BENCH.inverse() @ (start @ step(u))
    return robot.movel(list(goal), V, A, 0.0, [], "gripper", "bench", *END)


def by_wobj_2p(robot: Program, start: Pose, u: float) -> int:
    first = Pose(0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
    second = along(np.eye(3), first, step(u))
    return robot.wobj_move_2p(list(first), list(second), V, A, 0.0, "", "bench", *END)


def by_tcp_2p(robot: Program, start: Pose, u: float) -> int:
    first, second = pair(u)
    return robot.tcp_move_2p(list(first), list(second), V, A, 0.0, "", "", *END)


CASES = [
    Case("movel_frames", line_to, lambda s, u: straight(s, s @ step(u)), frames=True),
    Case(
        "tcp_move",
        lambda robot, s, u: robot.tcp_move(list(step(u)), V, A, 0.0, "", *END),
        lambda s, u: straight(s, s @ step(u)),
        frames=True,
    ),
    Case("tcp_move_2p", by_tcp_2p, lambda s, u: straight(s, s @ step(u)), frames=True),
    Case(
        "wobj_move",
        lambda robot, s, u: robot.wobj_move(list(step(u)), V, A, 0.0, "bench", *END),
        lambda s, u: straight(s, along(BENCH.rotation, s, step(u))),
        frames=True,
    ),
    Case(
        "wobj_move_2p",
        by_wobj_2p,
        lambda s, u: straight(s, along(BENCH.rotation, s, step(u))),
        frames=True,
    ),
    *(arc(mode) for mode in (0, 1, 2)),
    *(circle(mode) for mode in (1, 2)),
    *(spiral(mode) for mode in (0, 1)),
    Case(
        "spline",
        lambda robot, s, u: robot.spline(
            [list(pose) for pose in knots(s, u)], V, A, "", "", True, Op(), 0.0, False
        ),
        through,
    ),
]


@dataclass
class Cell:
    """An arm in a simulator that runs as fast as it can, and what it did cycle by cycle."""

    sim: Simulator
    robot: Program
    cycles: Cycles
    reach: float = field(init=False)

    def __post_init__(self) -> None:
        self.reach = float(self.sim.arm.fkine(READY)[0, 3])

    def begin(self, tool: Pose, wobj: Pose) -> None:
        """Stand at the start, with a tool and a work object in use."""
        robot = self.robot
        assert robot.to(*READY, v=2.0) == TaskState.FINISHED
        robot.set_tool_data("gripper", list(tool), [0.0] * 4, [0.0] * 6)
        robot.set_wobj("bench", list(wobj))
        self.sim.wait_until(lambda: not self.sim.moving)
        self.cycles.clear()

    def moved(self) -> slice:
        """The cycles in which the set-points moved."""
        going = np.flatnonzero(np.abs(np.diff(self.cycles.wanted, axis=0)).max(axis=1) > 0.0)
        return slice(int(going[0]), int(going[-1]) + 2)


@pytest.fixture(scope="module", params=["gcr3_618", "gcr16_2000"])
def cell(request: pytest.FixtureRequest) -> Iterator[Cell]:
    with pytest.MonkeyPatch.context() as patch:
        cycles = Cycles(patch)
        with Simulator(request.param, speed=math.inf) as sim, a_program(sim) as robot:
            robot.bring_up()
            yield Cell(sim, robot, cycles)


def fastest(length: float, v: float, a: float, curvature: float) -> float:
    """The least time for a way of one curvature, a being along and across it together."""
    top = min(v, math.sqrt(a / curvature)) if curvature > 0.0 else v

    def rate(speed: float) -> float:
        return math.sqrt(max(a * a - (curvature * speed * speed) ** 2, 1e-12))

    takes = scipy.integrate.quad(lambda speed: 1.0 / rate(speed), 0.0, top)[0]
    covers = scipy.integrate.quad(lambda speed: speed / rate(speed), 0.0, top)[0]
    assert 2 * covers < length  # it comes to its speed
    return float(2 * takes + (length - 2 * covers) / top)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_path_of_the_tool(cell: Cell, case: Case) -> None:
    robot, arm = cell.robot, cell.sim.arm
    tool = TOOL if case.frames else PLAIN
    cell.begin(tool, BENCH if case.frames else PLAIN)
    start = Pose.from_matrix(arm.fkine(READY) @ tool.matrix)
    unit = 0.2 * cell.reach
    assert case.call(robot, start, unit) == TaskState.FINISHED, robot.get_last_error()
    expected = case.path(start, unit)
    # where the tool was, by the arm and not by the set-points
    part = cell.moved()
    seen = np.linspace(part.start, part.stop - 1, 120).astype(int)
    tips = arm.fkine(np.array(cell.cycles.q)[seen]) @ tool.matrix
    away, nearest = scipy.spatial.cKDTree(expected.positions).query(tips[:, :3, 3])
    assert np.max(away) < DEVIATION
    turned_back = np.swapaxes(expected.rotations[nearest], -1, -2)
    off = rotvec_from_matrix(turned_back @ tips[:, :3, :3])
    assert np.linalg.norm(off, axis=1).max() < ANGLE
    # how fast it was told to go
    wanted = (arm.fkine(np.array(cell.cycles.wanted[part])) @ tool.matrix)[:, :3, 3]
    np.testing.assert_allclose(wanted[-1], expected.positions[-1], atol=1e-6)
    speeds = np.diff(wanted, axis=0) / CYCLE
    changes = np.diff(speeds, axis=0) / CYCLE
    assert np.linalg.norm(speeds, axis=1).max() < OVER * expected.v
    assert np.linalg.norm(changes, axis=1).max() < OVER * expected.a
    # how long it took
    ways = np.linalg.norm(np.diff(expected.positions, axis=0), axis=1)
    tangents = np.diff(expected.positions, axis=0) / ways[:, None]
    bends = np.linalg.norm(np.diff(tangents, axis=0), axis=1) / ways[1:]
    least = fastest(float(ways.sum()), expected.v, expected.a, float(np.median(bends)))
    assert len(speeds) * CYCLE == pytest.approx(least, rel=0.02)
    assert cell.cycles.farthest() < TRACKING


@pytest.mark.cases(1)
@pytest.mark.parametrize("function", ["movej2", "movej_pose2"])
def test_a_way_of_the_joints(cell: Cell, function: str) -> None:
    robot, arm = cell.robot, cell.sim.arm
    cell.begin(PLAIN, PLAIN)
    start = np.array(READY)
    goal = start + np.array([0.9, -0.3, 0.4, 0.2, 0.5, -0.7])
    v, a = 1.2, 4.0
    if function == "movej2":
        assert robot.movej2(goal.tolist(), v, a, 0.0, *END) == TaskState.FINISHED
    else:
        pose = list(Pose.from_matrix(arm.fkine(goal)))
        answer = robot.movej_pose2(pose, v, a, 0.0, goal.tolist(), "", "", *END)
        assert answer == TaskState.FINISHED
    wanted = np.array(cell.cycles.wanted[cell.moved()])
    share = (wanted - start) @ (goal - start) / ((goal - start) @ (goal - start))
    assert np.abs(wanted - start - share[:, None] * (goal - start)).max() < 1e-6
    np.testing.assert_allclose(wanted[-1], goal, atol=1e-6)
    speeds = np.diff(wanted, axis=0) / CYCLE
    assert np.abs(speeds).max() < OVER * v
    assert np.abs(np.diff(speeds, axis=0)).max() / CYCLE < OVER * a
    assert len(speeds) * CYCLE == pytest.approx(fastest(0.9, v, a, 0.0), rel=0.02)
    assert cell.cycles.farthest() < TRACKING
