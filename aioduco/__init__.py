"""An asyncio-native SDK for DUCO (SIASUN) collaborative robot arms.

    import aioduco
    from aioduco import Joints

    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await robot.motion.movej2(Joints.deg(30, -15, 105, 0, -90, 0), v=1.0, a=1.0)

Units are SI: metres, radians, seconds, kilograms, newtons; `deg()` and `mm()` convert.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from aioduco import errors
from aioduco.errors import *  # noqa: F403  # all of them, as errors.__all__ lists them

if TYPE_CHECKING:
    from aioduco import events
    from aioduco._process.frozen import freeze_support
    from aioduco.api.motion.switch import SwitchPlace, TrajectorySwitch
    from aioduco.api.streams.arguments import ServoGains
    from aioduco.models.enums import (
        FileKind,
        OperationMode,
        Outcome,
        OutputMode,
        ProgramState,
        RobotState,
        SafetyState,
        TaskState,
    )
    from aioduco.models.external_axis import ExternalAxis, ExternalAxisScheme, ExternalAxisState
    from aioduco.models.force import ForceFrame, ForceLogic, GuardedForce
    from aioduco.models.jog import Jog, JogDirections, JogFrame
    from aioduco.models.load import Load
    from aioduco.models.op import (
        Op,
        PointOp,
        bool_register,
        event,
        float_register,
        output,
        tool_output,
        word_register,
    )
    from aioduco.models.points import TaughtPoints
    from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
    from aioduco.models.realtime import RealtimeMode, RealtimePoint
    from aioduco.models.state import ForceStatus, IOStatus, RobotStates, RobotStatus
    from aioduco.models.units import deg, mm
    from aioduco.models.version import ControllerVersion
    from aioduco.models.weave import WeavePlane, WeaveShape
    from aioduco.planning.cell import Cell
    from aioduco.robot import Robot, connect, stop_all
    from aioduco.streaming.joint_trajectory import JointTrajectory, Tolerances
    from aioduco.streaming.report import StreamStatistics
    from aioduco.streaming.shared.options import WorkerOptions
    from aioduco.supervision.bringup import RecoverReport
    from aioduco.supervision.command import HeldMotion, MotionCommand
    from aioduco.supervision.heartbeat import HeartbeatState
    from aioduco.supervision.motion_path import MotionPath
    from aioduco.supervision.settings import ClosingSteps
    from aioduco.supervision.state_feed import Snapshot
    from aioduco.supervision.task import OnCancel, Task

__version__ = "0.1.0"

__all__ = [  # noqa: RUF022  # grouped by purpose
    "__version__",
    # the robot
    "connect",
    "freeze_support",
    "Robot",
    "stop_all",
    "Cell",
    "HeldMotion",
    "MotionCommand",
    "MotionPath",
    "ClosingSteps",
    "OnCancel",
    "Outcome",
    "Task",
    # poses, joints, units
    "deg",
    "mm",
    "Joints",
    "JointsLike",
    "Pose",
    "PoseLike",
    # outputs set along the path of a motion
    "bool_register",
    "event",
    "float_register",
    "output",
    "tool_output",
    "word_register",
    "Op",
    "PointOp",
    "TaughtPoints",
    # jogs, weaves, realtime control, external axes, force control, loads, outputs, files
    "ExternalAxis",
    "ExternalAxisScheme",
    "ExternalAxisState",
    "FileKind",
    "ForceFrame",
    "ForceLogic",
    "GuardedForce",
    "Jog",
    "JogDirections",
    "JogFrame",
    "Load",
    "OutputMode",
    "RealtimeMode",
    "RealtimePoint",
    "WeavePlane",
    "WeaveShape",
    # streams of set-points, joint trajectories
    "JointTrajectory",
    "WorkerOptions",
    "ServoGains",
    "StreamStatistics",
    "SwitchPlace",
    "Tolerances",
    "TrajectorySwitch",
    # states
    "ControllerVersion",
    "HeartbeatState",
    "ForceStatus",
    "IOStatus",
    "OperationMode",
    "ProgramState",
    "RobotState",
    "RobotStates",
    "RecoverReport",
    "RobotStatus",
    "SafetyState",
    "Snapshot",
    "TaskState",
    "events",
]
__all__ += errors.__all__

#: names by the module that provides them on first use; the imports above are for type checkers
_HOMES = {
    "aioduco._process.frozen": ("freeze_support",),
    "aioduco.api.motion.switch": ("SwitchPlace", "TrajectorySwitch"),
    "aioduco.models.enums": (
        "FileKind",
        "OperationMode",
        "Outcome",
        "OutputMode",
        "ProgramState",
        "RobotState",
        "SafetyState",
        "TaskState",
    ),
    "aioduco.models.external_axis": ("ExternalAxis", "ExternalAxisScheme", "ExternalAxisState"),
    "aioduco.models.force": ("ForceFrame", "ForceLogic", "GuardedForce"),
    "aioduco.models.jog": ("Jog", "JogDirections", "JogFrame"),
    "aioduco.models.load": ("Load",),
    "aioduco.models.op": (
        "Op",
        "PointOp",
        "bool_register",
        "event",
        "float_register",
        "output",
        "tool_output",
        "word_register",
    ),
    "aioduco.models.points": ("TaughtPoints",),
    "aioduco.models.pose": ("Joints", "JointsLike", "Pose", "PoseLike"),
    "aioduco.models.realtime": ("RealtimeMode", "RealtimePoint"),
    "aioduco.models.state": ("ForceStatus", "IOStatus", "RobotStates", "RobotStatus"),
    "aioduco.models.units": ("deg", "mm"),
    "aioduco.models.version": ("ControllerVersion",),
    "aioduco.models.weave": ("WeavePlane", "WeaveShape"),
    "aioduco.planning.cell": ("Cell",),
    "aioduco.robot": ("Robot", "connect", "stop_all"),
    "aioduco.streaming.joint_trajectory": ("JointTrajectory", "Tolerances"),
    "aioduco.streaming.report": ("StreamStatistics",),
    "aioduco.api.streams.arguments": ("ServoGains",),
    "aioduco.streaming.shared.options": ("WorkerOptions",),
    "aioduco.supervision.bringup": ("RecoverReport",),
    "aioduco.supervision.command": ("HeldMotion", "MotionCommand"),
    "aioduco.supervision.motion_path": ("MotionPath",),
    "aioduco.supervision.state_feed": ("Snapshot",),
    "aioduco.supervision.heartbeat": ("HeartbeatState",),
    "aioduco.supervision.settings": ("ClosingSteps",),
    "aioduco.supervision.task": ("OnCancel", "Task"),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Load a name on first use: `import aioduco` alone loads neither numpy nor anyio."""
    if name == "events":
        return importlib.import_module("aioduco.events")
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
