"""The simulated arm that an environment moves step by step: its physics alone, or all of it.

Both take one target per step: joints, as `servoj` does. The physics alone follow them with the
servo law of the simulated controller, in the same cycles. So the same actions lead along the same
way, and a policy that was learned on one works on the other.
"""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING

import numpy as np

import aioduco.sync
from aioduco.errors import DucoError
from aioduco.integrations.gym.tasks import ArmTask, TaskReading
from aioduco.models.gripper_models import gripper_model
from aioduco.sim.controller.state_machine import DEVIATION
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.planner.servo_follower import ServoFollower, ServoTuning
from aioduco.sim.refusal import Refusal
from aioduco.sim.scene import mjcf_of
from aioduco.sim.simulator import Simulator
from aioduco.sim.view.render import PictureProcess

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.sim.view.camera import Camera, PictureMark

    Vector = NDArray[np.float64]
    Picture = NDArray[np.uint8]


PERIOD = 0.04
"""Time of one step [s]."""

# Servo parameters: within the ranges of the manual, with little smoothing.
_V, _A, _KP, _KD, _SMOOTH_VEL, _SMOOTH_ACC = 2.5, 30.0, 1600.0, 80.0, 1.0, 0.0
_SETTLING = 0.04  # time for things to settle after they were placed [s]
_CLOSE, _HOLDS = 1, 1  # number of the gripper's output, and of the input of its sensor
_PATIENCE = 120.0  # time-out for a controller in this process, also on a busy computer [s]


def _tip(arm: Arm, q: Vector, length: float) -> tuple[Vector, Vector]:
    flange = arm.fkine(q)
    return flange[:3, 3] + length * flange[:3, 2], flange[:3, :3]


class PhysicsArm:
    """MuJoCo and the servo law, in the thread of the caller.

    Args:
        arm: the arm.
        task: the task.
        home: joints at the start [rad]. Shape (6,).
    """

    def __init__(self, arm: Arm, task: ArmTask, home: Vector) -> None:
        self._arm, self._task, self._home = arm, task, home
        self._cycles = round(PERIOD / task.cycle)
        self._world = World(
            arm,
            task.cycle,
            home,
            scene=mjcf_of(task.scene()),
            tool=None if (tool := task.tool()) is None else mjcf_of(tool, free=False),
            gripper=gripper_model(task.gripper) if task.gripper else None,
        )
        self._closed = False
        self._thing = self._world.parts.place(task.moved) if task.moved else slice(0)
        self._tuning = ServoTuning(_V, _A, _KP, _KD, _SMOOTH_VEL, _SMOOTH_ACC)
        self._follower = ServoFollower(arm, home, task.cycle)
        self._drive = JointSetPoint.at_rest(home)
        self._pictures = PictureProcess(self._world.drawn)

    def restart(self, things: Mapping[str, tuple[float, ...]]) -> None:
        """Begin an episode: the arm at home, things at their poses [m, rad]."""
        self._closed = False
        self._world.arrange(self._home, things)
        self._follower = ServoFollower(self._arm, self._home, self._task.cycle)
        self._drive = JointSetPoint.at_rest(self._home)
        for _ in range(round(_SETTLING / self._task.cycle)):
            self._world.step(self._drive)

    def follow(self, target: Vector, *, closed: bool) -> str:
        """Move towards target joints for one period.

        Args:
            target: target joints [rad]. Shape (6,).
            closed: whether to close the gripper; no effect without a gripper.

        Returns:
            The reason for which the arm was stopped; empty if it was not.
        """
        world, hand = self._world, self._world.hand
        if self._follower.ended:
            self._follower = ServoFollower(self._arm, self._drive.q, self._task.cycle)
        self._follower.aim(target, self._tuning)
        for _ in range(self._cycles):
            world.step(self._drive)
            if hand is not None and closed != self._closed:
                # As the controller does, at the end of the cycle in which its output changes.
                goal = 0.0 if closed else hand.gripper.stroke
                hand.command((goal,), hand.gripper.fastest, hand.gripper.force[1])
                self._closed = closed
            self._drive = self._follower.tick(self._drive.q, self._drive.qd)
        deviation = np.abs(self._drive.q - world.q)
        if deviation.max() > DEVIATION:
            return f"joint {int(deviation.argmax()) + 1}: position deviation"
        return ""

    def reading(self) -> TaskReading:
        """Read the current state."""
        world = self._world
        q = world.q
        tip, turn = _tip(self._arm, q, self._task.tip)
        force = turn @ world.wrench[:3] if self._task.feels else np.zeros(3)
        hand = world.hand
        holds = float(hand is not None and self._closed and hand.reading.caught == 1)
        return TaskReading(q, world.qd, tip, force, holds, world.positions[self._thing])

    def picture(
        self, width: int, height: int, camera: Camera, marks: tuple[PictureMark, ...]
    ) -> Picture:
        """Draw the scene: red, green, blue. Shape (height, width, 3)."""
        return self._pictures.picture(self._world.positions, width, height, camera, marks)

    def close(self) -> None:
        """End the drawing process."""
        self._pictures.close()


