"""The safety controller: safety stops and the emergency stop (manual 1.2, SafetyState)."""

from __future__ import annotations

from aioduco.models.enums import RobotState, SafetyState

__all__ = ["Safety"]


class Safety:
    """What stops the arm for the sake of safety.

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
        """A safety stop; of two the graver holds."""
        if self.fault is None or category > self.fault:
            self.fault = category

    def clear(self) -> None:
        """The power was off: nothing holds any more but the button."""
        self.fault = SafetyState.STOP0 if self.emergency_stop else None
