"""State of arm and controller after a cycle, for readers without a lock.

Each cycle makes a snapshot, and most are never read. So values that can be derived are derived
only on access.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array
    from aioduco.sim.controller.state_machine import ControllerState
    from aioduco.sim.cycle import PlantReading, SensedState
    from aioduco.sim.planner.path import JointSetPoint


__all__ = ["SimulationSnapshot"]


class SimulationSnapshot:
    """Arm and controller after one cycle. It never changes.

    While the controller simulates, joints, set-point and wrench are those of its simulated arm;
    torques, temperatures and `positions` stay those of the real one.

    Args:
        known: the controller's measurements of the arm.
        reading: state of the physics.
        qdd: joint accelerations of the arm that `known` describes [rad/s²]. Shape (6,).
        setpoint: set-point that the drives have followed up to this instant.
        view: the controller's state.
        external: observed external torques at the joints [N m]. Six.
        warmth: temperatures of joints and drive boards [°C]. Shapes (6,).
    """

    __slots__ = ("_external", "_known", "_reading", "_warmth", "qdd", "setpoint", "view")

    def __init__(
        self,
        known: SensedState,
        reading: PlantReading,
        qdd: Array,
        setpoint: JointSetPoint,
        view: ControllerState,
        external: Sequence[float],
        warmth: tuple[Array, Array],
    ) -> None:
        self._known = known
        self._reading = reading
        self.qdd: Array = qdd
        self.setpoint: JointSetPoint = setpoint
        self.view: ControllerState = view
        self._external = external
        self._warmth = warmth

    def seen(self, view: ControllerState) -> SimulationSnapshot:
        """Give a snapshot of the same arm with another state of the controller."""
        if view is self.view:
            return self
        return SimulationSnapshot(
            self._known,
            self._reading,
            self.qdd,
            self.setpoint,
            view,
            self._external,
            self._warmth,
        )

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._known.time

    @property
    def q(self) -> Array:
        """Actual joints [rad]. Shape (6,)."""
        return self._known.q

    @property
    def qd(self) -> Array:
        """Actual joint speeds [rad/s]. Shape (6,)."""
        return self._known.qd

    @property
    def wrench(self) -> Array:
        """Force and torque on the flange, in its frame, with the load's weight [N, N m]. (6,)"""
        return self._known.wrench

    @property
    def positions(self) -> Array:
        """Positions of all moving parts, the joints first [rad, m]."""
        return self._reading.positions

    @property
    def torque(self) -> Array:
        """Actual joint torques [N m]. Shape (6,)."""
        return self._reading.torque

    @property
    def target_torque(self) -> Array:
        """Joint torques that the motion of the set-point needs [N m]. Shape (6,)."""
        return self._reading.target_torque

    @property
    def external_torque(self) -> Array:
        """Observed external torques at the joints [N m]. Shape (6,)."""
        return np.array(self._external)

    @property
    def joint_temperature(self) -> Array:
        """Temperatures of the joints [°C]. Shape (6,)."""
        return self._warmth[0]

    @property
    def board_temperature(self) -> Array:
        """Temperatures of the drive boards [°C]. Shape (6,)."""
        return self._warmth[1]
