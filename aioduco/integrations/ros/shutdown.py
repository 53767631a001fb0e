"""The end of a driver by a signal, for any middleware."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from anyio import CancelScope

__all__ = ["cancel_on_signal"]


async def cancel_on_signal(scope: CancelScope) -> None:
    """Wait for SIGINT or SIGTERM, and cancel a scope then."""
    with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
        async for _ in signals:
            scope.cancel()
            return
