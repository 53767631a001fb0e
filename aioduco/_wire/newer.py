"""Structs of manual 4.3 in answers: with more fields than those of 3.8, or with others.

The numbers of these fields are inferred: the manual prints the structs in order. Nothing of this is
sent. A controller of 3.8 never sends them, so its answers are read as structs of `rpc`.
"""

# The names of fields are the manual's.
# ruff: noqa: N815

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from aioduco._wire import rpc

__all__ = ["ADDED", "INSTEAD", "EAxissInfo", "ReachabilityParam", "RobotStatus"]


@dataclass(slots=True)
class RobotStatus(rpc.RobotStatus):
    """Position and motion of the arm, with the joints' torques; None: not sent."""

    jointAuxiliaryPosition: list[float] | None = None
    jointDynamicTorque: list[float] | None = None
    jointGravityTorque: list[float] | None = None
    jointActualTorque: list[float] | None = None
    jointExtraTorque: list[float] | None = None


@dataclass(slots=True)
class EAxissInfo(rpc.EAxissInfo):
    """A scheme of external axes, with its speed and acceleration; None: not sent."""

    vel: float | None = None
    acc: float | None = None


@dataclass(slots=True)
class ReachabilityParam(rpc.ReachabilityParam):
    """What reach_check found: the pose that cannot be reached, and its singularity; no joints."""

    index: int = 0
    singularity_type: int = 0


_TORQUES: Final = (
    "22: list<double> jointAuxiliaryPosition 23: list<double> jointDynamicTorque "
    "24: list<double> jointGravityTorque 25: list<double> jointActualTorque "
    "26: list<double> jointExtraTorque"
)
#: functions whose struct has more fields: its class, and the fields as in the IDL
ADDED: Final[dict[str, tuple[type, str]]] = {
    "getRobotStatus": (RobotStatus, _TORQUES),
    "get_eaxis_info": (EAxissInfo, "4: double vel 5: double acc"),
}
#: functions whose struct has other fields under the same numbers: all of them
INSTEAD: Final[dict[str, tuple[type, str]]] = {
    "reach_check": (ReachabilityParam, "1: bool result 2: i32 index 3: i32 singularity_type"),
}
