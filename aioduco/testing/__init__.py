"""Help for tests of programs that drive an arm: faults on the wire, leaks, waiting.

A `FaultProxy` stands between a client and a controller, real or simulated, and applies faults of
networks and controllers to chosen calls. `no_leaks` finds resources that were not closed, and
`eventually` waits for a condition where a test would otherwise sleep. `nothing_forgiven` asserts
that every call conforms to the manual.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aioduco.testing.cancel import Cancelled, cancel_at, cancel_at_every_await
    from aioduco.testing.conformance import check_controller
    from aioduco.testing.faults import (
        ApplicationError,
        Chaos,
        Cut,
        Delay,
        DropReply,
        DropRequest,
        Ending,
        Fault,
        Garbage,
        HalfOpen,
        HoldReply,
        Place,
        Plan,
        RepeatReply,
        Throttle,
        WrongKind,
        WrongMethod,
        WrongSeqid,
    )
    from aioduco.testing.forgiven import nothing_forgiven
    from aioduco.testing.leaks import Resources, no_leaks
    from aioduco.testing.proxy import FaultProxy
    from aioduco.testing.recording_server import ReceivedCall, RecordingServer
    from aioduco.testing.records import CallRecord, ConnectionRecord, ProxyStatistics
    from aioduco.testing.waiting import eventually, eventually_async

__all__ = [
    "ApplicationError",
    "CallRecord",
    "Cancelled",
    "Chaos",
    "ConnectionRecord",
    "Cut",
    "Delay",
    "DropReply",
    "DropRequest",
    "Ending",
    "Fault",
    "FaultProxy",
    "Garbage",
    "HalfOpen",
    "HoldReply",
    "Place",
    "Plan",
    "ProxyStatistics",
    "ReceivedCall",
    "RecordingServer",
    "RepeatReply",
    "Resources",
    "Throttle",
    "WrongKind",
    "WrongMethod",
    "WrongSeqid",
    "cancel_at",
    "cancel_at_every_await",
    "check_controller",
    "eventually",
    "eventually_async",
    "no_leaks",
    "nothing_forgiven",
]

#: modules of these names; the others are faults
_HOMES = {
    "cancel": ("Cancelled", "cancel_at", "cancel_at_every_await"),
    "conformance": ("check_controller",),
    "forgiven": ("nothing_forgiven",),
    "leaks": ("Resources", "no_leaks"),
    "proxy": ("FaultProxy",),
    "recording_server": ("ReceivedCall", "RecordingServer"),
    "records": ("CallRecord", "ConnectionRecord", "ProxyStatistics"),
    "waiting": ("eventually", "eventually_async"),
}
_HOME = dict.fromkeys(__all__, "faults")
_HOME |= {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Load a name on first use: not all with each run of pytest, which loads the plugin."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
