"""Runs a program as it is, but that its robots judge loops, connections and controllers lost later.

    python patient.py PROGRAM [its arguments]

A busy machine takes seconds over what takes a millisecond.
"""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import aioduco
import aioduco.sync

#: s that the tests' robots give by default; tests about such a time set it
PATIENCE = {"heartbeat": 20.0, "loop_stall_limit": 15.0, "call_timeout": 10.0}


def be_patient() -> None:
    """Make these the defaults of both ways to connect."""
    for connect in (aioduco.connect, aioduco.sync.connect):
        connect.__kwdefaults__ = {**(connect.__kwdefaults__ or {}), **PATIENCE}


if __name__ == "__main__":
    be_patient()
    del sys.argv[0]
    sys.path[0] = str(Path(sys.argv[0]).parent)
    runpy.run_path(sys.argv[0], run_name="__main__")
