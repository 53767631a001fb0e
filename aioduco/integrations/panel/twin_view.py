"""The twin of an arm for pages: where it is, and a line about what differs. It never commands."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from aioduco import Robot, events
    from aioduco.kinematics import Arm
    from aioduco.planning import Scene
    from aioduco.sim.twin import Twin, TwinFigures, TwinLimits

__all__ = ["TWIN_RATE", "TwinView", "parted_text", "twin_text"]

#: samples per second that a twin compares [Hz]
TWIN_RATE: Final = 125.0
#: seconds for which the line says what has parted
_PARTED: Final = 10.0


class TwinView:
    """The twin that one panel shows.

    Args:
        robot: the robot that observes the arm.
        limits: limits of the twin; None for wide ones.
        arm: the arm.
        around: objects around the arm, and where its base is; None for an arm on the floor.
    """

    def __init__(
        self, robot: Robot, limits: TwinLimits | None, arm: Arm, around: Scene | None
    ) -> None:
        # The twin sees the arm alone: other programs may command it.
        mounting = None if around is None else around.mounting
        self.twin: Twin = robot.twin(limits, arm=arm.name, mounting=mounting, commands=False)

    @property
    def joints(self) -> tuple[float, ...] | None:
        """Where the twin is [rad]; None before its first sample."""
        return self.twin.joints

    def as_json(self) -> dict[str, Any]:
        """The line about the twin, and whether it is a warning."""
        last = self.twin.divergences[-1] if self.twin.divergences else None
        if last is not None and time.monotonic() - last.at > _PARTED:
            last = None
        error = self.twin.error
        text = twin_text(self.twin.figures, last, error)
        return {"text": text, "parted": last is not None or error is not None}


def twin_text(
    figures: TwinFigures, parted: events.TwinDiverged | None, error: Exception | None
) -> str:
    """The line about the arm's twin.

    Args:
        figures: the present differences.
        parted: what has parted a short while ago; None for nothing.
        error: why the twin has ended; None if it has not.
    """
    if error is not None:
        return f"the twin ended early: {error}"
    if parted is not None:
        return parted_text(parted)
    shown = (
        ("payload", figures.mass, 1.0, 2, "kg"),
        ("force", figures.force, 1.0, 1, "N"),
        ("friction", figures.friction, 100.0, 0, "%"),
        ("position", figures.position, 1000.0, 2, "mm"),
    )
    differ = ", ".join(
        f"{name} {round(value * scale, digits) + 0.0:.{digits}f} {unit}"
        for name, value, scale, digits, unit in shown
        if value is not None
    )
    return f"differences from its twin: {differ}" if differ else "its twin has not begun yet"


def parted_text(event: events.TwinDiverged) -> str:
    """What has parted, and the probable cause, in words."""
    estimate = ", ".join(f"{name} {value:.3g}" for name, value in event.estimate.items())
    cause = f"{event.cause} ({estimate})" if estimate else event.cause
    return f"arm and twin have parted: {event.quantity} at {event.where}, probably {cause}"
