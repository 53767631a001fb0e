"""Kinematics, as the controller computes it (manual 1.3.7)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from aioduco._wire import newer
from aioduco.api.section import Section
from aioduco.errors import ControllerError, Unreachable
from aioduco.models import ranges
from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
from aioduco.models.samples import joints as joints_of
from aioduco.models.samples import pose as pose_of
from aioduco.models.state import Vector, vector

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


#: largest accepted distance between a pose and the pose of the joints computed for it [m, rad]:
#: much more than rounding, much less than if the controller returned the joints unchanged
_POSITION, _ROTATION = 1e-4, 1e-3


@dataclass(frozen=True, slots=True)
class Reachability:
    """Result of `reach_check` (ReachabilityParam, manual 1.3.7).

    Attributes:
        reachable: whether all poses can be reached.
        joints: joints for each pose, in the order of the poses; empty if not all can be reached,
            and on controllers of manual 4.3, which do not send them.
        index: on those, the controller's index of the pose that cannot be reached; else None.
        singularity: on those, why (singularity_type): 0 none, 1 shoulder, 2 elbow, 3 wrist, 4 out
            of space; else None.
    """

    reachable: bool
    joints: tuple[Joints, ...]
    index: int | None = None
    singularity: int | None = None

    def __bool__(self) -> bool:
        return self.reachable


class Kinematics(Section):
    """Kinematics, as the controller computes it (manual 1.3.7).

    The controller uses the arm's calibration. `aioduco.kinematics` computes on this computer,
    without a controller, for the arm as designed.
    """

    __slots__ = ()

    async def cal_fkine(
        self,
        joints: JointsLike,
        *,
        tool: PoseLike | None = None,
        wobj: PoseLike | None = None,
    ) -> Pose:
        """Compute the tool's pose at joint angles (正运动学).

        Args:
            joints: joint angles, -2π to 2π [rad]. Shape (6,).
            tool: pose of the tool in the flange's frame [m, rad]; None for the one in use.
            wobj: pose of the work object in the base frame [m, rad]; None for the one in use.

        Returns:
            The pose of the tool in the work object [m, rad].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.

        Manual section 1.3.7.
        """
        joints_ = ranges.JOINTS("joints", joints)
        tool_ = ranges.POSE_OR_CURRENT("tool", tool)
        wobj_ = ranges.POSE_OR_CURRENT("wobj", wobj)
        return pose_of(await self._rpc.cal_fkine(joints_, tool_, wobj_))

    async def cal_ikine(
        self,
        pose: PoseLike,
        *,
        q_near: JointsLike | None = None,
        tool: PoseLike | None = None,
        wobj: PoseLike | None = None,
    ) -> Joints:
        """Compute joint angles for a pose (逆运动学).

        For a pose out of reach, controllers return `q_near` itself. So this function puts the
        answer through `cal_fkine` and compares the result with the pose: another pose is an error.
        If you leave out `tool` or `wobj`, do not set another one during the call.

        Args:
            pose: pose of the tool in the work object [m, rad].
            q_near: joint angles, -2π to 2π [rad], near which a solution is looked for; None for
                the arm's present ones. Shape (6,).
            tool: pose of the tool in the flange's frame [m, rad]; None for the one in use.
            wobj: pose of the work object [m, rad]; None for the one in use. It is in the world
                frame, as the manual says here, while `cal_fkine` has it in the base frame: on an
                arm that is mounted at a wall or a ceiling they differ.

        Returns:
            The joints [rad].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            Unreachable: the controller found no joints for the pose.

        Manual section 1.3.7.
        """
        pose_ = ranges.POSE("pose", pose)
        near_ = ranges.JOINTS_NEAR("q_near", q_near)
        tool_ = ranges.POSE_OR_CURRENT("tool", tool)
        wobj_ = ranges.POSE_OR_CURRENT("wobj", wobj)
        found = await self._rpc.cal_ikine(pose_, near_, tool_, wobj_)
        target = Pose(*pose_)
        if len(found) < 6 or not all(map(math.isfinite, found)):
            raise Unreachable(f"the controller found no joints for {target}; nothing was moved")
        led = pose_of(await self._rpc.cal_fkine(found, tool_, wobj_))
        if wobj_ and not led.almost_equal(target, position=_POSITION, rotation=_ROTATION):
            led = await self._in_world(led, Pose(*wobj_))
        if not led.almost_equal(target, position=_POSITION, rotation=_ROTATION):
            apart, turned = led.distance(target)
            raise Unreachable(
                f"{target} is out of the arm's reach: the controller's joints for it lead "
                f"{apart:.3g} m and {turned:.3g} rad away from it; nothing was moved"
            )
        return Joints(*found[:6])

    async def _in_world(self, pose: Pose, wobj: Pose) -> Pose:
        """Convert a pose in a work object of the base frame into one of the world frame."""
        status = await self._rpc.getRobotStatus()  # joints and pose of one instant
        there = list(joints_of(status.jointActualPosition))
        tip = await self._rpc.cal_fkine(there, [], [0.0] * 6)
        base = pose_of(status.cartActualPosition) @ pose_of(tip).inverse()
        return wobj.inverse() @ base @ wobj @ pose

    async def reach_check(
        self,
        *,
        base: PoseLike,
        wobj: PoseLike,
        tool: PoseLike,
        ref_pos: JointsLike,
        check_points: Iterable[PoseLike],
    ) -> Reachability:
        """Check whether an arm with a given pose of its base can reach poses (可达性).

        Manual 4.3 has `tool` before `wobj`: they are sent so to a controller whose version is 4.3
        or later.

        Args:
            base: pose of the arm's base in the world [m, rad].
            wobj: pose of the work object in the world [m, rad].
            tool: pose of the tool in the flange's frame [m, rad].
            ref_pos: joint angles near which solutions are looked for, -2π to 2π [rad].
                Shape (6,).
            check_points: poses of the tool in the work object [m, rad], at least one.

        Returns:
            Whether all poses can be reached, and if so the joints for each: see `Reachability`.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            ControllerError: the controller says that all can be reached, but does not send the
                joints; or it answers as one of manual 4.3, but its version is not known to be one.

        Manual section 1.3.7.
        """
        points = ranges.CHECK_POINTS("check_points", check_points)
        is_newer = self._supervisor.version.manual == "4.3"
        base_ = ranges.POSE("base", base)
        first, second = ranges.POSE("wobj", wobj), ranges.POSE("tool", tool)
        if is_newer:
            first, second = second, first
        near = ranges.JOINTS("ref_pos", ref_pos)
        found = await self._rpc.reach_check(base_, first, second, near, points)
        if isinstance(found, newer.ReachabilityParam):
            if not is_newer:
                raise ControllerError(
                    "reach_check",
                    "the controller answered as one of manual 4.3, but its version, "
                    f"{self._supervisor.version}, does not say so: it may have taken tool and "
                    "work object in the other order",
                )
            index = None if found.result else found.index
            return Reachability(found.result, (), index, found.singularity_type)
        if not found.result:
            return Reachability(reachable=False, joints=())
        joints = [row for row in found.joints_pos if len(row) >= 6]
        if len(joints) != len(points):
            raise ControllerError(
                "reach_check",
                f"the controller sent the joints of {len(joints)} of {len(points)} poses",
            )
        return Reachability(reachable=True, joints=tuple(Joints(*row[:6]) for row in joints))

    async def get_origin_DH(self) -> Vector:  # noqa: N802  # the manual's name
        """Read the Denavit-Hartenberg parameters of the arm as designed (原始 DH 参数).

        A read-only array of shape (6, 4): a [m], alpha [rad], d [m], theta [rad] of each joint.
        Manual section 1.3.7.
        """
        return _table(await self._rpc.get_origin_DH())

    async def get_calib_DH(self) -> Vector:  # noqa: N802  # the manual's name
        """Read the Denavit-Hartenberg parameters of this arm, calibrated (补偿后 DH 参数).

        A read-only array of shape (6, 4): a [m], alpha [rad], d [m], theta [rad] of each joint.
        Manual section 1.3.7.
        """
        return _table(await self._rpc.get_calib_DH())


def _table(wire: Sequence[Sequence[float]]) -> Vector:
    """Make a read-only array with a row of four numbers for each joint."""
    table = np.array([vector(row, 4) for row in wire]).reshape(-1, 4)
    table.flags.writeable = False
    return table
