"""Tools, kinematics, settings, Modbus, force, service: the rest of the wire."""

from __future__ import annotations

import math
from typing import Any

from aioduco import ForceFrame, ForceLogic, GuardedForce, Joints, Load, Pose
from aioduco._wire import rpc
from aioduco.api.kinematics import Reachability
from api.bus_cases import call, frozen
from api.cases import Case
from api.motion_cases import FRAMES, HOME, NEAR, OFFSET, OTHER, POSE, motion

LOAD = [1.5, 0.01, 0.02, 0.03]
INERTIA = [0.1, 0.0, 0.0, 0.2, 0.0, 0.3]
PLACES = {"tool": OFFSET, "wobj": Pose(*OTHER)}
ROWS = [[0.1, 0.2, 0.3, 0.4], [0.5, 0.6, 0.7, 0.8]]
TABLE = frozen(*ROWS)

TOOLS = [
    call(
        *("frames", "set_tool_data"),
        {"name": "grip", "tool_offset": OFFSET, "payload": Load(*LOAD), "inertia_tensor": INERTIA},
        *("grip", OFFSET, LOAD, INERTIA),
    ),
    call("frames", "set_load_data", {"load": Load(*LOAD)}, LOAD),
    call("frames", "set_wobj", {"name": "table", "wobj": Pose(*POSE)}, "table", POSE),
    call("frames", "set_wobj_offset", {"wobj": OFFSET, "active": True}, OFFSET, True),
    call("frames", "get_tcp_offset", {}, answer=OFFSET, result=Pose(*OFFSET)),
    call("frames", "get_tool_load", {}, answer=LOAD, result=Load(*LOAD)),
    call("frames", "get_wobj", {}, answer=POSE, result=Pose(*POSE)),
    call(
        *("kinematics", "cal_fkine", {"joints": Joints(*HOME), **PLACES}, HOME, OFFSET, OTHER),
        answer=POSE,
        result=Pose(*POSE),
    ),
    call(
        *("kinematics", "cal_ikine", {"pose": POSE, "q_near": NEAR, **PLACES}),
        *(POSE, NEAR, OFFSET, OTHER),
        answer=HOME,
        result=Joints(*HOME),
        also={"cal_fkine": POSE},
    ),
    call(
        *("kinematics", "reach_check"),
        {"base": OTHER, "wobj": POSE, "tool": OFFSET, "ref_pos": NEAR, "check_points": [POSE] * 2},
        *(OTHER, POSE, OFFSET, NEAR, [POSE] * 2),
        answer=rpc.ReachabilityParam(result=True, joints_pos=[HOME, NEAR]),
        result=Reachability(reachable=True, joints=(Joints(*HOME), Joints(*NEAR))),
    ),
    call("kinematics", "get_origin_DH", {}, answer=ROWS, result=TABLE),
    call("kinematics", "get_calib_DH", {}, answer=ROWS, result=TABLE),
    call("state", "read_encoder_count", {}, answer=2**40, result=2**40),
]
SETTINGS = [
    Case("settings", "simulation", {"sim": True}, (True, False), answer=1000, by_itself=True),
    call("settings", "speed", {"val": 55.5}, 55.5),
    call("settings", "get_global_speed", {}, answer=55, result=55),
    call("settings", "set_teach_speed", {"v": 30}, 30),
    call("settings", "get_teach_speed", {}, answer=30, result=30),
    call("settings", "collision_detect", {"level": 3}, 3),
    call("settings", "collision_detection_reset", {}),
    call("settings", "set_teach_pendant", {"enable": False}, False),
    call(
        *("motion", "start_record_track"),
        {"name": "seam", "mode": 0, **FRAMES, "interval": math.radians(4.0)},
        *("seam", 0, "grip", "table", math.degrees(math.radians(4.0))),
    ),
    call("motion", "stop_record_track", {}),
    call("log", "log_info", {"message": "begun"}, "begun", answer=None),
    call("log", "log_error", {"message": "no part"}, "no part", answer=None),
    *(
        call("optimization", f"{switch}_{what}", {})
        for switch in ("enable", "disable")
        for what in (
            *("speed_optimization", "acc_optimization"),
            *("singularity_control", "vibration_control"),
        )
    ),
]
MODBUS = [
    call("modbus", "modbus_read", {"signal_name": "belt"}, "belt", answer=1200, result=1200),
    call("modbus", "modbus_write", {"signal_name": "belt", "value": 65535}, "belt", 65535),
    call(
        *("modbus", "modbus_set_frequency", {"signal_name": "belt", "frequency": 20}, "belt", 20),
        answer=None,
    ),
    call(
        *("modbus", "modbus_write_multiple_regs"),
        {"slave_num": 1, "name": "belt", "word_list": [1, 65535, 32768]},
        *(1, "belt", 3, [1, -1, -32768]),
    ),
    call(
        *("modbus", "modbus_write_multiple_coils"),
        {"slave_num": 2, "name": "lamps", "byte_list": [1, 0, 1, 1]},
        *(2, "lamps", 4, [1, 0, 1, 1]),
    ),
    call(
        *("modbus", "modbus_add_signal"),
        {
            "ip": "192.0.2.7",
            "slave_number": 1,
            "signal_address": 256,
            "signal_type": 2,
            "signal_name": "belt",
        },
        *("192.0.2.7", 1, 256, 2, "belt"),
    ),
    call("modbus", "modbus_delete_signal", {"signal_name": "belt"}, "belt"),
]
ON = [True, False, True, False, True, False]
PRESS = [5.0, 0.0, -10.0, 0.0, 1.0, 0.0]
DAMP = [1000.0, 0.0, 2000.0, 0.0, 57.0, 0.0]
CAPS = [0.1, 0.0, 0.15, 0.0, 0.2, 0.0]
BAND = [1.0, 0.0, 2.0, 0.0, 0.1, 0.0]
SIX = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
WAIT: dict[str, Any] = {"range": BAND, "absolute": True, "duration": 0.25, "timeout": 30.0}
FORCE = [
    call("force", "fc_start", {}),
    call("force", "fc_stop", {}),
    call(
        *("force", "fc_config"),
        {
            "direction": ON,
            "ref_ft": PRESS,
            "damp": DAMP,
            "max_vel": CAPS,
            "dead_band": BAND,
            **FRAMES,
            "frame": ForceFrame.WORK_OBJECT,
        },
        *(ON, PRESS, DAMP, CAPS, BAND, "grip", "table", 1),
    ),
    motion("force", "fc_move", {}, False),
    call(
        *("force", "fc_guard_act"),
        {
            "direction": ON,
            "ref_ft": BAND,
            **FRAMES,
            "frame": ForceFrame.WORK_OBJECT,
            "force_property": GuardedForce.EXTERNAL,
        },
        *(ON, BAND, "grip", "table", 1, 1),
    ),
    call("force", "fc_guard_deact", {}),
    call("force", "fc_force_set_value", {"direction": ON, "ref_ft": PRESS}, ON, PRESS),
    *(
        call(
            *("force", f"fc_wait_{what}", {"middle": PRESS if what == "ft" else SIX, **WAIT}),
            *(PRESS if what == "ft" else SIX, BAND, True, 250, 30000),
        )
        for what in ("pos", "vel", "ft")
    ),
    call("force", "fc_wait_logic", {"logic": [ForceLogic.OFF, 2, ForceLogic.AND]}, [0, 2, 1]),
    call("force", "fc_get_ft", {}, answer=PRESS, result=frozen(*PRESS)),
    call("force", "fc_mode_is_active", {}, answer=True, result=True),
]
SECRET = {"passwd": "secret"}
SERVICE = [
    call(
        *("service", "set_servo_config", {"axis_num": 2, "id": 7, "value": -5, "qfmt": 16}),
        *(2, 7, -5, 16, True),
    ),
    call("service", "apply_servo_config", {"axis_num": 2}, 2, True),
    call(
        *("service", "set_servo_file_params"),
        {"axis_num": 2, "id": 7, "name": "kp", "value": 1.5, "qfmt": 16.0},
        *(2, 7, "kp", 1.5, 16.0),
    ),
    *(
        call("service", f"set_{what}_calibration_params", {"params": ROWS}, ROWS)
        for what in ("dynamic", "kinematic")
    ),
    *(
        call(
            *("service", f"set_{what}_calibration_info", {**SECRET, "info": "on Monday"}),
            *("secret", "on Monday"),
        )
        for what in ("dynamic", "kinematic", "vibration")
    ),
    *(
        call("service", f"save_{what}_calibration_params", SECRET, "secret")
        for what in ("dynamic", "kinematic")
    ),
    *(
        call(
            *("service", f"get_{what}_calibration_params", {}),
            answer=ROWS,
            result=tuple(frozen(*row) for row in ROWS),
        )
        for what in ("dynamic", "vibration")
    ),
    call("service", "upload_robot_param_to_toolboard", SECRET, "secret"),
    call("service", "set_pendant_type", {"type": 1}, 1),
    call("service", "change_recipe", {}, answer=None),
    *(
        call("service", f"get_{what}", {}, answer=[1.5, 2.5], result=frozen(1.5, 2.5))
        for what in ("axis_motor_kt", "axis_motor_rated_current", "pos_bias")
    ),
    *(
        call("service", f"get_{what}", {}, answer=[101, 121], result=(101, 121))
        for what in ("axis_ratio", "motor_pole_pair_number", "motor_stator_slots")
    ),
]
CASES = [*TOOLS, *SETTINGS, *MODBUS, *FORCE, *SERVICE]
