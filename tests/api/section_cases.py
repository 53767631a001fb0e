"""Functions that are answered at once: manual sections 1.3.4, 1.3.5, 1.3.12 to 1.3.15."""

from __future__ import annotations

from typing import Any

import aioduco
from aioduco import (
    ExternalAxis,
    ExternalAxisScheme,
    ExternalAxisState,
    JogFrame,
    Joints,
    PointOp,
    Pose,
    RealtimeMode,
    RealtimePoint,
    WeavePlane,
    WeaveShape,
)
from aioduco._wire import rpc
from api.cases import Case
from api.motion_cases import HOME, OFFSET, OP, OP_WIRE, OTHER, POSE


def call(section: str, name: str, args: dict[str, Any], *wire: Any, **rest: Any) -> Case:
    return Case(section, name, args, wire, **rest)


AXIS = ExternalAxis(
    type=1,
    mode=2,
    ref_velo=0.1,
    ref_acc=0.2,
    ref_jerk=0.3,
    max_velo=0.4,
    max_acc=0.5,
    encoder_type=3,
    encoder_resolution=4096,
    position_bias=0.6,
    screw_lead=0.7,
    invert=True,
    position_limit=(-1.0, 2.0),
)
SCHEME = ExternalAxisScheme(
    type=1, axis_link=(0, 1), base=POSE, dh=((0.1, 0.2, 0.3, 0.4),), install=2
)
YIELD = [True, False, True, False, True, False]

CASES = [
    call(
        *("program", "get_current_project", {}),
        answer="/home/duco/projects/one/",
        result="/home/duco/projects/one/",
    ),
    call(
        *("program", "get_files_list", {"path": "/programs"}, "/programs"),
        answer={"a": 0, "b.jspf": 1},
        result={"a": aioduco.FileKind.FOLDER, "b.jspf": aioduco.FileKind.FILE},
    ),
    call("motion", "set_blend_ahead", {"per": 0, "num": 3}, 0, 3),
    call(
        *("motion", "set_hand_teach_parameter"),
        {
            "space": 1,
            "joint_scale": [1, 2, 3, 4, 5, 6],
            "cart_scale": [6, 5, 4, 3, 2, 1],
            "coord_type": JogFrame.WORK_OBJECT,
            "direction": YIELD,
        },
        *(1, [1, 2, 3, 4, 5, 6], [6, 5, 4, 3, 2, 1], 3, YIELD),
    ),
    call("motion", "replay", {"name": "track 1", "v": 50, "mode": 1}, "track 1", 50, 1),
    call(
        *("track", "trackEnqueue", {"points": [Joints(*HOME), Joints(*HOME)]}),
        *([HOME, HOME], True),
    ),
    call(
        *("track", "trackEnqueueOp", {"points": [PointOp(Pose(*POSE)), PointOp(OTHER, OP)]}),
        *([rpc.PointOp(POSE, rpc.Op()), rpc.PointOp(OTHER, OP_WIRE)], True),
    ),
    call("track", "trackClearQueue", {}),
    call("track", "getQueueSize", {}, answer=17, result=17),
    call(
        *("compound", "combine_motion_config"),
        {
            "type": WeaveShape.TRAPEZOID,
            "ref_plane": WeavePlane.WORK_OBJECT_XZ,
            "fq": 1.5,
            "amp": 0.003,
            "el_offset": 0.001,
            "az_offset": 0.002,
            "up_height": 0.004,
            "time": (0.1, 0.25),
            "path_dwell": True,
            "op_list": [OP],
        },
        *(4, 4, 1.5, 0.003, 0.001, 0.002, 0.004, [100, 250], True, [OP_WIRE]),
    ),
    call("compound", "enable_combine_motion", {}),
    call("compound", "disable_combine_motion", {}),
    call("external_axes", "enable_eaxis_scheme", {"scheme_name": "rail", "timeout": 5.0}, "rail"),
    call("external_axes", "disable_eaxis_scheme", {"scheme_name": "rail", "timeout": 5.0}, "rail"),
    call(
        *("external_axes", "get_eaxis_info", {}),
        answer=[rpc.EAxissInfo("rail", 1, 0.5), rpc.EAxissInfo("table", 0, -1.5)],
        result=(ExternalAxisState("rail", 1, 0.5), ExternalAxisState("table", 0, -1.5)),
    ),
    call(
        *("external_axes", "set_eaxis_param", {"num": 2, "param": AXIS}),
        2,
        rpc.EAxisParam(1, 2, 0.1, 0.2, 0.3, 0.4, 0.5, 3, 4096, 0.6, 0.7, True, [-1.0, 2.0]),
        True,
    ),
    call(
        *("external_axes", "set_eaxiss_scheme_param", {"num": 2, "param": SCHEME}),
        *(2, rpc.EAxisSchemeParam(1, [0, 1], POSE, [[0.1, 0.2, 0.3, 0.4]], 2), True),
    ),
    call("external_axes", "add_eaxis_scheme", {"num": 2}, 2, True),
    call("external_axes", "delete_eaxis_scheme", {"num": 2}, 2, True),
    call(
        *("realtime", "start_realtime_mode"),
        {"mode": RealtimeMode.TWIST, "filter_bandwidth": 50.0, "com_lost_time": 0.04},
        *(4, 50.0, 0.04),
    ),
    call("realtime", "end_realtime_mode", {}, also={"clear_realtime_data_queue": 4}),
    call(
        *("realtime", "realtime_data_enqueue", {"points": [RealtimePoint.twist(OFFSET)]}),
        [rpc.RealTimeControlData(cart_vel_tool_wobj_cmd=OFFSET, status=True)],
        True,
    ),
    call("realtime", "clear_realtime_data_queue", {}),
    call("realtime", "get_realtime_data_queue_size", {}, answer=42, result=42),
]
