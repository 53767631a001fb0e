"""Handlers that return readings in single precision, as a controller does."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco._wire.rpc import RobotStatus

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.sim.handlers import Handlers


#: functions that return readings of the arm: measured, commanded, or computed from these
READINGS = (
    "getRobotStatus",
    *(
        f"get_{which}_joints_{quantity}"
        for which in ("actual", "target")
        for quantity in ("position", "speed", "acceleration", "torque")
    ),
    *(
        f"get_{what}_{quantity}"
        for what in ("tcp", "flange")
        for quantity in ("pose", "speed", "acceleration")
    ),
    *("get_tcp_pose_coord", "get_tcp_force", "get_tcp_force_tool"),
    *("get_ext_torque", "fc_get_ft"),
    # of controllers of manual 4.3
    *("get_tcp_pose_command", "get_tcp_speed_command"),
)


@functools.cache
def in_single_precision(kind: type[Handlers]) -> type[Handlers]:
    """Return the same handlers with each number of a reading rounded to a 32-bit float."""
    readings = {name: _rounded(getattr(kind, name)) for name in READINGS if hasattr(kind, name)}
    return type(f"SinglePrecision{kind.__name__}", (kind,), readings)


def _rounded(exact: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(exact)
    def reading(self: Handlers, *args: Any) -> Any:
        return _single(exact(self, *args))

    return reading


def _single(answer: Any) -> Any:
    if isinstance(answer, RobotStatus):
        names = [field.name for field in dataclasses.fields(answer)]
        lists = {name: _single(getattr(answer, name)) for name in names}
        return dataclasses.replace(answer, **lists)
    if isinstance(answer, list) and answer and isinstance(answer[0], float):
        return np.array(answer, np.float32).tolist()
    return answer
