"""What the wire of manual 4.3 has otherwise than that of 3.8: answers, calls, schemes in lists.

The numbers of the fields in answers are inferred: the manual prints the structs in order. None of
them is sent. Motions with external axes name several schemes; their lists are sent under the
numbers that the single values have in 3.8, to controllers of 4.3 alone. A controller of 3.8 never
sends what is added, so its answers are read as structs of `rpc`. A call without arguments is its
name alone, so those of 4.3 can be sent; what they return follows from the manual, and is an
assumption for the two of the newest headers.
"""

# The names of fields are the manual's.
# ruff: noqa: N815

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from aioduco._wire import rpc

__all__ = [
    "ADDED",
    "CLEAR_ERROR_MESSAGE",
    "DISABLE_LASER_TRACK",
    "ENABLE_LASER_TRACK",
    "GET_BASE",
    "GET_HOME_POSE",
    "GET_INSTALLATION",
    "GET_SIMULATION_STATE",
    "GET_TCP_POSE_COMMAND",
    "GET_TCP_SPEED_COMMAND",
    "INSTEAD",
    "IN_LISTS",
    "RESET_LASER_TRACK",
    "SCHEMES",
    "EAxissInfo",
    "ReachabilityParam",
    "RobotStatus",
    "in_lists",
]

GET_BASE: Final[rpc.WireCall[list[float]]] = rpc.WireCall("get_base", ())
GET_HOME_POSE: Final[rpc.WireCall[list[float]]] = rpc.WireCall("get_home_pose", ())
GET_INSTALLATION: Final[rpc.WireCall[list[float]]] = rpc.WireCall("get_installation", ())
GET_TCP_POSE_COMMAND: Final[rpc.WireCall[list[float]]] = rpc.WireCall("get_tcp_pose_command", ())
GET_TCP_SPEED_COMMAND: Final[rpc.WireCall[list[float]]] = rpc.WireCall("get_tcp_speed_command", ())
GET_SIMULATION_STATE: Final[rpc.WireCall[bool]] = rpc.WireCall("get_simulation_state", ())
CLEAR_ERROR_MESSAGE: Final[rpc.WireCall[None]] = rpc.WireCall("clear_error_message", ())
ENABLE_LASER_TRACK: Final[rpc.WireCall[int]] = rpc.WireCall("enable_laser_track", ())
DISABLE_LASER_TRACK: Final[rpc.WireCall[int]] = rpc.WireCall("disable_laser_track", ())
RESET_LASER_TRACK: Final[rpc.WireCall[int]] = rpc.WireCall("reset_laser_track", ())


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


#: types of the name, the target and the speed of schemes of external axes in 4.3
IN_LISTS: Final = ("list<string>", "list<list<double>>", "list<double>")
#: motions with external axes, by name the number of the first of these three fields; of the last
#: one, which no manual describes, it is not known what 4.3 takes
SCHEMES: Final[dict[str, int]] = {
    "move_eaxis": 1,
    "movej2_eaxis": 5,
    "movej2_pose_eaxis": 8,
    "movel_eaxis": 8,
    "movec_eaxis": 9,
    "move_circle_eaxis": 10,
}
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


def in_lists(call: rpc.WireCall[int]) -> rpc.WireCall[int]:
    """Return a motion with external axes as 4.3 takes it: with a list of one scheme."""
    first = SCHEMES[call.name] - 1
    args = list(call.args)
    args[first : first + 3] = ([value] for value in args[first : first + 3])
    return rpc.WireCall(call.name, tuple(args))
