"""How motions are optimized (运动优化函数, manual 1.3.11)."""

from __future__ import annotations

from aioduco.api.section import Section, done

__all__ = ["Optimization"]


class Optimization(Section):
    """How motions are optimized (运动优化函数, manual 1.3.11).

    What is switched here holds for all programs, and after the end of this one. Singularities
    are only avoided while vibrations are not damped, which they are from the start on.
    """

    __slots__ = ()

    async def enable_speed_optimization(self) -> None:
        """Let the arm move as fast as its safety limits allow (开启速度优化).

        In automatic mode the speeds given to motions then have no effect any more: the arm moves
        faster than they say. It optimizes accelerations as well.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("enable_speed_optimization", await self._rpc.enable_speed_optimization())

    async def disable_speed_optimization(self) -> None:
        """Let the arm move at the speeds that motions are given (退出速度优化).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("disable_speed_optimization", await self._rpc.disable_speed_optimization())

    async def enable_acc_optimization(self) -> None:
        """Let the arm accelerate as hard as its drives can (开启加速度优化).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("enable_acc_optimization", await self._rpc.enable_acc_optimization())

    async def disable_acc_optimization(self) -> None:
        """Let the arm accelerate as motions are told to (退出加速度优化).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("disable_acc_optimization", await self._rpc.disable_acc_optimization())

    async def enable_singularity_control(self) -> None:
        """Let Cartesian motions go around singularities (开启奇异点规避).

        Near one the arm changes over to a joint motion, and leaves the path a little. It has no
        effect while vibrations are damped.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("enable_singularity_control", await self._rpc.enable_singularity_control())

    async def disable_singularity_control(self) -> None:
        """Let Cartesian motions stop with an alarm near singularities (退出奇异点规避).

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("disable_singularity_control", await self._rpc.disable_singularity_control())

    async def enable_vibration_control(self) -> None:
        """Damp vibrations as motions start and end, as from the start (开启振动控制).

        Each motion takes 200 to 400 ms longer by it.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("enable_vibration_control", await self._rpc.enable_vibration_control())

    async def disable_vibration_control(self) -> None:
        """Damp no vibrations as motions start and end (退出振动控制).

        It stays so after the program.

        Raises:
            TaskError: it was not switched.

        Manual section 1.3.11.
        """
        done("disable_vibration_control", await self._rpc.disable_vibration_control())
