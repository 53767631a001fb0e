"""External axes over the wire, by the SDK (manual 1.3.14)."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Awaitable, Iterator
from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco._wire.rpc import EAxisParam
from aioduco.models.enums import TaskState
from aioduco.models.external_axis import ExternalAxis, ExternalAxisScheme
from aioduco.models.op import Op, output
from aioduco.models.pose import Pose
from aioduco.sim.cabinet.axis_schemes import Axis
from aioduco.sim.simulator import READY, Simulator

from .conftest import Connect, advance_until, standing_time
from .raw import RawClient

RAIL, TABLE = Axis(-0.5, 3.0, 1.0, 2.0), Axis(-math.pi, math.pi, 2.0, 8.0, jog=1.0)
AXES: dict[str, Any] = {"scheme_name": "rail", "epose": [1.0, 0.0, 0.0], "eaxis_v": 0.5}
#: 1 m at 0.5 m/s and 2 m/s²
ALONE = 1.0 / 0.5 + 0.5 / 2.0


@pytest.fixture(scope="module")
def cell() -> Iterator[Simulator]:
    schemes = {"rail": [RAIL], "table": [TABLE, Axis(0.0, 1.0, 0.5, 1.0)]}
    with Simulator(speed=math.inf, external_axes=schemes) as sim:
        yield sim


@pytest.fixture
async def robot(cell: Simulator) -> AsyncIterator[aioduco.Robot]:
    """A robot that stands at its start, with its axes at zero and its schemes active."""
    async with aioduco.connect(cell.host, cell.port) as robot:
        await robot.bring_up()
        for name in ("rail", "table"):
            await robot.external_axes.enable_eaxis_scheme(name)
            await robot.external_axes.move_eaxis(name, [0.0, 0.0, 0.0], 2.0)
        await robot.motion.movej2(READY, v=3.0, a=10.0)
        yield robot


async def refused(
    cell: Simulator, call: Awaitable[Any], error: type[aioduco.TaskError], why: str
) -> None:
    with pytest.raises(error):
        await call
    assert why in cell.view.errors[-1]


def seen(cell: Simulator, name: str = "rail") -> float:
    """Where the first axis of a scheme is, without a call."""
    return {each.name: each.position for each in cell.external_axes.states()}[name]


async def where(robot: aioduco.Robot, name: str = "rail") -> float:
    states = {state.scheme_name: state for state in await robot.external_axes.get_eaxis_info()}
    return states[name].position


@for_each(
    "axes",
    [3, "rail", {}, [3.0], ["rail"], [None], [[1.0]], [[0.0, 1.0, math.nan, 1.0]], [[1.0] * 7]],
)
def test_a_scheme_of_what_are_no_axes_is_refused(axes: Any) -> None:
    with pytest.raises(aioduco.ParameterError, match=r"external_axes\['rail'\]"):
        Simulator(external_axes={"rail": axes})


@for_each("table", ["external_axes", "values", "programs"])
def test_what_a_simulator_has_by_name_has_names(table: str) -> None:
    for name in ("", 3, None, "a\nb"):
        tables: dict[str, Any] = {table: {name: []}}
        with pytest.raises(aioduco.ParameterError, match=f"a name of {table} is"):
            Simulator(**tables)


async def test_schemes_are_switched_on_and_off(robot: aioduco.Robot, cell: Simulator) -> None:
    axes = robot.external_axes
    assert [(s.scheme_name, s.status) for s in await axes.get_eaxis_info()] == [
        ("rail", 1),
        ("table", 1),
    ]
    await axes.disable_eaxis_scheme("rail")
    assert [s.status for s in await axes.get_eaxis_info()] == [0, 1]
    await refused(
        cell, axes.move_eaxis("rail", [0.1, 0.0, 0.0], 0.1), aioduco.TaskIllegal, "not active"
    )
    await refused(cell, axes.enable_eaxis_scheme("crane"), aioduco.TaskIllegal, "no scheme 'crane'")
    await axes.enable_eaxis_scheme("rail")


async def test_a_dry_run_leaves_the_axes_where_they_are(robot: aioduco.Robot) -> None:
    await robot.settings.simulation(True)
    await robot.external_axes.move_eaxis("rail", [0.4, 0.0, 0.0], 2.0)
    assert await where(robot) == 0.4
    await robot.settings.simulation(False)
    assert await where(robot) == 0.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "function",
    ["movej2_eaxis", "movej2_pose_eaxis", "movel_eaxis", "movec_eaxis", "move_circle_eaxis"],
)
async def test_arm_and_axes_arrive_together(
    robot: aioduco.Robot, cell: Simulator, function: str
) -> None:
    start = Pose.from_matrix(cell.arm.fkine(READY))
    side, far = start.shifted(x=0.03, y=0.05), start.shifted(y=0.1)
    calls: dict[str, tuple[Any, ...]] = {
        "movej2_eaxis": ([0.3, *READY[1:]],),
        "movej2_pose_eaxis": (far,),
        "movel_eaxis": (far,),
        "movec_eaxis": (side, far),
        "move_circle_eaxis": (side, far),
    }
    begin = cell.time
    move = getattr(robot.external_axes, function)
    motion = await move(*calls[function], v=0.5, a=2.0, **AXES).start()
    await cell.wait_until_async(lambda: cell.moving, 60.0)
    together: list[tuple[float, float]] = []

    def on_the_way() -> bool:
        at = seen(cell)
        turned = max(abs(a - b) for a, b in zip(cell.joints, READY, strict=True))
        together.append((at, turned))
        return at >= 1.0

    await cell.wait_until_async(on_the_way, 60.0)
    await motion
    assert cell.time - begin > ALONE - 0.01  # the axis takes longer than the arm would
    middle = [way for at, way in together if 0.3 < at < 0.7]
    assert middle == [] or min(middle) > 0.01
    goal = {"movej2_eaxis": cell.arm.fkine([0.3, *READY[1:]]), "move_circle_eaxis": start.matrix}
    flange = Pose.from_matrix(cell.arm.fkine(cell.joints))
    there = Pose.from_matrix(goal.get(function, far.matrix))
    assert flange.almost_equal(there, position=1e-3, rotation=3e-3)


async def test_an_emergency_stop_leaves_the_axes_where_they_are(
    robot: aioduco.Robot, cell: Simulator
) -> None:
    with standing_time(cell):
        motion = await robot.external_axes.move_eaxis("rail", [2.0, 0.0, 0.0], 0.5).start()
        advance_until(cell, lambda: seen(cell) > 0.1)
        cell.emergency_stop()
    with pytest.raises(aioduco.TaskError):
        await motion
    at = await where(robot)
    assert 0.1 < at < 2.0
    cell.release_emergency_stop()
    await robot.bring_up()
    await robot.external_axes.move_eaxis("rail", [at, 0.0, 0.0], 0.5)
    assert await where(robot) == pytest.approx(at)


@pytest.mark.slow
async def test_a_jog_goes_on_to_the_end_of_the_way_or_until_it_is_ended(
    robot: aioduco.Robot, cell: Simulator
) -> None:
    begin = cell.time
    # So slow that the end of the way is far beyond whatever a busy machine takes to end it.
    jog = robot.external_axes.move_jog_eaxis("table", -1, vel=2, time=None)
    async with jog:
        await cell.wait_until_async(lambda: seen(cell, "table") < -0.02, 60.0)
    at = await where(robot, "table")
    assert -math.pi < at < -0.02
    assert cell.time - begin > 0.02 / 0.02  # a fiftieth of its jog speed of 1 rad/s
    async with robot.external_axes.move_jog_eaxis("table", 1, vel=100, time=None):
        await cell.wait_until_async(lambda: seen(cell, "table") == math.pi, 60.0)


@pytest.mark.slow
async def test_triggers_by_distance_are_without_effect(robot: aioduco.Robot) -> None:
    far = Pose.of(await robot.state.get_tcp_pose()).shifted(y=0.05)
    op = Op.at_start(output(3), distance=0.01) | Op.near_end(output(4), time=0.1)
    await robot.external_axes.movel_eaxis(far, v=0.5, a=2.0, op=op, **AXES)
    assert not await robot.io.get_standard_digital_out(3)
    assert await robot.io.get_standard_digital_out(4)


@pytest.mark.slow
async def test_what_axes_cannot_do_is_refused(robot: aioduco.Robot, cell: Simulator) -> None:
    axes = robot.external_axes
    far = axes.move_eaxis("rail", [3.1, 0.0, 0.0], 0.5)
    await refused(cell, far, aioduco.TaskFailed, "would leave -0.5 to 3")
    assert await where(robot) == 0.0
    # where it is, as read in 32 bits
    await axes.move_eaxis("table", [float(np.float32(-math.pi)), 0.0, 0.0], 2.0)
    assert await where(robot, "table") == pytest.approx(-math.pi, abs=1e-6)
    # As fast as it can, if it is asked for more.
    await axes.move_eaxis("rail", [1.0, 9.9, 9.9], 100.0)
    assert await where(robot) == 1.0


@pytest.mark.slow
async def test_axes_and_schemes_are_set_up_over_the_wire(
    robot: aioduco.Robot, cell: Simulator
) -> None:
    axes = robot.external_axes
    slide = ExternalAxis(
        type=0, mode=0, ref_velo=0.2, ref_acc=1.0, ref_jerk=0.0, max_velo=0.5, max_acc=2.0,
        encoder_type=0, encoder_resolution=17, position_bias=0.0, screw_lead=0.0, invert=False,
        position_limit=[0.0, 0.4],
    )  # fmt: skip
    scheme = ExternalAxisScheme(type=0, axis_link=[7], base=[0.0] * 6, dh=[], install=0)
    await axes.add_eaxis_scheme(5)
    await refused(cell, axes.enable_eaxis_scheme("scheme5"), aioduco.TaskIllegal, "no axes")
    await refused(
        cell,
        axes.set_eaxiss_scheme_param(5, scheme),
        aioduco.TaskParameterMismatch,
        "has not been set up",
    )
    await axes.set_eaxis_param(7, slide)
    await axes.set_eaxiss_scheme_param(5, scheme)
    await axes.enable_eaxis_scheme("scheme5")
    await axes.move_eaxis("scheme5", [0.3, 0.0, 0.0], 0.5)
    assert await where(robot, "scheme5") == pytest.approx(0.3)
    await refused(cell, axes.delete_eaxis_scheme(5), aioduco.TaskIllegal, "is active")
    await refused(cell, axes.set_eaxis_param(7, slide), aioduco.TaskIllegal, "in use")
    await axes.disable_eaxis_scheme("scheme5")
    await axes.delete_eaxis_scheme(5)
    await refused(cell, axes.delete_eaxis_scheme(5), aioduco.TaskIllegal, "no scheme 5")


@for_each(
    "schemes",
    [
        {"rail": []},
        {"rail": [Axis(1.0, 0.0, 1.0, 1.0)]},
        {"rail": [Axis(0.0, math.nan, 1.0, 1.0)]},
        {"rail": [Axis(0.0, 1.0, 0.0, 1.0)]},
        {"rail": [RAIL] * 4},
    ],
)
def test_schemes_that_make_no_sense(schemes: dict[str, list[Axis]]) -> None:
    with pytest.raises(ValueError, match=r"external.axes"):
        Simulator(external_axes=schemes)


WRONG: list[tuple[str, tuple[Any, ...], TaskState]] = [
    ("move_eaxis", ("rail", [0.1, 0.0], 0.5), TaskState.PARAMETER_MISMATCH),
    ("move_eaxis", ("rail", [math.nan, 0.0, 0.0], 0.5), TaskState.PARAMETER_MISMATCH),
    ("move_eaxis", ("rail", [0.1, 0.0, 0.0], 0.0), TaskState.PARAMETER_MISMATCH),
    ("move_eaxis", ("rail", [0.1, 0.0, 0.0], math.inf), TaskState.PARAMETER_MISMATCH),
    ("move_eaxis", ("", [0.1, 0.0, 0.0], 0.5), TaskState.ILLEGAL),
    ("move_jog_eaxis", ("rail", 0, 10.0), TaskState.PARAMETER_MISMATCH),
    ("move_jog_eaxis", ("rail", 1, 101.0), TaskState.PARAMETER_MISMATCH),
    ("move_jog_eaxis", ("crane", 1, 10.0), TaskState.ILLEGAL),
    ("movel_eaxis", ([0.5] * 5, 0.1, 1.0), TaskState.PARAMETER_MISMATCH),
    ("movej2_eaxis", ([0.0] * 5, 0.5, 1.0), TaskState.ILLEGAL),
    ("add_eaxis_scheme", (-1,), TaskState.PARAMETER_MISMATCH),
    ("set_eaxis_param", (0, EAxisParam()), TaskState.PARAMETER_MISMATCH),
    ("delete_eaxis_scheme", (9,), TaskState.ILLEGAL),
]


@for_each("function, arguments, state", WRONG)
def test_calls_that_make_no_sense(
    cell: Simulator, function: str, arguments: tuple[Any, ...], state: TaskState
) -> None:
    with RawClient(cell.port) as client:
        for name in ("power_on", "enable"):
            assert client.call(name, block=True) == TaskState.FINISHED
        assert client.call(function, *arguments, block=True) == state


@pytest.mark.usefixtures("robot")
async def test_a_jog_that_stop_manual_move_ends_is_finished(
    cell: Simulator, connect: Connect
) -> None:
    program = connect(cell)
    id_ = program.move_jog_eaxis("table", -1, 2.0, False)
    await cell.wait_until_async(lambda: seen(cell, "table") < -0.002, 60.0)
    assert program.stop_manual_move(True) == TaskState.FINISHED
    assert program.get_noneblock_taskstate(id_) == TaskState.FINISHED
