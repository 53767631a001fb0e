"""What goes into the controller and comes out of it, cycle by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
    from aioduco.sim.force.sensor import Sensor
    from aioduco.sim.frames import Tool, WorkObject
    from aioduco.sim.planner.mover import SetPoint

    Vector = NDArray[np.float64]

__all__ = ["Drive", "Sensed", "View"]


class Sensed(NamedTuple):
    """What the controller knows of the arm in one cycle.

    Attributes:
        time: simulated time [s].
        now: time of the network, for the heartbeat [s].
        q: actual joints [rad]. Shape (6,).
        qd: actual joint speeds [rad/s]. Shape (6,).
        wrench: signal of the force sensor: what acts on the flange, in its frame, the weight of
            what it carries included [N, N m]. Shape (6,).
        external: torques that the motion needed beyond those of the drives [N m]. Shape (6,).
    """

    time: float
    now: float
    q: Vector
    qd: Vector
    wrench: Vector
    external: Vector


class Drive(NamedTuple):
    """What the drives get: a set-point, or the brakes."""

    setpoint: SetPoint
    brake: bool


class View(NamedTuple):
    """The controller's state at one instant, for readers without a lock.

    Attributes:
        robot, program, safety, mode: as get_robot_state tells them.
        moving: whether the arm moves, as robotmoving tells it: what swings out does not.
        emergency_stop: whether the emergency stop is pressed.
        collision_axis: joint that detected a collision, 1 to 6, or 0.
        error: 1 while a safety stop holds, else 0.
        errors: the error list.
        speed: global speed [%].
        tool: the tool in use.
        wobj: the work object in use.
        force_control: whether force control is on.
        sensor: how the signal of the force sensor is read.
        standing: whether the arm has stood for a while.
    """

    robot: RobotState
    program: ProgramState
    safety: SafetyState
    mode: OperationMode
    moving: bool
    emergency_stop: bool
    collision_axis: int
    error: int
    errors: tuple[str, ...]
    speed: int
    tool: Tool
    wobj: WorkObject
    force_control: bool
    sensor: Sensor
    standing: bool
