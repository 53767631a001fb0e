"""Fixtures: those of the client's tests, and a recording."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest
from client.conftest import bench, robot

import aioduco.sync
from aioduco.sim import Simulator

__all__ = ["bench", "robot", "whole"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a motion of the simulated arm, with a tool that is turned."""
    path = tmp_path_factory.mktemp("recording") / "run.mcap"
    with (
        Simulator() as sim,
        aioduco.sync.connect(
            sim.host, sim.port, state_rate=100, clock=sim.clock, heartbeat=None
        ) as robot,
    ):
        robot.bring_up()
        robot.frames.set_tool_data("long", [0.1, 0.0, 0.2, 0.0, 0.3, 0.0], [1, 0, 0, 0])
        with robot.record(path) as recording:
            line = logging.LogRecord("own", logging.ERROR, "a.py", 7, "no part", (), None)
            recording.handler.handle(line)
            robot.motion.movej2([0.4, -0.2, 1.8, 0.1, -1.5, 0.2], v=1.0, a=2.0)
    return path
