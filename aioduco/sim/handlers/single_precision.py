"""Handlers that return readings in single precision, as a controller does."""

from __future__ import annotations

import dataclasses
import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco._wire.rpc import RobotStatus
from aioduco.sim.handlers import Handlers

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["READINGS", "SinglePrecisionHandlers"]

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
)


class SinglePrecisionHandlers(Handlers):
    """The same functions; each number of a reading is rounded to a 32-bit float."""


def _rounded(name: str) -> Callable[..., Any]:
    exact = getattr(Handlers, name)

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


for _name in READINGS:
    setattr(SinglePrecisionHandlers, _name, _rounded(_name))
