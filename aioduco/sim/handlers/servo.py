"""Servo motions: targets that replace each other while the arm moves (manual 1.3.5)."""

from __future__ import annotations

import math
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from aioduco.sim.controller.motion_queue import Following
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import arguments_of, as_on_the_wire
from aioduco.sim.handlers.paths import (
    JOINT_ACCELERATION,
    JOINT_SPEED,
    TOO_FAST,
    MotionCall,
    PathSection,
    near,
)
from aioduco.sim.planner.servo_follower import ServoFollower, ServoTuning

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.rotation import Array
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.handlers.paths import Range

    #: gives the joints to go to, from the present target [rad]
    Target: TypeAlias = Callable[[Array], Array]


#: the vendor's values, for a client that leaves them out: all four are then zero on the wire
_GAINS = (200.0, 25.0, 10.0, 1.0)


def servo(target: Callable[[ServoHandlers, MotionCall], Target]) -> Callable[..., int]:
    """Make a handler that follows a target, of what gives the target of a call.

    That has the function's name, and raises Rejected if an argument is wrong.
    """
    name = target.__name__
    names = arguments_of(name)

    def answer(self: ServoHandlers, *values: Any) -> int:
        return self._servo(name, MotionCall(names, values), partial(target, self))

    return as_on_the_wire(target, answer)


class ServoHandlers(PathSection):
    """servoj, servoj_pose, servo_tcp, servol."""

    @servo
    def servoj(self, call: MotionCall) -> Target:
        """Move to joint angles, each joint independently."""
        goal = np.array(arguments.joints("joints_list", call.joints_list))
        return lambda _last: goal

    @servo
    def servoj_pose(self, call: MotionCall) -> Target:
        """Move to a pose of the tool, each joint independently."""
        return self._at_pose(call)

    @servo
    def servo_tcp(self, call: MotionCall) -> Target:
        """Move by an offset in the tool's frame, relative to the present target."""
        used = self._frames.tool(call.tool)
        step = used.matrix @ arguments.pose("pose_offset", call.pose_offset).matrix @ used.inverse
        return lambda last: self._inverse(self._arm.fkine(last) @ step, last)

    @servo
    def servol(self, call: MotionCall) -> Target:
        """Move to a pose of the tool, each joint independently, as the manual's text says."""
        return self._at_pose(call)

    # -- shared parts --------------------------------------------------------------------------

    def _servo(self, name: str, call: MotionCall, target: Callable[[MotionCall], Target]) -> int:
        def command(controller: Controller) -> int:
            goal, tuning = target(call), self._tuning(self._paces(name), call)

            def aim(follower: ServoFollower) -> None:
                to = goal(follower.target)
                follower.aim(to, self._by_joints(name, tuning, follower.setpoint.q, to))

            following = Following(name, lambda q: ServoFollower(self._arm, q, self._cycle), aim)
            return controller.follow(name, following)

        return self._task(name, call.block, command)

    def _paces(self, name: str) -> tuple[Range, Range]:  # noqa: ARG002 - others differ by it
        """Return the ranges of v and a of a function."""
        return JOINT_SPEED, JOINT_ACCELERATION

    def _by_joints(
        self,
        name: str,  # noqa: ARG002 - others differ by it
        tuning: ServoTuning,
        at: Array,  # noqa: ARG002 - as above
        to: Array,  # noqa: ARG002 - as above
    ) -> ServoTuning:
        """Return the tuning with the v and a of the joints, for a target `to` from `at` [rad]."""
        return tuning

    def _tuning(self, paces: tuple[Range, Range], call: MotionCall) -> ServoTuning:
        kp, kd, smooth_vel, smooth_acc = call.kp, call.kd, call.smooth_vel, call.smooth_acc
        if not (kp or kd or smooth_vel or smooth_acc):
            kp, kd, smooth_vel, smooth_acc = _GAINS
        return ServoTuning(
            arguments.at_most(self._forgiving, TOO_FAST, "v", call.v, *paces[0]),
            arguments.number("a", call.a, *paces[1]),
            # Without a proportional part the arm would never arrive.
            arguments.positive("kp", self._usual("kp", kp, _GAINS[0]), 1e6, ""),
            arguments.number("kd", kd, 0.0, 1e6, ""),
            self._smoothing(
                "smooth_vel", self._usual("smooth_vel", smooth_vel, _GAINS[2]), 1.0, 100.0
            ),
            self._smoothing("smooth_acc", smooth_acc, 0.0, 1.0),
        )

    def _usual(self, name: str, value: float, usual: float) -> float:
        """Replace a 0 that is out of range by the vendor's value, if that is forgiven."""
        if value:
            return value
        self._forgiving.forgive("servo gains and smoothing", f"{name} is 0, but must be above 0")
        return usual

    def _smoothing(self, name: str, value: float, low: float, high: float) -> float:
        """Check a smoothing; one out of range is moved to the nearest limit if that is forgiven."""
        if math.isfinite(value) and not low <= value <= high:
            text = f"{name} is {value}, but must be from {low:g} to {high:g}"
            self._forgiving.forgive("servo gains and smoothing", text)
            value = min(max(value, low), high)
        return arguments.number(name, value, low, high, "")

    def _at_pose(self, call: MotionCall) -> Target:
        flange, _ = self._target("pose_list", call.pose_list, call)
        reference = near(call.q_near)
        return lambda last: self._inverse(flange, last if reference is None else reference)
