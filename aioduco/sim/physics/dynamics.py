"""Inverse dynamics of the arm with the load that was set on the controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


NOTHING = 1e-6
"""Mass that stands for none [kg]."""


def mount(model: Any, mass: float, centre: Sequence[float]) -> None:
    """Change what the flange of a model carries.

    Args:
        model: MuJoCo model, with a body "flange" that has no other mass.
        mass: mass of the load, a point without inertia of its own [kg].
        centre: its centre of mass in the frame of the flange [m].
    """
    body = model.body("flange")
    body.mass[:] = max(mass, NOTHING)
    body.ipos[:] = centre
    # Computes what depends on the masses; it leaves the data that it gets at the zero pose.
    mujoco.mj_setConst(model, mujoco.MjData(model))


class InverseDynamics:
    """The torques that a motion needs, from a model that is separate from the world.

    The model has no contacts and no scene. The controller compares its torques with those in the
    world to find the external forces.

    Args:
        model: MuJoCo model of the arm with its tool, without a scene. It is modified.

    Attributes:
        positions, speeds: numbers of positions and of speeds of the arm and its tool.
    """

    def __init__(self, model: Any) -> None:
        off = mujoco.mjtDisableBit
        model.opt.disableflags |= (
            off.mjDSBL_CONSTRAINT | off.mjDSBL_ACTUATION | off.mjDSBL_SENSOR | off.mjDSBL_CONTACT
        )
        self._model, self._data = model, mujoco.MjData(model)
        self.positions: int = model.nq
        self.speeds: int = model.nv
        self._qpos: Array = self._data.qpos
        self._qvel: Array = self._data.qvel
        self._bias: Array = self._data.qfrc_bias
        self._acceleration, self._product = np.zeros(model.nv), np.zeros(model.nv)

    def load(self, mass: float, centre: Sequence[float]) -> None:
        """Take a load into account [kg, m]."""
        mount(self._model, mass, centre)

    def at(self, qpos: Array, qvel: Array) -> None:
        """Set the state for which `torque` computes torques from now on.

        Args:
            qpos: positions of the arm and its tool [rad].
            qvel: speeds of the arm and its tool [rad/s].
        """
        self._qpos[:] = qpos
        self._qvel[:] = qvel
        mujoco.mj_fwdPosition(self._model, self._data)
        mujoco.mj_fwdVelocity(self._model, self._data)

    def torque(self, acceleration: Array) -> Array:
        """Compute the torques that the arm needs for accelerations, and against its weight [N m].

        Args:
            acceleration: accelerations of the joints, or of arm and tool [rad/s²].

        Returns:
            Shape (6,), valid until the next call.
        """
        wanted = self._acceleration
        wanted[: acceleration.size] = acceleration
        wanted[acceleration.size :] = 0.0
        mujoco.mj_mulM(self._model, self._data, self._product, wanted)
        self._product += self._bias
        needed: Array = self._product[:6]
        return needed
