"""State of arm and controller after a cycle, for readers without a lock.

Each cycle makes a snapshot, and most are never read. So values that can be derived are derived
only on access.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array
    from aioduco.sim.controller.state_machine import ControllerState
    from aioduco.sim.cycle import PlantReading, SensedState
    from aioduco.sim.planner.path import JointSetPoint


class SimulationSnapshot(NamedTuple):
    """Arm and controller after one cycle. It never changes.

    While the controller simulates, joints, set-point and wrench are those of its simulated arm;
    torques, temperatures and `positions` stay those of the real one.

    Attributes:
        known: the controller's measurements of the arm.
        reading: state of the physics.
        qdd: joint accelerations of the arm that `known` describes [rad/s²]. Shape (6,).
        setpoint: set-point that the drives have followed up to this instant.
        view: the controller's state.
        external: observed external torques at the joints [N m]. Six.
        warmth: temperatures of joints and drive boards [°C]. Shapes (6,).
    """

    known: SensedState
    reading: PlantReading
    qdd: Array
    setpoint: JointSetPoint
    view: ControllerState
    external: Sequence[float]
    warmth: tuple[Array, Array]

    def seen(self, view: ControllerState) -> SimulationSnapshot:
        """Give a snapshot of the same arm with another state of the controller."""
        return self if view is self.view else self._replace(view=view)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.known.time

    @property
    def q(self) -> Array:
        """Actual joints [rad]. Shape (6,)."""
        return self.known.q

    @property
    def qd(self) -> Array:
        """Actual joint speeds [rad/s]. Shape (6,)."""
        return self.known.qd

    @property
    def wrench(self) -> Array:
        """Force and torque on the flange, in its frame, with the load's weight [N, N m]. (6,)"""
        return self.known.wrench

    @property
    def positions(self) -> Array:
        """Positions of all moving parts, the joints first [rad, m]."""
        return self.reading.positions

    @property
    def torque(self) -> Array:
        """Actual joint torques [N m]. Shape (6,)."""
        return self.reading.torque

    @property
    def target_torque(self) -> Array:
        """Joint torques that the motion of the set-point needs [N m]. Shape (6,)."""
        return self.reading.target_torque

    @property
    def external_torque(self) -> Array:
        """Observed external torques at the joints [N m]. Shape (6,)."""
        return np.array(self.external)

    @property
    def joint_temperature(self) -> Array:
        """Temperatures of the joints [°C]. Shape (6,)."""
        return self.warmth[0]

    @property
    def board_temperature(self) -> Array:
        """Temperatures of the drive boards [°C]. Shape (6,)."""
        return self.warmth[1]
