"""External axes (外部轴, manual 1.3.14): schemes, and motions, alone or together with the arm.

Controllers of manual 4.3 take the scheme, its target and its speed in lists, one of each for every
scheme that moves. They are sent so, with one, to controllers whose version is 4.3 or later, and by
their names up to 3.8 and where the version has no number, as of old controllers. How any other
version takes them is not known, nor `move_circle_eaxis` in 4.3: there the motion is refused with
`LayoutUnknown`, before anything is sent. What is sent in the other form is passed over: the arm
would move, and its external axes would not.

The manual contradicts itself about `def_acc` here. By its name, and by section 1.3.5, the
controller chooses the acceleration if it is true; the text of section 1.3.14 says the opposite.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco._wire import newer
from aioduco._wire.rpc import WireCall, calls
from aioduco.api.arguments import frames, limits, outputs
from aioduco.api.section import JOG_TIME, Section
from aioduco.errors import LayoutUnknown
from aioduco.models import ranges
from aioduco.models.external_axis import (
    ExternalAxis,
    ExternalAxisScheme,
    ExternalAxisState,
    checked,
)
from aioduco.models.jog import JogDirections, directions_of
from aioduco.models.op import Op, wire_op

if TYPE_CHECKING:
    from aioduco._wire import rpc
    from aioduco.models.pose import JointsLike, PoseLike
    from aioduco.models.rules import Real, VectorLike
    from aioduco.models.version import ControllerVersion
    from aioduco.supervision.command import HeldMotion, MotionCommand


#: time-out of calls that the controller answers only after it has switched drives [s]
_SWITCHING = 10.0
#: on the wire of 3.8 alone: no manual has it
_NOT_IN_4_3 = ("move_circle_eaxis",)
#: what is known, for a version between the manuals, and for a function that manual 4.3 lacks
_KNOWN = (
    "up to 3.8 a scheme comes by its name, from 4.3 on several come in lists",
    "no manual describes it, and 4.3 has changed the others like it",
)


class ExternalAxes(Section):
    """External axes (外部轴, manual 1.3.14): turntables, rails, in schemes of up to three values.

        await robot.external_axes.enable_eaxis_scheme("rail")
        await robot.external_axes.movel_eaxis(
            target, v=0.2, a=0.5, scheme_name="rail", epose=[1.5, 0, 0], eaxis_v=0.1
        )

    A stop stops the arm and these axes. But the wire does not report whether an axis stands: where
    this package says that the arm stands, that says nothing about the axes.
    """

    __slots__ = ()

    async def enable_eaxis_scheme(self, scheme_name: str, *, timeout: float = _SWITCHING) -> None:
        """Activate a scheme of external axes (启动外部轴方案).

        Args:
            scheme_name: name of the scheme.
            timeout: seconds within which the controller must have finished.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError, Refused: it was not activated.
            OutcomeUnknown: the controller did not answer within `timeout`.

        Manual section 1.3.14.
        """
        name = ranges.LONG_NAME("scheme_name", scheme_name)
        await self._finish_within(calls.enable_eaxis_scheme(name), timeout)

    async def disable_eaxis_scheme(self, scheme_name: str, *, timeout: float = _SWITCHING) -> None:
        """Deactivate a scheme of external axes (结束外部轴方案).

        Args:
            scheme_name: name of the scheme.
            timeout: seconds within which the controller must have finished.

        Raises:
            ParameterError: the name is empty; nothing was sent.
            TaskError, Refused: it was not deactivated.
            OutcomeUnknown: the controller did not answer within `timeout`.

        Manual section 1.3.14.
        """
        name = ranges.LONG_NAME("scheme_name", scheme_name)
        await self._finish_within(calls.disable_eaxis_scheme(name), timeout)

    async def get_eaxis_info(self) -> tuple[ExternalAxisState, ...]:
        """Read the state of each scheme of external axes (外部轴反馈信息).

        The wire of 3.8 has this function, and manual 4.3 describes it. Section 1.2 of manual 3.8
        describes the struct. Controllers of manual 4.3 also send speed and acceleration.
        """
        schemes = await self._rpc.get_eaxis_info()
        return tuple(
            ExternalAxisState(one.scheme_name, one.status, one.pos, *_rates(one)) for one in schemes
        )

    async def set_eaxis_param(self, num: int, param: ExternalAxis) -> None:
        """Set the parameters of an external axis.

        Args:
            num: number of the axis, from 0.
            param: its parameters.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: they were not set.

        Not in the manual, only on the wire. Check what the controller's own page shows before and
        after the call.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        checked("param", param, ExternalAxis)
        await self._finish(calls.set_eaxis_param(num_, param.wire(), True))

    async def set_eaxiss_scheme_param(self, num: int, param: ExternalAxisScheme) -> None:
        """Set the parameters of a scheme of external axes.

        Args:
            num: number of the scheme, from 0.
            param: its parameters.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: they were not set.

        Not in the manual, only on the wire. Check what the controller's own page shows before and
        after the call.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        checked("param", param, ExternalAxisScheme)
        await self._finish(calls.set_eaxiss_scheme_param(num_, param.wire(), True))

    async def add_eaxis_scheme(self, num: int) -> None:
        """Add a scheme of external axes.

        Args:
            num: number of the scheme, from 0.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            TaskError, Refused: it was not added.

        Not in the manual, only on the wire.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        await self._finish(calls.add_eaxis_scheme(num_, True))

    async def delete_eaxis_scheme(self, num: int) -> None:
        """Delete a scheme of external axes.

        Args:
            num: number of the scheme, from 0.

        Raises:
            ParameterError: the number is out of range; nothing was sent.
            TaskError, Refused: it was not deleted.

        Not in the manual, only on the wire.
        """
        num_ = ranges.EAXIS_NUMBER("num", num)
        await self._finish(calls.delete_eaxis_scheme(num_, True))

    def _with_axes(self, call: WireCall[int], r: float = 0.0) -> MotionCommand:
        """Make a motion whose schemes are sent as the controller's version takes them."""
        self._supervisor.dispatcher.require_opened(call.name)  # before, its version is unknown
        return self._motion(_as_taken(call, self._supervisor.version), r)

    def move_eaxis(
        self, scheme_name: str, epose: VectorLike, v: Real, *, op: Op | None = None
    ) -> MotionCommand:
        """Move external axes (外部轴移动); the arm stays where it is.

        The manual has a parameter def_acc here; the wire does not.

        Args:
            scheme_name: name of the scheme.
            epose: target, three values [rad or m, as the scheme is]. Shape (3,).
            v: highest speed of the axes (vel), above 0 [rad/s or m/s].
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            LayoutUnknown: it is not known how the controller's version takes the arguments.
            RobotStateError: the robot was not opened yet, so the version is not known.

        Manual section 1.3.14.
        """
        name = ranges.LONG_NAME("scheme_name", scheme_name)
        epose_ = ranges.EAXIS_POSITION("epose", epose)
        v_ = ranges.EAXIS_SPEED("v", v)
        op_ = wire_op("op", op, joint_motion=True)
        return self._with_axes(calls.move_eaxis(name, epose_, v_, False, op_))

    def move_jog_eaxis(
        self,
        scheme_name: str,
        direction: int,
        vel: Real,
        *,
        time: Real | None = JOG_TIME,
        directions: JogDirections | None = None,
    ) -> HeldMotion:
        """Jog external axes (外部轴点动).

            async with robot.external_axes.move_jog_eaxis("rail", 1, vel=5, time=10.0):
                await released()                # leaving the block ends the jog

        The controller jogs until a command ends the jog. No function is documented that ends this
        one alone, so this program stops all tasks, as `Robot.stop` does, when the block is left or
        after `time`. Cancelling its await, or an error inside its block, stops them too.

        Args:
            scheme_name: name of the scheme.
            direction: 1 or -1.
            vel: speed in percent, above 0, up to 100.
            time: seconds after which this program ends the jog, from 0.001; None: the jog runs
                until the block is left. Then only the heartbeat stops the axes if the program
                hangs.
            directions: the controller's meaning of the two directions; None: that of manual 3.8
                if its version is not newer. What newer ones mean is not known: manual 4.3 prints
                -1 and 1 here, and 0 and 1 for jogs of the arm.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range, or the controller's version is newer or
                unknown and `directions` is not given.

        Manual section 1.3.14.
        """
        name = ranges.LONG_NAME("scheme_name", scheme_name)
        direction_ = ranges.JOG_DIRECTION("direction", direction)
        vel_ = ranges.JOG_SPEED("vel", vel)
        ranges.RUN_TIME("time", time)
        means = directions_of(directions, self._supervisor.version, external=True)
        # The wire does not report whether these axes stand, so only a command ends the motion.
        return self._held(
            calls.move_jog_eaxis(name, means.number(direction_), vel_, False),
            "stop",
            time=time,
            timed_by_program=True,
            until_commanded=True,
        )

    def movej2_eaxis(
        self,
        joints: JointsLike,
        v: Real,
        a: Real,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: Real,
        *,
        r: Real = 0.0,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the joints and external axes together (外部轴关节运动), as `movej2`.

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            LayoutUnknown: it is not known how the controller's version takes the arguments.
            RobotStateError: the robot was not opened yet, so the version is not known.

        Manual section 1.3.14. It gives no ranges for v and a: those of `movej2` apply.
        """
        q = ranges.JOINTS("joints", joints)
        v_, a_, r_ = limits(ranges.EAXIS_JOINT_SPEED, ranges.EAXIS_JOINT_ACCELERATION, v, a, r)
        axes = _axes(scheme_name, epose, eaxis_v)
        end = outputs(op, def_acc, joint_motion=True)
        return self._with_axes(calls.movej2_eaxis(q, v_, a_, r_, *axes, *end), r_)

    def movej2_pose_eaxis(
        self,
        pose: PoseLike,
        v: Real,
        a: Real,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: Real,
        *,
        r: Real = 0.0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool to a pose by the joints, with external axes, as `movej_pose2`.

        外部轴关节运动到位姿.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way, by time: a distance is refused, since it has no effect here.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            LayoutUnknown: it is not known how the controller's version takes the arguments.
            RobotStateError: the robot was not opened yet, so the version is not known.

        Manual section 1.3.14. It gives no ranges for v and a: those of `movej_pose2` apply.
        """
        p = ranges.POSE("pose", pose)
        v_, a_, r_ = limits(ranges.EAXIS_JOINT_SPEED, ranges.EAXIS_JOINT_ACCELERATION, v, a, r)
        axes = _axes(scheme_name, epose, eaxis_v)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc, joint_motion=True)
        return self._with_axes(calls.movej2_pose_eaxis(p, v_, a_, r_, *there, *axes, *end), r_)

    def movel_eaxis(
        self,
        pose: PoseLike,
        v: Real,
        a: Real,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: Real,
        *,
        r: Real = 0.0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a line, with external axes (外部轴直线运动), as `movel`.

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, above 0, up to 5 [m/s].
            a: highest acceleration of the tool, above 0 [m/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            LayoutUnknown: it is not known how the controller's version takes the arguments.
            RobotStateError: the robot was not opened yet, so the version is not known.

        Manual section 1.3.14, which prints its name as move1_eaxis.
        """
        p = ranges.POSE("pose", pose)
        v_, a_, r_ = limits(ranges.EAXIS_LINE_SPEED, ranges.EAXIS_LINE_ACCELERATION, v, a, r)
        axes = _axes(scheme_name, epose, eaxis_v)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        return self._with_axes(calls.movel_eaxis(p, v_, a_, r_, *there, *axes, *end), r_)

    def movec_eaxis(
        self,
        via: PoseLike,
        pose: PoseLike,
        v: Real,
        a: Real,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: Real,
        *,
        r: Real = 0.0,
        mode: int = 0,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along an arc, with external axes (外部轴圆弧运动), as `movec`.

        Args:
            via: a pose on the arc (p1): x, y, z [m], rx, ry, rz [rad].
            pose: target pose (p2) of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest speed of the tool, above 0, up to 5 [m/s].
            a: highest acceleration of the tool, above 0 [m/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 0 changes to that of the end pose, 1 stays as at the
                start, 2 stays fixed to the arc's tangent.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            LayoutUnknown: it is not known how the controller's version takes the arguments.
            RobotStateError: the robot was not opened yet, so the version is not known.

        Manual section 1.3.14. It has no `mode`; the wire does.
        """
        p1, p2 = ranges.POSE("via", via), ranges.POSE("pose", pose)
        v_, a_, r_ = limits(ranges.EAXIS_LINE_SPEED, ranges.EAXIS_LINE_ACCELERATION, v, a, r)
        axes = _axes(scheme_name, epose, eaxis_v)
        mode_ = ranges.ARC_MODE("mode", mode)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        call = calls.movec_eaxis(p1, p2, v_, a_, r_, *there, *axes, *end, mode_)
        return self._with_axes(call, r_)

    def move_circle_eaxis(
        self,
        p1: PoseLike,
        p2: PoseLike,
        v: Real,
        a: Real,
        scheme_name: str,
        epose: VectorLike,
        eaxis_v: Real,
        *,
        r: Real = 0.0,
        mode: int = 1,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        op: Op | None = None,
        def_acc: bool = False,
    ) -> MotionCommand:
        """Move the tool along a circle, with external axes (外部轴圆周运动), as `move_circle`.

        Args:
            p1: the first pose on the circle: x, y, z [m], rx, ry, rz [rad].
            p2: the second pose on the circle; the order start, p1, p2 gives the direction.
            v: highest speed of the tool, above 0, up to 5 [m/s].
            a: highest acceleration of the tool, above 0 [m/s²].
            scheme_name: name of the scheme.
            epose: target of the axes, three values [rad or m, as the scheme is]. Shape (3,).
            eaxis_v: highest speed of the axes, above 0 [rad/s or m/s].
            r: blend radius into the next motion [m]; 0 to stop at the end.
            mode: orientation of the tool: 1 as at the start, 2 fixed to the circle's tangent.
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            op: outputs set on the way.
            def_acc: whether the controller chooses the acceleration in place of `a`.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.
            LayoutUnknown: it is not known how the controller's version takes the arguments.
            RobotStateError: the robot was not opened yet, so the version is not known.

        Not in the manual, only on the wire. The ranges are those of `movec_eaxis`.
        """
        p1_, p2_ = ranges.POSE("p1", p1), ranges.POSE("p2", p2)
        v_, a_, r_ = limits(ranges.EAXIS_LINE_SPEED, ranges.EAXIS_LINE_ACCELERATION, v, a, r)
        axes = _axes(scheme_name, epose, eaxis_v)
        mode_ = ranges.CIRCLE_MODE("mode", mode)
        there = frames(q_near, tool, wobj)
        end = outputs(op, def_acc)
        return self._with_axes(
            calls.move_circle_eaxis(p1_, p2_, v_, a_, r_, mode_, *there, *axes, *end), r_
        )


def _axes(scheme_name: str, epose: VectorLike, eaxis_v: Real) -> tuple[str, list[float], float]:
    return (
        ranges.LONG_NAME("scheme_name", scheme_name),
        ranges.EAXIS_POSITION("epose", epose),
        ranges.EAXIS_SPEED("eaxis_v", eaxis_v),
    )


def _as_taken(call: WireCall[int], version: ControllerVersion) -> WireCall[int]:
    """Return a call as a controller of a version takes it."""
    manual = version.manual
    if manual == "4.3" and call.name not in _NOT_IN_4_3:
        return newer.in_lists(call)
    if manual == "4.3" or (manual is None and version.known):
        raise LayoutUnknown(call.name, version.text, _KNOWN[manual == "4.3"])
    return call


def _rates(scheme: rpc.EAxissInfo) -> tuple[float, float]:
    """Speed and acceleration of a scheme; NaN for one that was not sent."""
    if not isinstance(scheme, newer.EAxissInfo):
        return math.nan, math.nan
    vel, acc = (math.nan if rate is None else rate for rate in (scheme.vel, scheme.acc))
    return vel, acc
