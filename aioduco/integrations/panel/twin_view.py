"""The twin of an arm for pages: a line about what differs."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from aioduco import events
    from aioduco.sim.twin import Twin, TwinFigures


#: samples per second that a twin compares [Hz]
TWIN_RATE: Final = 125.0
#: seconds for which the line says what has parted
_PARTED: Final = 10.0


def twin_line(twin: Twin) -> dict[str, Any]:
    """The line about a twin for pages, and whether it is a warning."""
    last = twin.divergences[-1] if twin.divergences else None
    if last is not None and time.monotonic() - last.at > _PARTED:
        last = None
    text = twin_text(twin.figures, last, twin.error)
    return {"text": text, "parted": last is not None or twin.error is not None}


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
