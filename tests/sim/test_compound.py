"""Combined motion over the wire: a weave over the paths that come (manual 1.3.13)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco._wire.rpc import Op
from aioduco.models.enums import TaskState
from aioduco.models.pose import Pose
from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.sim.simulator import READY, Simulator

from .conftest import Program
from .cycles import Cycles

END: Any = (0.0, [], "", "", True, Op(), False)
AMPLITUDE = 0.004


def configure(robot: Program, **given: Any) -> int:
    settings: dict[str, Any] = {
        "type": 2,
        "ref_plane": 0,
        "fq": 2.0,
        "amp": AMPLITUDE,
        "el_offset": 0.0,
        "az_offset": 0.0,
        "up_height": 0.0,
        "time": [0, 0],
        "path_dwell": False,
        "op_list": [],
    }
    return robot.combine_motion_config(*(settings | given).values())


def deviation(cycles: Cycles, sim: Simulator, start: Pose) -> float:
    """How far the tool has been from a way along y, at most [m]."""
    tips = sim.arm.fkine(np.array(cycles.q))[:, :3, 3]
    return float(np.abs(tips[:, (0, 2)] - np.array(start.position)[[0, 2]]).max())


@pytest.mark.slow
def test_a_weave_is_over_the_paths_while_it_is_enabled(
    sim: Simulator, robot: Program, cycles: Cycles
) -> None:
    start = Pose.of(robot.get_tcp_pose())
    there, back = list(start.shifted(y=0.1)), list(start)

    def along() -> float:
        cycles.clear()
        assert robot.movel(there, 0.1, 1.0, *END) == TaskState.FINISHED
        assert robot.movel(back, 0.1, 1.0, *END) == TaskState.FINISHED
        return deviation(cycles, sim, start)

    assert configure(robot) == TaskState.FINISHED
    assert along() < 3e-4
    assert robot.enable_combine_motion() == TaskState.FINISHED
    assert along() == pytest.approx(AMPLITUDE, abs=5e-4)
    tips = sim.arm.fkine(np.array(cycles.wanted))[:, :3, 3]
    out = tips[: len(tips) // 2]
    swings = round(0.1 / 0.1 * 2.0)
    # The tool points down, so that left of a way along y is along x.
    wave = AMPLITUDE * np.sin(2 * np.pi * swings * (out[:, 1] - start.y) / 0.1)
    assert np.abs(out[:, 0] - start.x - wave).max() < 5e-4
    # Another setting has effect when it is switched on next.
    assert configure(robot, amp=0.001) == TaskState.FINISHED
    assert along() == pytest.approx(AMPLITUDE, abs=5e-4)
    assert robot.disable_combine_motion() == TaskState.FINISHED
    assert along() < 3e-4


@pytest.mark.slow
@pytest.mark.parametrize("function", ["movec", "move_circle", "move_spiral", "spline", "tcp_move"])
def test_it_is_over_every_path_and_no_joint_motion(
    sim: Simulator, robot: Program, cycles: Cycles, function: str
) -> None:
    start = Pose.of(robot.get_tcp_pose())
    side, far = list(start.shifted(x=-0.05, y=0.05)), list(start.shifted(x=-0.1))
    rest = (True, Op(), False)
    calls: dict[str, tuple[Any, ...]] = {
        "movec": (side, far, 0.2, 1.0, 0.0, 1, [], "", "", *rest),
        "move_circle": (side, far, 0.2, 1.0, 0.0, 1, [], "", "", *rest),
        "move_spiral": (
            *(list(start.shifted(x=-0.05)), far, 0.5, 0.0, 0.03, 0),
            *(0.2, 1.0, [], "", "", *rest),
        ),
        "spline": ([side, far], 0.2, 1.0, "", "", True, Op(), 0.0, False),
        "tcp_move": ([0.0, 0.1, 0.0, 0.0, 0.0, 0.0], 0.2, 1.0, 0.0, "", *rest),
    }

    def way() -> Any:
        assert robot.to(*READY) == TaskState.FINISHED
        cycles.clear()
        assert getattr(robot, function)(*calls[function]) == TaskState.FINISHED
        return sim.arm.fkine(np.array(cycles.wanted[::10]))[:, :3, 3]

    plain = way()
    assert configure(robot, fq=5.0) == TaskState.FINISHED
    assert robot.enable_combine_motion() == TaskState.FINISHED
    woven = way()
    away = np.linalg.norm(woven[:, None] - plain[None], axis=2).min(axis=1)
    assert away.max() == pytest.approx(AMPLITUDE, abs=6e-4)  # the plain way is only sampled
    assert robot.to(*READY) == TaskState.FINISHED
    cycles.clear()
    assert robot.to(0.3, *READY[1:]) == TaskState.FINISHED
    middle = np.array(cycles.wanted) - cycles.wanted[0]
    ratio = middle @ middle[-1] / (middle[-1] @ middle[-1])
    assert np.abs(middle - ratio[:, None] * middle[-1]).max() < 1e-9


def test_it_is_switched_only_while_nothing_runs(sim: Simulator, robot: Program) -> None:
    assert robot.enable_combine_motion() == TaskState.ILLEGAL  # nothing has been set
    assert configure(robot) == TaskState.FINISHED
    robot.to(2.0, *READY[1:], v=0.002, block=False)
    sim.wait_until(lambda: sim.moving)
    assert configure(robot) == TaskState.FINISHED
    assert robot.enable_combine_motion() == TaskState.ILLEGAL
    assert robot.pause(True) == TaskState.FINISHED
    assert robot.disable_combine_motion() == TaskState.ILLEGAL
    assert robot.stop(True) == TaskState.FINISHED
    assert robot.enable_combine_motion() == TaskState.FINISHED


def test_the_plane_of_a_work_object_is_that_of_the_motion(
    sim: Simulator, robot: Program, cycles: Cycles
) -> None:
    assert robot.set_wobj("wall", [0.0, 0.0, 0.0, math.pi / 2, 0.0, 0.0]) == TaskState.FINISHED
    assert robot.set_wobj("bench", [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) == TaskState.FINISHED
    assert configure(robot, ref_plane=3, fq=4.0) == TaskState.FINISHED
    assert robot.enable_combine_motion() == TaskState.FINISHED
    for name, axis in (("bench", 1), ("wall", 2)):
        flange = Pose.of(robot.get_tcp_pose())
        target = list(Pose.of(robot.get_tcp_pose_coord("", name)).shifted(x=0.05))
        cycles.clear()
        rest: Any = (0.0, [], "", name, True, Op(), False)
        assert robot.movel(target, 0.1, 1.0, *rest) == TaskState.FINISHED
        tips = sim.arm.fkine(np.array(cycles.wanted))[:, :3, 3] - np.array(flange.position)
        assert np.abs(tips[:, axis]).max() == pytest.approx(AMPLITUDE, abs=5e-4)
        assert np.abs(tips[:, 3 - axis]).max() < 5e-4


def test_a_path_square_to_the_plane_is_refused(robot: Program) -> None:
    start = Pose.of(robot.get_tcp_pose())
    assert configure(robot) == TaskState.FINISHED
    assert robot.enable_combine_motion() == TaskState.FINISHED
    down = list(start.shifted(z=-0.1))
    assert robot.movel(down, 0.1, 1.0, *END) == TaskState.PARAMETER_MISMATCH
    assert "square to the plane" in robot.get_last_error()[-1]


@for_each(
    "wrong",
    [
        {"type": 0},
        {"type": 6},
        {"ref_plane": -1},
        {"ref_plane": 6},
        {"fq": 0.0},
        {"fq": math.nan},
        {"fq": math.inf},
        {"amp": -0.001},
        {"amp": math.nan},
        {"el_offset": math.nan},
        {"time": [100]},
        {"time": [100, -1]},
        {"op_list": [Op(time_or_dist_1=5)]},
    ],
)
def test_a_weave_that_makes_no_sense_is_not_set(strict: Program, wrong: dict[str, Any]) -> None:
    assert configure(strict, **wrong) == TaskState.PARAMETER_MISMATCH


def test_dwells_that_are_left_out_are_none(robot: Program) -> None:
    assert configure(robot, time=[]) == TaskState.FINISHED


@pytest.mark.slow
async def test_the_sdks_weave_with_dwells_takes_as_long_as_it_says(sim: Simulator) -> None:
    async with aioduco.connect(sim.host, sim.port) as robot:
        await robot.bring_up()
        start = await robot.state.get_tcp_pose()

        async def takes() -> float:
            begin = sim.time
            await robot.motion.movel(start.shifted(y=0.05), v=0.05, a=1.0)
            await robot.motion.movel(start, v=0.05, a=1.0)
            return sim.time - begin

        plain = await takes()
        await robot.compound.combine_motion_config(
            WeaveShape.TRIANGLE, WeavePlane.TOOL_XY, 2.0, 0.003, time=(0.3, 0.2), path_dwell=True
        )
        await robot.compound.enable_combine_motion()
        # Two swings each way, and in each the path waits on both sides.
        assert await takes() > plain + 4 * (0.3 + 0.2)
        await robot.compound.disable_combine_motion()
