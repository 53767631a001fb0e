"""The arm in MuJoCo: joints driven by position servos, gravity, contact, a sensor at the flange."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.sim.mjcf import mjcf

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.mover import SetPoint

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco

__all__ = ["World"]

_BRAKE = 0.5  # torque of a brake, of its drive's; an assumption
_NOTHING = 1e-6  # mass that stands for none [kg]


class World:
    """An arm that follows set-points, one step at a time. Belongs to one thread.

    Each servo holds its joint at the set-point; what the motion needs on top of that, inertia,
    gravity and Coriolis forces, is computed and fed forward, as a controller with a dynamic model
    does. Torques end at the drives' limits.

    Args:
        arm: the arm.
        timestep: of one step [s].
        q: joints at the start [rad]. Shape (6,); None for zero, straight up.
    """

    def __init__(self, arm: Arm, timestep: float = 0.001, q: Array | None = None) -> None:
        self.arm = arm
        self.model: Any = mujoco.MjModel.from_xml_string(mjcf(arm, timestep))
        self.data: Any = mujoco.MjData(self.model)
        self._stiffness = self.model.actuator_gainprm[:, 0].copy()
        self._damping = -self.model.actuator_biasprm[:, 2] / self._stiffness
        self._timestep = timestep
        self._change = self._stiffness * self._damping * timestep
        self._effort = np.array(arm.effort)
        self._hold = _BRAKE * self._effort
        self._feed = np.empty(6)
        self._flange = self.model.site("flange").id
        self._braked = False
        self.reset(np.zeros(6) if q is None else q)

    def reset(self, q: Array) -> None:
        """Stand at q [rad] at once."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:] = q
        self.data.ctrl[:] = q
        mujoco.mj_forward(self.model, self.data)

    def step(self, setpoint: SetPoint) -> None:
        """Go on by one time step, towards a set-point for its end."""
        data = self.data
        if self._braked:
            # The brakes carry the weight, as far as they reach: MuJoCo's friction would creep.
            np.clip(data.qfrc_bias, -self._hold, self._hold, out=data.qfrc_applied)
        else:
            # Mass matrix and forces are those of the last step's beginning: a millisecond old.
            feed = self._feed
            mujoco.mj_mulM(self.model, data, feed, setpoint.qdd)
            feed += data.qfrc_bias
            feed /= self._stiffness
            # MuJoCo pulls at the joint where the step begins, and damps the speed that the step
            # ends with, which is its mean speed: both are taken from the set-point of the end.
            feed += setpoint.q + (self._damping - self._timestep) * setpoint.qd
            feed -= (0.5 * self._timestep) * (self._damping - self._timestep) * setpoint.qdd
            data.ctrl[:] = feed
        # Releases the GIL for its few microseconds: what waits for it may come in between.
        mujoco.mj_step(self.model, data)

    def load(self, mass: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Mount a load at the flange, and tell the servos about it.

        Args:
            mass: of the load, a point without inertia of its own [kg]; zero takes it off.
            centre: its centre of mass in the frame of the flange [m].
        """
        body = self.model.body("flange")
        body.mass[:] = max(mass, _NOTHING)
        body.ipos[:] = centre
        # What follows from the masses is computed on a copy, since it is left at the zero pose.
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))
        mujoco.mj_forward(self.model, self.data)

    def push(self, wrench: Sequence[float]) -> None:
        """Push at the flange from now on.

        Args:
            wrench: force [N], then torque [N m], in the base frame, at the flange; zeros to end.
        """
        self.data.xfrc_applied[self.model.body("flange").id] = wrench

    def brake(self, on: bool) -> None:
        """Let the joint brakes fall and cut the drives' power, or the reverse.

        The brakes hold by friction: a moving arm is slowed down by them, a standing one stays.
        """
        self._braked = on
        self.model.opt.disableactuator = 1 if on else 0
        self.model.dof_frictionloss[:] = self._hold if on else 0.0
        self.data.qfrc_applied[:] = 0.0

    @property
    def braked(self) -> bool:
        """Whether the brakes hold and the drives have no power."""
        return self._braked

    @property
    def time(self) -> float:
        """Simulated time since the last reset [s]."""
        return float(self.data.time)

    @property
    def q(self) -> Array:
        """Joint angles [rad]. Shape (6,)."""
        return np.array(self.data.qpos)

    @property
    def qd(self) -> Array:
        """Joint speeds [rad/s]. Shape (6,)."""
        return np.array(self.data.qvel)

    @property
    def qdd(self) -> Array:
        """Joint accelerations [rad/s²]. Shape (6,)."""
        return np.array(self.data.qacc)

    @property
    def torque(self) -> Array:
        """Torques of the drives in the last step [N m]. Shape (6,)."""
        # MuJoCo gives them for the speed that the step began with, but integrates them with the
        # damping at the speed that it ended with, unless the drive is at its limit.
        torque = np.array(self.data.actuator_force)
        if not self._braked:
            torque -= self._change * self.data.qacc * (np.abs(torque) < self._effort)
        return torque

    @property
    def wrench(self) -> Array:
        """Force [N] and torque [N m] that the world applies to the flange, in its frame. (6,)"""
        return -np.array(self.data.sensordata)

    def flange(self) -> Array:
        """Give the pose of the flange in the base frame. Shape (4, 4)."""
        # A step leaves the frames where they were at its beginning.
        mujoco.mj_kinematics(self.model, self.data)
        pose = np.eye(4)
        pose[:3, :3] = self.data.site_xmat[self._flange].reshape(3, 3)
        pose[:3, 3] = self.data.site_xpos[self._flange]
        return pose
