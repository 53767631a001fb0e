"""Recordings for tests: written as `Recording` writes them, with times that no machine disturbs."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aioduco._wire import rpc
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
from aioduco.models.samples import Samples
from aioduco.models.state import RobotStates
from aioduco.recording.channels import FileChannels
from aioduco.supervision.state_feed import Snapshot

Array = NDArray[np.float64]

HOME = np.array([0.0, -0.3, 1.9, 0.0, -1.5, 0.0])
FAR = np.array([0.5, 0.0, 1.6, 0.3, -1.2, 0.4])
RATE = 125.0


def nod(times: Array, begin: float = 0.5, seconds: float = 1.5) -> Array:
    """From home and back, smoothly, by joint 1 and others."""
    share = np.clip((times - begin) / seconds, 0.0, 1.0)
    up = (1 - np.cos(2 * np.pi * share)) / 2
    return np.asarray(HOME + up[:, None] * (FAR - HOME))


def write(
    path: Path,
    positions: Callable[[Array], Array] = nod,
    *,
    seconds: float = 2.5,
    taken: Array | None = None,
    late: Callable[[Array], Array] = np.zeros_like,
    outputs: dict[float, dict[int, bool]] | None = None,
    arm: str = "GCR5 910",
    error: float | None = None,
    without: tuple[float, float] = (0.0, 0.0),
    untold: tuple[float, float] = (0.0, 0.0),
) -> Path:
    """Record an arm that does what a function says.

    Args:
        path: the file.
        positions: where the arm is at some times [rad].
        seconds: how long.
        taken: when the samples are taken; None for all 8 ms.
        late: by how much each sample is received late [s].
        outputs: from when on which output is how.
        arm: what its controller tells.
        error: from when on it has a fault.
        without: a time in which samples are missing.
        untold: a time in which the controller tells no outputs.
    """
    times = np.arange(0.0, seconds, 1 / RATE) if taken is None else taken
    q = positions(times)
    speeds = (positions(times + 1e-4) - positions(times - 1e-4)) / 2e-4
    lag = late(times)
    started = 1_700_000_000_000_000_000
    samples = Samples()
    with path.open("wb") as file:
        metadata = {"clock_offset": str(started), "started": str(started), "arm": arm}
        channels = FileChannels(file, metadata)
        for at, here, speed, behind in zip(times, q, speeds, lag, strict=True):
            if without[0] < at < without[1]:
                continue
            levels = [False] * 16
            for begin, changed in (outputs or {}).items():
                for num, level in changed.items():
                    levels[num - 1] = level if at >= begin else levels[num - 1]
            levels = [] if untold[0] < at < untold[1] else levels
            fault = 7 if error is not None and at >= error else 0
            channels.sample(_snapshot(samples, at + behind, here, speed, levels, fault))
        channels.close()
    return path


def _snapshot(
    samples: Samples, at: float, q: Array, speeds: Array, outputs: list[bool], error: int
) -> Snapshot:
    lists = [each.name for each in dataclasses.fields(rpc.RobotStatus)[:15]]
    seen: dict[str, Any] = dict.fromkeys(lists, [0.0] * 6)
    for kind in ("Expect", "Actual"):
        seen[f"joint{kind}Position"] = q.tolist()
        seen[f"joint{kind}Velocity"] = speeds.tolist()
    seen |= {"slaveReady": [True] * 6, "robotState": 6, "robotError": error}
    status: Any = samples.status(rpc.RobotStatus(**seen))
    io = samples.io(lambda: rpc.IOStatus(digitalInputs=[False] * 16, digitalOutputs=outputs))
    states = RobotStates(
        0, at, RobotState.ENABLE, ProgramState.STOPPED, SafetyState.RUN, OperationMode.AUTO
    )
    return Snapshot(0, at, states, dataclasses.replace(status, received_at=at), io, None)
