"""States, digital signals, power, and what acts on the whole robot: manual 1.3.2, 1.3.3, 1.3.7."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import aioduco
from aioduco import Joints, OperationMode, Pose, TaskState
from aioduco._wire import rpc
from aioduco.api.version import RobotType
from api.bus_cases import call, frozen
from api.cases import Case
from api.motion_cases import HOME, POSE

SIX = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
#: the lists of a status that hold no positions
DERIVED: dict[str, Any] = {
    **{
        f"{part}{which}{what}": SIX
        for part in ("joint", "cart")
        for which in ("Expect", "Actual")
        for what in ("Velocity", "Accelera")
    },
    **dict.fromkeys(("jointActualCurrent", "jointTemperature", "driverTemperature"), SIX),
}


def carried_out(section: str, name: str, args: dict[str, Any], *wire: Any) -> Case:
    """A call that the desk carries out by itself, as a task."""
    return Case(section, name, args, wire, answer=1000, by_itself=True)


def vector(name: str) -> Case:
    return call("state", name, {}, answer=SIX, result=frozen(*SIX))


STATES = [
    call("state", "robotmoving", {}, answer=True, result=True),
    call("state", "get_last_error", {}, answer=["one", "两"], result=("one", "两")),
    call(
        *("state", "get_noneblock_taskstate", {"task_id": 1000}, 1000),
        answer=6,
        result=TaskState.ERROR,
    ),
    call("state", "get_actual_joints_position", {}, answer=HOME, result=Joints(*HOME)),
    call("state", "get_target_joints_position", {}, answer=HOME, result=Joints(*HOME)),
    *[
        vector(f"get_{which}_joints_{what}")
        for which in ("actual", "target")
        for what in ("speed", "acceleration", "torque")
    ],
    vector("get_ext_torque"),
    call("state", "get_tcp_pose", {}, answer=POSE, result=Pose(*POSE)),
    call(
        *("state", "get_tcp_pose_coord", {"tool": "grip", "wobj": "table"}, "grip", "table"),
        answer=POSE,
        result=Pose(*POSE),
    ),
    *[vector(f"get_tcp_{what}") for what in ("speed", "acceleration", "force")],
    call(
        *("state", "get_tcp_force_tool", {"tool": "grip"}, "grip"), answer=SIX, result=frozen(*SIX)
    ),
    call("state", "get_flange_pose", {}, answer=POSE, result=Pose(*POSE)),
    *[vector(f"get_flange_{what}") for what in ("speed", "acceleration")],
    call("version", "get_robot_version", {}, answer="v2.6.1", result="v2.6.1"),
    call(
        *("version", "get_robot_type", {}),
        answer=["GCR", "5", "910", "SN1"],
        result=RobotType("GCR", "5", "910", "SN1"),
    ),
]
#: samples have a number and a time, which no table knows: they are looked at one by one
SAMPLES = [
    call("state", "get_robot_state", {}, answer=[6, 0, 5, 1], result=aioduco.RobotStates),
    call(
        *("state", "getRobotStatus", {}),
        answer=rpc.RobotStatus(
            jointActualPosition=HOME,
            jointExpectPosition=HOME,
            cartActualPosition=POSE,
            cartExpectPosition=POSE,
            **DERIVED,
            slaveReady=[True] * 6,
            robotState=6,
        ),
        result=aioduco.RobotStatus,
    ),
    call(
        *("state", "getRobotIOStatus", {}),
        answer=rpc.IOStatus(digitalInputs=[True] * 16, wordRegisterInputs=[1] * 32),
        result=aioduco.IOStatus,
    ),
]
SIGNALS = [
    *[
        call("io", name, {"num": num}, num, answer=True, result=True)
        for name, num in {
            "get_standard_digital_out": 16,
            "get_standard_digital_in": 1,
            "get_tool_digital_out": 2,
            "get_tool_digital_in": 1,
            "get_function_digital_in": 8,
            "get_function_digital_out": 1,
        }.items()
    ],
    *[
        call("io", name, {"num": 2, "value": True}, 2, True, True)
        for name in ("set_standard_digital_out", "set_tool_digital_out")
    ],
]
POWER = [
    *[
        carried_out("system", name, {"timeout": 5.0}, False)
        for name in ("power_on", "power_off", "enable", "disable")
    ],
    call("system", "shutdown", {}, False, answer=1000),
    call("system", "restart", {"timeout": 5.0}, False, answer=4),
    call("system", "switch_mode", {"mode": OperationMode.AUTO}, 1),
]
ENDINGS = [
    carried_out("motion", name, {}, False)
    for name in ("speed_stop", "stop_manual_move", "end_teach_mode")
]
WHOLE = [carried_out("", name, {}, False) for name in ("stop", "abort")]
#: whether anything is paused, or was: nothing moves
PAUSES = [replace(carried_out("", name, {}, False), result=False) for name in ("pause", "resume")]
TEACHING = [Case("motion", "teach_mode", {"time": 30.0}, (False,), answer=1000, moves=True)]

CASES = [*STATES, *SAMPLES, *SIGNALS, *POWER, *ENDINGS, *WHOLE, *PAUSES, *TEACHING]
