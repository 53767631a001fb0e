"""The choreography: what the arm does, in which order, and how each motion should end.

Nothing here shows, measures or connects anything. All lines are relative to the pose that the
controller reports at the start position, so that a mounted tool is respected.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import anyio

from aioduco.models.enums import Outcome
from aioduco.models.pose import Joints

if TYPE_CHECKING:
    from aioduco.cli.demo.stage import Stage
    from aioduco.models.pose import Pose
    from aioduco.robot import Robot
    from aioduco.supervision.command import MotionCommand

__all__ = ["Choreography", "pick_and_place"]

GRIPPER = 1  # general digital output of the cabinet that would close a gripper


@dataclass(frozen=True, slots=True)
class Choreography:
    """Where the arm goes and how fast.

    Attributes:
        start: joints that the demonstration begins and ends at [rad].
        aside: joints that it turns to, for the pause and for the stop [rad].
        width: from the start to the place to pick from, and to that to put to, along y [m].
        depth: from the start down to where things lie [m].
        blend: blend radius of the first line of the pair that blends [m].
        joint_speed: speed of joint moves [rad/s].
        joint_acceleration: acceleration of joint moves [rad/s²].
        line_speed: speed of straight lines [m/s].
        line_acceleration: acceleration of straight lines [m/s²].
        hold: how long the arm stands paused [s].
    """

    start: Joints
    aside: Joints
    width: float
    depth: float
    blend: float
    joint_speed: float = 1.2
    joint_acceleration: float = 4.0
    line_speed: float = 0.4
    line_acceleration: float = 1.5
    hold: float = 0.5

    @classmethod
    def for_reach(cls, reach: float, *, careful: bool) -> Choreography:
        """Make a plan for an arm.

        Args:
            reach: how far the arm reaches [m]; all lengths are parts of it.
            careful: a quarter of the speeds, for an arm that is real.
        """
        right = math.pi / 2
        plan = cls(
            start=Joints(0.0, 0.0, right, 0.0, -right, 0.0),
            aside=Joints(1.3, -0.2, right - 0.3, 0.2, -right, 0.6),
            width=0.25 * reach,
            depth=0.12 * reach,
            blend=0.03 * reach,
        )
        if not careful:
            return plan
        return replace(
            plan,
            joint_speed=plan.joint_speed / 4,
            joint_acceleration=plan.joint_acceleration / 4,
            line_speed=plan.line_speed / 4,
            line_acceleration=plan.line_acceleration / 4,
        )


async def pick_and_place(robot: Robot, stage: Stage, plan: Choreography) -> None:
    """Pick something up, put it down, pause and go on, stop in mid motion, and go back.

    Args:
        robot: the robot, brought up.
        stage: what the motions run on.
        plan: where to and how fast.
    """

    def joint(to: Joints) -> MotionCommand:
        return robot.motion.movej2(to, v=plan.joint_speed, a=plan.joint_acceleration)

    def line(to: Pose, blend: float = 0.0) -> MotionCommand:
        return robot.motion.movel(to, v=plan.line_speed, a=plan.line_acceleration, r=blend)

    await stage.move("to the start", joint(plan.start))
    start = await robot.state.get_tcp_pose()
    over_pick = replace(start, y=start.y - plan.width)
    over_place = replace(start, y=start.y + plan.width)
    pick = replace(over_pick, z=start.z - plan.depth)
    place = replace(over_place, z=start.z - plan.depth)

    await stage.move("over the pick", line(over_pick))
    await stage.move("down to pick", line(pick))
    await robot.io.set_standard_digital_out(GRIPPER, value=True)
    stage.note(f"digital output {GRIPPER} on: the gripper closes")

    lift = await stage.start("lift, and blend", line(over_pick, plan.blend), expect=Outcome.BLENDED)
    across = await stage.start("across", line(over_place))
    await stage.finish(lift)
    await stage.finish(across)
    await stage.move("down to place", line(place))
    await robot.io.set_standard_digital_out(GRIPPER, value=False)
    stage.note(f"digital output {GRIPPER} off: the gripper opens")
    await stage.move("up again", line(over_place))

    turn = await stage.start("turn aside, with a pause", joint(plan.aside))
    await stage.moved(0.2)
    await robot.pause()
    stage.note("paused: the arm stands on its path")
    await anyio.sleep(plan.hold)
    await robot.resume()
    await stage.finish(turn)

    back = await stage.start("turn back, and be stopped", joint(plan.start), expect=Outcome.STOPPED)
    await stage.moved(0.4)
    await robot.stop()
    stage.note("stopped: the arm stands on its path")
    await stage.finish(back)

    await stage.move("to the start again", joint(plan.start))
