"""The functions as the vendor's Python class has them.

Generated from `aioduco/_wire/rpc.py` and the data of the vendor's class and manual by
`idl/generate_compat.py`; change that, not this. Order and names of the functions, and the order of
arguments, are the wire's; names and defaults of arguments are the class's. What is the same in
both is inherited.
"""

# As in aioduco/_wire/rpc.py: what came over the wire becomes what the IDL says it is.
# mypy: disable-error-code="no-any-return"
# The names of arguments are the vendor's, some of which differ from the wire's on purpose.
# pyright: reportIncompatibleMethodOverride=false

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from aioduco._wire.rpc import Functions, NewerFunctions
from aioduco.compat._arguments import no_fixed_radius

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import Op, PointOp, ReachabilityParam

#: by function what else its arguments are called, by the manual and by other versions of the class
KEYWORDS: Final[dict[str, dict[str, str]]] = {
    "collision_detect": {"level": "value"},
    "fc_config": {
        "num_list": "dead_zone",
        "number_list": "dead_zone",
        "tool": "toolname",
        "wobj": "wobjname",
        "type": "value",
    },
    "fc_guard_act": {"tool": "toolname", "wobj": "wobjname"},
    "fc_wait_ft": {"middle_value": "middle"},
    "fc_wait_logic": {"logic": "value"},
    "fc_wait_pos": {"middle_value": "middle"},
    "fc_wait_vel": {"middle_value": "middle"},
    "get_function_digital_in": {"portnum": "num"},
    "get_function_digital_out": {"portnum": "num"},
    "modbus_set_frequency": {"frequency": "frequence"},
    "move_circle": {"rad": "r", "qnear": "q_near"},
    "move_eaxis": {"vel": "v"},
    "move_jog_eaxis": {"scheme_name": "name"},
    "move_spiral": {"rad": "r", "qnear": "q_near"},
    "movec_eaxis": {"q_near": "qnear", "epos": "epose"},
    "movej2": {"rad": "r"},
    "movej2_eaxis": {"epos": "epose"},
    "movej2_pose_eaxis": {"q_near": "qnear", "epos": "epose"},
    "movel": {"rad": "r"},
    "movel_eaxis": {"q_near": "qnear", "epos": "epose"},
    "replay": {"v": "value"},
    "servoj_pose": {"p": "pose_list", "qnear": "q_near"},
    "set_dynamic_calibration_info": {"info": "version"},
    "set_kinematic_calibration_info": {"info": "version"},
    "set_load_data": {"load": "value"},
    "set_standard_digital_out": {"val": "value"},
    "set_tool_digital_out": {"val": "value"},
    "set_vibration_calibration_info": {"info": "version"},
    "spline": {"p_list": "pose_list"},
    "start_realtime_mode": {"filter_bandwidth": "fileter_bandwidth"},
    "tool_write_raw_data_485_h": {"value": "data"},
    "tool_write_raw_data_485_ht": {"value": "data"},
    "trackEnqueue": {"points": "track"},
    "trackEnqueueOp": {"points": "track"},
    "write_raw_data_485": {"value": "data"},
    "write_raw_data_485_h": {"value": "data"},
    "write_raw_data_485_ht": {"value": "data"},
}


