"""Motions without a given end: velocities, jogs, hand guiding (manual 1.3.5)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from aioduco.models.jog import JogFrame
from aioduco.models.rotation import Array, matrix_from_rotvec, transform
from aioduco.sim.controller.motion_queue import Following
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.handlers.paths import JOINT_ACCELERATION
from aioduco.sim.planner.guiding import HandGuidingFollower, cartesian_giving, joint_giving
from aioduco.sim.planner.segments import Segment, joint_move, line_move
from aioduco.sim.planner.velocity_follower import JointVelocity, ToolVelocity
from aioduco.sim.refusal import mismatch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import MoveJogTaskParam
    from aioduco.sim.controller.motion_queue import Plan
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.planner.follower import TargetFollower


_FASTEST_JOINT = 1.25 * math.pi
_FASTEST_TOOL = 5.0
_TOOL_ACCELERATION = (1e-5, math.inf, "m/s²")
_UNLIMITED_ACCELERATION = 1e4  # stands for an acceleration without a limit
#: speeds of a jog at 100 %: assumptions, of the order of the reduced speed of ISO 10218
_JOG_JOINT, _JOG_LINE, _JOG_TURN = 0.5, 0.25, 0.5  # [rad/s, m/s, rad/s]
_JOG_JOINT_ACCELERATION, _JOG_LINE_ACCELERATION = 2.0, 1.0  # [rad/s², m/s²]
_CARTESIAN, _JOINTS = 1, 2


class VelocityHandlers(HandlerSection):
    """speedj, speedl, speed_stop, move_jog, stop_manual_move, hand guiding."""

    @task()
    def speedj(
        self, controller: Controller, joints_list: Sequence[float], a: float, time: int
    ) -> int:
        """Turn each joint at a velocity."""
        speeds = np.array(arguments.six("joints_list", joints_list, _FASTEST_JOINT, "rad/s"))
        change = min(arguments.number("a", a, *JOINT_ACCELERATION), _UNLIMITED_ACCELERATION)
        left = _time(time)

        def aim(follower: JointVelocity) -> None:
            follower.aim(speeds, change, left)

        following = Following("speedj", self._joint_velocity, aim, alone=True)
        return controller.follow("speedj", following)

    @task()
    def speedl(
        self, controller: Controller, pose_list: Sequence[float], a: float, time: int
    ) -> int:
        """Move the tool at a velocity in its own frame (manual 4.3)."""
        twist = np.array(
            arguments.six("pose_list", pose_list, _FASTEST_TOOL, "m/s, rad/s", _FASTEST_JOINT)
        )
        change = min(arguments.number("a", a, *_TOOL_ACCELERATION), _UNLIMITED_ACCELERATION)
        left, tool = _time(time), self._frames.tool().matrix

        def make(q: Array) -> ToolVelocity:
            return ToolVelocity(self._arm, q, self._cycle, tool)

        def aim(follower: ToolVelocity) -> None:
            follower.tool = tool
            follower.aim(twist, change, left)

        return controller.follow("speedl", Following("speedl", make, aim, alone=True))

    def speed_stop(self, block: bool) -> int:
        """Bring speedj and speedl to rest at their own acceleration."""
        name = "speed_stop"
        return self._task(name, block, lambda c: c.end_following(name, "speedj", "speedl"))

    @task()
    def move_jog(self, controller: Controller, param: MoveJogTaskParam) -> int:
        """Jog a joint or a direction, by a step or until stop_manual_move."""
        jog = self._as_in_3_8(param)
        _check_jog(jog)
        if jog.use_step:
            return controller.jog("move_jog", self._jog_step(jog))
        return controller.follow("move_jog", self._jog(jog))

    def stop_manual_move(self, block: bool) -> int:
        """End a jog."""
        name = "stop_manual_move"
        return self._task(name, block, lambda c: c.end_jog(name))

    @task()
    def teach_mode(self, controller: Controller) -> int | None:
        """Begin hand guiding; the task is done when that has begun."""
        giving = self._cabinet.hand_teaching
        guiding = Following.once(
            "teach_mode", lambda q: HandGuidingFollower(self._arm, q, self._cycle, giving)
        )
        id_ = controller.follow("teach_mode", guiding)
        return id_ if controller.tasks.state(id_).ended else None

    def end_teach_mode(self, block: bool) -> int:
        """End hand guiding; the arm stays where it is."""
        name = "end_teach_mode"
        return self._task(name, block, lambda c: c.end_following(name, "teach_mode"))

    @task()
    def set_hand_teach_parameter(
        self,
        _: Controller,
        space: int,
        joint_scale: Sequence[int],
        cart_scale: Sequence[int],
        coord_type: int,
        direction: Sequence[bool],
    ) -> None:
        """牵引参数, from the next hand guiding on: a scale of 0 blocks, all others act alike."""
        arguments.choice("space", space, range(2), "from 0 to 1")
        arguments.choice("coord_type", coord_type, range(4), "from 0 to 3")
        for name, values in (("joint_scale", joint_scale), ("cart_scale", cart_scale)):
            if len(values) != 6 or min(values) < 0:
                raise mismatch(f"{name} must be six whole numbers from 0")
        if len(direction) != 6:
            raise mismatch("direction must be six flags")
        if space == 0:
            giving = joint_giving([scale > 0 for scale in joint_scale])
        else:
            active = [on and s > 0 for on, s in zip(direction, cart_scale, strict=True)]
            tool, frame = self._frames.tool().matrix, self._axes(coord_type)
            giving = cartesian_giving(self._arm, active, tool, frame)
        self._cabinet.hand_teaching = giving

    # -- shared parts --------------------------------------------------------------------------

    def _as_in_3_8(self, param: MoveJogTaskParam) -> MoveJogTaskParam:
        """Return a jog in the numbers of manual 3.8."""
        return param

    def _joint_velocity(self, q: Array) -> JointVelocity:
        return JointVelocity(self._arm, q, self._cycle)

    def _jog(self, param: MoveJogTaskParam) -> Following:
        share, axis = param.jog_direction * self._jog_share(param), param.axis_num
        velocity = np.zeros(6)
        if param.jog_type == _JOINTS:
            velocity[axis] = share * _JOG_JOINT

            def begin(q: Array) -> TargetFollower:
                joints = self._joint_velocity(q)
                joints.aim(velocity, _JOG_JOINT_ACCELERATION)
                return joints

            return Following.once("move_jog", begin)
        velocity[axis] = share * (_JOG_LINE if axis < 3 else _JOG_TURN)
        tool, frame = self._frames.tool().matrix, self._axes(param.jog_coordinate)

        def begin_tool(q: Array) -> TargetFollower:
            follower = ToolVelocity(self._arm, q, self._cycle, tool, frame)
            follower.aim(velocity, _JOG_LINE_ACCELERATION)
            return follower

        return Following.once("move_jog", begin_tool)

    def _jog_share(self, param: MoveJogTaskParam) -> float:
        """Speed of a jog as a share of the highest: its own percent of the teaching speed."""
        return param.vel / 100.0 * self._cabinet.teach_speed / 100.0

    def _axes(self, frame: int) -> Array | None:
        """Axes of a frame, by its number, in the base frame; None for those of the tool."""
        if frame == JogFrame.TOOL:
            return None
        if frame == JogFrame.WORK_OBJECT:
            return self._frames.wobj().matrix[:3, :3]
        if frame == JogFrame.WORLD:
            world: Array = self._context.mounting.matrix[:3, :3].T
            return world
        return np.eye(3)

    def _jog_step(self, param: MoveJogTaskParam) -> Plan:
        axis, share = param.axis_num, self._jog_share(param)
        if param.jog_type == _JOINTS:
            turn = np.zeros(6)
            turn[axis] = param.jog_direction * param.step_jointValue
            return lambda start: joint_move(
                self._arm, start, start + turn, share * _JOG_JOINT, _JOG_JOINT_ACCELERATION
            )
        step = np.zeros(6)
        step[axis] = param.jog_direction * param.step_cartvalue
        tool, frame = self._frames.tool().matrix, self._axes(param.jog_coordinate)
        speed = share * (_JOG_LINE if axis < 3 else _JOG_TURN)

        def line(start: Array) -> Segment:
            tip = self._arm.fkine(start) @ tool
            axes = tip[:3, :3] if frame is None else frame
            turned = matrix_from_rotvec(axes @ step[3:]) @ tip[:3, :3]
            goal = transform(turned, tip[:3, 3] + axes @ step[:3])
            flange = goal @ np.linalg.inv(tool)
            return line_move(self._arm, start, flange, speed, _JOG_LINE_ACCELERATION, tool=tool)

        return line


def _check_jog(param: MoveJogTaskParam) -> None:
    for name, value, allowed in (
        ("jog_direction", param.jog_direction, (-1, 1)),
        ("jog_type", param.jog_type, (_CARTESIAN, _JOINTS)),
        ("axis_num", param.axis_num, range(6)),
        ("jog_coordinate", param.jog_coordinate, range(4)),
    ):
        arguments.choice(name, value, allowed, f"one of {list(allowed)}")
    arguments.positive("vel", param.vel, 100.0, "%")
    if param.use_step:
        step = ("step_jointValue", param.step_jointValue)
        if param.jog_type == _CARTESIAN:
            step = ("step_cartvalue", param.step_cartvalue)
        arguments.positive(*step, 2 * math.pi, "m or rad")


def _time(milliseconds: int) -> float:
    """Convert a duration to seconds; infinite for -1."""
    if milliseconds == -1:
        return math.inf
    if milliseconds <= 0:
        raise mismatch(f"time is {milliseconds}, but must be above 0 ms, or -1")
    return milliseconds / 1000.0
