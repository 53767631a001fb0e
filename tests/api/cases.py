"""One call of each function: our arguments, what arrives on the wire, what comes back."""

from __future__ import annotations

import inspect
import json
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import aioduco
from aioduco._wire import idl
from aioduco._wire.rpc import AsyncRpc
from aioduco.supervision.command import MotionCommand

#: never connected to: for what is refused, or made, before anything is sent
NOBODY = aioduco.connect("192.0.2.1")

#: states in which a task may have ended without success, and the error of each
END_ERRORS = {
    3: aioduco.TaskStopped,
    5: aioduco.TaskInterrupted,
    6: aioduco.TaskFailed,
    7: aioduco.TaskIllegal,
    8: aioduco.TaskParameterMismatch,
}

DATA = json.loads((Path(__file__).parents[1] / "data" / "manual-3.8.json").read_text("utf-8"))
#: the manual's functions, by their names on the wire
MANUAL: dict[str, dict[str, Any]] = {one["wire"]: one for one in DATA["functions"] if one["wire"]}

#: what the manual calls our parameters; the first name that the function has
NAMES = {
    "joints": ("joints_list", "joints_position"),
    "velocities": ("joints_list",),
    "pose": ("p", "pose_list", "p2"),
    "twist": ("pose_list",),
    "offset": ("pose_offset",),
    "via": ("p1",),
    "center": ("p1",),
    "poses": ("p_list",),
    "data": ("data", "value"),
    "num": ("num", "portnum"),
    "dead_band": ("number_list",),
    "frame": ("type",),
    "middle": ("middle_value",),
    "points": ("pose_list", "points", "realtime_data"),
    "r": ("r", "rad"),
    "radius": ("rad",),
    "length": ("len",),
    "q_near": ("q_near", "qnear"),
    "jog": ("param",),
    "v": ("v", "vel"),
    "epose": ("epose", "epos"),
    "task_id": ("id",),
    "value": ("value", "val"),
}


@dataclass(frozen=True)
class Case:
    """A call of a function.

    Attributes:
        section: the attribute of the robot; empty for what is on the robot itself.
        name: the function.
        args: our arguments, each as it can be given, all of them.
        wire: what arrives.
        answer: what the controller answers.
        result: what comes back, if the function returns something; a class if it is a sample,
            which has a number and a time.
        moves: whether it makes a motion.
        also: what else the controller is asked for, and answers.
        by_itself: whether the desk answers by itself, and carries it out.
    """

    section: str
    name: str
    args: dict[str, Any]
    wire: tuple[Any, ...]
    answer: Any = 4
    result: Any = None
    moves: bool = False
    also: dict[str, Any] = field(default_factory=dict)
    by_itself: bool = False

    def __str__(self) -> str:
        return self.name

    def method(self, robot: aioduco.Robot) -> Callable[..., Any]:
        """The function of a robot."""
        section = getattr(robot, self.section) if self.section else robot
        method: Callable[..., Any] = getattr(section, self.name)
        return method

    @property
    def parameters(self) -> dict[str, inspect.Parameter]:
        """Our parameters."""
        return dict(inspect.signature(self.method(NOBODY)).parameters)

    def manual_name(self, parameter: str) -> str | None:
        """What the manual calls a parameter of ours; None if it has no such one."""
        function = MANUAL.get(self.name)
        if function is None:
            return None
        known = {one["name"] for one in function["parameters"] if not one.get("out")}
        for name in (parameter, *NAMES.get(parameter, ())):
            if name in known:
                return name
        return None


class _Reached(Exception):
    """A call got as far as the connection."""


async def _reached(name: str, args: tuple[Any, ...]) -> Any:
    raise _Reached


def nobody() -> aioduco.Robot:
    """A robot that is never connected to, and remembers only what it is asked for from now on."""
    robot = aioduco.connect(NOBODY.host)
    robot._supervisor.dispatcher.require_opened = lambda _: None  # it counts as open
    return robot


def refusal(
    case: Case, robot: aioduco.Robot | None = None, /, **changed: Any
) -> BaseException | None:
    """What a call with other arguments raises before anything could be sent; None if nothing."""
    robot = nobody() if robot is None else robot
    if case.section:
        getattr(robot, case.section)._rpc = AsyncRpc(_reached)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", aioduco.UnitWarning)
            made = case.method(robot)(**(case.args | changed))
    except Exception as exc:
        return exc
    if isinstance(made, MotionCommand):
        made.mark_used()
        return None
    try:
        made.send(None)
    except (_Reached, aioduco.ConnectionLost):
        return None  # it got as far as the connection, so nothing was wrong with it
    except aioduco.RobotStateError as exc:
        return None if "the robot is not open" in str(exc) else exc
    except Exception as exc:
        return exc
    finally:
        made.close()
    return None


@cache
def cases() -> tuple[Case, ...]:
    """All of them."""
    from api import bus_cases, motion_cases, section_cases, setting_cases, state_cases  # noqa: PLC0415  # they are made of what is here

    modules = (motion_cases, section_cases, bus_cases, setting_cases, state_cases)
    return tuple(case for module in modules for case in module.CASES)


def blocking_cases() -> list[Case]:
    """The motions of `robot.blocking`, with what arrives."""
    found = []
    for case in cases():
        if case.moves and hasattr(NOBODY.blocking, case.name):
            at = idl.functions()[case.name].parameters.index("block")
            wire = (*case.wire[:at], True, *case.wire[at + 1 :])
            args = dict(case.args)
            if case.name == "move_jog":  # without a step, it has no end of its own
                del args["time"]
                args["jog"] = replace(args["jog"], step=0.002)
                param = replace(wire[0], use_step=True, step_cartvalue=0.002)
                wire = (param, *wire[1:])
            found.append(replace(case, section="blocking", args=args, wire=wire))
    return found
