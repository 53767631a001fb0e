"""State of the arm and of the controller (manual 1.3.7 and 1.3.8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.models.enums import TaskState
from aioduco.models.samples import joints, pose
from aioduco.models.state import IOStatus, RobotStates, RobotStatus, Vector, vector

if TYPE_CHECKING:
    from aioduco.models.pose import Joints, Pose


class State(Section):
    """State of the arm and of the controller (manual 1.3.7, 1.3.8).

    Every function only reads. Vectors are read-only arrays of shape (6,). A number that the
    controller does not send is NaN in them, as a force without a sensor, or any right after its
    start; functions for joints, poses and states raise `StaleState` then.
    """

    __slots__ = ()

    async def get_robot_state(self) -> RobotStates:
        """Read the states of robot, program, safety and mode (机器人状态). Manual section 1.3.7."""
        return self._supervisor.samples.states(await self._rpc.get_robot_state())

    async def getRobotStatus(self) -> RobotStatus:  # noqa: N802  # the manual's name
        """Read positions, speeds, temperatures and faults at once (机器人位姿等信息).

        Manual section 1.3.7.
        """
        return self._supervisor.samples.status(await self._rpc.getRobotStatus())

    async def getRobotIOStatus(self) -> IOStatus:  # noqa: N802  # the manual's name
        """Read all inputs, outputs and registers at once (IO 和寄存器信息).

        Manual section 1.3.7.
        """
        status = await self._rpc.getRobotIOStatus()
        return self._supervisor.samples.io(lambda: status)

    async def robotmoving(self) -> bool:
        """Tell whether the arm moves (机器人是否在运动). Manual section 1.3.8."""
        return await self._rpc.robotmoving()

    async def get_last_error(self) -> tuple[str, ...]:
        """Read the controller's latest errors (错误列表), in its own words.

        Manual section 1.3.8.
        """
        return tuple(await self._rpc.get_last_error())

    async def clear_error_message(self) -> None:
        """Empty the controller's list of errors (清除错误列表).

        Raises:
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        await self._rpc.clear_error_message()

    async def get_noneblock_taskstate(self, task_id: int) -> TaskState:
        """Read the state of a task by its id (任务状态).

        This package follows the state of its own tasks; this function is for tasks of other
        programs.

        Manual section 1.3.8, which prints its name as get_noblock_taskstate.
        """
        id_ = ranges.TASK_ID("task_id", task_id)
        return TaskState(await self._rpc.get_noneblock_taskstate(id_))

    async def get_actual_joints_position(self) -> Joints:
        """Read the joint angles (关节角度) [rad]. Manual section 1.3.7."""
        return joints(await self._rpc.get_actual_joints_position())

    async def get_target_joints_position(self) -> Joints:
        """Read the planned joint angles (规划角度) [rad]. Manual section 1.3.7."""
        return joints(await self._rpc.get_target_joints_position())

    async def get_actual_joints_speed(self) -> Vector:
        """Read the joint speeds (关节角速度) [rad/s]. Manual section 1.3.7."""
        return vector(await self._rpc.get_actual_joints_speed())

    async def get_target_joints_speed(self) -> Vector:
        """Read the planned joint speeds (规划角速度) [rad/s]. Manual section 1.3.7."""
        return vector(await self._rpc.get_target_joints_speed())

    async def get_actual_joints_acceleration(self) -> Vector:
        """Read the joint accelerations (关节角加速度) [rad/s²]. Manual section 1.3.7."""
        return vector(await self._rpc.get_actual_joints_acceleration())

    async def get_target_joints_acceleration(self) -> Vector:
        """Read the planned joint accelerations (规划加速度) [rad/s²]. Manual section 1.3.7."""
        return vector(await self._rpc.get_target_joints_acceleration())

    async def get_actual_joints_torque(self) -> Vector:
        """Read the joint torques (关节力矩) [N·m]. Manual section 1.3.7."""
        return vector(await self._rpc.get_actual_joints_torque())

    async def get_target_joints_torque(self) -> Vector:
        """Read the planned joint torques (目标力矩) [N·m]. Manual section 1.3.7."""
        return vector(await self._rpc.get_target_joints_torque())

    async def get_ext_torque(self) -> Vector:
        """Read the observed external joint torques (外力矩) [N·m]. Manual section 1.3.7."""
        return vector(await self._rpc.get_ext_torque())

    async def get_tcp_pose(self) -> Pose:
        """Read the pose of the tool in the base frame (末端位姿) [m, rad]. Manual section 1.3.7."""
        return pose(await self._rpc.get_tcp_pose())

    async def get_tcp_pose_coord(self, tool: str = "", wobj: str = "") -> Pose:
        """Read the pose of a tool in a work object (工件坐标系下的位姿) [m, rad].

        Args:
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.

        Returns:
            The pose.

        Raises:
            ParameterError: a name is too long; nothing was sent.
            Refused: the controller lists an error: it has no such tool or work object.

        Manual section 1.3.7.
        """
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        call = calls.get_tcp_pose_coord(tool_, wobj_)
        return pose(await self._read_checked(call, tool_ or wobj_))

    async def get_tcp_speed(self) -> Vector:
        """Read the speed of the tool (末端速度) [m/s, rad/s]. Manual section 1.3.7."""
        return vector(await self._rpc.get_tcp_speed())

    async def get_tcp_acceleration(self) -> Vector:
        """Read the acceleration of the tool (末端加速度) [m/s², rad/s²]. Manual section 1.3.7."""
        return vector(await self._rpc.get_tcp_acceleration())

    async def get_tcp_pose_command(self) -> Pose:
        """Read the commanded pose of the tool (末端指令位姿) [m, rad].

        Raises:
            UnknownFunction: the controller is older than the function.

        Not in manual 3.8, nor described in manual 4.3: the vendor's newest headers have it. That
        the pose is in the base frame, as `get_tcp_pose` has it, is an assumption.
        """
        return pose(await self._rpc.get_tcp_pose_command())

    async def get_tcp_speed_command(self) -> Vector:
        """Read the commanded speed of the tool (末端指令速度) [m/s, rad/s].

        Raises:
            UnknownFunction: the controller is older than the function.

        Not in manual 3.8, nor described in manual 4.3: the vendor's newest headers have it. That
        the speed is in the base frame, as `get_tcp_speed` has it, is an assumption.
        """
        return vector(await self._rpc.get_tcp_speed_command())

    async def get_tcp_force(self) -> Vector:
        """Read force and torque at the tool (末端力) [N, N·m]; needs a force sensor.

        Manual section 1.3.7.
        """
        return vector(await self._rpc.get_tcp_force())

    async def get_tcp_force_tool(self, tool: str = "") -> Vector:
        """Read force and torque in a tool's frame (工具坐标系下的力) [N, N·m], by a sensor.

        Args:
            tool: name of the tool; empty for the one in use.

        Raises:
            ParameterError: the name is too long; nothing was sent.
            Refused: the controller lists an error: it has no such tool.

        Manual section 1.3.7.
        """
        tool_ = ranges.FRAME("tool", tool)
        return vector(await self._read_checked(calls.get_tcp_force_tool(tool_), tool_))

    async def get_flange_pose(self) -> Pose:
        """Read the pose of the flange in the base frame (法兰位姿) [m, rad].

        Manual section 1.3.7.
        """
        return pose(await self._rpc.get_flange_pose())

    async def get_flange_speed(self) -> Vector:
        """Read the speed of the flange (法兰速度) [m/s, rad/s]. Manual section 1.3.7."""
        return vector(await self._rpc.get_flange_speed())

    async def get_flange_acceleration(self) -> Vector:
        """Read the acceleration of the flange (法兰加速度) [m/s², rad/s²]. Manual section 1.3.7."""
        return vector(await self._rpc.get_flange_acceleration())

    async def read_encoder_count(self) -> int:
        """Read the count of an external incremental encoder (外接 INC 的实际 count 值).

        Manual section 1.3.7.
        """
        return await self._rpc.read_encoder_count()
