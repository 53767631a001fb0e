"""Messages, errors and task states (manual 1.3.8)."""

from __future__ import annotations

import logging

from aioduco.sim.handlers.base import Section

_log = logging.getLogger("aioduco.sim.program")


class LogHandlers(Section):
    """log_info to robotmoving."""

    def log_info(self, message: str) -> None:
        """Write to the controller's log."""
        _log.info("%s", message)

    def log_error(self, message: str) -> None:
        """Show a message on the pendant, and pause all tasks."""
        _log.error("%s", message)
        with self._runtime.command() as controller:
            controller.note_error(message)
            controller.pause()

    def get_last_error(self) -> list[str]:
        """机器人最新的错误列表."""
        return list(self._runtime.snapshot.view.errors)

    def get_noneblock_taskstate(self, id: int) -> int:  # noqa: A002 - the name on the wire
        """State of a task."""
        return int(self._runtime.task_state(id))

    def robotmoving(self) -> bool:
        """Whether the arm moves."""
        return self._runtime.snapshot.view.moving
