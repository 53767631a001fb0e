"""The classes of the events of `robot.events`: `from aioduco.events import CollisionDetected`."""

from __future__ import annotations

from aioduco.supervision import events
from aioduco.supervision.events import *  # noqa: F403  # all of them, as events.__all__ lists them

__all__: list[str] = []
__all__ += events.__all__
