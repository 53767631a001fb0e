"""Measures tool and load for the page that commands, step by step.

`Measurement` keeps what was read, without I/O; `take_step` and `write` use the robot of the lease.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import anyio
import numpy as np

from aioduco import Load, Pose
from aioduco.errors import CalibrationError, ParameterError
from aioduco.kinematics import (
    calibrate_tool_axes,
    calibrate_tool_tip,
    gravity,
    identify_load_by_forces,
    identify_load_by_torques,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco import Joints, Robot
    from aioduco.integrations.panel.page_requests import MeasureStep, WriteMeasured
    from aioduco.kinematics import Arm, MeasuredLoad, ToolAxes, ToolTip
    from aioduco.kinematics.mounting import MountingLike


#: readings of a pose, and seconds between two
_READINGS: Final = 50
_EVERY: Final = 0.02
#: largest difference of a joint over these readings [rad]
_AT_REST: Final = 2e-3
_MIN_TOUCHES: Final = 4
_MIN_POSES: Final = 6


class Measurement:
    """What was read of a tool and a load, and what follows from it.

    Args:
        arm: the arm.
        mounting: where its base is in the world.

    Attributes:
        arm: the arm; the panel sets it.
        touches: poses of the flange at the touches.
        ahead: pose of the flange with the point ahead of the tip; None until it was read.
        beside: the same with the point on the side of the x axis.
        poses: joints and reading of each pose of the load.
        sensor: what was read of a load: "torque" or "force".
        known: load that the controller knows of, in the flange's frame.
        written: whether a load was written after the first of these poses.
        gravity: acceleration of gravity along the base's axes [m/s²].
    """

    def __init__(self, arm: Arm, mounting: MountingLike = "floor") -> None:
        self.arm: Arm = arm
        self.gravity: list[float] = gravity(mounting).tolist()
        self.touches: list[Pose] = []
        self.ahead: Pose | None = None
        self.beside: Pose | None = None
        self.poses: list[tuple[Joints, Sequence[float]]] = []
        self.sensor: str = "torque"
        self.known: Load = Load(0.0)
        self.written: bool = False

    def tip(self) -> ToolTip:
        """Compute the tool's tip.

        Raises:
            CalibrationError: the touches do not determine it.
        """
        if len(self.touches) < _MIN_TOUCHES:
            raise CalibrationError(f"touch the point {_MIN_TOUCHES} times or more")
        return calibrate_tool_tip(self.touches)

    def axes(self) -> ToolAxes | None:
        """Compute the tool's axes; None if their positions were not read.

        Raises:
            CalibrationError: the positions do not determine them.
        """
        if self.ahead is None or self.beside is None:
            return None
        return calibrate_tool_axes(self.tip(), self.ahead, self.beside)

    def load(self) -> MeasuredLoad:
        """Compute the load.

        Raises:
            CalibrationError: the readings do not determine it.
        """
        if len(self.poses) < _MIN_POSES:
            raise CalibrationError(f"read {_MIN_POSES} poses or more, eight are good")
        joints, read = zip(*self.poses, strict=True)
        if self.sensor == "force":
            flanges = [self.arm.fkine(q) for q in joints]
            return identify_load_by_forces(flanges, read, gravity=self.gravity)
        return identify_load_by_torques(
            self.arm, joints, read, known=self.known, gravity=self.gravity
        )

    def as_json(self) -> dict[str, object]:
        """What pages show."""
        return {
            "tell": "measured",
            "tool": f"{len(self.touches)} touches: {self._tool_text()}",
            "load": f"{len(self.poses)} poses: {self._load_text()}",
        }

    def _tool_text(self) -> str:
        try:
            tip, axes = self.tip(), self.axes()
        except CalibrationError as error:
            return str(error)
        x, y, z = (part * 1e3 for part in tip.tip)
        text = f"tip at {x:.2f}, {y:.2f}, {z:.2f} mm, within {tip.uncertainty * 1e3:.2f} mm"
        if axes is None:
            return text
        tilt, turn = map(math.degrees, axes.uncertainty)
        return f"{text}; z axis within {tilt:.2f}°, the turn about it within {turn:.2f}°"

    def _load_text(self) -> str:
        try:
            found = self.load()
        except CalibrationError as error:
            return str(error)
        x, y, z = (part * 1e3 for part in found.load[1:])
        return (
            f"{found.load.mass:.3f} kg within {found.uncertainty[0]:.3f} kg, at {x:.1f}, {y:.1f}, "
            f"{z:.1f} mm within {found.uncertainty[1] * 1e3:.1f} mm"
        )


async def take_step(measured: Measurement, robot: Robot, request: MeasureStep) -> None:
    """Read what a step needs, or forget what was read."""
    match request.step:
        case "touch":
            measured.touches.append(await robot.state.get_flange_pose())
        case "ahead":
            measured.ahead = await robot.state.get_flange_pose()
        case "beside":
            measured.beside = await robot.state.get_flange_pose()
        case "pose":
            await _read_pose(measured, robot, request.sensor)
        case "drop_touch":
            del measured.touches[-1:]
        case "drop_pose":
            del measured.poses[-1:]
        case "clear":
            measured.touches.clear()
            measured.poses.clear()
            measured.ahead = measured.beside = None


async def _read_pose(measured: Measurement, robot: Robot, sensor: str) -> None:
    if measured.poses and sensor != measured.sensor:
        raise ParameterError("sensor", sensor, f"{measured.sensor}, as for the other poses")
    known = await robot.frames.get_tool_load()
    if measured.poses and (measured.written or known != measured.known):
        raise CalibrationError(
            "the controller's load has changed since the first pose: begin again"
        )
    begun = await robot.state.get_actual_joints_position()
    read = robot.force.fc_get_ft if sensor == "force" else robot.state.get_ext_torque
    values, due = [], anyio.current_time()
    for _ in range(_READINGS):
        values.append(await read())
        due += _EVERY
        await anyio.sleep_until(due)
    mean = np.mean(values, axis=0)
    if not np.isfinite(mean).all():
        raise CalibrationError(f"the controller tells no {sensor}: nothing was stored")
    joints = await robot.state.get_actual_joints_position()
    if not joints.almost_equal(begun, _AT_REST):
        raise CalibrationError("the arm moved while it was read: nothing was stored")
    if not measured.arm.fits(joints, await robot.state.get_flange_pose()):
        raise CalibrationError(
            f"the arm is no {measured.arm.name}, by the place of its flange: start the panel with "
            "its model; nothing was stored"
        )
    measured.sensor, measured.known, measured.written = sensor, known, False
    measured.poses.append((joints, mean.tolist()))


async def write(measured: Measurement, robot: Robot, request: WriteMeasured) -> str:
    """Write a result to the controller, and return what was written.

    Raises:
        CalibrationError: there is no result; nothing was written.
        ParameterError: what is held would weigh nothing; nothing was written.
    """
    frames = robot.frames
    if request.what == "tip":
        tip, axes = measured.tip().tip.tolist(), measured.axes()
        known = await frames.get_tcp_offset()
        offset = Pose(*tip, *known[3:]) if axes is None else axes.frame
        await frames.set_tool_data(request.name, offset, await frames.get_tool_load())
    else:
        load = measured.load().load
        offset = await frames.get_tcp_offset()
        measured.written = True  # also if that fails: it may have been carried out
        if request.what == "held":
            held = load.without_load(await frames.get_tool_load()).in_tool(offset)
            await frames.set_load_data(held)
            return f"the controller takes {held.mass:.3f} kg for what the tool holds"
        await frames.set_tool_data(request.name, offset, load)
    return f"the controller uses the tool {request.name!r} from now on"
