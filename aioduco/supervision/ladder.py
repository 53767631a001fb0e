"""The way out of a robot: rung by rung, each with its time, none left out because one failed.

Guarantees:
- A rung is gone through to its end even if leaving is cancelled, once or more; the cancellation
  goes on afterwards.
- A rung that fails is logged, and the next one follows. What failed is raised at the end.
- The heartbeat beats until the arm was seen to stand, or until that has failed.
"""

from __future__ import annotations

import logging
import math
import time
from typing import TYPE_CHECKING, Protocol

from aioduco.errors import DucoError
from aioduco.supervision.insist import insist

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from aioduco.supervision.heartbeat import Heart
    from aioduco.supervision.keeper import Keeper
    from aioduco.supervision.launcher import Launcher
    from aioduco.supervision.settings import ExitLadder

__all__ = ["Way", "leave"]

_log = logging.getLogger(__name__)

#: closing is never left out; each of its parts has a limit of its own
_NO_LIMIT = math.inf


class Way(Protocol):
    """What is to be left."""

    keeper: Keeper
    launcher: Launcher
    heartbeat: Heart | None

    async def close_lines(self) -> None:
        """Close everything that was opened."""
        ...


async def leave(way: Way, ladder: ExitLadder) -> None:
    """Go down the ladder.

    Raises:
        StopUnconfirmed: it is not known that the arm stands.
    """
    keeper = way.keeper
    down = _Descent()
    await down.rung("settle", ladder.settle, way.launcher.quiet)
    if keeper.moving:
        await down.rung("stop", ladder.stop, keeper.send_stop)
        again = ladder.stop
        await down.rung("standstill", ladder.standstill, lambda limit: keeper.rest(again, limit))
    if keeper.modes.any:
        await down.rung("modes", ladder.modes, keeper.leave_modes)
    if way.heartbeat is not None:
        way.heartbeat.end()
    await down.rung("close", _NO_LIMIT, lambda _: way.close_lines())
    down.finish()


class _Descent:
    """Goes down rungs, and keeps what is to be raised at the end."""

    def __init__(self) -> None:
        self._failed: Exception | None = None
        self._cancelled: BaseException | None = None

    async def rung(
        self, name: str, limit: float | None, step: Callable[[float], Awaitable[object]]
    ) -> None:
        """Do a step to its end, whatever comes."""
        if limit is None:
            _log.info("leaving the robot: %s is left out", name)
            return
        begin = time.monotonic()
        try:
            _, cancelled = await insist(lambda: step(limit))
        except Exception as exc:
            took = time.monotonic() - begin
            known = isinstance(exc, DucoError)
            _log.warning(
                "leaving the robot: %s failed after %.3f s: %s",
                *(name, took, exc),
                exc_info=None if known else exc,
            )
            self._failed = self._failed or exc
        else:
            _log.debug("leaving the robot: %s took %.3f s", name, time.monotonic() - begin)
            self._cancelled = cancelled or self._cancelled

    def finish(self) -> None:
        """Raise what failed, or the cancellation that came meanwhile."""
        if self._failed is not None:
            raise self._failed
        if self._cancelled is not None:
            raise self._cancelled