class ControllerArm:
    """The whole simulated controller, over the wire; its time advances only by steps.

    A step is one `servoj`, forty milliseconds, and a program's readings. The places of things are
    read from the simulator, as a camera would measure them.

    Args:
        arm: the arm.
        task: the task.
        home: joints at the start [rad]. Shape (6,).
    """

    def __init__(self, arm: Arm, task: ArmTask, home: Vector) -> None:
        self._arm, self._task, self._home = arm, task, home
        self._cycles = round(PERIOD / task.cycle)
        self._thing = slice(0)
        self._closed = False
        self._simulator: Simulator | None = None
        self._robot: aioduco.sync.Robot | None = None

    def restart(self, things: Mapping[str, tuple[float, ...]]) -> None:
        """Begin an episode: move the arm home; if that fails, restart the simulator."""
        simulator, robot = self._simulator, self._robot
        if simulator is not None and robot is not None:
            simulator.unlock_time()
            try:
                if self._task.gripper:
                    robot.io.set_standard_digital_out(_CLOSE, False)
                robot.motion.movej2(self._home, v=2.0, a=5.0)
            except DucoError:
                self.close()
                simulator = None
        if simulator is None or robot is None:
            simulator, robot = self._open()
        self._closed = False
        simulator.lock_time()
        simulator.arrange(things)
        simulator.advance(round(_SETTLING / self._task.cycle))

    def follow(self, target: Vector, *, closed: bool) -> str:
        """Move towards target joints for one period.

        Args:
            target: target joints [rad]. Shape (6,).
            closed: whether to close the gripper; no effect without a gripper.

        Returns:
            The reason for which the arm was stopped; empty if it was not.
        """
        simulator, robot = self._opened()
        try:
            if self._task.gripper and closed != self._closed:
                robot.io.set_standard_digital_out(_CLOSE, closed)
                self._closed = closed
            robot.motion.servoj.start(
                target, _V, _A, kp=_KP, kd=_KD, smooth_vel=_SMOOTH_VEL, smooth_acc=_SMOOTH_ACC
            )
            simulator.advance(self._cycles)
        except (DucoError, Refusal) as exc:
            return str(exc)
        return "a safety stop of the controller" if simulator.view.error else ""

    def reading(self) -> TaskReading:
        """Read the current state."""
        simulator, robot = self._opened()
        q = robot.state.get_actual_joints_position().array
        qd = np.array(robot.state.get_actual_joints_speed())
        tip, _ = _tip(self._arm, q, self._task.tip)
        force = np.zeros(3)
        if self._task.feels:
            force = np.array(robot.state.get_tcp_force()[:3])
        holds = 0.0
        if self._task.gripper:
            holds = float(robot.io.get_standard_digital_in(_HOLDS))
        return TaskReading(q, qd, tip, force, holds, simulator.positions[self._thing])

    def picture(
        self, width: int, height: int, camera: Camera, marks: tuple[PictureMark, ...]
    ) -> Picture:
        """Draw the scene: red, green, blue. Shape (height, width, 3)."""
        simulator, _ = self._opened()
        return simulator.render(width=width, height=height, camera=camera, marks=marks)

    def close(self) -> None:
        """Close the robot, and end the simulator."""
        simulator, self._simulator = self._simulator, None
        robot, self._robot = self._robot, None
        if simulator is None:
            return
        try:
            simulator.unlock_time()
            with contextlib.suppress(Refusal):  # the simulation may have failed
                # An arm that is wedged never stands by itself: the brakes hold it.
                simulator.emergency_stop()
            if robot is not None:
                robot.__exit__(None, None, None)
        finally:
            simulator.close()

    def _open(self) -> tuple[Simulator, aioduco.sync.Robot]:
        simulator = self._simulator = Simulator(
            self._arm.name,
            speed=math.inf,
            cycle=self._task.cycle,
            joints=self._home,
            scene=self._task.scene(),
            tool=self._task.tool(),
            gripper=self._task.gripper or None,
        ).start()
        robot = aioduco.sync.connect(
            simulator.host,
            simulator.port,
            # The simulator is in this process: both end at the same time.
            heartbeat=None,
            lag_limit=None,
            clock=simulator.clock,
            call_timeout=_PATIENCE,
            stop_timeout=_PATIENCE,
            standstill_timeout=_PATIENCE,
        )
        robot.__enter__()
        self._robot = robot
        robot.bring_up(timeout=_PATIENCE)
        # The controller must not take deliberate pushing and pressing for a collision.
        robot.settings.collision_detect(0)
        if self._task.moved:
            self._thing = simulator.place(self._task.moved)
        return simulator, robot

    def _opened(self) -> tuple[Simulator, aioduco.sync.Robot]:
        if self._simulator is None or self._robot is None:
            raise RuntimeError("there is no episode: call reset() first")
        return self._simulator, self._robot
