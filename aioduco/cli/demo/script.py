"""The choreography: the motions of the arm, their order, and the expected outcome of each.

This module neither shows nor measures nor connects anything. All lines are relative to the pose
that the controller reports at the start position, so that a mounted tool is taken into account.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import anyio

from aioduco.cli.demo.stage import PATIENCE, Stage
from aioduco.devices.grippers import DigitalGripper, gripper_model
from aioduco.models.enums import Outcome
from aioduco.models.pose import Joints, Pose
from aioduco.sim.scene import Box, Table, Thing

if TYPE_CHECKING:
    from aioduco.kinematics import Arm
    from aioduco.robot import Robot
    from aioduco.supervision.command import MotionCommand


GRIPPER = 1  # general digital output of the cabinet that closes a gripper
GRIPPER_NAME = "parallel"  # the simulated one
PART = 0.04  # length of the edges of the box that is picked up [m]
#: inputs of the simulated gripper: it holds something, it is open
_HOLDS, _OPENED = 1, 2
#: seconds within which its sensors answer even on a busy computer
_BUSY = 10.0
#: height above the table at which the box is released [m]
_ABOVE = 0.001


@dataclass(frozen=True, slots=True)
class Choreography:
    """Places and speeds of the demonstration.

    Attributes:
        start: joints at the begin and the end of the demonstration [rad].
        aside: joints to which it turns, for the pause and for the stop [rad].
        width: distance along y from the start to the pick, and from the start to the place [m].
        depth: distance from the start down to the part [m].
        blend: blend radius of the first line of the blended pair [m].
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
            careful: whether to use a quarter of the speeds and accelerations, for a real arm.
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


def scene(arm: Arm, plan: Choreography) -> list[Thing]:
    """The box that a simulated arm picks up, and the table under the box."""
    flange = arm.fkine(plan.start)
    x, y, z = (float(value) for value in flange[:3, 3])
    middle = z - plan.depth - gripper_model(GRIPPER_NAME).length
    turn = math.atan2(flange[1, 1], flange[0, 1])
    size = (0.3 * arm.reach, 2.0 * plan.width + 0.2)
    box = Box(
        at=(x, y - plan.width, middle, 0.0, 0.0, turn),
        size=(PART, PART, PART),
        mass=0.2,
        colour=(0.85, 0.3, 0.2),
        name="part",
    )
    return [Table(at=(x, y, middle - 0.5 * PART), size=size), box]


def _gripped(*, holding: bool | None) -> str:
    if holding is None:
        return "the gripper closes"
    return "the gripper holds the box" if holding else "the gripper closes on nothing"


async def pick_and_place(robot: Robot, stage: Stage, plan: Choreography) -> None:
    """Pick a part up, put it down, pause and resume, stop in mid motion, and go back.

    Args:
        robot: the robot, brought up.
        stage: stage that runs the motions.
        plan: places and speeds.
    """
    sensors: dict[str, Any] = {}
    if stage.simulated:
        sensors = {"holds": _HOLDS, "opened": _OPENED, "travel_time": _BUSY, "max_age": PATIENCE}
    async with DigitalGripper(robot, GRIPPER, timeout=PATIENCE, **sensors) as gripper:
        await _perform(robot, stage, plan, gripper)


async def _perform(robot: Robot, stage: Stage, plan: Choreography, gripper: DigitalGripper) -> None:
    def joint(to: Joints) -> MotionCommand:
        return robot.motion.movej2(to, v=plan.joint_speed, a=plan.joint_acceleration)

    def line(to: Pose, blend: float = 0.0) -> MotionCommand:
        return robot.motion.movel(to, v=plan.line_speed, a=plan.line_acceleration, r=blend)

    await stage.move("to the start", joint(plan.start))
    start = await robot.state.get_tcp_pose()
    over_pick = replace(start, y=start.y - plan.width)
    over_place = replace(start, y=start.y + plan.width)
    pick = replace(over_pick, z=start.z - plan.depth)
    place = replace(over_place, z=start.z - plan.depth + _ABOVE)

    await stage.move("over the pick", line(over_pick))
    await stage.move("down to pick", line(pick))
    await stage.see("it lies")
    closed = await gripper.close()
    stage.note(f"digital output {GRIPPER} on: {_gripped(holding=closed.holding)}")

    # If the part is lost on its way, the arm is stopped.
    async with gripper.carrying():
        lift = await stage.start(
            "lift, and blend", line(over_pick, plan.blend), expect=Outcome.BLENDED
        )
        across = await stage.start("across", line(over_place))
        await stage.finish(lift)
        await stage.finish(across)
    await stage.see("it is carried")
    await stage.move("down to place", line(place))
    await gripper.open()
    stage.note(f"digital output {GRIPPER} off: the gripper opens")
    await stage.move("up again", line(over_place))
    await stage.see("it was put down")

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
