"""Tool and load as steps in the panel: requests, and the file that is written."""

from __future__ import annotations

import math
import re
from typing import Any, Literal

import numpy as np
import pytest

import aioduco
from aioduco import Load, Pose
from aioduco.errors import CalibrationError, ParameterError
from aioduco.integrations.panel import Panel
from aioduco.integrations.panel.measuring import Measurement, take_step, write
from aioduco.integrations.panel.page_requests import MeasureStep, Sensor, Step, WriteMeasured
from aioduco.kinematics import arm
from aioduco.models.rotation import matrix_from_rotvec
from aioduco.planning import Scene
from aioduco.sim import Simulator

HOME = (0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0)
TIP = np.array([0.01, -0.02, 0.15])
POINT = np.array([0.45, 0.15, 0.25])
GCR5 = arm("gcr5_910")
TURNS = [
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (0.0, -0.4, 0.3, 0.6, 0.5, 0.0),
    (0.0, 0.3, -0.4, -0.6, -0.5, 0.8),
    (0.0, -0.4, 0.6, 0.2, -0.7, 1.6),
    (0.0, 0.4, -0.2, -0.7, 0.6, -0.8),
    (0.0, 0.3, 0.3, 0.6, -0.5, -1.6),
]


def flange(number: int, to: tuple[float, ...] = (0.0, 0.0, 0.0), *, tilt: float = 0.6) -> Pose:
    """The flange with a place of the tool, from its tip, at the point."""
    side = number * math.pi / 3
    rotation = (
        matrix_from_rotvec(np.array([math.pi, 0.0, 0.0]))
        @ matrix_from_rotvec(tilt * np.array([math.cos(side), math.sin(side), 0.0]))
        @ matrix_from_rotvec(np.array([0.0, 0.0, 0.4 * number]))
    )
    return Pose.from_rotation(POINT - rotation @ (TIP + to), rotation)


def kilograms(text: str) -> float:
    """The first mass in a text."""
    found = re.search(r"([\d.]+) kg", text)
    assert found is not None, text
    return float(found[1])


async def read(measured: Measurement, robot: aioduco.Robot, step: Step, sensor: Sensor) -> None:
    await take_step(measured, robot, MeasureStep(step, sensor))


def test_what_is_missing_is_said() -> None:
    measured = Measurement(GCR5)
    assert measured.as_json() == {
        "tell": "measured",
        "tool": "0 touches: touch the point 4 times or more",
        "load": "0 poses: read 6 poses or more, eight are good",
    }
    measured.touches = [flange(0)] * 6
    assert "hardly turn the tool" in str(measured.as_json()["tool"])


