"""Motions, and what belongs to them: manual sections 1.3.4, 1.3.5, 1.3.12 and 1.3.14."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aioduco import Jog, JogDirections, JogFrame, Joints, Op, PointOp, Pose, output
from aioduco._wire import rpc
from api.cases import Case

HOME = [0.0, 0.0, 1.5, 0.0, -1.5, 0.0]
NEAR = [0.1, 0.2, 1.4, 0.1, -1.4, 0.1]
POSE = [0.5, 0.1, 0.6, 3.1, 0.0, -1.5]
OTHER = [0.5, 0.2, 0.6, 3.1, 0.1, -1.5]
OFFSET = [0.0, 0.0, 0.1, 0.0, 0.0, 0.5]

OP = Op.at_start(output(3), time=0.5)
OP_WIRE = rpc.Op(time_or_dist_1=1, trig_io_1=3, trig_value_1=True, trig_time_1=500.0)

JOINT = {"v": 1.0, "a": 2.0}
LINE = {"v": 0.1, "a": 0.2}
FRAMES = {"tool": "grip", "wobj": "table"}
REST = {"op": OP, "def_acc": True}
BLEND = {"r": 0.05}
NEARBY = {"q_near": Joints(*NEAR)}
SERVO = {"kp": 150.0, "kd": 35.0, "smooth_vel": 5.0, "smooth_acc": 0.5}
SERVO_WIRE = (150.0, 35.0, 5.0, 0.5)
AXES = {"scheme_name": "rail", "epose": [1.5, 0.0, 0.0], "eaxis_v": 0.3}
AXES_WIRE = ("rail", [1.5, 0.0, 0.0], 0.3)


def motion(section: str, name: str, args: dict[str, Any], *wire: Any) -> Case:
    return Case(section, name, args, wire, moves=True)


JOINTS = [
    motion(
        *("motion", "movej2", {"joints": Joints(*HOME), **JOINT, **BLEND, **REST}),
        *(HOME, 1.0, 2.0, 0.05, False, OP_WIRE, True),
    ),
    motion(
        *("motion", "movej", {"joints": np.array(HOME), "v": 30, "a": 40, **BLEND, **REST}),
        *(HOME, 30.0, 40.0, 0.05, False, OP_WIRE, True),
    ),
    motion(
        *("motion", "movej_pose2"),
        {"pose": Pose(*POSE), **JOINT, **BLEND, **NEARBY, **FRAMES, **REST},
        *(POSE, 1.0, 2.0, 0.05, NEAR, "grip", "table", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "movej_pose"),
        {"pose": POSE, "v": 30.0, "a": 40.0, **BLEND, **NEARBY, **FRAMES, **REST},
        *(POSE, 30.0, 40.0, 0.05, NEAR, "grip", "table", False, OP_WIRE, True),
    ),
]
LINES = [
    motion(
        *("motion", "movel", {"pose": POSE, **LINE, **BLEND, **NEARBY, **FRAMES, **REST}),
        *(POSE, 0.1, 0.2, 0.05, NEAR, "grip", "table", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "tcp_move", {"offset": OFFSET, **LINE, **BLEND, "tool": "grip", **REST}),
        *(OFFSET, 0.1, 0.2, 0.05, "grip", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "tcp_move_2p", {"p1": POSE, "p2": OTHER, **LINE, **BLEND, **FRAMES, **REST}),
        *(POSE, OTHER, 0.1, 0.2, 0.05, "grip", "table", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "wobj_move", {"offset": OFFSET, **LINE, **BLEND, "wobj": "table", **REST}),
        *(OFFSET, 0.1, 0.2, 0.05, "table", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "wobj_move_2p", {"p1": POSE, "p2": OTHER, **LINE, **BLEND, **FRAMES, **REST}),
        *(POSE, OTHER, 0.1, 0.2, 0.05, "grip", "table", False, OP_WIRE, True),
    ),
]
CURVES = [
    motion(
        *("motion", "movec"),
        {"via": POSE, "pose": OTHER, **LINE, **BLEND, "mode": 2, **NEARBY, **FRAMES, **REST},
        *(POSE, OTHER, 0.1, 0.2, 0.05, 2, NEAR, "grip", "table", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "move_circle"),
        {"p1": POSE, "p2": OTHER, **LINE, **BLEND, "mode": 2, **NEARBY, **FRAMES, **REST},
        *(POSE, OTHER, 0.1, 0.2, 0.05, 2, NEAR, "grip", "table", False, OP_WIRE, True),
    ),
    motion(
        *("motion", "spline"),
        {"poses": np.array([POSE, OTHER]), **LINE, **FRAMES, **REST, **BLEND},
        *([POSE, OTHER], 0.1, 0.2, "grip", "table", False, OP_WIRE, 0.05, True),
    ),
    motion(
        *("motion", "spline_op"),
        {"points": [PointOp(POSE), PointOp(OTHER, OP)], **LINE, **FRAMES, **REST, **BLEND},
        [rpc.PointOp(POSE, rpc.Op()), rpc.PointOp(OTHER, OP_WIRE)],
        *(0.1, 0.2, "grip", "table", False, OP_WIRE, 0.05, True),
    ),
    motion(
        *("motion", "move_spiral"),
        {"center": POSE, "pose": OTHER, "rev": -2.5, "length": 0.1, "radius": 0.2, "mode": 1}
        | {**LINE, **NEARBY, **FRAMES, **REST},
        *(POSE, OTHER, -2.5, 0.1, 0.2, 1, 0.1, 0.2, NEAR, "grip", "table", False, OP_WIRE, True),
    ),
]
SERVOS = [
    motion(
        *("motion", "servoj", {"joints": HOME, **JOINT, **SERVO}),
        *(HOME, 1.0, 2.0, False, *SERVO_WIRE),
    ),
    motion(
        *("motion", "servoj_pose", {"pose": POSE, **JOINT, **NEARBY, **FRAMES, **SERVO}),
        *(POSE, 1.0, 2.0, NEAR, "grip", "table", False, *SERVO_WIRE),
    ),
    motion(
        *(
            "motion",
            "servo_tcp",
            {"offset": OFFSET, **LINE, "tool": "grip", "frame": "tool", "wobj": "", **SERVO},
        ),
        *(OFFSET, 0.1, 0.2, "grip", False, *SERVO_WIRE),
    ),
    motion(
        *("motion", "servol", {"pose": POSE, **LINE, **NEARBY, **FRAMES, **SERVO}),
        *(POSE, 0.1, 0.2, NEAR, "grip", "table", False, *SERVO_WIRE),
    ),
]
HELD = [
    motion(
        *("motion", "speedj", {"velocities": [0.1, -0.1, 0, 0, 0, 0.2], "a": 2.0, "time": 0.03}),
        *([0.1, -0.1, 0.0, 0.0, 0.0, 0.2], 2.0, 30, False),
    ),
    motion(
        *(
            "motion",
            "speedl",
            {"twist": np.array(OFFSET), "a": 0.5, "time": 0.03, "frame": "tool", "wobj": ""},
        ),
        *(OFFSET, 0.5, 30, False),
    ),
    motion(
        *("motion", "move_jog"),
        {
            "jog": Jog.cartesian("z", -1, 5, frame=JogFrame.TOOL),
            "time": 0.03,
            "directions": JogDirections.MANUAL_4_3,
        },
        rpc.MoveJogTaskParam(1, 1, 2, 5.0, 2, False, 0.0, 0.0),
        False,
    ),
    motion(
        *("external_axes", "move_jog_eaxis"),
        {
            "scheme_name": "rail",
            "direction": -1,
            "vel": 5.0,
            "time": 0.03,
            "directions": JogDirections.MANUAL_3_8,
        },
        *("rail", -1, 5.0, False),
    ),
]
EXTERNAL = [
    motion(
        *("external_axes", "move_eaxis"),
        {"scheme_name": "rail", "epose": [1.5, 0, 0], "v": 0.3, "op": OP},
        *("rail", [1.5, 0.0, 0.0], 0.3, False, OP_WIRE),
    ),
    motion(
        *("external_axes", "movej2_eaxis", {"joints": HOME, **JOINT, **AXES, **BLEND, **REST}),
        *(HOME, 1.0, 2.0, 0.05, *AXES_WIRE, False, OP_WIRE, True),
    ),
    motion(
        *("external_axes", "movej2_pose_eaxis"),
        {"pose": POSE, **JOINT, **AXES, **BLEND, **NEARBY, **FRAMES, **REST},
        *(POSE, 1.0, 2.0, 0.05, NEAR, "grip", "table", *AXES_WIRE, False, OP_WIRE, True),
    ),
    motion(
        *("external_axes", "movel_eaxis"),
        {"pose": POSE, **LINE, **AXES, **BLEND, **NEARBY, **FRAMES, **REST},
        *(POSE, 0.1, 0.2, 0.05, NEAR, "grip", "table", *AXES_WIRE, False, OP_WIRE, True),
    ),
    motion(
        *("external_axes", "movec_eaxis"),
        {"via": POSE, "pose": OTHER, **LINE, **AXES, **BLEND, "mode": 2}
        | {**NEARBY, **FRAMES, **REST},
        *(POSE, OTHER, 0.1, 0.2, 0.05, NEAR, "grip", "table", *AXES_WIRE, False, OP_WIRE, True, 2),
    ),
    motion(
        *("external_axes", "move_circle_eaxis"),
        {"p1": POSE, "p2": OTHER, **LINE, **AXES, **BLEND, "mode": 2}
        | {**NEARBY, **FRAMES, **REST},
        *(POSE, OTHER, 0.1, 0.2, 0.05, 2, NEAR, "grip", "table", *AXES_WIRE),
        *(False, OP_WIRE, True),
    ),
]
OTHERS = [
    motion("program", "run_program", {"name": "palletize"}, "palletize", False),
    motion(
        *("track", "trackJointMotion", {"speed": 1.0, "acc": 4 * math.pi}),
        *(1.0, 4 * math.pi, False),
    ),
    motion(
        *("track", "trackCartMotion", {"speed": 0.1, "acc": 0.2, **FRAMES, "radius": 0.01}),
        *(0.1, 0.2, False, "grip", "table", 0.01),
    ),
]
CASES = [*JOINTS, *LINES, *CURVES, *SERVOS, *HELD, *EXTERNAL, *OTHERS]
