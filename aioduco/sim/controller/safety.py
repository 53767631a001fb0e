"""Safety stops and the emergency stop (manual 1.2, SafetyState), and when the arm may move."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.models.enums import RobotState, SafetyState
from aioduco.sim.controller.motion_queue import CAPACITY, DeferredMotions, Following, MotionQueue
from aioduco.sim.controller.tasks import MotionPhase

if TYPE_CHECKING:
    from aioduco.sim.controller.power import PowerControl
    from aioduco.sim.controller.programs import ProgramExecution


class SafetyController:
    """Safety stops and the emergency stop.

    Attributes:
        fault: the safety stop that holds; None if there is none.
        emergency_stop: whether the button is pressed.
    """

    def __init__(self) -> None:
        self.fault: SafetyState | None = None
        self.emergency_stop: bool = False

    @property
    def safe(self) -> bool:
        """Whether the arm may get power."""
        return self.fault is None and not self.emergency_stop

    def state(self, robot: RobotState) -> SafetyState:
        """State of the safety controller."""
        if self.fault is not None:
            return self.fault
        if robot in (RobotState.START, RobotState.INITIALIZE):
            return SafetyState.INIT
        return SafetyState.POWER_OFF if robot is RobotState.POWER_OFF else SafetyState.RUN

    def trip(self, category: SafetyState) -> None:
        """Begin a safety stop; of two stops the more severe one holds."""
        if self.fault is None or category > self.fault:
            self.fault = category

    def clear(self) -> None:
        """Clear the stop after the power was off; a pressed button still holds."""
        self.fault = SafetyState.STOP0 if self.emergency_stop else None


class Admission:
    """Reasons for a refusal, each a text for people; empty where there is none."""

    def __init__(
        self,
        power: PowerControl,
        safety: SafetyController,
        motion: MotionQueue,
        execution: ProgramExecution,
        deferred: DeferredMotions,
    ) -> None:
        self._power = power
        self._safety = safety
        self._motion = motion
        self._execution = execution
        self._deferred = deferred

    def moving(self) -> str:
        """Why the arm may not move."""
        if self._power.state is not RobotState.ENABLE:
            return f"the robot is not enabled, but in state {self._power.state.name}"
        if self._safety.fault is not None:
            return f"safety stop {self._safety.fault.name}"
        return f"{self._power.changing} is under way" if self._power.changing is not None else ""

    def motion(self, following: Following | None = None) -> str:
        """Why a motion is not accepted; during a stop it is, and waits until the arm stands."""
        if reason := self.moving():
            return reason
        if self._motion.phase is MotionPhase.STOPPING and not self._motion.ending:
            return "the robot is stopping"
        if self._execution.excludes:
            return "a program is running"
        full = len(self._motion) + len(self._deferred) >= CAPACITY
        return "the queue of motions is full" if full else self._taken(following)

    def program(self) -> str:
        """Why a program may not begin."""
        if self._motion.phase is MotionPhase.STOPPING:
            return "the robot is stopping"
        if reason := self.motion():
            return reason
        if self._execution.active:
            return "a program is running"
        idle = self._motion.phase is MotionPhase.IDLE and not self._deferred
        return "" if idle else "other motions are running"

    def _taken(self, following: Following | None) -> str:
        """Why the motions in the queue admit no other one."""
        ending = self._motion.ending or bool(self._deferred)
        last = self._deferred.last if ending else self._motion.last
        if last is not None and last == following:
            return ""  # it takes over
        if last is not None and last.alone:
            return f"{last.kind} is running"
        idle = not self._deferred if ending else self._motion.phase is MotionPhase.IDLE
        return "other motions are running" if following and following.idle and not idle else ""