@pytest.mark.slow
async def test_a_tool_is_measured_and_written() -> None:
    measured = Measurement(GCR5)
    options: dict[str, Any] = {"heartbeat": None}
    with Simulator(speed=math.inf, joints=HOME) as sim:
        async with aioduco.connect(sim.host, sim.port, **options) as robot:
            await robot.bring_up()

            async def go(pose: Pose) -> None:
                await robot.motion.movej2(GCR5.ikine(pose, HOME), v=2.0, a=5.0)
                await sim.wait_until_async(lambda: sim.view.standing)

            with pytest.raises(CalibrationError, match="touch the point"):
                await write(measured, robot, WriteMeasured("tip", "pen"))
            for number in range(6):
                await go(flange(number))
                await read(measured, robot, "touch", "torque")
            await read(measured, robot, "touch", "torque")
            await read(measured, robot, "drop_touch", "torque")
            assert "6 touches: tip at 10.0" in str(measured.as_json()["tool"])
            await go(flange(0, (0.0, 0.0, 0.06), tilt=0.0))
            await read(measured, robot, "ahead", "torque")
            await go(flange(0, (0.05, 0.0, 0.06), tilt=0.0))
            await read(measured, robot, "beside", "torque")
            assert "z axis within" in str(measured.as_json()["tool"])
            said = await write(measured, robot, WriteMeasured("tip", "pen"))
            assert said == "the controller uses the tool 'pen' from now on"
            offset = await robot.frames.get_tcp_offset()
            x, y, z = TIP.tolist()
            told = Pose(x, y, z, 0.0, 0.0, 0.0)
            assert offset.almost_equal(told, position=1e-4, rotation=1e-3)
            with pytest.raises(ParameterError, match="name"):
                await write(measured, robot, WriteMeasured("tip", ""))
            await read(measured, robot, "clear", "torque")
            assert (measured.touches, measured.ahead) == ([], None)


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("sensor", "mounting"), [("torque", "floor"), ("force", "floor"), ("torque", "ceiling")]
)
async def test_a_load_is_measured_and_written(
    monkeypatch: pytest.MonkeyPatch, sensor: Sensor, mounting: Literal["floor", "ceiling"]
) -> None:
    monkeypatch.setattr("aioduco.integrations.panel.measuring._EVERY", 0.0)
    measured, hidden = Measurement(GCR5, mounting), Load(1.5, 0.02, -0.01, 0.1)
    options: dict[str, Any] = {"heartbeat": None}
    with Simulator(speed=math.inf, joints=HOME, mounting=mounting) as sim:
        sim.load(hidden.mass, hidden[1:])
        async with aioduco.connect(sim.host, sim.port, **options) as robot:
            await robot.bring_up()
            await robot.frames.set_tool_data("pen", Pose(0, 0, 0.12, 0, 0, 0), Load(0.5, z=0.05))
            for turn in TURNS:
                await robot.motion.movej2(np.add(HOME, turn), v=2.0, a=5.0)
                await sim.wait_until_async(lambda: sim.view.standing)
                await read(measured, robot, "pose", sensor)
            with pytest.raises(ParameterError, match="as for the other poses"):
                await read(measured, robot, "pose", "force" if sensor == "torque" else "torque")
            shown = str(measured.as_json()["load"])
            assert shown.startswith("6 poses: ")
            assert kilograms(shown) == pytest.approx(1.5, abs=0.01)
            said = await write(measured, robot, WriteMeasured("held", ""))
            assert said.endswith("for what the tool holds")
            assert kilograms(said) == pytest.approx(1.0, abs=0.01)
            await write(measured, robot, WriteMeasured("load", "whole"))
            assert np.allclose(await robot.frames.get_tool_load(), hidden, atol=0.01)
            with pytest.raises(CalibrationError, match="load has changed"):
                await read(measured, robot, "pose", sensor)
            await read(measured, robot, "drop_pose", sensor)
            assert len(measured.poses) == 5


async def test_a_pose_at_which_the_arm_moves_is_not_stored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aioduco.integrations.panel.measuring._READINGS", 1)
    measured = Measurement(GCR5)
    with Simulator(joints=HOME) as sim:
        async with aioduco.connect(sim.host, sim.port, heartbeat=None, clock=sim.clock) as robot:
            await robot.bring_up()
            moving = await robot.motion.movej2((3.0, *HOME[1:]), v=0.2, a=5.0).start()
            await sim.wait_until_async(lambda: sim.joints[0] > 0.1)
            with pytest.raises(CalibrationError, match="the arm moved"):
                await read(measured, robot, "pose", "torque")
            await moving.cancel()
    assert not measured.poses


async def test_a_load_is_not_measured_with_another_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aioduco.integrations.panel.measuring._READINGS", 1)
    measured = Measurement(GCR5)
    with Simulator("gcr10_1300", joints=HOME) as sim:
        async with aioduco.connect(sim.host, sim.port, heartbeat=None) as robot:
            with pytest.raises(CalibrationError, match="the arm is no gcr5_910"):
                await read(measured, robot, "pose", "torque")
    assert not measured.poses


def test_the_load_of_a_panel_hangs_as_the_arm_of_its_scene_is_mounted() -> None:
    panel = Panel("192.0.2.1", scene=Scene("gcr5_910", mounting="ceiling"))
    assert panel._measured.gravity == pytest.approx([0.0, 0.0, 9.81], abs=1e-9)
