"""Warnings that may come with every message of a client, logged at a limited rate."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from aioduco._process.reporting import BackgroundLogger

__all__ = ["SeldomLog"]

_AGAIN = 2.0  # seconds before the same kind is logged again


class SeldomLog:
    """Logs each kind of warning every two seconds at most.

    Args:
        log: the logger.
    """

    def __init__(self, log: BackgroundLogger) -> None:
        self._log = log
        self._said: dict[str, float] = {}

    def warn(self, kind: str, text: str, *values: object) -> None:
        """Log a warning, unless one of its kind was logged just now."""
        now = anyio.current_time()
        if now - self._said.get(kind, -math.inf) > _AGAIN:
            self._said[kind] = now
            self._log.warning(text, *values)
