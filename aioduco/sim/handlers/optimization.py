"""Optimization of motions (manual 1.3.11)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.sim.handlers.base import HandlerSection

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.controller.motion_settings import OptimizationSwitches
    from aioduco.sim.controller.state_machine import Controller


class OptimizationHandlers(HandlerSection):
    """enable_speed_optimization to disable_vibration_control; they apply to later motions."""

    def enable_speed_optimization(self) -> int:
        """开启速度优化."""

        def on(flags: OptimizationSwitches) -> None:
            flags.speed = True

        return self._switch("enable_speed_optimization", on)

    def disable_speed_optimization(self) -> int:
        """退出速度优化."""

        def off(flags: OptimizationSwitches) -> None:
            flags.speed = False

        return self._switch("disable_speed_optimization", off)

    def enable_acc_optimization(self) -> int:
        """开启加速度优化."""

        def on(flags: OptimizationSwitches) -> None:
            flags.acceleration = True

        return self._switch("enable_acc_optimization", on)

    def disable_acc_optimization(self) -> int:
        """退出加速度优化."""

        def off(flags: OptimizationSwitches) -> None:
            flags.acceleration = False

        return self._switch("disable_acc_optimization", off)

    def enable_singularity_control(self) -> int:
        """开启奇异点规避."""

        def on(flags: OptimizationSwitches) -> None:
            flags.singularity = True

        return self._switch("enable_singularity_control", on)

    def disable_singularity_control(self) -> int:
        """关闭奇异点规避."""

        def off(flags: OptimizationSwitches) -> None:
            flags.singularity = False

        return self._switch("disable_singularity_control", off)

    def enable_vibration_control(self) -> int:
        """开启振动控制."""

        def on(flags: OptimizationSwitches) -> None:
            flags.vibration = True

        return self._switch("enable_vibration_control", on)

    def disable_vibration_control(self) -> int:
        """退出振动控制."""

        def off(flags: OptimizationSwitches) -> None:
            flags.vibration = False

        return self._switch("disable_vibration_control", off)

    def _switch(self, name: str, change: Callable[[OptimizationSwitches], None]) -> int:
        def command(controller: Controller) -> int:
            change(controller.optimization)
            return controller.finish(name)

        return self._task(name, True, command)
