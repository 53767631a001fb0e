"""No motion of its own (fc_move, manual 1.3.10): what moves the arm then is force control."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.sim.planner.follower import Follower

if TYPE_CHECKING:
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.mover import SetPoint

__all__ = ["Standing"]


class Standing(Follower):
    """Commands the joints to be where they were at the start, until it is stopped."""

    def _next(self, q: Array, qd: Array) -> SetPoint:  # noqa: ARG002 - it follows no sensors
        return self._setpoint
