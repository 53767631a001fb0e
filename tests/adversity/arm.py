"""What must be true of the arm when the program is gone."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.sim import Simulator

#: joints between which the programs move; far from every singularity and limit [rad]
LEFT = (0.4, 0.0, 1.57, 0.0, -1.57, 0.0)
RIGHT = (-0.4, 0.1, 1.4, 0.0, -1.57, 0.2)

#: tasks that move nothing, and end by themselves
_STANDING = frozenset({"power_on", "power_off", "enable", "disable"})


def stands(sim: Simulator) -> bool:
    """Whether the arm stands, and no task is there that could move it."""
    return not sim.moving and all(task.name in _STANDING for task in sim.tasks)


def unrest(sim: Simulator) -> str:
    """What keeps the arm from standing, for messages."""
    return f"moving: {sim.moving}; tasks: {sim.tasks}; states: {sim.view[:4]}"