class ManualFunctions(NewerFunctions):
    """Every function of the wire, under its name there and under the manual's."""

    def rpc_heartbeat(self, time: int = 1000) -> None:
        """Report that this client lives; the arm stops if none follows within `time` ms."""
        return self._call("rpc_heartbeat", (time,))

    def movej2(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to `joints_list` rad; v rad/s, a rad/s², r m of blending."""
        return self._call("movej2", (joints_list, v, a, r, block, op, def_acc))

    def movej_pose2(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to the pose p m, rad; v rad/s, a rad/s², r m of blending."""
        return self._call("movej_pose2", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

    def movel(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along a line to the pose p m, rad; v m/s, a m/s², r m of blending."""
        return self._call("movel", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

    def movec(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
        arc_rad: float = 0.0,
    ) -> int:
        """Move the tool along an arc through p1 to p2 m, rad; v m/s, a m/s², r m of blending.

        `arc_rad`, of manual 4.3, is taken as 0, no fixed radius; others cannot be sent: the number of
        its field is not known.
        """
        no_fixed_radius(arc_rad)
        return self._call("movec", (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc))

    def move_circle(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool = True,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along the full circle through p1 and p2; v m/s, a m/s², r m."""
        return self._call(
            "move_circle", (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc)
        )

    def tcp_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by an offset m, rad in the tool's frame; v m/s, a m/s², r m."""
        return self._call("tcp_move", (pose_offset, v, a, r, tool, block, op, def_acc))

    def tcp_move_2p(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by the offset from p1 to p2 in the tool's frame; v m/s, a m/s²."""
        return self._call("tcp_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))

    def wobj_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by an offset m, rad in the work object's frame; v m/s, a m/s²."""
        return self._call("wobj_move", (pose_offset, v, a, r, wobj, block, op, def_acc))

    def wobj_move_2p(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str | None,
        wobj: str | None,
        block: bool = True,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by the offset from p1 to p2 in the work object's frame."""
        return self._call("wobj_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))

    def speedj(
        self, joints_list: Sequence[float], a: float, time: int = -1, block: bool = False
    ) -> int:
        """Turn the joints at `joints_list` rad/s for `time` ms, -1 for no end; a rad/s²."""
        return self._call("speedj", (joints_list, a, time, block))

    def speedl(
        self, pose_list: Sequence[float], a: float, time: int = -1, block: bool = False
    ) -> int:
        """Move the tool at `pose_list` m/s, rad/s in its frame for `time` ms, -1 for no end; a m/s²."""
        return self._call("speedl", (pose_list, a, time, block))

    def spline(
        self,
        pose_list: Sequence[Sequence[float]],
        v: float,
        a: float,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        r: float = 0.0,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along a spline through up to 50 poses m, rad; v m/s, a m/s², r m."""
        return self._call("spline", (pose_list, v, a, tool, wobj, block, op, r, def_acc))

    def spline_op(
        self,
        pose_list: Sequence[PointOp],
        v: float,
        a: float,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        r: float = 0.0,
        def_acc: bool = False,
    ) -> int:
        """Move along a spline of up to 50 poses with triggers at the points; v m/s, a m/s²."""
        return self._call("spline_op", (pose_list, v, a, tool, wobj, block, op, r, def_acc))

    def servoj(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        block: bool = False,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> int:
        """Follow joint targets rad that come one after another; v rad/s, a rad/s²."""
        return self._call("servoj", (joints_list, v, a, block, kp, kd, smooth_vel, smooth_acc))

    def servoj_pose(
        self,
        pose_list: Sequence[float],
        v: float,
        a: float,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool = False,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> int:
        """Follow poses m, rad that come one after another, by the joints; v rad/s, a rad/s²."""
        return self._call(
            "servoj_pose",
            (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc),
        )

    def servo_tcp(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        tool: str | None,
        block: bool = False,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> int:
        """Follow offsets m, rad in the tool's frame that come one after another."""
        return self._call(
            "servo_tcp", (pose_offset, v, a, tool, block, kp, kd, smooth_vel, smooth_acc)
        )

    def servol(
        self,
        pose_list: Sequence[float],
        v: float,
        a: float,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool = False,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> int:
        """Follow poses m, rad that come one after another, by the Cartesian directions."""
        return self._call(
            "servol", (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc)
        )

    def move_spiral(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        rev: float,
        len: float,
        r: float,
        mode: int,
        v: float,
        a: float,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a spiral: `rev` turns, `len` m along the axis, `r` m; v m/s, a m/s²."""
        return self._call(
            "move_spiral", (p1, p2, rev, len, r, mode, v, a, q_near, tool, wobj, block, op, def_acc)
        )

    def set_blend_ahead(self, per: int, num: int = 1) -> int:
        """Read following motions ahead at `per` percent of the path, or `num` of them."""
        return self._call("set_blend_ahead", (per, num))

    def movej(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to `joints_list` rad; v, a and r in percent. Not in the manual."""
        return self._call("movej", (joints_list, v, a, r, block, op, def_acc))

    def movej_pose(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to the pose p m, rad; v, a and r in percent. Not in the manual."""
        return self._call("movej_pose", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

    def set_wobj_offset(self, wobj: Sequence[float], active: bool = True) -> int:
        """Add an offset m, rad to the work object of all following motions, or take it away."""
        return self._call("set_wobj_offset", (wobj, active))

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float] | None,
        tool: Sequence[float] | None,
        wobj: Sequence[float] | None,
    ) -> list[float]:
        """Joints rad for the pose p m, rad, near q_near; empty lists mean the present values."""
        return self._call("cal_ikine", (p, q_near, tool, wobj))

    def cal_fkine(
        self,
        joints_position: Sequence[float],
        tool: Sequence[float] | None,
        wobj: Sequence[float] | None,
    ) -> list[float]:
        """Pose m, rad for joints rad; empty tool and wobj mean the present ones."""
        return self._call("cal_fkine", (joints_position, tool, wobj))

    def get_tcp_pose_coord(self, tool: str | None = "", wobj: str | None = "") -> list[float]:
        """Pose m, rad with the tool and the work object of these names."""
        return self._call("get_tcp_pose_coord", (tool, wobj))

    def get_tcp_force_tool(self, tool: str | None = "") -> list[float]:
        """Force in the frame of the tool of this name, N, N m; needs a force sensor."""
        return self._call("get_tcp_force_tool", (tool,))

    def start_record_track(
        self,
        name: str,
        mode: int,
        tool: str | None,
        wobj: str | None,
        interval: float | None = None,
    ) -> int:
        """Start to record a track: mode 0 each `interval` degrees, 1 each `interval` seconds.

        Without `interval` it is 5.0 [deg] in mode 0 and 0.25 [s] in mode 1, as the manual prints.
        """
        if interval is None:
            interval = 5.0 if mode == 0 else 0.25
        return self._call("start_record_track", (name, mode, tool, wobj, interval))

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float] | None,
        tool: Sequence[float] | None,
        ref_pos: Sequence[float] | None,
        check_points: Sequence[Sequence[float]],
    ) -> ReachabilityParam:
        """Whether poses m, rad can be reached with this base, work object and tool."""
        return self._call("reach_check", (base, wobj, tool, ref_pos, check_points))

    def fc_config(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        damp: Sequence[float],
        max_vel: Sequence[float],
        dead_zone: Sequence[float],
        toolname: str | None,
        wobjname: str | None,
        value: int,
    ) -> int:
        """Set force control: directions, target N, N m, damping, greatest speed, dead band, frame."""
        return self._call(
            "fc_config", (direction, ref_ft, damp, max_vel, dead_zone, toolname, wobjname, value)
        )

    def fc_move(self, block: bool = True) -> int:
        """Move by force control alone.

        Without `block` it returns at the end of its task, as the manual prints it.
        """
        return self._call("fc_move", (block,))

    def fc_guard_act(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        toolname: str | None,
        wobjname: str | None,
        type: int,
        force_property: int = 0,
    ) -> int:
        """Watch the force, N, N m: the arm stops with an alarm when it is exceeded."""
        return self._call(
            "fc_guard_act", (direction, ref_ft, toolname, wobjname, type, force_property)
        )

    def trackCartMotion(
        self,
        speed: float,
        acc: float,
        block: bool,
        tool: str | None,
        wobj: str | None,
        radius: float = 0.005,
    ) -> int:
        """Follow the pool's points as poses; speed m/s, acc m/s², radius m.

        The manual prints `wobj` before `tool`; this is the wire's order: name them.
        """
        return self._call("trackCartMotion", (speed, acc, block, tool, wobj, radius))

    def combine_motion_config(
        self,
        type: int,
        ref_plane: int,
        fq: float,
        amp: float,
        el_offset: float,
        az_offset: float,
        up_height: float,
        time: Sequence[int],
        path_dwell: bool = False,
        op_list: Sequence[Op] | None = None,
    ) -> int:
        """Set the weave that is laid over motions: shape, plane, fq Hz, amp m, dwell ms."""
        return self._call(
            "combine_motion_config",
            (type, ref_plane, fq, amp, el_offset, az_offset, up_height, time, path_dwell, op_list),
        )

    def move_eaxis(
        self,
        scheme_name: str,
        epose: Sequence[float],
        v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move external axes to `epose` rad or m; v rad/s or m/s.

        `def_acc` is taken since the manual prints it; the wire has no place for it.
        """
        return self._call("move_eaxis", (scheme_name, epose, v, block, op))

    def movej2_eaxis(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        rad: float,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """movej2 together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movej2_eaxis",
            (joints_list, v, a, rad, scheme_name, epose, eaxis_v, block, op, def_acc),
        )

    def movej2_pose_eaxis(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        qnear: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """movej_pose2 together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movej2_pose_eaxis",
            (p, v, a, rad, qnear, tool, wobj, scheme_name, epose, eaxis_v, block, op, def_acc),
        )

    def movel_eaxis(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        qnear: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """movel together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movel_eaxis",
            (p, v, a, rad, qnear, tool, wobj, scheme_name, epose, eaxis_v, block, op, def_acc),
        )

    def movec_eaxis(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        rad: float,
        qnear: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
        mode: int = 0,
    ) -> int:
        """movec together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movec_eaxis",
            (
                p1,
                p2,
                v,
                a,
                rad,
                qnear,
                tool,
                wobj,
                scheme_name,
                epose,
                eaxis_v,
                block,
                op,
                def_acc,
                mode,
            ),
        )

    def move_circle_eaxis(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        rad: float,
        mode: int,
        qnear: Sequence[float] | None,
        tool: str | None,
        wobj: str | None,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """move_circle together with external axes. Not in the manual."""
        return self._call(
            "move_circle_eaxis",
            (
                p1,
                p2,
                v,
                a,
                rad,
                mode,
                qnear,
                tool,
                wobj,
                scheme_name,
                epose,
                eaxis_v,
                block,
                op,
                def_acc,
            ),
        )

    def start_realtime_mode(
        self, mode: int, fileter_bandwidth: float = 100.0, com_lost_time: float = 0.02
    ) -> int:
        """Follow the realtime queue; filter Hz, stop without data for com_lost_time s."""
        return self._call("start_realtime_mode", (mode, fileter_bandwidth, com_lost_time))

    def set_servo_config(
        self, axis_num: int, id: int, value: int, qfmt: int, block: bool = False
    ) -> int:
        """Set a parameter of an axis' servo drive. Not in the manual."""
        return self._call("set_servo_config", (axis_num, id, value, qfmt, block))

    def set_dynamic_calibration_info(self, passwd: str, version: str) -> int:
        """Set the notes of the dynamic calibration. Not in the manual."""
        return self._call("set_dynamic_calibration_info", (passwd, version))

    def set_kinematic_calibration_info(self, passwd: str, version: str) -> int:
        """Set the notes of the kinematic calibration. Not in the manual."""
        return self._call("set_kinematic_calibration_info", (passwd, version))

    def set_vibration_calibration_info(self, passwd: str, version: str) -> int:
        """Set the notes of the vibration calibration. Not in the manual."""
        return self._call("set_vibration_calibration_info", (passwd, version))

    # as the manual spells them
    disable_combined_motion: Final = Functions.disable_combine_motion
    enable_combined_motion: Final = Functions.enable_combine_motion
    get_noblock_taskstate: Final = Functions.get_noneblock_taskstate
    get_nonblock_taskstate: Final = Functions.get_noneblock_taskstate
    move1: Final = movel
    move1_eaxis: Final = movel_eaxis
    set_digital_out_mode: Final = Functions.set_digital_output_mode
