"""Who may move the arm: why a motion is not taken."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.models.enums import RobotState
from aioduco.sim.motion import Phase

if TYPE_CHECKING:
    from aioduco.sim.execution import Execution
    from aioduco.sim.following import Following
    from aioduco.sim.motion import Motion
    from aioduco.sim.power import Power
    from aioduco.sim.safety import Safety

__all__ = ["Admission"]


class Admission:
    """Reasons for a refusal, each a text for people; empty where there is none."""

    def __init__(self, power: Power, safety: Safety, motion: Motion, execution: Execution) -> None:
        self._power = power
        self._safety = safety
        self._motion = motion
        self._execution = execution

    def moving(self) -> str:
        """Why the arm may not move."""
        if self._power.state is not RobotState.ENABLE:
            return f"the robot is not enabled, but in state {self._power.state.name}"
        if self._safety.fault is not None:
            return f"safety stop {self._safety.fault.name}"
        if self._motion.phase is Phase.STOPPING:
            return "the robot is stopping"
        return f"{self._power.changing} is under way" if self._power.changing is not None else ""

    def motion(self, following: Following | None = None) -> str:
        """Why a motion is not taken."""
        if reason := self.moving():
            return reason
        if self._execution.excludes:
            return "a program is running"
        return "the queue of motions is full" if self._motion.full else self._taken(following)

    def program(self) -> str:
        """Why a program does not begin."""
        if reason := self.motion():
            return reason
        if self._execution.active:
            return "a program is running"
        return "" if self._motion.phase is Phase.IDLE else "other motions are running"

    def _taken(self, following: Following | None) -> str:
        """By what the arm is taken, so that no other motion may begin or wait."""
        last = self._motion.last
        if last is not None and last == following:
            return ""  # it takes over
        if last is not None and last.alone:
            return f"{last.kind} is running"
        idle = self._motion.phase is Phase.IDLE
        return "other motions are running" if following and following.idle and not idle else ""
