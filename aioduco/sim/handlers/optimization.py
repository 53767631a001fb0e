"""Optimization of motions (manual 1.3.11)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from aioduco.sim.handlers.base import HandlerSection

if TYPE_CHECKING:
    from aioduco.sim.controller.state_machine import Controller


class OptimizationHandlers(HandlerSection):
    """enable_speed_optimization to disable_vibration_control; they apply to later motions."""

    def enable_speed_optimization(self) -> int:
        """开启速度优化."""
        return self._switch("enable_speed_optimization", speed=True)

    def disable_speed_optimization(self) -> int:
        """退出速度优化."""
        return self._switch("disable_speed_optimization", speed=False)

    def enable_acc_optimization(self) -> int:
        """开启加速度优化."""
        return self._switch("enable_acc_optimization", acceleration=True)

    def disable_acc_optimization(self) -> int:
        """退出加速度优化."""
        return self._switch("disable_acc_optimization", acceleration=False)

    def enable_singularity_control(self) -> int:
        """开启奇异点规避."""
        return self._switch("enable_singularity_control", singularity=True)

    def disable_singularity_control(self) -> int:
        """关闭奇异点规避."""
        return self._switch("disable_singularity_control", singularity=False)

    def enable_vibration_control(self) -> int:
        """开启振动控制."""
        return self._switch("enable_vibration_control", vibration=True)

    def disable_vibration_control(self) -> int:
        """退出振动控制."""
        return self._switch("disable_vibration_control", vibration=False)

    def _switch(self, name: str, **switches: bool) -> int:
        def command(controller: Controller) -> None:
            controller.optimization = replace(controller.optimization, **switches)

        return self._task(name, True, command)
