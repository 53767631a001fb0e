"""Settings, versions and dimensions (manual 1.3.7)."""

from __future__ import annotations

import contextlib
import importlib.metadata
import math
from typing import TYPE_CHECKING

from aioduco._wire.rpc import ReachabilityParam
from aioduco.errors import Unreachable
from aioduco.models.enums import OperationMode
from aioduco.sim.handlers.arguments import choice, joints, number, pose
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.refusal import Rejected, illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.controller.state_machine import Controller


class SettingHandlers(HandlerSection):
    """Settings of robot, pendant and collision detection; type and reach of the robot."""

    _version = "3.8.0"

    def speed(self, val: float) -> int:
        """机器人全局速度百分比 [%]."""
        return self._task("speed", True, lambda c: c.set_speed(number("val", val, 1.0, 100.0, "%")))

    def get_global_speed(self) -> int:
        """全局速度的百分比 [%], in whole numbers on the wire."""
        return math.floor(self._runtime.snapshot.view.speed)

    @task()
    def switch_mode(self, controller: Controller, mode: int) -> int:
        """Set manual (0) or automatic mode (1); refused if a switch at the cabinet decides it."""
        choice("mode", mode, (OperationMode.MANUAL, OperationMode.AUTO), "0 or 1")
        if self._cabinet.mode_switch:
            raise illegal("a switch at the cabinet decides the mode")
        return controller.switch_mode(OperationMode(mode))

    def collision_detection_reset(self) -> int:
        """重置碰撞检测警告."""
        return self._task("collision_detection_reset", True, lambda c: c.reset_collision())

    def get_robot_version(self) -> str:
        """Version of the controller's software: that of the manual, then this package's."""
        return f"{self._version}+aioduco.simulator.{importlib.metadata.version('aioduco')}"

    def get_robot_type(self) -> list[str]:
        """Series, model, extension, serial number."""
        series, _, model = self._arm.name.upper().partition("_")
        return [series, model, "", self._context.serial]

    def get_origin_DH(self) -> list[list[float]]:  # noqa: N802 - the name on the wire
        """Denavit-Hartenberg parameters a, alpha, d, theta of each joint [m, rad]."""
        g = self._arm.geometry
        return [list(row) for row in zip(g.a, g.alpha, g.d, g.theta, strict=True)]

    def get_calib_DH(self) -> list[list[float]]:  # noqa: N802 - the name on the wire
        """The same as get_origin_DH: a simulated arm is built as designed."""
        return self.get_origin_DH()

    @task()
    def set_teach_speed(self, _: Controller, v: int) -> None:
        """示教速度的百分比 [%]; it applies from the next jog on."""
        self._cabinet.teach_speed = int(number("v", v, 1, 100, "%"))

    def get_teach_speed(self) -> int:
        """示教速度的百分比 [%]."""
        return self._cabinet.teach_speed

    @task()
    def collision_detect(self, controller: Controller, value: int) -> None:
        """碰撞检测等级: 0 for off, 1 to 5."""
        controller.collisions.level = int(number("level", value, 0, 5, "in whole numbers"))

    @task()
    def set_teach_pendant(self, _: Controller, enable: bool) -> None:
        """启用或禁用示教器的物理按键."""
        self._cabinet.pendant_enabled = enable

    def simulation(self, sim: bool, block: bool) -> int:
        """切换机器人到仿真或者真机模式; the arm must be completely at rest."""
        return self._task("simulation", block, lambda controller: controller.simulate(sim))

    def read_encoder_count(self) -> int:
        """外接 INC 的实际 count 值."""
        return self._cabinet.encoder_count

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> ReachabilityParam:
        """Tell whether every pose can be reached, and if so by which joints."""
        found = self._joints_of(base, wobj, tool, ref_pos, check_points)
        reached = found is not None and len(found) == len(check_points)
        return ReachabilityParam(reached, found if found and reached else [])

    def _joints_of(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> list[list[float]] | None:
        """Return joints for the poses, up to the first out of reach; None: wrong arguments."""
        found: list[list[float]] = []
        try:
            frame = pose("base", base).inverse() @ pose("wobj", wobj)
            flange = pose("tool", tool).inverse()
            near = joints("ref_pos", ref_pos)
            targets = [frame @ pose("check_points", point) @ flange for point in check_points]
        except Rejected as exc:
            return self._invalid_arguments("reach_check", exc, None)
        with contextlib.suppress(Unreachable):
            for target in targets:
                reached = self._arm.ikine(target.matrix, near)
                found.append(reached.tolist())
        return found

    @task()
    def set_dynamic_calibration_params(
        self, _: Controller, params: Sequence[Sequence[float]]
    ) -> None:
        """Store the parameters. They have no effect: a simulated arm is built as designed."""
        if not all(math.isfinite(value) for row in params for value in row):
            raise mismatch("params must be finite numbers")
        self._cabinet.dynamics = [list(row) for row in params]

    def get_dynamic_calibration_params(self) -> list[list[float]]:
        """The parameters that were set last; empty before."""
        return self._cabinet.dynamics
