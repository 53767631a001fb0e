"""The end of a driver by a signal, for any middleware."""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

import anyio

from aioduco._process.reporting import BackgroundLogger

if TYPE_CHECKING:
    from anyio import CancelScope


_log = BackgroundLogger(__name__)


async def cancel_on_signal(scope: CancelScope) -> None:
    """Wait for Ctrl-C, SIGTERM, or the end of the terminal, and cancel a scope then."""
    ends = [signal.SIGINT, signal.SIGTERM]
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        ends.append(signal.SIGHUP)  # not under nohup
    with anyio.open_signal_receiver(*ends) as signals:
        async for number in signals:
            _log.info(
                "%s: the driver ends as soon as the arm is known to stand. If the controller does "
                "not answer, that is given up after 20 s, or 90 s if a motion was on its way to it",
                signal.Signals(number).name,
            )
            scope.cancel()
            return
