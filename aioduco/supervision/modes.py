"""Modes that the controller is in because of this program, and that outlast a stop.

Two kinds. Those in which the arm gives way or follows (hand guiding, realtime mode) count as
motion: a stop leaves them at once. Force control changes only what motions do: it goes on through
a stop, is left on the way out of the robot, and only while the arm stands (manual 1.3.10).
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from aioduco.errors import DucoError, Refused
from aioduco.models.enums import TaskState

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.supervision.control import Control

__all__ = ["Modes"]

_log = logging.getLogger(__name__)

#: seconds for a mode to be left after a stop
_LEAVE_LIMIT = 0.5


class Modes:
    """The modes of one robot, each named by the function of the wire that ends it.

    Args:
        control: sends what ends them.

    Attributes:
        standing: modes that may be left only while the arm stands.
    """

    def __init__(self, control: Control) -> None:
        self._control = control
        self._moving: dict[str, tuple[bool, ...]] = {}
        self.standing: set[str] = set()

    def __repr__(self) -> str:
        return f"<Modes {sorted(self._moving)}, while standing {sorted(self.standing)}>"

    def __contains__(self, ending: str) -> bool:
        return ending in self._moving

    @property
    def moving(self) -> bool:
        """Whether the arm may move because of one, with nobody following it."""
        return bool(self._moving)

    @property
    def any(self) -> bool:
        """Whether there is one of either kind."""
        return bool(self._moving or self.standing)

    def enter(self, ending: str, args: tuple[bool, ...] = ()) -> bool:
        """A mode in which the arm gives way or follows is about to be entered.

        Args:
            ending: the function that ends it.
            args: its arguments.

        Returns:
            Whether it was on before.
        """
        was_on = ending in self._moving
        self._moving[ending] = args
        return was_on

    def over(self, ending: str) -> None:
        """A mode in which the arm gives way or follows is off."""
        self._moving.pop(ending, None)

    async def leave(self) -> None:
        """Leave the modes in which the arm gives way or follows; what fails is logged."""
        modes, self._moving = self._moving, {}
        for name, args in modes.items():
            try:
                await self._control.leave(name, args, _LEAVE_LIMIT)
            except DucoError as exc:
                _log.warning("%s after a stop was not carried out: %s", name, exc)

    async def leave_standing(
        self, timeout: float, follow: Callable[[str, int, float], Awaitable[object]]
    ) -> None:
        """Leave the modes that may be left only while the arm stands; what fails is logged.

        Args:
            timeout: seconds for each of what it takes.
            follow: waits for the end of a task, given its name, its id and the time for it.
        """
        if not self.standing:
            return
        try:
            await self._control.standstill(timeout)
        except DucoError as exc:
            names = ", ".join(sorted(self.standing))
            _log.warning("%s was not sent, since the arm is not known to stand: %s", names, exc)
            return
        for name in sorted(self.standing):
            self.standing.discard(name)
            try:
                answer = await self._control.leave(name, (), timeout)
                if answer > max(TaskState):
                    await follow(name, answer, timeout)
                elif answer != TaskState.FINISHED:
                    raise Refused(name, answer, "no reason is given")
            except DucoError as exc:
                _log.warning("%s was not carried out: the mode may still be on: %s", name, exc)
