"""The functions as the vendor's Python class has them.

Generated from `aioduco/_wire/rpc.py` and the manual's data by `idl/generate_compat.py`; change
that, not this. Order and names of the functions, and the order of arguments, are the wire's; the
names of arguments are the manual's. What is the same in both is inherited.
"""

# As in aioduco/_wire/rpc.py: what came over the wire becomes what the IDL says it is.
# mypy: disable-error-code="no-any-return"
# The names of arguments are the manual's, which differ from the wire's on purpose.
# pyright: reportIncompatibleMethodOverride=false

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from aioduco._wire.rpc import Functions, Op

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import PointOp


class ManualFunctions(Functions):
    """Every function of the wire, under its name there and under the manual's."""

    def movej2(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        rad: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to `joints_list` rad; v rad/s, a rad/s², r m of blending."""
        return self._call("movej2", (joints_list, v, a, rad, block, op or Op(), def_acc))

    def movej_pose2(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to the pose p m, rad; v rad/s, a rad/s², r m of blending."""
        return self._call(
            "movej_pose2", (p, v, a, r, q_near, tool, wobj, block, op or Op(), def_acc)
        )

    def movel(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along a line to the pose p m, rad; v m/s, a m/s², r m of blending."""
        return self._call("movel", (p, v, a, rad, q_near, tool, wobj, block, op or Op(), def_acc))

    def movec(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along an arc through p1 to p2 m, rad; v m/s, a m/s², r m of blending."""
        return self._call(
            "movec", (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op or Op(), def_acc)
        )

    def move_circle(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        rad: float,
        mode: int,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along the full circle through p1 and p2; v m/s, a m/s², r m."""
        return self._call(
            "move_circle", (p1, p2, v, a, rad, mode, qnear, tool, wobj, block, op or Op(), def_acc)
        )

    def tcp_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by an offset m, rad in the tool's frame; v m/s, a m/s², r m."""
        return self._call("tcp_move", (pose_offset, v, a, r, tool, block, op or Op(), def_acc))

    def tcp_move_2p(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by the offset from p1 to p2 in the tool's frame; v m/s, a m/s²."""
        return self._call("tcp_move_2p", (p1, p2, v, a, r, tool, wobj, block, op or Op(), def_acc))

    def wobj_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by an offset m, rad in the work object's frame; v m/s, a m/s²."""
        return self._call("wobj_move", (pose_offset, v, a, r, wobj, block, op or Op(), def_acc))

    def wobj_move_2p(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a line by the offset from p1 to p2 in the work object's frame."""
        return self._call("wobj_move_2p", (p1, p2, v, a, r, tool, wobj, block, op or Op(), def_acc))

    def replay(self, name: str, v: int, mode: int) -> int:
        """Run a recorded track at `value` percent; mode 0 by joints, 1 by poses."""
        return self._call("replay", (name, v, mode))

    def spline(
        self,
        p_list: Sequence[Sequence[float]],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        r: float = 0.0,
        def_acc: bool = False,
    ) -> int:
        """Move the tool along a spline through up to 50 poses m, rad; v m/s, a m/s², r m."""
        return self._call("spline", (p_list, v, a, tool, wobj, block, op or Op(), r, def_acc))

    def spline_op(
        self,
        pose_list: Sequence[PointOp],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        r: float = 0.0,
        def_acc: bool = False,
    ) -> int:
        """Move along a spline of up to 50 poses with triggers at the points; v m/s, a m/s²."""
        return self._call("spline_op", (pose_list, v, a, tool, wobj, block, op or Op(), r, def_acc))

    def servoj(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        block: bool,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> int:
        """Follow joint targets rad that come one after another; v rad/s, a rad/s²."""
        return self._call("servoj", (joints_list, v, a, block, kp, kd, smooth_vel, smooth_acc))

    def servoj_pose(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        kp: float = 200.0,
        kd: float = 25.0,
        smooth_vel: float = 10.0,
        smooth_acc: float = 1.0,
    ) -> int:
        """Follow poses m, rad that come one after another, by the joints; v rad/s, a rad/s²."""
        return self._call(
            "servoj_pose", (p, v, a, qnear, tool, wobj, block, kp, kd, smooth_vel, smooth_acc)
        )

    def servo_tcp(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        tool: str,
        block: bool,
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
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
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
        rad: float,
        mode: int,
        v: float,
        a: float,
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move along a spiral: `rev` turns, `len` m along the axis, `r` m; v m/s, a m/s²."""
        return self._call(
            "move_spiral",
            (p1, p2, rev, len, rad, mode, v, a, qnear, tool, wobj, block, op or Op(), def_acc),
        )

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
        """Move the joints to `joints_list` rad; v and a in percent. Not in the manual."""
        return self._call("movej", (joints_list, v, a, r, block, op or Op(), def_acc))

    def movej_pose(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """Move the joints to the pose p m, rad; v and a in percent. Not in the manual."""
        return self._call(
            "movej_pose", (p, v, a, r, q_near, tool, wobj, block, op or Op(), def_acc)
        )

    def write_raw_data_485(self, value: Sequence[int]) -> bool:
        """Write bytes to RS-485."""
        return self._call("write_raw_data_485", (value,))

    def write_raw_data_485_h(self, value: Sequence[int], head: Sequence[int]) -> bool:
        """Write `head` and bytes to RS-485."""
        return self._call("write_raw_data_485_h", (value, head))

    def write_raw_data_485_ht(
        self, value: Sequence[int], head: Sequence[int], tail: Sequence[int]
    ) -> bool:
        """Write `head`, bytes and `tail` to RS-485."""
        return self._call("write_raw_data_485_ht", (value, head, tail))

    def tool_write_raw_data_485_h(self, value: Sequence[int], head: Sequence[int]) -> bool:
        """Write `head` and bytes to the tool's RS-485."""
        return self._call("tool_write_raw_data_485_h", (value, head))

    def tool_write_raw_data_485_ht(
        self, value: Sequence[int], head: Sequence[int], tail: Sequence[int]
    ) -> bool:
        """Write `head`, bytes and `tail` to the tool's RS-485."""
        return self._call("tool_write_raw_data_485_ht", (value, head, tail))

    def set_standard_digital_out(self, num: int, val: bool, block: bool) -> int:
        """Set cabinet output 1 to 16."""
        return self._call("set_standard_digital_out", (num, val, block))

    def set_tool_digital_out(self, num: int, val: bool, block: bool) -> int:
        """Set tool output 1 or 2."""
        return self._call("set_tool_digital_out", (num, val, block))

    def get_function_digital_in(self, portnum: int) -> bool:
        """Level of function input 1 to 8."""
        return self._call("get_function_digital_in", (portnum,))

    def get_function_digital_out(self, portnum: int) -> bool:
        """Level of function output 1 to 8."""
        return self._call("get_function_digital_out", (portnum,))

    def set_load_data(self, load: Sequence[float]) -> int:
        """Set the mass kg and centre m of what the tool holds."""
        return self._call("set_load_data", (load,))

    def start_record_track(
        self, name: str, mode: int, tool: str, wobj: str, interval: float | None = None
    ) -> int:
        """Start to record a track: mode 0 each `interval` degrees, 1 each `interval` seconds.

        Without `interval` it is 5.0 [deg] in mode 0 and 0.5 [s] in mode 1, as the vendor has it.
        """
        if interval is None:
            interval = 5.0 if mode == 0 else 0.5
        return self._call("start_record_track", (name, mode, tool, wobj, interval))

    def collision_detect(self, level: int) -> int:
        """Set the level of collision detection, 0 off, 1 to 5."""
        return self._call("collision_detect", (level,))

    def modbus_set_frequency(self, signal_name: str, frequency: int) -> None:
        """Set how often a Modbus signal is refreshed, 1 to 100 Hz."""
        return self._call("modbus_set_frequency", (signal_name, frequency))

    def fc_config(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        damp: Sequence[float],
        max_vel: Sequence[float],
        number_list: Sequence[float],
        tool: str,
        wobj: str,
        type: int,
    ) -> int:
        """Set force control: directions, target N, N m, damping, greatest speed, dead band, frame."""
        return self._call(
            "fc_config", (direction, ref_ft, damp, max_vel, number_list, tool, wobj, type)
        )

    def fc_move(self, block: bool = False) -> int:
        """Move by force control alone."""
        return self._call("fc_move", (block,))

    def fc_wait_pos(
        self,
        middle_value: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a position m, rad held for `duration` ms; give up after `timeout` ms."""
        return self._call("fc_wait_pos", (middle_value, range, absolute, duration, timeout))

    def fc_wait_vel(
        self,
        middle_value: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a speed m/s, rad/s held for `duration` ms; give up after `timeout` ms."""
        return self._call("fc_wait_vel", (middle_value, range, absolute, duration, timeout))

    def fc_wait_ft(
        self,
        middle_value: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a force N, N m held for `duration` ms; give up after `timeout` ms."""
        return self._call("fc_wait_ft", (middle_value, range, absolute, duration, timeout))

    def fc_wait_logic(self, logic: Sequence[int]) -> int:
        """Combine the conditions position, speed, force: 0 off, 1 and, 2 or. Resets them."""
        return self._call("fc_wait_logic", (logic,))

    def trackEnqueue(self, points: Sequence[Sequence[float]], block: bool) -> int:
        """Put points, joints rad or poses m, rad, into the pool of 1000. -1 if it is full."""
        return self._call("trackEnqueue", (points, block))

    def trackCartMotion(
        self, speed: float, acc: float, block: bool, tool: str, wobj: str, radius: float = 0.005
    ) -> int:
        """Follow the pool's points as poses; speed m/s, acc m/s², radius m.

        The manual prints `wobj` before `tool`; this is the wire's order: name them.
        """
        return self._call("trackCartMotion", (speed, acc, block, tool, wobj, radius))

    def trackEnqueueOp(self, points: Sequence[PointOp], block: bool) -> int:
        """Put points with triggers into the pool of 1000. -1 if it is full."""
        return self._call("trackEnqueueOp", (points, block))

    def move_eaxis(
        self,
        scheme_name: str,
        epose: Sequence[float],
        vel: float,
        block: bool,
        op: Op | None = None,
    ) -> int:
        """Move external axes to `epose` rad or m; v rad/s or m/s."""
        return self._call("move_eaxis", (scheme_name, epose, vel, block, op or Op()))

    def move_jog_eaxis(self, scheme_name: str, direction: int, vel: float, block: bool) -> int:
        """Jog an external axis, direction -1 or 1, at `vel` percent."""
        return self._call("move_jog_eaxis", (scheme_name, direction, vel, block))

    def movej2_eaxis(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        rad: float,
        scheme_name: str,
        epos: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """movej2 together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movej2_eaxis",
            (joints_list, v, a, rad, scheme_name, epos, eaxis_v, block, op or Op(), def_acc),
        )

    def movej2_pose_eaxis(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epos: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """movej_pose2 together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movej2_pose_eaxis",
            (
                p,
                v,
                a,
                rad,
                q_near,
                tool,
                wobj,
                scheme_name,
                epos,
                eaxis_v,
                block,
                op or Op(),
                def_acc,
            ),
        )

    def movel_eaxis(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        rad: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epos: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op | None = None,
        def_acc: bool = False,
    ) -> int:
        """movel together with external axes: epose rad or m, eaxis_v rad/s or m/s."""
        return self._call(
            "movel_eaxis",
            (
                p,
                v,
                a,
                rad,
                q_near,
                tool,
                wobj,
                scheme_name,
                epos,
                eaxis_v,
                block,
                op or Op(),
                def_acc,
            ),
        )

    def movec_eaxis(
        self,
        p1: Sequence[float],
        p2: Sequence[float],
        v: float,
        a: float,
        rad: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epos: Sequence[float],
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
                q_near,
                tool,
                wobj,
                scheme_name,
                epos,
                eaxis_v,
                block,
                op or Op(),
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
        qnear: Sequence[float],
        tool: str,
        wobj: str,
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
                op or Op(),
                def_acc,
            ),
        )

    def start_realtime_mode(self, mode: int, filter_bandwidth: float, com_lost_time: float) -> int:
        """Follow the realtime queue; filter Hz, stop without data for com_lost_time s."""
        return self._call("start_realtime_mode", (mode, filter_bandwidth, com_lost_time))

    # as the manual spells them
    disable_combined_motion: Final = Functions.disable_combine_motion
    enable_combined_motion: Final = Functions.enable_combine_motion
    get_noblock_taskstate: Final = Functions.get_noneblock_taskstate
    get_nonblock_taskstate: Final = Functions.get_noneblock_taskstate
    move1: Final = movel
    move1_eaxis: Final = movel_eaxis
    set_digital_out_mode: Final = Functions.set_digital_output_mode
