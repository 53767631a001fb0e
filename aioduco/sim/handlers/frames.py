"""Tools, work objects and loads, and the controller's kinematics (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.errors import Unreachable
from aioduco.models.pose import Pose
from aioduco.sim.cabinet.tools import MAX_NAME, NamedFrame
from aioduco.sim.force.sensor import ForceAxes
from aioduco.sim.handlers.arguments import joints, load, name_of, numbers, pose
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.controller.state_machine import Controller


class FrameHandlers(HandlerSection):
    """set_tool_data to get_wobj, cal_fkine, cal_ikine, set_load_data, get_tcp_force."""

    @task()
    def set_tool_data(
        self,
        controller: Controller,
        name: str,
        tool_offset: Sequence[float],
        payload: Sequence[float],
        inertia_tensor: Sequence[float],
    ) -> None:
        """Define a tool, and use it."""
        tool = NamedFrame.at(
            pose("tool_offset", tool_offset),
            name_of("name", name, MAX_NAME),
            load("payload", payload),
        )
        if inertia_tensor:  # which has no effect: a load is a point
            numbers("inertia_tensor", inertia_tensor, 6)
        controller.frames.set_tool(tool)
        self._carry(controller)

    @task()
    def set_wobj(self, controller: Controller, name: str, wobj: Sequence[float]) -> None:
        """Define a work object, and use it; on the wire, not in the manual."""
        controller.frames.set_wobj(name_of("name", name, MAX_NAME), pose("wobj", wobj))

    @task()
    def set_wobj_offset(self, controller: Controller, wobj: Sequence[float], active: bool) -> None:
        """Offset the frames of work objects, multiplied from the right."""
        controller.frames.set_wobj_offset(pose("wobj", wobj) if active else None)

    def get_tcp_offset(self) -> list[float]:
        """末端工具的偏移量 [m, rad]."""
        return list(self._runtime.snapshot.view.tool.pose)

    def get_tool_load(self) -> list[float]:
        """工具的负载质量及质心位置 [kg, m]."""
        return list(self._runtime.snapshot.view.tool.load)

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
            used, frame = self._tool(tool), self._wobj(wobj)
        except Rejected as exc:
            return self._invalid_arguments("cal_fkine", exc, [])
        return list(Pose.from_matrix(frame.inverse @ self._arm.fkine(q) @ used.matrix))

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """Joints for a pose of a tool in a work object; `q_near` itself when there are none.

        Unlike cal_fkine, it takes the work object in the world frame.
        """
        try:
            target = pose("p", p)
            near = joints("q_near", q_near) if q_near else tuple(self._runtime.snapshot.q.tolist())
            flange, base = self._tool(tool).inverse, self._wobj(wobj).matrix
            if wobj:
                base = self._context.mounting.inverse().matrix @ base
        except Rejected as exc:
            return self._invalid_arguments("cal_ikine", exc, [])
        try:
            found: list[float] = self._arm.ikine(base @ target.matrix @ flange, near).tolist()
        except Unreachable:
            return list(near)
        return found

    def _tool(self, offset: Sequence[float]) -> NamedFrame:
        """A tool with its tip at a pose; the one in use if none is given."""
        return NamedFrame.at(pose("tool", offset)) if offset else self._runtime.snapshot.view.tool

    def _wobj(self, frame: Sequence[float]) -> NamedFrame:
        """A work object at a pose; the one in use if none is given."""
        return NamedFrame.at(pose("wobj", frame)) if frame else self._runtime.snapshot.view.wobj

    @task()
    def set_load_data(self, controller: Controller, value: Sequence[float]) -> None:
        """抓取负载 [kg, m], centre of gravity in the tool's frame; the physics mount it, too."""
        held = load("value", value)
        self._cabinet.held = held.in_flange(controller.frames.tool().pose)
        self._carry(controller)

    def get_tcp_force(self) -> list[float]:
        """Force and torque on the tool's tip along the base's axes [N, N m], by a sensor."""
        return self._external(ForceAxes(self._runtime.snapshot.view.tool.matrix, np.eye(4), False))

    def get_tcp_force_tool(self, tool: str) -> list[float]:
        """Force and torque on a tool's tip along its own axes [N, N m], by a sensor."""
        try:
            matrix = self._frames.tool(tool).matrix
        except Rejected as exc:
            return self._invalid_arguments("get_tcp_force_tool", exc, [])
        return self._external(ForceAxes(matrix, np.eye(4)))

    def _external(self, axes: ForceAxes) -> list[float]:
        if not self._cabinet.force_sensor:
            return []
        snapshot = self._runtime.snapshot
        flange = self._arm.fkine(snapshot.q)[:3, :3]
        return axes.seen(snapshot.view.sensor.external(snapshot.wrench, flange), flange)

    def _carry(self, controller: Controller) -> None:
        """Pass the masses of the tool in use and of its load to the force sensor and the physics.

        The physics mount both. A tool that the simulator was given is not mounted again: the
        model of the arm has it already, with its own mass.
        """
        held = self._cabinet.held
        both = controller.frames.tool().load.with_load(held)
        mass, *centre = held if self._cabinet.tooled else both
        # The sensor knows of a weight from the cycle on in which it feels it.
        self._runtime.load(mass, centre, controller.force.carry(both.mass, both[1:]))
