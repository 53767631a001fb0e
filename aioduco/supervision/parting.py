"""The last thing that a program does which ends without having left its robot: it stops the arm.

A program that forgets to, or whose event loop is broken by one interrupt too many, comes to no
await any more, but still to the end of its interpreter.
"""

from __future__ import annotations

import atexit
import logging
import os
from typing import TYPE_CHECKING

from aioduco.errors import DucoError

if TYPE_CHECKING:
    from aioduco.supervision.keeper import Keeper

__all__ = ["Parting"]

_log = logging.getLogger(__name__)

#: seconds in which the stop must be accepted: nothing comes after it but the end
_LIMIT = 2.0


class Parting:
    """Stops the arm at the end of the program, if it may be moving by then.

    It keeps alive whatever is needed for that, until it is called off.

    Args:
        keeper: who stops it.
    """

    def __init__(self, keeper: Keeper) -> None:
        self._keeper = keeper
        self._process = os.getpid()
        atexit.register(self.take)

    def take(self) -> None:
        """Part now: nobody will leave the robot as it should be left."""
        self.call_off()
        # In a forked child the connections are the parent's.
        if not self._keeper.moving or os.getpid() != self._process:
            return
        _log.critical("the program ends without having left the robot: the arm is stopped")
        try:
            self._keeper.stop_now(_LIMIT)
        except DucoError as exc:
            _log.critical("it could not be stopped: %s", exc)

    def call_off(self) -> None:
        """The robot is being left as it should be."""
        atexit.unregister(self.take)
