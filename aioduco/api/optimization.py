"""How motions are optimized (运动优化函数, manual 1.3.11)."""

from __future__ import annotations

from aioduco._wire.rpc import calls
from aioduco.api.section import Section


class Optimization(Section):
    """How motions are optimized (运动优化函数, manual 1.3.11).

    These settings apply to all programs, and remain after the end of this one. The controller
    avoids singularities only while vibration control is off; it is on after the controller's start.
    """

    __slots__ = ()

    async def enable_speed_optimization(self) -> None:
        """Let the arm move as fast as its safety limits allow (开启速度优化).

        In automatic mode the speeds given to motions then have no effect: the arm moves faster.
        This optimizes accelerations as well.

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        # before it is sent, since its answer may be lost
        self._supervisor.envelope.strays("enable_speed_optimization")
        await self._finish(calls.enable_speed_optimization())

    async def disable_speed_optimization(self) -> None:
        """Let the arm move at the speeds given to motions (退出速度优化).

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        await self._finish(calls.disable_speed_optimization())
        self._supervisor.envelope.strays("enable_speed_optimization", on=False)

    async def enable_acc_optimization(self) -> None:
        """Let the arm accelerate as hard as its drives can (开启加速度优化).

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        await self._finish(calls.enable_acc_optimization())

    async def disable_acc_optimization(self) -> None:
        """Let the arm accelerate at the values given to motions (退出加速度优化).

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        await self._finish(calls.disable_acc_optimization())

    async def enable_singularity_control(self) -> None:
        """Let Cartesian motions go around singularities (开启奇异点规避).

        Near a singularity the arm changes over to a joint motion, and leaves the path a little.
        This has no effect while vibration control is on.

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        # before it is sent, since its answer may be lost
        self._supervisor.envelope.strays("enable_singularity_control")
        await self._finish(calls.enable_singularity_control())

    async def disable_singularity_control(self) -> None:
        """Let Cartesian motions stop with an alarm near singularities (退出奇异点规避).

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        await self._finish(calls.disable_singularity_control())
        self._supervisor.envelope.strays("enable_singularity_control", on=False)

    async def enable_vibration_control(self) -> None:
        """Damp vibrations as motions start and end (开启振动控制), the controller's default.

        It makes each motion 200 to 400 ms longer.

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        await self._finish(calls.enable_vibration_control())

    async def disable_vibration_control(self) -> None:
        """Do not damp vibrations as motions start and end (退出振动控制).

        This setting remains after the end of the program, until the controller starts again.

        Raises:
            TaskError, Refused: it was not switched.

        Manual section 1.3.11.
        """
        await self._finish(calls.disable_vibration_control())
