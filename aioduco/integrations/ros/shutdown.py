"""The end of a driver by a signal, for any middleware."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

import anyio

if TYPE_CHECKING:
    from anyio import CancelScope


async def cancel_on_signal(scope: CancelScope) -> None:
    """Wait for Ctrl-C, SIGTERM, or the end of the terminal, and cancel a scope then."""
    ends = [signal.SIGINT, signal.SIGTERM]
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        ends.append(signal.SIGHUP)  # not under nohup
    with anyio.open_signal_receiver(*ends) as signals:
        async for _ in signals:
            scope.cancel()
            return
