"""Set-points of the servo functions, one at a time.

These functions wait for the answer to each set-point. For set-points at a fixed rate use streams,
which have a schedule and a connection of their own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.arguments import frames, gains
from aioduco.api.motion.aiming import tool_aim
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.streaming.shared.turning import MotionFrame, in_tool, into_tool

if TYPE_CHECKING:
    from aioduco.models.pose import JointsLike, PoseLike
    from aioduco.models.rules import Real
    from aioduco.supervision.command import MotionCommand


#: the vendor's defaults; the manual gives the first two
_KP, _KD, _SMOOTH_VEL, _SMOOTH_ACC = 200.0, 25.0, 10.0, 1.0


class ServoMotions(Section):
    """Set-points to which the controller plans the motion; each one replaces the one before.

    A set-point of another kind waits until the arm has reached the last one of the present kind. A
    set-point that was replaced counts as blended.
    """

    __slots__ = ()

    def servoj(
        self,
        joints: JointsLike,
        v: Real,
        a: Real,
        *,
        kp: Real = _KP,
        kd: Real = _KD,
        smooth_vel: Real = _SMOOTH_VEL,
        smooth_acc: Real = _SMOOTH_ACC,
    ) -> MotionCommand:
        """Go to joint angles, each joint independently (关节伺服运动), from any state of motion.

        Args:
            joints: target, six angles in [-2π, 2π] [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        q = ranges.JOINTS("joints", joints)
        v_ = ranges.JOINT_SPEED("v", v)
        a_ = ranges.JOINT_ACCELERATION("a", a)
        tuning = gains(kp, kd, smooth_vel, smooth_acc)
        return self._motion(calls.servoj(q, v_, a_, False, *tuning), superseded=True)

    def servoj_pose(
        self,
        pose: PoseLike,
        v: Real,
        a: Real,
        *,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        kp: Real = _KP,
        kd: Real = _KD,
        smooth_vel: Real = _SMOOTH_VEL,
        smooth_acc: Real = _SMOOTH_ACC,
    ) -> MotionCommand:
        """Go to a pose of the tool, each joint independently (关节伺服运动到位姿).

        Args:
            pose: target pose of the tool in the work object; x, y, z [m], rx, ry, rz [rad].
            v: highest joint speed, 0.01·π/180 to 1.25·π [rad/s].
            a: highest joint acceleration, from 0.01·π/180 [rad/s²].
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("pose", pose)
        v_ = ranges.JOINT_SPEED("v", v)
        a_ = ranges.JOINT_ACCELERATION("a", a)
        there = frames(q_near, tool, wobj)
        tuning = gains(kp, kd, smooth_vel, smooth_acc)
        return self._motion(calls.servoj_pose(p, v_, a_, *there, False, *tuning), superseded=True)

    def servo_tcp(
        self,
        offset: PoseLike,
        v: Real,
        a: Real,
        *,
        tool: str = "",
        frame: MotionFrame = "tool",
        wobj: str = "",
        kp: Real = _KP,
        kd: Real = _KD,
        smooth_vel: Real = _SMOOTH_VEL,
        smooth_acc: Real = _SMOOTH_ACC,
    ) -> MotionCommand:
        """Shift the arm's present target by an offset of the tool (工具增量伺服运动).

        The controller takes the offset in the tool's frame. With another `frame`, this package
        converts it by the tool's orientation. It reads the orientation just before it sends the
        motion, so the value is a few milliseconds old. While the tool turns, its target has another
        orientation; `robot.servo.tcp_offset` takes that into account.

        Args:
            offset: translation x, y, z [m] and rotation rx, ry, rz [rad] (pose_offset) along and
                about the axes of `frame`, from the arm's present target. The tool turns about its
                tip.
            v: highest speed, 0.01·π/180 to 1.25·π: of the joints by manual 3.8 [rad/s], of the
                tool by manual 4.3 [m/s].
            a: highest acceleration, from 0.01·π/180 [rad/s² or m/s²].
            tool: name of the tool; empty for the one in use.
            frame: frame of the offset: "tool", "base" (z points up if the arm stands on a floor)
                or "wobj", a work object.
            wobj: name of the work object; empty for the one in use.
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            The motion, not sent yet. Each further use shifts the target by the offset
            again. Sending it raises `StaleState` if the orientation cannot be read.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("offset", offset)
        v_ = ranges.SERVO_SPEED("v", v)
        a_ = ranges.SERVO_ACCELERATION("a", a)
        tool_ = ranges.FRAME("tool", tool)
        tuning = gains(kp, kd, smooth_vel, smooth_acc)
        turning = into_tool(frame, wobj, tool_)
        aim = None
        if turning is not None:
            aim = tool_aim(self._supervisor, turning, in_tool)
        call = calls.servo_tcp(p, v_, a_, tool_, False, *tuning)
        return self._motion(call, superseded=True, aim=aim, frame=frame)

    def servol(
        self,
        pose: PoseLike,
        v: Real,
        a: Real,
        *,
        q_near: JointsLike | None = None,
        tool: str = "",
        wobj: str = "",
        kp: Real = _KP,
        kd: Real = _KD,
        smooth_vel: Real = _SMOOTH_VEL,
        smooth_acc: Real = _SMOOTH_ACC,
    ) -> MotionCommand:
        """Go to a pose of the tool, each Cartesian direction independently (笛卡尔伺服运动).

        Args:
            pose: target pose of the tool in the work object (pose_list); x, y, z [m], rx, ry, rz
                [rad].
            v: highest speed, 0.01·π/180 to 1.25·π: of the joints by manual 3.8 [rad/s], of the
                tool by manual 4.3 [m/s].
            a: highest acceleration, from 0.01·π/180 [rad/s² or m/s²].
            q_near: joint angles [rad] near which the solution is chosen; None: the present ones.
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            kp: proportional gain, from 0; 200 is recommended.
            kd: derivative gain, from 0; 25 is recommended.
            smooth_vel: smoothing of the speed, 1 to 100; a larger value lags more.
            smooth_acc: smoothing of the acceleration, 0 to 1; a larger value lags more.

        Returns:
            The motion, not sent yet.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.5.
        """
        p = ranges.POSE("pose", pose)
        v_ = ranges.SERVO_SPEED("v", v)
        a_ = ranges.SERVO_ACCELERATION("a", a)
        there = frames(q_near, tool, wobj)
        tuning = gains(kp, kd, smooth_vel, smooth_acc)
        return self._motion(calls.servol(p, v_, a_, *there, False, *tuning), superseded=True)
