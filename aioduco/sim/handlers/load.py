"""The load that is held, and the forces at the tool (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.force.sensor import Axes
from aioduco.sim.frames import UnknownName
from aioduco.sim.handlers.arguments import load
from aioduco.sim.handlers.carrying import CarryingSection
from aioduco.sim.load import Load

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.controller import Controller


class LoadHandlers(CarryingSection):
    """set_load_data, get_tcp_force, get_tcp_force_tool."""

    def set_load_data(self, value: Sequence[float]) -> int:
        """抓取负载 [kg, m], its centre of gravity in the tool's frame: it is mounted, too."""

        def command(controller: Controller) -> int:
            mass, *centre = load("value", value)
            tool = controller.frames.tool().matrix
            at = tool[:3, :3] @ centre + tool[:3, 3]
            self._cabinet.held = Load(mass, tuple(at.tolist()))
            self._carry(controller)
            return controller.finish("set_load_data")

        return self._task("set_load_data", True, command)

    def get_tcp_force(self) -> list[float]:
        """Force and torque on the tool's tip along the base's axes [N, N m]."""
        return self._external(Axes(self._runtime.snapshot.view.tool.matrix, np.eye(4), False))

    def get_tcp_force_tool(self, tool: str) -> list[float]:
        """Force and torque on a tool's tip along its own axes [N, N m]."""
        try:
            matrix = self._frames.tool(tool).matrix
        except UnknownName as exc:
            return self._senseless("get_tcp_force_tool", exc, [])
        return self._external(Axes(matrix, np.eye(4)))

    def _external(self, axes: Axes) -> list[float]:
        snapshot = self._runtime.snapshot
        flange = self._arm.fkine(snapshot.q)[:3, :3]
        return axes.seen(snapshot.view.sensor.external(snapshot.wrench, flange), flange)
