"""A simulated controller that says when the arm begins to move, and when it has come to rest.

    python -m hostile.cable.controller

It says "port", "begin" and "rest" with the joints, "task" for each task that it accepts, and "mark"
when it is asked to by a line on its standard input. It ends when that is closed.
"""

from __future__ import annotations

import sys
import time
from typing import Any
from unittest.mock import patch

import numpy as np
from cycle_time import COARSE

import aioduco.sync
from aioduco.sim import Simulator
from aioduco.sim.controller.state_machine import Controller
from aioduco.sim.cycle import DriveCommand, SensedState

from .lines import say

#: way from where the arm rested after which it has begun to move [rad]; less is swinging out
_BEGUN = 1e-3
#: what a moving arm goes at least [rad], in this time [s]; less is resting
_STEP, _REST = 1e-4, 0.1
#: what a set-point differs from the one before, as a number [rad]
_SAME = 1e-6
#: time after which a function that makes many tasks is named again [s]
_AGAIN = 0.5


class RecordingController(Controller):
    """Looks at each set-point that it sends to the drives."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._last: Any = None
        #: where it rested, or was at the last step
        self._anchor: Any = None
        self._moved_at = (0.0, 0.0)
        self._left_at: float | None = None
        self._resting = True
        self._newest_task = 0
        self._named: dict[str, float] = {}

    def tick(self, sensed: SensedState) -> DriveCommand:
        drive = super().tick(sensed)
        now = time.monotonic()
        for task in self.tasks.unfinished():
            if task.id > self._newest_task:
                self._newest_task = task.id
                if now - self._named.get(task.name, 0.0) > _AGAIN:
                    say("task", f"{task.name} {task.id}", now)
                self._named[task.name] = now
        self._look(drive.setpoint.q, sensed.time, now)
        return drive

    def _look(self, q: Any, time_: float, now: float) -> None:
        if self._last is None:
            self._last = self._anchor = q
        way, step = _distance(q, self._anchor), _distance(q, self._last)
        self._last = q
        if self._resting:
            if step <= _SAME:
                self._left_at = None
            elif self._left_at is None:
                self._left_at = now
            if way > _BEGUN:
                say("begin", _text(q), self._left_at)
                self._resting, self._left_at = False, None
        if not self._resting:
            if way > _STEP:
                self._anchor, self._moved_at = q, (time_, now)
            elif time_ - self._moved_at[0] > _REST:
                self._resting = True
                say("rest", _text(q), self._moved_at[1])


def _distance(q: Any, other: Any) -> float:
    return float(np.abs(q - other).max())


def _text(joints: Any) -> str:
    return " ".join(f"{joint:.3f}" for joint in joints)


def main() -> None:
    with (
        patch("aioduco.sim.assembly.Controller", RecordingController),
        Simulator(host="0.0.0.0", speed=200.0, cycle=COARSE) as sim,
    ):
        with aioduco.sync.connect("127.0.0.1", sim.port, heartbeat=None) as robot:
            robot.bring_up()
        sim.speed = 1.0
        say("port", str(sim.port))
        for _ in sys.stdin:
            say("mark")


if __name__ == "__main__":
    main()
