"""Data that the controller and the physics exchange in each cycle.

The controller takes a `SensedState` and returns a `DriveCommand`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.rotation import Array
    from aioduco.sim.planner.path import JointSetPoint


def untouched() -> str:
    """Say that the arm touches nothing."""
    return ""


class SensedState(NamedTuple):
    """Measurements of the arm that the controller has in one cycle.

    Attributes:
        time: simulated time [s].
        now: real time, which the heartbeat uses [s].
        q: actual joints [rad]. Shape (6,).
        qd: actual joint speeds [rad/s]. Shape (6,).
        wrench: signal of the force sensor: force and torque on the flange, in its frame, including
            the weight of its load [N, N m]. Shape (6,).
        external: torques that the motion needed beyond those of the drives [N m]. Shape (6,).
        touched: gives a text for messages about the arm's contacts; empty for no contact.
    """

    time: float
    now: float
    q: Array
    qd: Array
    wrench: Array
    external: Array
    touched: Callable[[], str] = untouched


class PlantReading(NamedTuple):
    """State of the physics after a step. None of the arrays is changed later.

    Attributes:
        positions: positions of all moving parts, the joints first [rad, m].
        q: joints [rad]. Shape (6,).
        qd: joint speeds [rad/s]. Shape (6,).
        qdd: joint accelerations [rad/s²]. Shape (6,).
        torque: joint torques [N m]. Shape (6,).
        wrench: force and torque on the flange, in its frame [N, N m]. Shape (6,).
        target_torque: torques that the motion of the set-point needs [N m]. Shape (6,).
        external_torque: torques that the motion needed beyond those of the drives [N m]: of
            external forces, and of errors of the load in the servos' model. Shape (6,).
    """

    positions: Array
    q: Array
    qd: Array
    qdd: Array
    torque: Array
    wrench: Array
    target_torque: Array
    external_torque: Array


class GripperReading(NamedTuple):
    """State of a gripper.

    Attributes:
        number: number of the order that it carries out.
        opening: distance between the fingers [m].
        moving: whether the order is still being carried out.
        caught: 1 if something stopped it while it closed, -1 while it opened, 0 if nothing did.
        lost: whether it has lost what it had caught.
    """

    number: int
    opening: float
    moving: bool
    caught: int
    lost: bool


class DriveCommand(NamedTuple):
    """Command to the drives: a set-point, or the brakes."""

    setpoint: JointSetPoint
    brake: bool
