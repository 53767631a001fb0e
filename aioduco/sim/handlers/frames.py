"""Tools, work objects, and the controller's kinematics (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.errors import Unreachable
from aioduco.models.pose import Pose
from aioduco.sim.frames import MAX_NAME, Tool
from aioduco.sim.handlers.arguments import joints, load, name_of, numbers, pose
from aioduco.sim.handlers.carrying import CarryingSection
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from aioduco.sim.controller import Controller

    Matrix = NDArray[np.float64]


class FrameHandlers(CarryingSection):
    """set_tool_data to get_wobj, cal_fkine and cal_ikine."""

    def set_tool_data(
        self,
        name: str,
        tool_offset: Sequence[float],
        payload: Sequence[float],
        inertia_tensor: Sequence[float],
    ) -> int:
        """Define a tool, and use it."""

        def command(controller: Controller) -> int:
            tool = Tool.at(
                pose("tool_offset", tool_offset),
                name_of("name", name, MAX_NAME),
                load("payload", payload),
                numbers("inertia_tensor", inertia_tensor, 6) if inertia_tensor else (0.0,) * 6,
            )
            controller.frames.set_tool(tool)
            self._carry(controller)
            return controller.finish("set_tool_data")

        return self._task("set_tool_data", True, command)

    def set_wobj(self, name: str, wobj: Sequence[float]) -> int:
        """Define a work object, and use it; on the wire, not in the manual."""

        def command(controller: Controller) -> int:
            controller.frames.set_wobj(name_of("name", name, MAX_NAME), pose("wobj", wobj))
            return controller.finish("set_wobj")

        return self._task("set_wobj", True, command)

    def set_wobj_offset(self, wobj: Sequence[float], active: bool) -> int:
        """Offset the frames of work objects, multiplied from the right."""

        def command(controller: Controller) -> int:
            controller.frames.set_wobj_offset(pose("wobj", wobj) if active else None)
            return controller.finish("set_wobj_offset")

        return self._task("set_wobj_offset", True, command)

    def get_tcp_offset(self) -> list[float]:
        """末端工具的偏移量 [m, rad]."""
        return list(self._runtime.snapshot.view.tool.offset)

    def get_tool_load(self) -> list[float]:
        """工具的负载质量及质心位置 [kg, m]."""
        return list(self._runtime.snapshot.view.tool.payload)

    def get_wobj(self) -> list[float]:
        """工件坐标系相对于基坐标系的位移 [m, rad]."""
        return list(self._runtime.snapshot.view.wobj.pose)

    def cal_fkine(
        self,
        joints_position: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """Pose of a tool in a work object; empty lists mean the ones in use."""
        try:
            q = joints("joints_position", joints_position)
            tip, _ = self._tool(tool)
            _, base = self._wobj(wobj)
        except Rejected as exc:
            return self._senseless("cal_fkine", exc, [])
        return list(Pose.from_matrix(base @ self._arm.fkine(q) @ tip))

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """Joints for a pose of a tool in a work object; `q_near` itself when there are none."""
        try:
            target = pose("p", p)
            near = joints("q_near", q_near) if q_near else tuple(self._runtime.snapshot.q.tolist())
            _, flange = self._tool(tool)
            base, _ = self._wobj(wobj)
        except Rejected as exc:
            return self._senseless("cal_ikine", exc, [])
        try:
            found: list[float] = self._arm.ikine(base @ target.matrix @ flange, near).tolist()
        except Unreachable:
            return list(near)
        return found

    def _tool(self, offset: Sequence[float]) -> tuple[Matrix, Matrix]:
        """A tool's tip in the flange's frame, and the flange in the tip's."""
        tool = Tool.at(pose("tool", offset)) if offset else self._runtime.snapshot.view.tool
        return tool.matrix, tool.inverse

    def _wobj(self, frame: Sequence[float]) -> tuple[Matrix, Matrix]:
        """A work object in the base frame, and the base in the work object's."""
        if frame:
            given = pose("wobj", frame)
            return given.matrix, given.inverse().matrix
        used = self._runtime.snapshot.view.wobj
        return used.matrix, used.inverse
