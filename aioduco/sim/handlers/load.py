"""The load that is held, and the forces at the tool (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from aioduco.sim.frames import UnknownName
from aioduco.sim.handlers.arguments import load
from aioduco.sim.handlers.base import Section

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.sim.controller import Controller

    Vector = NDArray[np.float64]


class LoadHandlers(Section):
    """set_load_data, get_tcp_force, get_tcp_force_tool."""

    def set_load_data(self, value: Sequence[float]) -> int:
        """抓取负载 [kg, m], its centre of gravity in the tool's frame: it is mounted, too."""

        def command(controller: Controller) -> int:
            mass, *centre = load("value", value)
            tool = controller.frames.tool().matrix
            at = tool[:3, :3] @ centre + tool[:3, 3]
            self._cabinet.load = (mass, at)
            self._runtime.load(mass, at.tolist())
            return controller.finish("set_load_data")

        return self._task("set_load_data", True, command)

    def get_tcp_force(self) -> list[float]:
        """Force and torque on the tool's tip along the base's axes [N, N m]."""
        snapshot = self._runtime.snapshot
        turn = self._arm.fkine(snapshot.q)[:3, :3]
        force, torque = self._contact(snapshot.view.tool.matrix[:3, 3])
        return [*(turn @ force).tolist(), *(turn @ torque).tolist()]

    def get_tcp_force_tool(self, tool: str) -> list[float]:
        """Force and torque on a tool's tip along its own axes [N, N m]."""
        try:
            matrix = self._frames.tool(tool).matrix
        except UnknownName as exc:
            return self._senseless("get_tcp_force_tool", exc, [])
        force, torque = self._contact(matrix[:3, 3])
        turn = matrix[:3, :3].T
        return [*(turn @ force).tolist(), *(turn @ torque).tolist()]

    def _contact(self, tip: Vector) -> tuple[Vector, Vector]:
        """What acts on the flange besides the load's weight, about a point, in its frame."""
        snapshot = self._runtime.snapshot
        mass, centre = self._cabinet.load
        weight = mass * (self._arm.fkine(snapshot.q)[:3, :3].T @ self._context.gravity)
        force = snapshot.wrench[:3] - weight
        torque = snapshot.wrench[3:] - np.cross(centre, weight)
        return force, torque - np.cross(tip, force)
