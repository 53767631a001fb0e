"""An asyncio-native SDK for DUCO (SIASUN) collaborative robot arms.

    import aioduco
    from aioduco import Joints

    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await robot.motion.movej2(Joints.deg(0, 0, 90, 0, -90, 0), v=1.0, a=1.0)

Units are SI: metres, radians, seconds, kilograms, newtons; `deg()` and `mm()` convert.
"""

from __future__ import annotations

from aioduco import errors, events
from aioduco._version import __version__
from aioduco.errors import *  # noqa: F403  # all of them, as errors.__all__ lists them
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
from aioduco.models.pose import Joints, JointsLike, Pose, PoseLike
from aioduco.models.realtime import RealtimeMode, RealtimePoint
from aioduco.models.state import IOStatus, RobotStates, RobotStatus
from aioduco.models.units import deg, mm
from aioduco.models.version import ControllerVersion
from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.robot import Robot, connect
from aioduco.streaming.gains import ServoGains
from aioduco.streaming.joint_trajectory import JointTrajectory, Tolerances
from aioduco.streaming.report import StreamStatistics
from aioduco.streaming.settings import LaneOptions
from aioduco.supervision.command import HeldMotion, MotionCommand
from aioduco.supervision.feed import Snapshot
from aioduco.supervision.pulse import HeartbeatState
from aioduco.supervision.settings import ExitLadder
from aioduco.supervision.task import OnCancel, Task

__all__ = [  # noqa: RUF022  # grouped by what they are for
    "__version__",
    # the robot
    "connect",
    "Robot",
    "HeldMotion",
    "MotionCommand",
    "ExitLadder",
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
    # outputs set on the way of a motion
    "bool_register",
    "event",
    "float_register",
    "output",
    "tool_output",
    "word_register",
    "Op",
    "PointOp",
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
    "LaneOptions",
    "ServoGains",
    "StreamStatistics",
    "Tolerances",
    # states
    "ControllerVersion",
    "HeartbeatState",
    "IOStatus",
    "OperationMode",
    "ProgramState",
    "RobotState",
    "RobotStates",
    "RobotStatus",
    "SafetyState",
    "Snapshot",
    "TaskState",
    "events",
]
__all__ += errors.__all__
