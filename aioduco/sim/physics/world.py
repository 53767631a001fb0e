"""The arm in MuJoCo: joints driven by position servos, gravity, contact, a sensor at the flange."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models.pose import Pose, PoseLike
from aioduco.models.rotation import Array, transform
from aioduco.sim.cycle import PlantReading
from aioduco.sim.physics.dynamics import InverseDynamics, mount
from aioduco.sim.physics.gripper import Hand, gripper_mjcf
from aioduco.sim.physics.model import SERVOS, assemble, compiled, dressed, mjcf
from aioduco.sim.physics.parts import Parts, add_welds

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.gripper_models import GripperModel
    from aioduco.sim.physics.drives import TrailingDrives
    from aioduco.sim.planner.path import JointSetPoint

    mujoco: Any  # its bindings are compiled, without types
else:
    import mujoco


_BRAKE = 0.5  # torque of a brake as a share of its drive's; an assumption
_CREEP = 5e-3  # joint speed from which dry friction has its full size [rad/s]
_STILL = 1e-3  # speed below which a thing is at rest [m/s, rad/s]


def camera_of(model: Any, name: str, positions: Array) -> tuple[float, Array]:
    """Give a camera's vertical angle of view [rad], and its frame in the world. Shape (4, 4).

    Args:
        model: MuJoCo model.
        name: name of a camera of the scene or the tool.
        positions: positions of everything that moves.

    Raises:
        ParameterError: there is no such camera.
    """
    names = [model.camera(i).name for i in range(model.ncam)]
    found = [names.index(full) for full in (f"scene/{name}", f"tool/{name}") if full in names]
    if not found:
        raise ParameterError("name", name, f"one of the scene's cameras: {names}")
    data = mujoco.MjData(model)
    data.qpos[:] = positions
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
    # MuJoCo's cameras look along -z, with y up.
    turn = data.cam_xmat[found[0]].reshape(3, 3) * (1.0, -1.0, -1.0)
    return float(np.radians(model.cam_fovy[found[0]])), transform(turn, data.cam_xpos[found[0]])


class World:
    """An arm that follows set-points, one step at a time. Only one thread may use it.

    Each servo holds its joint at the set-point. The torques against inertia, gravity and Coriolis
    forces are computed and fed forward, as a controller with a dynamic model does. Torques are
    limited to those of the drives.

    Args:
        arm: the arm.
        timestep: length of one step [s].
        q: joints at the start [rad]. Shape (6,); None for zero, straight up.
        scene: what stands around it, as `scene.mjcf_of` gives it.
        tool: what it carries, likewise; the servos' model includes its mass.
        mounting: pose of its base in the world; None for on the floor.
        pedestal: whether it stands on a column there.
        gripper: a gripper that drives its fingers, in place of a tool.
        drives: how the joints trail their set-points; None if they follow at once.
        compensated: dry friction [N m] and viscous friction [N m s/rad] for which the drives
            compensate, six each: it shows in their torques alone, unlike that of `drag`.

    Raises:
        SceneError: MuJoCo rejects the scene or the tool.
    """

    def __init__(
        self,
        arm: Arm,
        timestep: float = 0.001,
        q: Array | None = None,
        *,
        scene: str | None = None,
        tool: str | None = None,
        mounting: Pose | None = None,
        pedestal: bool = False,
        gripper: GripperModel | None = None,
        drives: TrailingDrives | None = None,
        compensated: tuple[Sequence[float], Sequence[float]] | None = None,
    ) -> None:
        self.arm = arm
        self._drives = drives
        self._compensated = None
        if compensated is not None:
            self._compensated = np.array(compensated[0]), np.array(compensated[1])
        self.mounting: Pose = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0) if mounting is None else mounting
        if gripper is not None:
            tool = gripper_mjcf(gripper)
        bare = mjcf(arm, timestep, self.mounting, pedestal=pedestal)
        self._spec = assemble(bare, scene, tool)
        add_welds(self._spec)
        self.model: Any = compiled(self._spec)
        self.data: Any = mujoco.MjData(self.model)
        #: the gripper, if there is one
        self.hand: Hand | None = None
        if gripper is not None:
            self.hand = Hand(self.model, self.data, gripper)
        #: the loose things of the scene
        self.parts: Parts = Parts(self.model, self.data, self.hand, self.geom_label)
        # The servos' model: the arm with the tool and the load that was set, without the scene.
        self._known = InverseDynamics(compiled(assemble(bare, None, tool)))
        self._stiffness = self.model.actuator_gainprm[:6, 0].copy()
        self._damping = -self.model.actuator_biasprm[:6, 2] / self._stiffness
        self._timestep = timestep
        self._lead: Array = self._damping - timestep
        self._half: Array = 0.5 * timestep * self._lead
        self._drag: Array = self._stiffness * self._damping
        self._effort = np.array(arm.effort)
        self._hold: Array = _BRAKE * self._effort
        # The arm's part of MuJoCo's arrays; it comes first.
        data = self.data
        self._qpos: Array = data.qpos
        self._alone = self._qpos.size == 6  # nothing else moves
        self._q: Array = self._qpos[:6]
        self._qd: Array = data.qvel[:6]
        self._qdd: Array = data.qacc[:6]
        self._bias: Array = data.qfrc_bias[:6]
        self._applied: Array = data.qfrc_applied[:6]
        self._ctrl: Array = data.ctrl[:6]
        self._force: Array = data.actuator_force[:6]
        self._sensor: Array = data.sensordata[:6]
        # Arm and tool, which are in the servos' model.
        self._known_qpos: Array = data.qpos[: self._known.positions]
        self._known_qvel: Array = data.qvel[: self._known.speeds]
        self._others: Array = data.qvel[6:]
        self._target = self._torque = self._external = np.zeros(6)
        self._flange = self.model.site("flange").id
        self._last_link = self.model.body("flange").id
        self._root = self.model.body("base").id
        self._turn = self.mounting.matrix[:3, :3]
        self._braked = False
        self._dry: Array = np.zeros(6)
        #: force and torque on the flange along the world's axes, shape (2, 3); None for no push
        self._push: Array | None = None
        self.reset(np.zeros(6) if q is None else q)

    def reset(self, q: Array) -> None:
        """Put the arm at q [rad] at once, and everything else where the scene puts it."""
        mujoco.mj_resetData(self.model, self.data)
        if self._drives is not None:
            self._drives.reset()
        if self.hand is not None:
            self.hand.reset()
        self._push = None
        self._q[:] = q
        self._ctrl[:] = q
        self._target = self._torque = self._external = np.zeros(6)
        mujoco.mj_forward(self.model, self.data)

    def arrange(self, q: Array, things: Mapping[str, PoseLike]) -> None:
        """Put the arm at q [rad] at once, and things of the scene at given poses.

        Everything else is where the scene puts it, and nothing moves. So the further course
        depends on q and `things` alone.

        Args:
            q: joints [rad]. Shape (6,).
            things: poses in the world [m, rad], by the names of things that may move on their own.

        Raises:
            ParameterError: there is no such thing; the arm and the scene are then as after a reset.
        """
        self.reset(q)
        for name, pose in things.items():
            self.parts.put(name, Pose.of(pose))
        mujoco.mj_forward(self.model, self.data)

    def wear_tool(self, by: float) -> None:
        """Move the tool or the gripper back into the flange, as if its tip were shorter by [m]."""
        self.model.body_pos[self.tool_body, 2] = -by

    @property
    def tool_body(self) -> int:
        """Number of the body of the tool or the gripper; -1 if there is none."""
        return int(mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, "tool"))

    def step(self, setpoint: JointSetPoint) -> None:
        """Advance by one time step, towards a set-point for its end.

        Raises:
            ArithmeticError: forces or speeds are too large to compute with.
        """
        data, began = self.data, self.data.time
        if self.hand is not None:
            self.hand.step(self._timestep)
        if self._push is not None:
            self._apply(self._push)
        if self._braked:
            # The brakes carry the weight, up to their torque: MuJoCo's friction would creep.
            np.clip(self._bias, -self._hold, self._hold, out=self._applied)
            mujoco.mj_step(self.model, data)
            self._check(began)
            self._target = self._torque = self._external = np.zeros(6)
            return
        if self._drives is not None:
            setpoint = self._drives.follow(setpoint)
        known = self._known
        known.at(self._known_qpos, self._known_qvel)
        self._target = known.torque(setpoint.qdd).copy()
        # MuJoCo computes the spring force from the position at the beginning of the step, and the
        # damping from the speed at its end, which is the mean speed of the step. Both are derived
        # from the set-point for the end.
        ahead = setpoint.q + self._lead * setpoint.qd - self._half * setpoint.qdd
        self._ctrl[:] = self._target / self._stiffness + ahead
        before = self._known_qvel.copy()
        # This releases the GIL for a few microseconds, so that waiting threads may run.
        mujoco.mj_step(self.model, data)
        self._check(began)
        change = self._known_qvel - before
        # MuJoCo reports the torques for the speed at the beginning of the step. But it integrates
        # with the damping for the speed at the end, unless the drive is at its limit.
        force = self._force
        self._torque = force - self._drag * change[:6] * (np.abs(force) < self._effort)
        self._external = known.torque(change / self._timestep) - self._torque

    def _check(self, began: float) -> None:
        """Refuse a step that MuJoCo gave up: it then begins again with everything at its start."""
        if self.data.time <= began:
            raise ArithmeticError("forces or speeds in the scene are too large to compute with")

    def load(self, mass: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Mount a load at the flange, and add it to the servos' model.

        Args:
            mass: mass of the load, a point without inertia of its own [kg]; zero removes it.
            centre: its centre of mass in the frame of the flange [m].
        """
        self.carry(mass, centre)
        self.set_modelled_load(mass, centre)

    def carry(self, mass: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Mount a load at the flange, without adding it to the servos' model [kg, m]."""
        mount(self.model, mass, centre)
        mujoco.mj_forward(self.model, self.data)

    def set_modelled_load(self, mass: float, centre: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Set the load in the servos' model, whether or not it is mounted [kg, m]."""
        self._known.load(mass, centre)

    def push(self, wrench: Sequence[float]) -> None:
        """Apply a force to the flange from now on.

        Args:
            wrench: force [N], then torque [N m], in the base frame, at the flange; zeros to end.
        """
        turned = np.reshape(wrench, (2, 3)) @ self._turn.T
        self._push = turned if any(wrench) else None
        self.data.xfrc_applied[self._last_link] = 0.0

    def _apply(self, push: Array) -> None:
        """Apply a push where MuJoCo takes forces: at the centre of mass of link and load."""
        data, link = self.data, self._last_link
        lever = data.site_xpos[self._flange] - data.xipos[link]
        data.xfrc_applied[link, :3] = push[0]
        data.xfrc_applied[link, 3:] = push[1] + np.cross(lever, push[0])

    def drag(self, dry: Sequence[float], viscous: Sequence[float]) -> None:
        """Set what drags at the joints, which the servos' model does not include.

        Args:
            dry: torque against the motion [N m]. Six.
            viscous: torque that grows with the speed [N m s/rad]. Six.
        """
        self._dry = np.array(dry)
        self.model.dof_damping[:6] = viscous
        if not self._braked:
            self.model.dof_frictionloss[:6] = self._dry

    def brake(self, on: bool) -> None:
        """Close the joint brakes and cut the drives' power, or the reverse.

        The brakes act by friction: they slow a moving arm down, and hold one that stands.
        """
        self._braked = on
        if self._drives is not None:
            self._drives.reset()
        self.model.opt.disableactuator = 1 << SERVOS if on else 0
        self.model.dof_frictionloss[:6] = self._hold if on else self._dry
        self._applied[:] = 0.0

    @property
    def still(self) -> bool:
        """Whether the gripper and all loose things in the scene are at rest."""
        if self.hand is not None and not self.hand.still:
            return False
        return self._others.size == 0 or float(np.abs(self._others).max()) < _STILL

    def reading(self) -> PlantReading:
        """All readings that the controller's cycle needs, at once."""
        positions = self._qpos.copy()
        speeds = self._qd.copy()
        return PlantReading(
            positions,
            positions if self._alone else positions[:6],
            speeds,
            self._qdd.copy(),
            self._torque if self._compensated is None else self._torque + self._rubbed(speeds),
            -self._sensor,
            self._target,
            self._external,
        )

    def _rubbed(self, speeds: Array) -> Array:
        """Torques against friction [N m]; none with the brakes on, or at rest."""
        assert self._compensated is not None
        dry, viscous = self._compensated
        if self._braked:
            return np.zeros(6)
        rubbed: Array = dry * np.clip(speeds / _CREEP, -1.0, 1.0) + viscous * speeds
        return rubbed

    def drawn(self) -> Any:
        """Compile the model for pictures, with the looks of the arm."""
        return dressed(self._spec, self.arm)

    @property
    def positions(self) -> Array:
        """Positions of everything that moves, the joints first [rad, m]."""
        return self._qpos.copy()

    @property
    def q(self) -> Array:
        """Joint angles [rad]. Shape (6,)."""
        return self._q.copy()

    @property
    def qd(self) -> Array:
        """Joint speeds [rad/s]. Shape (6,)."""
        return self._qd.copy()

    @property
    def wrench(self) -> Array:
        """Force [N] and torque [N m] that the world applies to the flange, in its frame. (6,)"""
        return -self._sensor

    def touched(self) -> str:
        """List the contacts of the arm, its tool and what its gripper holds.

        Such as "link4 touches the floor": the arm's part comes first in each, else what is held.
        For a contact by which the gripper holds a thing the verb is "grips": see `Hand.grips`.
        """
        model, pairs = self.model, self.data.contact.geom.tolist()
        grips = [self.hand is not None and self.hand.grips(i) for i in range(len(pairs))]
        bodies = {geom: int(model.geom_bodyid[geom]) for pair in pairs for geom in pair}
        # The arm moves as a whole; a held thing may be a part of another one, such as a drawer.
        arm = {geom for geom, body in bodies.items() if model.body_rootid[body] == self._root}
        moved = {geom: int(model.body_weldid[body]) for geom, body in bodies.items()}
        held = {
            moved[geom]
            for pair, grip in zip(pairs, grips, strict=True)
            for geom in pair
            if grip and geom not in arm
        }
        rank = {geom: 0 if geom in arm else 1 if moved[geom] in held else 2 for geom in bodies}
        told = set()
        for pair, grip in zip(pairs, grips, strict=True):
            first, second = sorted(pair, key=rank.__getitem__)
            if rank[first] < 2:
                verb = "grips" if grip else "touches"
                told.add(f"{self.geom_label(first)} {verb} {self.geom_label(second)}")
        return ", ".join(sorted(told))

    def geom_label(self, geom: int) -> str:
        """Name a geom for messages: by its body, or by its own name if it is part of the world.

        Bodies without a name are parts of the one that carries them.
        """
        model, named = self.model, self.model.geom(geom).name
        if named in ("floor", "plate", "pedestal"):
            return f"the {named}"
        body = int(model.geom_bodyid[geom])
        while (above := int(model.body_parentid[body])) and not model.body(body).name:
            body = above
        name = model.body(body).name if body else named
        if name == "flange" or name.startswith("tool"):
            return f"the {name.partition('/')[0]}"
        return name.removeprefix("scene/") or "a thing without a name"

    def flange(self) -> Array:
        """Give the pose of the flange in the base frame. Shape (4, 4)."""
        # After a step, the frames are still those of its beginning.
        mujoco.mj_kinematics(self.model, self.data)
        turn = self.data.site_xmat[self._flange].reshape(3, 3)
        return self.mounting.inverse().matrix @ transform(turn, self.data.site_xpos[self._flange])
