"""The functions as the vendor's Python class has them.

Generated from `aioduco/_wire/rpc.py` and the manual's data by `idl/generate_compat.py`; change
that, not this. Order and names of the functions, and the order of arguments, are the wire's; the
names of arguments are the manual's.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

from aioduco._wire.rpc import Op

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import (
        EAxisParam,
        EAxisSchemeParam,
        EAxissInfo,
        IOStatus,
        MoveJogTaskParam,
        PointOp,
        ReachabilityParam,
        RealTimeControlData,
        RobotStatus,
    )


class Functions(ABC):
    """Every function of the wire, under its name there and under the manual's."""

    @abstractmethod
    def _number(self, name: str, args: tuple[Any, ...]) -> int:
        """Call a function whose answer is a number: -1 if the connection is lost."""

    @abstractmethod
    def _value(self, name: str, args: tuple[Any, ...]) -> Any:
        """Call a function whose answer is something else."""

    def rpc_heartbeat(self, time: int) -> None:
        """Report that this client lives; the arm stops if none follows within `time` ms."""
        self._value("rpc_heartbeat", (time,))

    def power_on(self, block: bool) -> int:
        """Power the arm on. Returns the task's end state if `block`, else its id."""
        return self._number("power_on", (block,))

    def power_off(self, block: bool) -> int:
        """Power the arm off. Returns the task's end state if `block`, else its id."""
        return self._number("power_off", (block,))

    def enable(self, block: bool) -> int:
        """Enable the servos. Returns the task's end state if `block`, else its id."""
        return self._number("enable", (block,))

    def disable(self, block: bool) -> int:
        """Disable the servos. Returns the task's end state if `block`, else its id."""
        return self._number("disable", (block,))

    def shutdown(self, block: bool) -> int:
        """Shut the controller down. Returns the task's end state if `block`, else its id."""
        return self._number("shutdown", (block,))

    def restart(self, block: bool) -> int:
        """Restart the controller. Returns the task's end state if `block`, else its id."""
        return self._number("restart", (block,))

    def stop(self, block: bool) -> int:
        """Stop all tasks. Returns the end state if `block`, else a task id."""
        return self._number("stop", (block,))

    def pause(self, block: bool) -> int:
        """Pause all tasks. Returns the end state if `block`, else a task id."""
        return self._number("pause", (block,))

    def resume(self, block: bool) -> int:
        """Resume all paused tasks. Returns the end state if `block`, else a task id."""
        return self._number("resume", (block,))

    def abort(self, block: bool) -> int:
        """End the running motion and those read ahead. Not in manual 3.8, in 4.3."""
        return self._number("abort", (block,))

    def run_program(self, name: str, block: bool) -> int:
        """Run a program of the controller by name. Returns end state or task id."""
        return self._number("run_program", (name, block))

    def get_current_project(self) -> str:
        """Path of the project that is loaded."""
        answer: str = self._value("get_current_project", ())
        return answer

    def get_files_list(self, path: str) -> dict[str, int]:
        """Files below `path`: name to kind, 0 a folder, 1 a file."""
        answer: dict[str, int] = self._value("get_files_list", (path,))
        return answer

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
        return self._number("movej2", (joints_list, v, a, rad, block, op or Op(), def_acc))

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
        return self._number(
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
        return self._number("movel", (p, v, a, rad, q_near, tool, wobj, block, op or Op(), def_acc))

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
        return self._number(
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
        return self._number(
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
        return self._number("tcp_move", (pose_offset, v, a, r, tool, block, op or Op(), def_acc))

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
        return self._number(
            "tcp_move_2p", (p1, p2, v, a, r, tool, wobj, block, op or Op(), def_acc)
        )

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
        return self._number("wobj_move", (pose_offset, v, a, r, wobj, block, op or Op(), def_acc))

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
        return self._number(
            "wobj_move_2p", (p1, p2, v, a, r, tool, wobj, block, op or Op(), def_acc)
        )

    def speedj(self, joints_list: Sequence[float], a: float, time: int, block: bool) -> int:
        """Turn the joints at `joints_list` rad/s for `time` ms, -1 for no end; a rad/s²."""
        return self._number("speedj", (joints_list, a, time, block))

    def speedl(self, pose_list: Sequence[float], a: float, time: int, block: bool) -> int:
        """Move the tool at `pose_list` m/s, rad/s for `time` ms, -1 for no end; a m/s²."""
        return self._number("speedl", (pose_list, a, time, block))

    def speed_stop(self, block: bool) -> int:
        """End speedj and speedl."""
        return self._number("speed_stop", (block,))

    def teach_mode(self, block: bool) -> int:
        """Enter hand guiding."""
        return self._number("teach_mode", (block,))

    def end_teach_mode(self, block: bool) -> int:
        """Leave hand guiding."""
        return self._number("end_teach_mode", (block,))

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: Sequence[int],
        cart_scale: Sequence[int],
        coord_type: int,
        direction: Sequence[bool],
    ) -> int:
        """Set hand guiding: space, compliance of joints or of x to rz, frame, directions."""
        return self._number(
            "set_hand_teach_parameter", (space, joint_scale, cart_scale, coord_type, direction)
        )

    def replay(self, name: str, v: int, mode: int) -> int:
        """Run a recorded track at `value` percent; mode 0 by joints, 1 by poses."""
        return self._number("replay", (name, v, mode))

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
        return self._number("spline", (p_list, v, a, tool, wobj, block, op or Op(), r, def_acc))

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
        return self._number(
            "spline_op", (pose_list, v, a, tool, wobj, block, op or Op(), r, def_acc)
        )

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
        return self._number("servoj", (joints_list, v, a, block, kp, kd, smooth_vel, smooth_acc))

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
        return self._number(
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
        """Follow offsets m, rad of the tool that come one after another."""
        return self._number(
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
        return self._number(
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
        return self._number(
            "move_spiral",
            (p1, p2, rev, len, rad, mode, v, a, qnear, tool, wobj, block, op or Op(), def_acc),
        )

    def move_jog(self, param: MoveJogTaskParam, block: bool) -> int:
        """Jog one joint or one Cartesian direction, continuously or by a step."""
        return self._number("move_jog", (param, block))

    def stop_manual_move(self, block: bool) -> int:
        """End move_jog."""
        return self._number("stop_manual_move", (block,))

    def set_blend_ahead(self, per: int, num: int) -> int:
        """Read following motions ahead at `per` percent of the path, or `num` of them."""
        return self._number("set_blend_ahead", (per, num))

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
        return self._number("movej", (joints_list, v, a, r, block, op or Op(), def_acc))

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
        return self._number(
            "movej_pose", (p, v, a, r, q_near, tool, wobj, block, op or Op(), def_acc)
        )

    def set_baudrate_485(self, value: int, block: bool) -> int:
        """Set the rate of the cabinet's RS-485 port, bit/s."""
        return self._number("set_baudrate_485", (value, block))

    def read_raw_data_485(self, len: int) -> list[int]:
        """Read `len` bytes from RS-485; empty if there is nothing."""
        answer: list[int] = self._value("read_raw_data_485", (len,))
        return answer

    def read_raw_data_485_h(self, head: Sequence[int], len: int) -> list[int]:
        """Read a frame of `len` bytes that starts with `head` from RS-485."""
        answer: list[int] = self._value("read_raw_data_485_h", (head, len))
        return answer

    def read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> list[int]:
        """Read a frame from `head` to `tail` from RS-485."""
        answer: list[int] = self._value("read_raw_data_485_ht", (head, tail))
        return answer

    def write_raw_data_485(self, value: Sequence[int]) -> bool:
        """Write bytes to RS-485."""
        answer: bool = self._value("write_raw_data_485", (value,))
        return answer

    def write_raw_data_485_h(self, value: Sequence[int], head: Sequence[int]) -> bool:
        """Write `head` and bytes to RS-485."""
        answer: bool = self._value("write_raw_data_485_h", (value, head))
        return answer

    def write_raw_data_485_ht(
        self, value: Sequence[int], head: Sequence[int], tail: Sequence[int]
    ) -> bool:
        """Write `head`, bytes and `tail` to RS-485."""
        answer: bool = self._value("write_raw_data_485_ht", (value, head, tail))
        return answer

    def read_data_485(self) -> list[int]:
        """Read from RS-485. Not in the manual."""
        answer: list[int] = self._value("read_data_485", ())
        return answer

    def write_data_485(self, data: Sequence[int]) -> bool:
        """Write to RS-485. Not in the manual."""
        answer: bool = self._value("write_data_485", (data,))
        return answer

    def tool_read_raw_data_485(self, len: int) -> list[int]:
        """Read `len` bytes from the tool's RS-485; empty if there is nothing."""
        answer: list[int] = self._value("tool_read_raw_data_485", (len,))
        return answer

    def tool_read_raw_data_485_h(self, head: Sequence[int], len: int) -> list[int]:
        """Read a frame of `len` bytes that starts with `head` from the tool's RS-485."""
        answer: list[int] = self._value("tool_read_raw_data_485_h", (head, len))
        return answer

    def tool_read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> list[int]:
        """Read a frame from `head` to `tail` from the tool's RS-485."""
        answer: list[int] = self._value("tool_read_raw_data_485_ht", (head, tail))
        return answer

    def tool_write_raw_data_485(self, data: Sequence[int]) -> bool:
        """Write bytes to the tool's RS-485."""
        answer: bool = self._value("tool_write_raw_data_485", (data,))
        return answer

    def tool_write_raw_data_485_h(self, value: Sequence[int], head: Sequence[int]) -> bool:
        """Write `head` and bytes to the tool's RS-485."""
        answer: bool = self._value("tool_write_raw_data_485_h", (value, head))
        return answer

    def tool_write_raw_data_485_ht(
        self, value: Sequence[int], head: Sequence[int], tail: Sequence[int]
    ) -> bool:
        """Write `head`, bytes and `tail` to the tool's RS-485."""
        answer: bool = self._value("tool_write_raw_data_485_ht", (value, head, tail))
        return answer

    def tool_read_data_485(self) -> list[int]:
        """Read from the tool's RS-485. Not in the manual."""
        answer: list[int] = self._value("tool_read_data_485", ())
        return answer

    def tool_write_data_485(self, data: Sequence[int]) -> bool:
        """Write to the tool's RS-485. Not in the manual."""
        answer: bool = self._value("tool_write_data_485", (data,))
        return answer

    def set_baudrate_can(self, value: int, block: bool) -> int:
        """Set the rate of the CAN bus, bit/s."""
        return self._number("set_baudrate_can", (value, block))

    def read_raw_data_can(self) -> list[int]:
        """Read one CAN frame: the sender's id, then the bytes; empty if there is none."""
        answer: list[int] = self._value("read_raw_data_can", ())
        return answer

    def write_raw_data_can(self, id: int, data: Sequence[int]) -> bool:
        """Write one CAN frame."""
        answer: bool = self._value("write_raw_data_can", (id, data))
        return answer

    def read_data_can(self) -> list[int]:
        """Read from CAN. Not in the manual."""
        answer: list[int] = self._value("read_data_can", ())
        return answer

    def write_data_can(self, id: int, data: Sequence[int]) -> bool:
        """Write to CAN. Not in the manual."""
        answer: bool = self._value("write_data_can", (id, data))
        return answer

    def set_digital_output_mode(self, num: int, type: int, freq: int, duty_cycle: int) -> int:
        """Make a cabinet output a level (type 0) or pulses (1) at freq Hz, duty_cycle percent."""
        return self._number("set_digital_output_mode", (num, type, freq, duty_cycle))

    def set_standard_digital_out(self, num: int, val: bool, block: bool) -> int:
        """Set cabinet output 1 to 16."""
        return self._number("set_standard_digital_out", (num, val, block))

    def get_standard_digital_out(self, num: int) -> bool:
        """Level of cabinet output 1 to 16."""
        answer: bool = self._value("get_standard_digital_out", (num,))
        return answer

    def get_standard_digital_in(self, num: int) -> bool:
        """Level of cabinet input 1 to 16."""
        answer: bool = self._value("get_standard_digital_in", (num,))
        return answer

    def set_tool_digital_out(self, num: int, val: bool, block: bool) -> int:
        """Set tool output 1 or 2."""
        return self._number("set_tool_digital_out", (num, val, block))

    def get_tool_digital_out(self, num: int) -> bool:
        """Level of tool output 1 or 2."""
        answer: bool = self._value("get_tool_digital_out", (num,))
        return answer

    def get_tool_digital_in(self, num: int) -> bool:
        """Level of tool input 1 or 2."""
        answer: bool = self._value("get_tool_digital_in", (num,))
        return answer

    def get_config_digital_in(self, num: int) -> bool:
        """Level of a configurable cabinet input. Not in the manual."""
        answer: bool = self._value("get_config_digital_in", (num,))
        return answer

    def get_function_digital_in(self, portnum: int) -> bool:
        """Level of function input 1 to 8."""
        answer: bool = self._value("get_function_digital_in", (portnum,))
        return answer

    def get_function_digital_out(self, portnum: int) -> bool:
        """Level of function output 1 to 8."""
        answer: bool = self._value("get_function_digital_out", (portnum,))
        return answer

    def get_standard_analog_voltage_in(self, num: int) -> float:
        """Voltage at cabinet channel 1 to 4, V."""
        answer: float = self._value("get_standard_analog_voltage_in", (num,))
        return answer

    def set_standard_analog_voltage_out(self, num: int, value: float, block: bool) -> int:
        """Set the voltage of cabinet channel 1 to 4, 0 to 10 V."""
        return self._number("set_standard_analog_voltage_out", (num, value, block))

    def get_tool_analog_voltage_in(self, num: int) -> float:
        """Voltage at tool channel 1 or 2, V."""
        answer: float = self._value("get_tool_analog_voltage_in", (num,))
        return answer

    def get_standard_analog_current_in(self, num: int) -> float:
        """Current at cabinet channel 1 to 4, mA."""
        answer: float = self._value("get_standard_analog_current_in", (num,))
        return answer

    def set_standard_analog_current_out(self, num: int, value: float, block: bool) -> int:
        """Set the current of cabinet channel 1 to 4, 4 to 20 mA."""
        return self._number("set_standard_analog_current_out", (num, value, block))

    def set_analog_output_mode(self, num: int, mode: int, block: bool) -> int:
        """Set the kind of an analog output. Not in the manual."""
        return self._number("set_analog_output_mode", (num, mode, block))

    def write_bool_reg(self, num: int, value: bool) -> int:
        """Write bool register 1 to 64."""
        return self._number("write_bool_reg", (num, value))

    def write_word_reg(self, num: int, value: int) -> int:
        """Write word register 1 to 32."""
        return self._number("write_word_reg", (num, value))

    def write_float_reg(self, num: int, value: float) -> int:
        """Write float register 1 to 32."""
        return self._number("write_float_reg", (num, value))

    def read_bool_reg(self, num: int) -> bool:
        """Read bool register 1 to 64."""
        answer: bool = self._value("read_bool_reg", (num,))
        return answer

    def read_word_reg(self, num: int) -> int:
        """Read word register 1 to 32."""
        return self._number("read_word_reg", (num,))

    def read_float_reg(self, num: int) -> float:
        """Read float register 1 to 32."""
        answer: float = self._value("read_float_reg", (num,))
        return answer

    def get_function_reg_in(self, num: int) -> bool:
        """Read function input register 1 to 16."""
        answer: bool = self._value("get_function_reg_in", (num,))
        return answer

    def get_function_reg_out(self, num: int) -> bool:
        """Read function output register 1 to 16."""
        answer: bool = self._value("get_function_reg_out", (num,))
        return answer

    def set_wobj_offset(self, wobj: Sequence[float], active: bool) -> int:
        """Add an offset m, rad to the work object of all following motions, or take it away."""
        return self._number("set_wobj_offset", (wobj, active))

    def set_wobj(self, name: str, wobj: Sequence[float]) -> int:
        """Set a work object by name, m, rad. Not in the manual."""
        return self._number("set_wobj", (name, wobj))

    def set_tool_data(
        self,
        name: str,
        tool_offset: Sequence[float],
        payload: Sequence[float],
        inertia_tensor: Sequence[float],
    ) -> int:
        """Set a tool: offset m, rad from the flange, payload kg, m, inertia kg m²."""
        return self._number("set_tool_data", (name, tool_offset, payload, inertia_tensor))

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """Joints rad for the pose p m, rad, near q_near; empty lists mean the present values."""
        answer: list[float] = self._value("cal_ikine", (p, q_near, tool, wobj))
        return answer

    def cal_fkine(
        self, joints_position: Sequence[float], tool: Sequence[float], wobj: Sequence[float]
    ) -> list[float]:
        """Pose m, rad for joints rad; empty tool and wobj mean the present ones."""
        answer: list[float] = self._value("cal_fkine", (joints_position, tool, wobj))
        return answer

    def get_tcp_pose(self) -> list[float]:
        """Pose of the tool in the base frame, m, rad."""
        answer: list[float] = self._value("get_tcp_pose", ())
        return answer

    def get_tcp_pose_coord(self, tool: str, wobj: str) -> list[float]:
        """Pose m, rad with the tool and the work object of these names."""
        answer: list[float] = self._value("get_tcp_pose_coord", (tool, wobj))
        return answer

    def get_tcp_speed(self) -> list[float]:
        """Speed of the tool's origin, m/s, rad/s."""
        answer: list[float] = self._value("get_tcp_speed", ())
        return answer

    def get_tcp_acceleration(self) -> list[float]:
        """Acceleration of the tool's origin, m/s², rad/s²."""
        answer: list[float] = self._value("get_tcp_acceleration", ())
        return answer

    def get_tcp_force(self) -> list[float]:
        """Force at the tool's origin, N, N m; needs a force sensor."""
        answer: list[float] = self._value("get_tcp_force", ())
        return answer

    def get_tcp_force_tool(self, tool: str) -> list[float]:
        """Force in the frame of the tool of this name, N, N m; needs a force sensor."""
        answer: list[float] = self._value("get_tcp_force_tool", (tool,))
        return answer

    def get_tcp_offset(self) -> list[float]:
        """Offset of the present tool from the flange, m, rad."""
        answer: list[float] = self._value("get_tcp_offset", ())
        return answer

    def get_tool_load(self) -> list[float]:
        """Mass and centre of mass of the present tool, kg, m."""
        answer: list[float] = self._value("get_tool_load", ())
        return answer

    def get_wobj(self) -> list[float]:
        """The present work object in the base frame, m, rad."""
        answer: list[float] = self._value("get_wobj", ())
        return answer

    def get_actual_joints_position(self) -> list[float]:
        """Measured joint positions, rad."""
        answer: list[float] = self._value("get_actual_joints_position", ())
        return answer

    def get_target_joints_position(self) -> list[float]:
        """Planned joint positions, rad."""
        answer: list[float] = self._value("get_target_joints_position", ())
        return answer

    def get_actual_joints_speed(self) -> list[float]:
        """Measured joint speeds, rad/s."""
        answer: list[float] = self._value("get_actual_joints_speed", ())
        return answer

    def get_target_joints_speed(self) -> list[float]:
        """Planned joint speeds, rad/s."""
        answer: list[float] = self._value("get_target_joints_speed", ())
        return answer

    def get_actual_joints_acceleration(self) -> list[float]:
        """Measured joint accelerations, rad/s²."""
        answer: list[float] = self._value("get_actual_joints_acceleration", ())
        return answer

    def get_target_joints_acceleration(self) -> list[float]:
        """Planned joint accelerations, rad/s²."""
        answer: list[float] = self._value("get_target_joints_acceleration", ())
        return answer

    def get_actual_joints_torque(self) -> list[float]:
        """Measured joint torques, N m."""
        answer: list[float] = self._value("get_actual_joints_torque", ())
        return answer

    def get_target_joints_torque(self) -> list[float]:
        """Planned joint torques, N m; the manual's text says rad/s²."""
        answer: list[float] = self._value("get_target_joints_torque", ())
        return answer

    def get_flange_pose(self) -> list[float]:
        """Pose of the flange in the base frame, m, rad."""
        answer: list[float] = self._value("get_flange_pose", ())
        return answer

    def get_flange_speed(self) -> list[float]:
        """Speed of the flange in the base frame, m/s, rad/s."""
        answer: list[float] = self._value("get_flange_speed", ())
        return answer

    def get_flange_acceleration(self) -> list[float]:
        """Acceleration of the flange in the base frame, m/s², rad/s²."""
        answer: list[float] = self._value("get_flange_acceleration", ())
        return answer

    def get_robot_state(self) -> list[int]:
        """Four states: robot, program, safety controller, operation mode."""
        answer: list[int] = self._value("get_robot_state", ())
        return answer

    def simulation(self, sim: bool, block: bool) -> int:
        """Switch between simulation and the real arm; the arm must stand."""
        return self._number("simulation", (sim, block))

    def speed(self, val: float) -> int:
        """Set the global speed, 1 to 100 percent."""
        return self._number("speed", (val,))

    def set_load_data(self, load: Sequence[float]) -> int:
        """Set the mass kg and centre m of what the tool holds."""
        return self._number("set_load_data", (load,))

    def start_record_track(
        self, name: str, mode: int, tool: str, wobj: str, interval: float | None = None
    ) -> int:
        """Start to record a track: mode 0 each `interval` degrees, 1 each `interval` seconds.

        Without `interval` it is 5.0 [deg] in mode 0 and 0.5 [s] in mode 1, as the vendor has it.
        """
        if interval is None:
            interval = 5.0 if mode == 0 else 0.5
        return self._number("start_record_track", (name, mode, tool, wobj, interval))

    def stop_record_track(self) -> int:
        """End the record of a track."""
        return self._number("stop_record_track", ())

    def collision_detect(self, level: int) -> int:
        """Set the level of collision detection, 0 off, 1 to 5."""
        return self._number("collision_detect", (level,))

    def collision_detection_reset(self) -> int:
        """Clear the collision warning."""
        return self._number("collision_detection_reset", ())

    def set_teach_pendant(self, enable: bool) -> int:
        """Turn the keys of the pendant on or off."""
        return self._number("set_teach_pendant", (enable,))

    def set_teach_speed(self, v: int) -> int:
        """Set the teaching speed, 1 to 100 percent."""
        return self._number("set_teach_speed", (v,))

    def get_teach_speed(self) -> int:
        """Teaching speed, percent."""
        return self._number("get_teach_speed", ())

    def get_global_speed(self) -> int:
        """Global speed, percent."""
        return self._number("get_global_speed", ())

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> ReachabilityParam:
        """Whether poses m, rad can be reached with this base, work object and tool."""
        answer: ReachabilityParam = self._value(
            "reach_check", (base, wobj, tool, ref_pos, check_points)
        )
        return answer

    def switch_mode(self, mode: int) -> int:
        """Switch to manual (0) or automatic (1) operation."""
        return self._number("switch_mode", (mode,))

    def getRobotStatus(self) -> RobotStatus:
        """The arm's positions, speeds, currents, temperatures and errors at once."""
        answer: RobotStatus = self._value("getRobotStatus", ())
        return answer

    def getRobotIOStatus(self) -> IOStatus:
        """All inputs, outputs and registers at once."""
        answer: IOStatus = self._value("getRobotIOStatus", ())
        return answer

    def read_encoder_count(self) -> int:
        """Count of the external incremental encoder."""
        answer: int = self._value("read_encoder_count", ())
        return answer

    def get_origin_DH(self) -> list[list[float]]:
        """DH parameters of the model: a m, alpha rad, d m, theta rad per joint."""
        answer: list[list[float]] = self._value("get_origin_DH", ())
        return answer

    def get_calib_DH(self) -> list[list[float]]:
        """DH parameters after calibration: a m, alpha rad, d m, theta rad per joint."""
        answer: list[list[float]] = self._value("get_calib_DH", ())
        return answer

    def get_robot_type(self) -> list[str]:
        """Series, model, extension and serial number."""
        answer: list[str] = self._value("get_robot_type", ())
        return answer

    def get_ext_torque(self) -> list[float]:
        """Observed external joint torques."""
        answer: list[float] = self._value("get_ext_torque", ())
        return answer

    def set_system_value_bool(self, name: str, value: bool) -> int:
        """Set a global variable of type bool."""
        return self._number("set_system_value_bool", (name, value))

    def set_system_value_double(self, name: str, value: float) -> int:
        """Set a global variable of type number."""
        return self._number("set_system_value_double", (name, value))

    def set_system_value_str(self, name: str, value: str) -> int:
        """Set a global variable of type string."""
        return self._number("set_system_value_str", (name, value))

    def set_system_value_list(self, name: str, value: Sequence[float]) -> int:
        """Set a global variable of type list of numbers."""
        return self._number("set_system_value_list", (name, value))

    def get_system_value_bool(self, name: str) -> bool:
        """Read a global variable of type bool."""
        answer: bool = self._value("get_system_value_bool", (name,))
        return answer

    def get_system_value_double(self, name: str) -> float:
        """Read a global variable of type number."""
        answer: float = self._value("get_system_value_double", (name,))
        return answer

    def get_system_value_str(self, name: str) -> str:
        """Read a global variable of type string."""
        answer: str = self._value("get_system_value_str", (name,))
        return answer

    def get_system_value_list(self, name: str) -> list[float]:
        """Read a global variable of type list of numbers."""
        answer: list[float] = self._value("get_system_value_list", (name,))
        return answer

    def get_system_value_lists(self, name: str) -> list[list[float]]:
        """Read a global variable of type list of poses. Not in manual 3.8, in 4.3."""
        answer: list[list[float]] = self._value("get_system_value_lists", (name,))
        return answer

    def log_info(self, message: str) -> None:
        """Write a line into the controller's log."""
        self._value("log_info", (message,))

    def log_error(self, message: str) -> None:
        """Show an error on the pendant and pause all tasks."""
        self._value("log_error", (message,))

    def get_last_error(self) -> list[str]:
        """The latest errors."""
        answer: list[str] = self._value("get_last_error", ())
        return answer

    def get_noneblock_taskstate(self, id: int) -> int:
        """State of a task by its id."""
        return self._number("get_noneblock_taskstate", (id,))

    def robotmoving(self) -> bool:
        """Whether the arm moves."""
        answer: bool = self._value("robotmoving", ())
        return answer

    def modbus_read(self, signal_name: str) -> int:
        """Read a Modbus signal."""
        answer: int = self._value("modbus_read", (signal_name,))
        return answer

    def modbus_write(self, signal_name: str, value: int) -> int:
        """Write a Modbus signal: a register 0 to 65535, a coil 0 or 1."""
        return self._number("modbus_write", (signal_name, value))

    def modbus_set_frequency(self, signal_name: str, frequency: int) -> None:
        """Set how often a Modbus signal is refreshed, 1 to 100 Hz."""
        self._value("modbus_set_frequency", (signal_name, frequency))

    def modbus_write_multiple_regs(
        self, slave_num: int, name: str, len: int, word_list: Sequence[int]
    ) -> int:
        """Write `len` registers of a Modbus unit."""
        return self._number("modbus_write_multiple_regs", (slave_num, name, len, word_list))

    def modbus_write_multiple_coils(
        self, slave_num: int, name: str, len: int, byte_list: Sequence[int]
    ) -> int:
        """Write `len` coils of a Modbus unit."""
        return self._number("modbus_write_multiple_coils", (slave_num, name, len, byte_list))

    def modbus_add_signal(
        self, ip: str, slave_number: int, signal_address: int, signal_type: int, signal_name: str
    ) -> int:
        """Add a Modbus signal. Not in the manual."""
        return self._number(
            "modbus_add_signal", (ip, slave_number, signal_address, signal_type, signal_name)
        )

    def modbus_delete_signal(self, signal_name: str) -> int:
        """Delete a Modbus signal. Not in the manual."""
        return self._number("modbus_delete_signal", (signal_name,))

    def fc_start(self) -> int:
        """Start force control; motions then give way to force."""
        return self._number("fc_start", ())

    def fc_stop(self) -> int:
        """End force control; the arm must stand."""
        return self._number("fc_stop", ())

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
        return self._number(
            "fc_config", (direction, ref_ft, damp, max_vel, number_list, tool, wobj, type)
        )

    def fc_move(self, block: bool = False) -> int:
        """Move by force control alone."""
        return self._number("fc_move", (block,))

    def fc_guard_act(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        tool: str,
        wobj: str,
        type: int,
        force_property: int,
    ) -> int:
        """Watch the force, N, N m: the arm stops with an alarm when it is exceeded."""
        return self._number("fc_guard_act", (direction, ref_ft, tool, wobj, type, force_property))

    def fc_guard_deact(self) -> int:
        """End the watch of fc_guard_act."""
        return self._number("fc_guard_deact", ())

    def fc_force_set_value(self, direction: Sequence[bool], ref_ft: Sequence[float]) -> int:
        """Set the readings of the force sensor to these values, N, N m."""
        return self._number("fc_force_set_value", (direction, ref_ft))

    def fc_wait_pos(
        self,
        middle_value: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a position m, rad held for `duration` ms; give up after `timeout` ms."""
        return self._number("fc_wait_pos", (middle_value, range, absolute, duration, timeout))

    def fc_wait_vel(
        self,
        middle_value: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a speed m/s, rad/s held for `duration` ms; give up after `timeout` ms."""
        return self._number("fc_wait_vel", (middle_value, range, absolute, duration, timeout))

    def fc_wait_ft(
        self,
        middle_value: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a force N, N m held for `duration` ms; give up after `timeout` ms."""
        return self._number("fc_wait_ft", (middle_value, range, absolute, duration, timeout))

    def fc_wait_logic(self, logic: Sequence[int]) -> int:
        """Combine the conditions position, speed, force: 0 off, 1 and, 2 or. Resets them."""
        return self._number("fc_wait_logic", (logic,))

    def fc_get_ft(self) -> list[float]:
        """Readings of the force sensor, N, N m."""
        answer: list[float] = self._value("fc_get_ft", ())
        return answer

    def fc_mode_is_active(self) -> bool:
        """Whether force control is on."""
        answer: bool = self._value("fc_mode_is_active", ())
        return answer

    def enable_speed_optimization(self) -> int:
        """Let the controller choose speeds up to the safety limits, in automatic operation."""
        return self._number("enable_speed_optimization", ())

    def disable_speed_optimization(self) -> int:
        """End enable_speed_optimization."""
        return self._number("disable_speed_optimization", ())

    def enable_acc_optimization(self) -> int:
        """Let the controller choose accelerations by the arm's dynamics."""
        return self._number("enable_acc_optimization", ())

    def disable_acc_optimization(self) -> int:
        """End enable_acc_optimization."""
        return self._number("disable_acc_optimization", ())

    def enable_singularity_control(self) -> int:
        """Pass singularities by joint motion, off the path; vibration control must be off."""
        return self._number("enable_singularity_control", ())

    def disable_singularity_control(self) -> int:
        """End enable_singularity_control."""
        return self._number("disable_singularity_control", ())

    def enable_vibration_control(self) -> int:
        """Damp vibration at start and stop; each motion takes 0.2 to 0.4 s longer."""
        return self._number("enable_vibration_control", ())

    def disable_vibration_control(self) -> int:
        """End enable_vibration_control, until it is enabled again."""
        return self._number("disable_vibration_control", ())

    def trackEnqueue(self, points: Sequence[Sequence[float]], block: bool) -> int:
        """Put points, joints rad or poses m, rad, into the pool of 1000. -1 if it is full."""
        return self._number("trackEnqueue", (points, block))

    def trackClearQueue(self) -> int:
        """Empty the pool."""
        return self._number("trackClearQueue", ())

    def getQueueSize(self) -> int:
        """How many points of the pool are still to come."""
        return self._number("getQueueSize", ())

    def trackJointMotion(self, speed: float, acc: float, block: bool) -> int:
        """Follow the pool's points as joints; speed rad/s, acc rad/s²."""
        return self._number("trackJointMotion", (speed, acc, block))

    def trackCartMotion(
        self, speed: float, acc: float, block: bool, tool: str, wobj: str, radius: float = 0.005
    ) -> int:
        """Follow the pool's points as poses; speed m/s, acc m/s², radius m.

        The manual prints `wobj` before `tool`; this is the wire's order: name them.
        """
        return self._number("trackCartMotion", (speed, acc, block, tool, wobj, radius))

    def trackEnqueueOp(self, points: Sequence[PointOp], block: bool) -> int:
        """Put points with triggers into the pool of 1000. -1 if it is full."""
        return self._number("trackEnqueueOp", (points, block))

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
        path_dwell: bool,
        op_list: Sequence[Op],
    ) -> int:
        """Set the weave that is laid over motions: shape, plane, fq Hz, amp m, dwell ms."""
        return self._number(
            "combine_motion_config",
            (type, ref_plane, fq, amp, el_offset, az_offset, up_height, time, path_dwell, op_list),
        )

    def enable_combine_motion(self) -> int:
        """Lay the weave over the following motions; the arm must stand."""
        return self._number("enable_combine_motion", ())

    def disable_combine_motion(self) -> int:
        """End the weave; the arm must stand."""
        return self._number("disable_combine_motion", ())

    def enable_eaxis_scheme(self, scheme_name: str) -> int:
        """Activate a scheme of external axes."""
        return self._number("enable_eaxis_scheme", (scheme_name,))

    def disable_eaxis_scheme(self, scheme_name: str) -> int:
        """Deactivate a scheme of external axes."""
        return self._number("disable_eaxis_scheme", (scheme_name,))

    def move_eaxis(
        self,
        scheme_name: str,
        epose: Sequence[float],
        vel: float,
        block: bool,
        op: Op | None = None,
    ) -> int:
        """Move external axes to `epose` rad or m; v rad/s or m/s."""
        return self._number("move_eaxis", (scheme_name, epose, vel, block, op or Op()))

    def move_jog_eaxis(self, scheme_name: str, direction: int, vel: float, block: bool) -> int:
        """Jog an external axis, direction -1 or 1, at `vel` percent."""
        return self._number("move_jog_eaxis", (scheme_name, direction, vel, block))

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
        return self._number(
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
        return self._number(
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
        return self._number(
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
        return self._number(
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
        return self._number(
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

    def get_eaxis_info(self) -> list[EAxissInfo]:
        """Schemes of external axes: state and position. Not in manual 3.8, in 4.3."""
        answer: list[EAxissInfo] = self._value("get_eaxis_info", ())
        return answer

    def set_eaxis_param(self, num: int, param: EAxisParam, block: bool) -> int:
        """Set the parameters of external axis `num`. Not in the manual."""
        return self._number("set_eaxis_param", (num, param, block))

    def set_eaxiss_scheme_param(self, num: int, param: EAxisSchemeParam, block: bool) -> int:
        """Set the parameters of scheme `num`. Not in the manual."""
        return self._number("set_eaxiss_scheme_param", (num, param, block))

    def add_eaxis_scheme(self, num: int, block: bool) -> int:
        """Add a scheme of external axes. Not in the manual."""
        return self._number("add_eaxis_scheme", (num, block))

    def delete_eaxis_scheme(self, num: int, block: bool) -> int:
        """Delete a scheme of external axes. Not in the manual."""
        return self._number("delete_eaxis_scheme", (num, block))

    def start_realtime_mode(self, mode: int, filter_bandwidth: float, com_lost_time: float) -> int:
        """Follow the realtime queue; filter Hz, stop without data for com_lost_time s."""
        return self._number("start_realtime_mode", (mode, filter_bandwidth, com_lost_time))

    def end_realtime_mode(self) -> int:
        """End realtime control."""
        return self._number("end_realtime_mode", ())

    def realtime_data_enqueue(
        self, realtime_data: Sequence[RealTimeControlData], block: bool
    ) -> int:
        """Put commands into the realtime queue."""
        return self._number("realtime_data_enqueue", (realtime_data, block))

    def clear_realtime_data_queue(self) -> int:
        """Empty the realtime queue."""
        return self._number("clear_realtime_data_queue", ())

    def get_realtime_data_queue_size(self) -> int:
        """How many commands wait in the realtime queue."""
        return self._number("get_realtime_data_queue_size", ())

    def get_robot_version(self) -> str:
        """Version of the controller's software."""
        answer: str = self._value("get_robot_version", ())
        return answer

    def change_recipe(self) -> None:
        """Change the recipe. Not in the manual."""
        self._value("change_recipe", ())

    def set_pendant_type(self, type: int) -> int:
        """Set the kind of pendant. Not in the manual."""
        return self._number("set_pendant_type", (type,))

    def set_servo_config(self, axis_num: int, id: int, value: int, qfmt: int, block: bool) -> int:
        """Set a parameter of an axis' servo drive. Not in the manual."""
        return self._number("set_servo_config", (axis_num, id, value, qfmt, block))

    def apply_servo_config(self, axis_num: int, block: bool) -> int:
        """Apply the parameters of an axis' servo drive. Not in the manual."""
        return self._number("apply_servo_config", (axis_num, block))

    def set_servo_file_params(
        self, axis_num: int, id: int, name: str, value: float, qfmt: float
    ) -> int:
        """Set a parameter in an axis' servo file. Not in the manual."""
        return self._number("set_servo_file_params", (axis_num, id, name, value, qfmt))

    def get_axis_motor_kt(self) -> list[float]:
        """Torque constants of the motors. Not in the manual."""
        answer: list[float] = self._value("get_axis_motor_kt", ())
        return answer

    def get_axis_motor_rated_current(self) -> list[float]:
        """Rated currents of the motors. Not in the manual."""
        answer: list[float] = self._value("get_axis_motor_rated_current", ())
        return answer

    def get_axis_ratio(self) -> list[int]:
        """Gear ratios of the axes. Not in the manual."""
        answer: list[int] = self._value("get_axis_ratio", ())
        return answer

    def get_motor_pole_pair_number(self) -> list[int]:
        """Pole pairs of the motors. Not in the manual."""
        answer: list[int] = self._value("get_motor_pole_pair_number", ())
        return answer

    def get_motor_stator_slots(self) -> list[int]:
        """Stator slots of the motors. Not in the manual."""
        answer: list[int] = self._value("get_motor_stator_slots", ())
        return answer

    def get_pos_bias(self) -> list[float]:
        """Position biases of the axes. Not in the manual."""
        answer: list[float] = self._value("get_pos_bias", ())
        return answer

    def get_dynamic_calibration_params(self) -> list[list[float]]:
        """Parameters of the dynamic calibration. Not in the manual."""
        answer: list[list[float]] = self._value("get_dynamic_calibration_params", ())
        return answer

    def set_dynamic_calibration_params(self, params: Sequence[Sequence[float]]) -> int:
        """Set the parameters of the dynamic calibration. Not in the manual."""
        return self._number("set_dynamic_calibration_params", (params,))

    def set_dynamic_calibration_info(self, passwd: str, info: str) -> int:
        """Set the notes of the dynamic calibration. Not in the manual."""
        return self._number("set_dynamic_calibration_info", (passwd, info))

    def save_dynamic_calibration_params(self, passwd: str) -> int:
        """Save the dynamic calibration. Not in the manual."""
        return self._number("save_dynamic_calibration_params", (passwd,))

    def set_kinematic_calibration_params(self, params: Sequence[Sequence[float]]) -> int:
        """Set the parameters of the kinematic calibration. Not in the manual."""
        return self._number("set_kinematic_calibration_params", (params,))

    def set_kinematic_calibration_info(self, passwd: str, info: str) -> int:
        """Set the notes of the kinematic calibration. Not in the manual."""
        return self._number("set_kinematic_calibration_info", (passwd, info))

    def save_kinematic_calibration_params(self, passwd: str) -> int:
        """Save the kinematic calibration. Not in the manual."""
        return self._number("save_kinematic_calibration_params", (passwd,))

    def get_vibration_calibration_params(self) -> list[list[float]]:
        """Parameters of the vibration calibration. Not in the manual."""
        answer: list[list[float]] = self._value("get_vibration_calibration_params", ())
        return answer

    def set_vibration_calibration_info(self, passwd: str, info: str) -> int:
        """Set the notes of the vibration calibration. Not in the manual."""
        return self._number("set_vibration_calibration_info", (passwd, info))

    def upload_robot_param_to_toolboard(self, passwd: str) -> int:
        """Write the robot's parameters to the tool board. Not in the manual."""
        return self._number("upload_robot_param_to_toolboard", (passwd,))

    # as the manual spells them
    disable_combined_motion = disable_combine_motion
    enable_combined_motion = enable_combine_motion
    get_noblock_taskstate = get_noneblock_taskstate
    get_nonblock_taskstate = get_noneblock_taskstate
    move1 = movel
    move1_eaxis = movel_eaxis
    set_digital_out_mode = set_digital_output_mode
