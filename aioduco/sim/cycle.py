"""What passes between the controller and the physics, cycle by cycle.

The controller takes a `SensedState` and returns a `DriveCommand`. `Plant` is what the runtime needs
of the physics.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.models.pose import PoseLike
    from aioduco.sim.planner.path import JointSetPoint

    Vector = NDArray[np.float64]

__all__ = ["DriveCommand", "Plant", "PlantReading", "SensedState"]


def untouched() -> str:
    """Say that the arm touches nothing."""
    return ""


class SensedState(NamedTuple):
    """What the controller knows of the arm in one cycle.

    Attributes:
        time: simulated time [s].
        now: time of the network, for the heartbeat [s].
        q: actual joints [rad]. Shape (6,).
        qd: actual joint speeds [rad/s]. Shape (6,).
        wrench: signal of the force sensor: what acts on the flange, in its frame, the weight of
            what it carries included [N, N m]. Shape (6,).
        external: torques that the motion needed beyond those of the drives [N m]. Shape (6,).
        touched: says what of the arm touches what, for messages; empty for nothing.
    """

    time: float
    now: float
    q: Vector
    qd: Vector
    wrench: Vector
    external: Vector
    touched: Callable[[], str] = untouched


class PlantReading(NamedTuple):
    """The physics after a step. None of the arrays is changed later on.

    Attributes:
        positions: of everything that moves, the joints first [rad, m].
        q: joints [rad]. Shape (6,).
        qd: joint speeds [rad/s]. Shape (6,).
        qdd: joint accelerations [rad/s²]. Shape (6,).
        torque: joint torques [N m]. Shape (6,).
        wrench: what acts on the flange, in its frame [N, N m]. Shape (6,).
        target_torque: torques that the set-point's motion needs [N m]. Shape (6,).
        external_torque: torques that the motion needed beyond those of the drives [N m]. (6,)
    """

    positions: Vector
    q: Vector
    qd: Vector
    qdd: Vector
    torque: Vector
    wrench: Vector
    target_torque: Vector
    external_torque: Vector


class DriveCommand(NamedTuple):
    """What the drives get: a set-point, or the brakes."""

    setpoint: JointSetPoint
    brake: bool


class Plant(Protocol):
    """The physics, as far as the runtime needs them."""

    def reading(self) -> PlantReading:
        """Where all is, how it moves, and what acts on it."""
        ...

    def touched(self) -> str:
        """What of the arm touches what, for people; empty for nothing."""
        ...

    def step(self, setpoint: JointSetPoint) -> None:
        """Go on by one cycle."""

    def arrange(self, q: Vector, things: Mapping[str, PoseLike]) -> None:
        """Stand at q [rad] at once, with things of the scene at their poses [m, rad]."""

    @property
    def still(self) -> bool:
        """Whether nothing else in the scene moves."""
        ...

    def load(self, mass: float, centre: Sequence[float]) -> None:
        """Mount a load at the flange, and tell the drives about it [kg, m]."""

    def carry(self, mass: float, centre: Sequence[float]) -> None:
        """Mount a load at the flange, of which the drives know nothing [kg, m]."""

    def tell(self, mass: float, centre: Sequence[float]) -> None:
        """Tell the drives about a load [kg, m]."""

    def brake(self, on: bool) -> None:
        """Put the brakes on, or release them."""

    def push(self, wrench: Sequence[float]) -> None:
        """Push at the flange from now on [N, N m], in the base frame."""
