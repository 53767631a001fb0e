"""What the wire of manual 4.3 has otherwise than that of 3.8: answers, and schemes in lists.

The numbers of the fields in answers are inferred: the manual prints the structs in order. None of
them is sent. Motions with external axes name several schemes; their lists are sent under the
numbers that the single values have in 3.8, to controllers of 4.3 alone. A controller of 3.8 never
sends what is added, so its answers are read as structs of `rpc`.
"""

# The names of fields are the manual's.
# ruff: noqa: N815

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from aioduco._wire import rpc


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
