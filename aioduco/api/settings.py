"""Settings of the robot as a whole (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.models.samples import joints

if TYPE_CHECKING:
    from aioduco.models.pose import Joints
    from aioduco.models.rules import Real, Whole


class Settings(Section):
    """Speeds, collision detection, simulation, pendant (manual 1.3.7).

    These settings apply to all programs, and remain after the end of this one.
    """

    __slots__ = ()

    async def speed(self, val: Real) -> None:
        """Set the global speed (全局速度百分比), which scales all motions.

        Args:
            val: percent, 1 to 100; fractions are allowed.

        Raises:
            ParameterError: it is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7.
        """
        await self._finish(calls.speed(ranges.GLOBAL_SPEED("val", val)))

    async def get_global_speed(self) -> int:
        """Read the global speed (全局速度的百分比), in percent.

        The wire has whole numbers here: the fraction of a speed is lost.

        Manual section 1.3.7.
        """
        return await self._rpc.get_global_speed()

    async def set_teach_speed(self, v: Whole) -> None:
        """Set the speed of jogs (示教速度的百分比), which scales the speed of each jog.

        Args:
            v: percent, a whole number from 1 to 100.

        Raises:
            ParameterError: it is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7.
        """
        await self._finish(calls.set_teach_speed(ranges.TEACH_SPEED("v", v)))

    async def get_teach_speed(self) -> int:
        """Read the speed of jogs (示教速度的百分比), in percent. Manual section 1.3.7."""
        return await self._rpc.get_teach_speed()

    async def collision_detect(self, level: Whole) -> None:
        """Set the level of the collision detection (碰撞检测等级).

        Args:
            level: 0 for no detection, or 1 to 5.

        Raises:
            ParameterError: it is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7.
        """
        level_ = ranges.COLLISION_LEVEL("level", level)
        await self._finish(calls.collision_detect(level_))

    async def collision_detection_reset(self) -> None:
        """Clear the alarm of a collision (重置碰撞检测警告).

        `Robot.recover` includes this step.

        Raises:
            TaskError, Refused: it was not cleared.

        Manual section 1.3.7.
        """
        await self._accept(calls.collision_detection_reset())

    async def simulation(self, sim: bool) -> None:
        """Switch between the controller's own simulation and the real arm (仿真或者真机模式).

        The simulation is for dry runs: motions run and the states that are read change, while the
        real arm stands. The simulated arm starts at the position of the real one. After switching
        back, read the real arm's position before the next motion: it has not moved.

        The arm must be completely at rest, or it moves in an unforeseen way and stops with an
        alarm. So this is refused while the arm moves. Make sure that no other program moves it.

        Args:
            sim: true for the simulation, false for the real arm.

        Raises:
            ParameterError: it is neither; nothing was sent.
            RobotStateError: the arm moves; nothing was sent.
            TaskError: it was not switched; the message contains the controller's reason.

        Manual section 1.3.7.
        """
        sim_ = ranges.FLAG("sim", sim)
        await self._carry_out_standing(calls.simulation(sim_, False))

    async def get_simulation_state(self) -> bool:
        """Tell whether the controller simulates the arm (仿真状态).

        Raises:
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        return await self._rpc.get_simulation_state()

    async def get_home_pose(self) -> Joints:
        """Read the joints of the home position (原点) [rad].

        Raises:
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        return joints(await self._rpc.get_home_pose())

    async def get_installation(self) -> tuple[float, ...]:
        """Read the angles at which the arm is mounted (安装角度).

        Returns:
            What the controller sends: ry and rz. The manual prints no unit.

        Raises:
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        return tuple(await self._rpc.get_installation())

    async def set_teach_pendant(self, enable: bool) -> None:
        """Turn the keys of the pendant on or off (示教器的物理按键).

        Args:
            enable: true for on.

        Raises:
            ParameterError: it is neither true nor false; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.7.
        """
        enable_ = ranges.FLAG("enable", enable)
        await self._finish(calls.set_teach_pendant(enable_))
