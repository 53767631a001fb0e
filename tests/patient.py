"""Runs a program with longer time limits for loops, connections and controllers.

    python patient.py [--speed N] PROGRAM [its arguments]

A busy machine takes seconds over what takes a millisecond. With `--speed`, simulators to which the
program gives no speed or cycle run so many times as fast, and in a coarse cycle.
"""

from __future__ import annotations

import contextlib
import runpy
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import aioduco
import aioduco.sync
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.streaming.shared.options import Feeding
from aioduco.supervision import task_follower
from aioduco.supervision.operator_stop import stop_arm
from aioduco.supervision.state_feed import StateFeed

#: the command line, run by this file
COMMAND_LINE = (
    *(sys.executable, "-W", "error", __file__),
    str(Path(aioduco.__file__).parent / "cli" / "__main__.py"),
)
#: s that the tests' robots give by default; tests about such a time set it
PATIENCE = {"heartbeat": 20.0, "loop_stall_limit": 15.0, "call_timeout": 10.0}
#: s for which the controller may not answer about a task
TASK_PATIENCE = 15.0
#: s that each part of an operator's stop may take
STOP_PATIENCE = 15.0
#: s that a sample may be old by default, and the first one may take
SAMPLE_PATIENCE = 10.0
#: s that a stream's controller may take for an answer by default, and its worker may not run
STREAM_PATIENCE = {"timeout": 10.0, "away_limit": 15.0}
#: how streams through the realtime queue are opened then, which else may run dry for 20 ms only
PATIENT_QUEUE = {"com_lost_time": 10.0, "depth": 100}
#: s for which a program may send a stream nothing, at the least
HOLD_PATIENCE = 10.0


@contextlib.contextmanager
def patient_queue() -> Iterator[None]:
    """Make these the defaults of streams for a while, and `HOLD_PATIENCE` the least hold."""
    stream, check = RealtimeStreams.stream, Feeding.__post_init__
    before = stream.__kwdefaults__ or {}

    def held_longer(self: Feeding) -> None:
        object.__setattr__(self, "hold", max(self.hold, HOLD_PATIENCE))
        check(self)

    stream.__kwdefaults__ = {**before, **PATIENT_QUEUE}
    Feeding.__post_init__ = held_longer  # type: ignore[method-assign]
    try:
        yield
    finally:
        stream.__kwdefaults__ = before
        Feeding.__post_init__ = check  # type: ignore[method-assign]


def be_patient() -> None:
    """Make these the defaults of connections, streams, the newest sample and an operator's stop."""
    for connect in (aioduco.connect, aioduco.sync.connect):
        connect.__kwdefaults__ = {**(connect.__kwdefaults__ or {}), **PATIENCE}
    task_follower.LOST_AFTER = TASK_PATIENCE
    stop_arm.__kwdefaults__ = dict.fromkeys(stop_arm.__kwdefaults__ or (), STOP_PATIENCE)
    options = aioduco.WorkerOptions.__init__
    options.__kwdefaults__ = {**(options.__kwdefaults__ or {}), **STREAM_PATIENCE}
    for latest in (StateFeed.latest, aioduco.sync.Feed.latest):
        latest.__kwdefaults__ = {"max_age": SAMPLE_PATIENCE}


if __name__ == "__main__":
    be_patient()
    del sys.argv[0]
    if sys.argv[0] == "--speed":
        import_module("cycle_time").spare_processor(float(sys.argv[1]))
        del sys.argv[:2]
    sys.path[0] = str(Path(sys.argv[0]).parent)
    with patient_queue():
        runpy.run_path(sys.argv[0], run_name="__main__")
