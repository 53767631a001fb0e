"""Speed, mode, versions and dimensions (manual 1.3.7)."""

from __future__ import annotations

import importlib.metadata
from typing import TYPE_CHECKING

from aioduco.models.enums import OperationMode, TaskState
from aioduco.sim.handlers.arguments import number
from aioduco.sim.handlers.base import Section, mismatch
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from aioduco.sim.controller import Controller


class SettingHandlers(Section):
    """Settings of the robot as a whole, and what it is."""

    def speed(self, val: float) -> int:
        """机器人全局速度百分比 [%]."""

        def command(controller: Controller) -> int:
            return controller.set_speed(round(number("val", val, 1.0, 100.0, "%")))

        return self._task("speed", True, command)

    def get_global_speed(self) -> int:
        """全局速度的百分比 [%]."""
        return self._runtime.snapshot.view.speed

    def switch_mode(self, mode: int) -> int:
        """0: manual, 1: automatic; refused where a switch at the cabinet decides."""

        def command(controller: Controller) -> int:
            if mode not in (OperationMode.MANUAL, OperationMode.AUTO):
                raise mismatch(f"mode is {mode}, but must be 0 or 1")
            if self._cabinet.mode_switch:
                raise Rejected(TaskState.ILLEGAL, "a switch at the cabinet decides the mode")
            return controller.switch_mode(OperationMode(mode))

        return self._task("switch_mode", True, command)

    def collision_detection_reset(self) -> int:
        """重置碰撞检测警告."""

        def command(controller: Controller) -> int:
            controller.reset_collision()
            return controller.finish("collision_detection_reset")

        return self._task("collision_detection_reset", True, command)

    def get_robot_version(self) -> str:
        """Version of the controller's software, which here is this package."""
        return f"aioduco simulator {importlib.metadata.version('aioduco')}"

    def get_robot_type(self) -> list[str]:
        """Series, model, extension, serial number."""
        return [self._context.series, self._context.model, "", self._context.serial]

    def get_origin_DH(self) -> list[list[float]]:  # noqa: N802 - the name on the wire
        """Denavit-Hartenberg parameters a, alpha, d, theta of each joint [m, rad]."""
        g = self._arm.geometry
        return [list(row) for row in zip(g.a, g.alpha, g.d, g.theta, strict=True)]

    def get_calib_DH(self) -> list[list[float]]:  # noqa: N802 - the name on the wire
        """The same: a simulated arm is built as designed."""
        return self.get_origin_DH()
