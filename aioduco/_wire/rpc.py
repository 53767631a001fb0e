"""The controller's interface as Python types: structs, functions, clients.

Generated from `idl/robot.thrift` by `idl/generate.py`; change those, not this. Nothing here
knows Thrift: `aioduco._wire.idl` binds the structs to the loaded IDL.

A field that the other side left out has the zero value of its type, as in the C++ code that
controllers run.
"""

# Here what came over the wire, of any type, becomes what the IDL says it is.
# mypy: disable-error-code="no-any-return"

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Concatenate, Final, Generic, ParamSpec, Protocol, TypeVar
from typing import cast, overload

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)
Spec = dict[int, tuple[Any, ...]]


@dataclass(slots=True)
class Op:
    """Outputs that a motion sets: 1 after its start, 2 around its end, 3 when it pauses or stops."""

    thrift_spec: ClassVar[Spec] = {}
    time_or_dist_1: int = 0
    trig_io_1: int = 0
    trig_value_1: bool = False
    trig_time_1: float = 0.0
    trig_dist_1: float = 0.0
    trig_event_1: str = ""
    time_or_dist_2: int = 0
    trig_io_2: int = 0
    trig_value_2: bool = False
    trig_time_2: float = 0.0
    trig_dist_2: float = 0.0
    trig_event_2: str = ""
    time_or_dist_3: int = 0
    trig_io_3: int = 0
    trig_value_3: bool = False
    trig_time_3: float = 0.0
    trig_dist_3: float = 0.0
    trig_event_3: str = ""


@dataclass(slots=True)
class PointOp:
    """A point of a spline or of the track pool, with what is triggered there."""

    thrift_spec: ClassVar[Spec] = {}
    pos: list[float] = field(default_factory=list)
    op: Op = field(default_factory=Op)


@dataclass(slots=True)
class RobotStatus:
    """The arm at one moment; Cartesian values are the tool's in the world frame."""

    thrift_spec: ClassVar[Spec] = {}
    jointExpectPosition: list[float] = field(default_factory=list)
    jointExpectVelocity: list[float] = field(default_factory=list)
    jointExpectAccelera: list[float] = field(default_factory=list)
    jointActualPosition: list[float] = field(default_factory=list)
    jointActualVelocity: list[float] = field(default_factory=list)
    jointActualAccelera: list[float] = field(default_factory=list)
    jointActualCurrent: list[float] = field(default_factory=list)
    jointTemperature: list[float] = field(default_factory=list)
    driverTemperature: list[float] = field(default_factory=list)
    cartExpectPosition: list[float] = field(default_factory=list)
    cartExpectVelocity: list[float] = field(default_factory=list)
    cartExpectAccelera: list[float] = field(default_factory=list)
    cartActualPosition: list[float] = field(default_factory=list)
    cartActualVelocity: list[float] = field(default_factory=list)
    cartActualAccelera: list[float] = field(default_factory=list)
    slaveReady: list[bool] = field(default_factory=list)
    collision: bool = False
    collisionAxis: int = 0
    emcStopSignal: bool = False
    robotState: int = 0
    robotError: int = 0


@dataclass(slots=True)
class IOStatus:
    """All inputs, outputs and registers at one moment."""

    thrift_spec: ClassVar[Spec] = {}
    analogCurrentOutputs: list[float] = field(default_factory=list)
    analogVoltageOutputs: list[float] = field(default_factory=list)
    analogCurrentInputs: list[float] = field(default_factory=list)
    analogVoltageInputs: list[float] = field(default_factory=list)
    digitalInputs: list[bool] = field(default_factory=list)
    digitalOutputs: list[bool] = field(default_factory=list)
    toolIOIn: list[bool] = field(default_factory=list)
    toolIOOut: list[bool] = field(default_factory=list)
    toolButton: list[bool] = field(default_factory=list)
    funRegisterInputs: list[bool] = field(default_factory=list)
    funRegisterOutputs: list[bool] = field(default_factory=list)
    boolRegisterInputs: list[bool] = field(default_factory=list)
    boolRegisterOutputs: list[bool] = field(default_factory=list)
    wordRegisterInputs: list[int] = field(default_factory=list)
    wordRegisterOutputs: list[int] = field(default_factory=list)
    floatRegisterInputs: list[float] = field(default_factory=list)
    floatRegisterOutputs: list[float] = field(default_factory=list)


@dataclass(slots=True)
class MoveJogTaskParam:
    """One jog."""

    thrift_spec: ClassVar[Spec] = {}
    jog_direction: int = 0
    jog_type: int = 0
    axis_num: int = 0
    vel: float = 0.0
    jog_coordinate: int = 0
    use_step: bool = False
    step_jointValue: float = 0.0
    step_cartvalue: float = 0.0


@dataclass(slots=True)
class ReachabilityParam:
    """What reach_check found."""

    thrift_spec: ClassVar[Spec] = {}
    result: bool = False
    joints_pos: list[list[float]] = field(default_factory=list)


@dataclass(slots=True)
class EAxissInfo:
    """A scheme of external axes."""

    thrift_spec: ClassVar[Spec] = {}
    scheme_name: str = ""
    status: int = 0
    pos: float = 0.0


@dataclass(slots=True)
class RealTimeControlData:
    """One command of realtime control; only the list of the chosen mode counts."""

    thrift_spec: ClassVar[Spec] = {}
    joint_pos_cmd: list[float] = field(default_factory=list)
    joint_vel_cmd: list[float] = field(default_factory=list)
    joint_torq_cmd: list[float] = field(default_factory=list)
    cart_pos_tool_wobj_cmd: list[float] = field(default_factory=list)
    cart_vel_tool_wobj_cmd: list[float] = field(default_factory=list)
    cart_ft_cmd: list[float] = field(default_factory=list)
    status: bool = False


@dataclass(slots=True)
class EAxisParam:
    """Parameters of an external axis. Not in the manual."""

    thrift_spec: ClassVar[Spec] = {}
    type: int = 0
    mode: int = 0
    ref_velo: float = 0.0
    ref_acc: float = 0.0
    ref_jerk: float = 0.0
    max_velo: float = 0.0
    max_acc: float = 0.0
    encoder_type: int = 0
    encoder_resolution: int = 0
    position_bias: float = 0.0
    screw_lead: float = 0.0
    invert: bool = False
    position_limit: list[float] = field(default_factory=list)


@dataclass(slots=True)
class EAxisSchemeParam:
    """Parameters of a scheme of external axes. Not in the manual."""

    thrift_spec: ClassVar[Spec] = {}
    type: int = 0
    axis_link: list[int] = field(default_factory=list)
    base: list[float] = field(default_factory=list)
    dh: list[list[float]] = field(default_factory=list)
    install: int = 0


class Functions(ABC):
    """Every function of the wire, for callers that own a thread."""

    __slots__ = ()

    @abstractmethod
    def _call(self, name: str, args: tuple[Any, ...]) -> Any:
        """Send one call and return what is answered."""

    def rpc_heartbeat(self, time: int) -> None:
        """Report that this client lives; the arm stops if none follows within `time` ms."""
        return self._call("rpc_heartbeat", (time,))

    def power_on(self, block: bool) -> int:
        """Power the arm on. Returns the task's end state if `block`, else its id."""
        return self._call("power_on", (block,))

    def power_off(self, block: bool) -> int:
        """Power the arm off. Returns the task's end state if `block`, else its id."""
        return self._call("power_off", (block,))

    def enable(self, block: bool) -> int:
        """Enable the servos. Returns the task's end state if `block`, else its id."""
        return self._call("enable", (block,))

    def disable(self, block: bool) -> int:
        """Disable the servos. Returns the task's end state if `block`, else its id."""
        return self._call("disable", (block,))

    def shutdown(self, block: bool) -> int:
        """Shut the controller down. Returns the task's end state if `block`, else its id."""
        return self._call("shutdown", (block,))

    def restart(self, block: bool) -> int:
        """Restart the controller. Returns the task's end state if `block`, else its id."""
        return self._call("restart", (block,))

    def stop(self, block: bool) -> int:
        """Stop all tasks. Returns the end state if `block`, else a task id."""
        return self._call("stop", (block,))

    def pause(self, block: bool) -> int:
        """Pause all tasks. Returns the end state if `block`, else a task id."""
        return self._call("pause", (block,))

    def resume(self, block: bool) -> int:
        """Resume all paused tasks. Returns the end state if `block`, else a task id."""
        return self._call("resume", (block,))

    def abort(self, block: bool) -> int:
        """End the running motion and those read ahead. Not in manual 3.8, in 4.3."""
        return self._call("abort", (block,))

    def run_program(self, name: str, block: bool) -> int:
        """Run a program of the controller by name. Returns end state or task id."""
        return self._call("run_program", (name, block))

    def get_current_project(self) -> str:
        """Path of the project that is loaded."""
        return self._call("get_current_project", ())

    def get_files_list(self, path: str) -> dict[str, int]:
        """Files below `path`: name to kind, 0 a folder, 1 a file."""
        return self._call("get_files_list", (path,))

    def movej2(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move the joints to `joints_list` rad; v rad/s, a rad/s², r m of blending."""
        return self._call("movej2", (joints_list, v, a, r, block, op, def_acc))

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
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move the joints to the pose p m, rad; v rad/s, a rad/s², r m of blending."""
        return self._call("movej_pose2", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

    def movel(
        self,
        p: Sequence[float],
        v: float,
        a: float,
        r: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
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
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move the tool along an arc through p1 to p2 m, rad; v m/s, a m/s², r m of blending."""
        return self._call("movec", (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc))

    def move_circle(
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
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move the tool along the full circle through p1 and p2; v m/s, a m/s², r m."""
        return self._call(
            "move_circle",
            (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc),
        )

    def tcp_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        block: bool,
        op: Op,
        def_acc: bool,
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
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move along a line by the offset from p1 to p2 in the tool's frame; v m/s, a m/s²."""
        return self._call("tcp_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))

    def wobj_move(
        self,
        pose_offset: Sequence[float],
        v: float,
        a: float,
        r: float,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
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
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move along a line by the offset from p1 to p2 in the work object's frame."""
        return self._call("wobj_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))

    def speedj(self, joints_list: Sequence[float], a: float, time: int, block: bool) -> int:
        """Turn the joints at `joints_list` rad/s for `time` ms, -1 for no end; a rad/s²."""
        return self._call("speedj", (joints_list, a, time, block))

    def speedl(self, pose_list: Sequence[float], a: float, time: int, block: bool) -> int:
        """Move the tool at `pose_list` m/s, rad/s in its frame for `time` ms, -1 for no end; a m/s²."""
        return self._call("speedl", (pose_list, a, time, block))

    def speed_stop(self, block: bool) -> int:
        """End speedj and speedl."""
        return self._call("speed_stop", (block,))

    def teach_mode(self, block: bool) -> int:
        """Enter hand guiding."""
        return self._call("teach_mode", (block,))

    def end_teach_mode(self, block: bool) -> int:
        """Leave hand guiding."""
        return self._call("end_teach_mode", (block,))

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: Sequence[int],
        cart_scale: Sequence[int],
        coord_type: int,
        direction: Sequence[bool],
    ) -> int:
        """Set hand guiding: space, compliance of joints or of x to rz, frame, directions."""
        return self._call(
            "set_hand_teach_parameter",
            (space, joint_scale, cart_scale, coord_type, direction),
        )

    def replay(self, name: str, value: int, mode: int) -> int:
        """Run a recorded track at `value` percent; mode 0 by joints, 1 by poses."""
        return self._call("replay", (name, value, mode))

    def spline(
        self,
        pose_list: Sequence[Sequence[float]],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        r: float,
        def_acc: bool,
    ) -> int:
        """Move the tool along a spline through up to 50 poses m, rad; v m/s, a m/s², r m."""
        return self._call("spline", (pose_list, v, a, tool, wobj, block, op, r, def_acc))

    def spline_op(
        self,
        pose_list: Sequence[PointOp],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        r: float,
        def_acc: bool,
    ) -> int:
        """Move along a spline of up to 50 poses with triggers at the points; v m/s, a m/s²."""
        return self._call("spline_op", (pose_list, v, a, tool, wobj, block, op, r, def_acc))

    def servoj(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int:
        """Follow joint targets rad that come one after another; v rad/s, a rad/s²."""
        return self._call("servoj", (joints_list, v, a, block, kp, kd, smooth_vel, smooth_acc))

    def servoj_pose(
        self,
        pose_list: Sequence[float],
        v: float,
        a: float,
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
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
        tool: str,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int:
        """Follow offsets m, rad in the tool's frame that come one after another."""
        return self._call(
            "servo_tcp",
            (pose_offset, v, a, tool, block, kp, kd, smooth_vel, smooth_acc),
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
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int:
        """Follow poses m, rad that come one after another, by the Cartesian directions."""
        return self._call(
            "servol",
            (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc),
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
        q_near: Sequence[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move along a spiral: `rev` turns, `len` m along the axis, `r` m; v m/s, a m/s²."""
        return self._call(
            "move_spiral",
            (p1, p2, rev, len, r, mode, v, a, q_near, tool, wobj, block, op, def_acc),
        )

    def move_jog(self, param: MoveJogTaskParam, block: bool) -> int:
        """Jog one joint or one Cartesian direction, continuously or by a step."""
        return self._call("move_jog", (param, block))

    def stop_manual_move(self, block: bool) -> int:
        """End move_jog."""
        return self._call("stop_manual_move", (block,))

    def set_blend_ahead(self, per: int, num: int) -> int:
        """Read following motions ahead at `per` percent of the path, or `num` of them."""
        return self._call("set_blend_ahead", (per, num))

    def movej(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move the joints to `joints_list` rad; v, a and r in percent. Not in the manual."""
        return self._call("movej", (joints_list, v, a, r, block, op, def_acc))

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
        op: Op,
        def_acc: bool,
    ) -> int:
        """Move the joints to the pose p m, rad; v, a and r in percent. Not in the manual."""
        return self._call("movej_pose", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

    def set_baudrate_485(self, value: int, block: bool) -> int:
        """Set the rate of the cabinet's RS-485 port, bit/s."""
        return self._call("set_baudrate_485", (value, block))

    def read_raw_data_485(self, len: int) -> list[int]:
        """Read `len` bytes from RS-485; empty if there is nothing."""
        return self._call("read_raw_data_485", (len,))

    def read_raw_data_485_h(self, head: Sequence[int], len: int) -> list[int]:
        """Read a frame of `len` bytes that starts with `head` from RS-485."""
        return self._call("read_raw_data_485_h", (head, len))

    def read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> list[int]:
        """Read a frame from `head` to `tail` from RS-485."""
        return self._call("read_raw_data_485_ht", (head, tail))

    def write_raw_data_485(self, data: Sequence[int]) -> bool:
        """Write bytes to RS-485."""
        return self._call("write_raw_data_485", (data,))

    def write_raw_data_485_h(self, data: Sequence[int], head: Sequence[int]) -> bool:
        """Write `head` and bytes to RS-485."""
        return self._call("write_raw_data_485_h", (data, head))

    def write_raw_data_485_ht(
        self,
        data: Sequence[int],
        head: Sequence[int],
        tail: Sequence[int],
    ) -> bool:
        """Write `head`, bytes and `tail` to RS-485."""
        return self._call("write_raw_data_485_ht", (data, head, tail))

    def read_data_485(self) -> list[int]:
        """Read from RS-485. Not in the manual."""
        return self._call("read_data_485", ())

    def write_data_485(self, data: Sequence[int]) -> bool:
        """Write to RS-485. Not in the manual."""
        return self._call("write_data_485", (data,))

    def tool_read_raw_data_485(self, len: int) -> list[int]:
        """Read `len` bytes from the tool's RS-485; empty if there is nothing."""
        return self._call("tool_read_raw_data_485", (len,))

    def tool_read_raw_data_485_h(self, head: Sequence[int], len: int) -> list[int]:
        """Read a frame of `len` bytes that starts with `head` from the tool's RS-485."""
        return self._call("tool_read_raw_data_485_h", (head, len))

    def tool_read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> list[int]:
        """Read a frame from `head` to `tail` from the tool's RS-485."""
        return self._call("tool_read_raw_data_485_ht", (head, tail))

    def tool_write_raw_data_485(self, data: Sequence[int]) -> bool:
        """Write bytes to the tool's RS-485."""
        return self._call("tool_write_raw_data_485", (data,))

    def tool_write_raw_data_485_h(self, data: Sequence[int], head: Sequence[int]) -> bool:
        """Write `head` and bytes to the tool's RS-485."""
        return self._call("tool_write_raw_data_485_h", (data, head))

    def tool_write_raw_data_485_ht(
        self,
        data: Sequence[int],
        head: Sequence[int],
        tail: Sequence[int],
    ) -> bool:
        """Write `head`, bytes and `tail` to the tool's RS-485."""
        return self._call("tool_write_raw_data_485_ht", (data, head, tail))

    def tool_read_data_485(self) -> list[int]:
        """Read from the tool's RS-485. Not in the manual."""
        return self._call("tool_read_data_485", ())

    def tool_write_data_485(self, data: Sequence[int]) -> bool:
        """Write to the tool's RS-485. Not in the manual."""
        return self._call("tool_write_data_485", (data,))

    def set_baudrate_can(self, value: int, block: bool) -> int:
        """Set the rate of the CAN bus, bit/s."""
        return self._call("set_baudrate_can", (value, block))

    def read_raw_data_can(self) -> list[int]:
        """Read one CAN frame: the sender's id, then the bytes; empty if there is none."""
        return self._call("read_raw_data_can", ())

    def write_raw_data_can(self, id: int, data: Sequence[int]) -> bool:
        """Write one CAN frame."""
        return self._call("write_raw_data_can", (id, data))

    def read_data_can(self) -> list[int]:
        """Read from CAN. Not in the manual."""
        return self._call("read_data_can", ())

    def write_data_can(self, id: int, data: Sequence[int]) -> bool:
        """Write to CAN. Not in the manual."""
        return self._call("write_data_can", (id, data))

    def set_digital_output_mode(self, num: int, type: int, freq: int, duty_cycle: int) -> int:
        """Make a cabinet output a level (type 0) or pulses (1) at freq Hz, duty_cycle percent."""
        return self._call("set_digital_output_mode", (num, type, freq, duty_cycle))

    def set_standard_digital_out(self, num: int, value: bool, block: bool) -> int:
        """Set cabinet output 1 to 16."""
        return self._call("set_standard_digital_out", (num, value, block))

    def get_standard_digital_out(self, num: int) -> bool:
        """Level of cabinet output 1 to 16."""
        return self._call("get_standard_digital_out", (num,))

    def get_standard_digital_in(self, num: int) -> bool:
        """Level of cabinet input 1 to 16."""
        return self._call("get_standard_digital_in", (num,))

    def set_tool_digital_out(self, num: int, value: bool, block: bool) -> int:
        """Set tool output 1 or 2."""
        return self._call("set_tool_digital_out", (num, value, block))

    def get_tool_digital_out(self, num: int) -> bool:
        """Level of tool output 1 or 2."""
        return self._call("get_tool_digital_out", (num,))

    def get_tool_digital_in(self, num: int) -> bool:
        """Level of tool input 1 or 2."""
        return self._call("get_tool_digital_in", (num,))

    def get_config_digital_in(self, num: int) -> bool:
        """Level of a configurable cabinet input. Not in the manual."""
        return self._call("get_config_digital_in", (num,))

    def get_function_digital_in(self, num: int) -> bool:
        """Level of function input 1 to 8."""
        return self._call("get_function_digital_in", (num,))

    def get_function_digital_out(self, num: int) -> bool:
        """Level of function output 1 to 8."""
        return self._call("get_function_digital_out", (num,))

    def get_standard_analog_voltage_in(self, num: int) -> float:
        """Voltage at cabinet channel 1 to 4, V."""
        return self._call("get_standard_analog_voltage_in", (num,))

    def set_standard_analog_voltage_out(self, num: int, value: float, block: bool) -> int:
        """Set the voltage of cabinet channel 1 to 4, 0 to 10 V."""
        return self._call("set_standard_analog_voltage_out", (num, value, block))

    def get_tool_analog_voltage_in(self, num: int) -> float:
        """Voltage at tool channel 1 or 2, V."""
        return self._call("get_tool_analog_voltage_in", (num,))

    def get_standard_analog_current_in(self, num: int) -> float:
        """Current at cabinet channel 1 to 4, mA."""
        return self._call("get_standard_analog_current_in", (num,))

    def set_standard_analog_current_out(self, num: int, value: float, block: bool) -> int:
        """Set the current of cabinet channel 1 to 4, 4 to 20 mA."""
        return self._call("set_standard_analog_current_out", (num, value, block))

    def set_analog_output_mode(self, num: int, mode: int, block: bool) -> int:
        """Set the kind of an analog output. Not in the manual."""
        return self._call("set_analog_output_mode", (num, mode, block))

    def write_bool_reg(self, num: int, value: bool) -> int:
        """Write bool register 1 to 64."""
        return self._call("write_bool_reg", (num, value))

    def write_word_reg(self, num: int, value: int) -> int:
        """Write word register 1 to 32."""
        return self._call("write_word_reg", (num, value))

    def write_float_reg(self, num: int, value: float) -> int:
        """Write float register 1 to 32."""
        return self._call("write_float_reg", (num, value))

    def read_bool_reg(self, num: int) -> bool:
        """Read bool register 1 to 64."""
        return self._call("read_bool_reg", (num,))

    def read_word_reg(self, num: int) -> int:
        """Read word register 1 to 32."""
        return self._call("read_word_reg", (num,))

    def read_float_reg(self, num: int) -> float:
        """Read float register 1 to 32."""
        return self._call("read_float_reg", (num,))

    def get_function_reg_in(self, num: int) -> bool:
        """Read function input register 1 to 16."""
        return self._call("get_function_reg_in", (num,))

    def get_function_reg_out(self, num: int) -> bool:
        """Read function output register 1 to 16."""
        return self._call("get_function_reg_out", (num,))

    def set_wobj_offset(self, wobj: Sequence[float], active: bool) -> int:
        """Add an offset m, rad to the work object of all following motions, or take it away."""
        return self._call("set_wobj_offset", (wobj, active))

    def set_wobj(self, name: str, wobj: Sequence[float]) -> int:
        """Set a work object by name, m, rad. Not in the manual."""
        return self._call("set_wobj", (name, wobj))

    def set_tool_data(
        self,
        name: str,
        tool_offset: Sequence[float],
        payload: Sequence[float],
        inertia_tensor: Sequence[float],
    ) -> int:
        """Set a tool: offset m, rad from the flange, payload kg, m, inertia kg m²."""
        return self._call("set_tool_data", (name, tool_offset, payload, inertia_tensor))

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """Joints rad for the pose p m, rad, near q_near; empty lists mean the present values."""
        return self._call("cal_ikine", (p, q_near, tool, wobj))

    def cal_fkine(
        self,
        joints_position: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """Pose m, rad for joints rad; empty tool and wobj mean the present ones."""
        return self._call("cal_fkine", (joints_position, tool, wobj))

    def get_tcp_pose(self) -> list[float]:
        """Pose of the tool in the base frame, m, rad."""
        return self._call("get_tcp_pose", ())

    def get_tcp_pose_coord(self, tool: str, wobj: str) -> list[float]:
        """Pose m, rad with the tool and the work object of these names."""
        return self._call("get_tcp_pose_coord", (tool, wobj))

    def get_tcp_speed(self) -> list[float]:
        """Speed of the tool's origin, m/s, rad/s."""
        return self._call("get_tcp_speed", ())

    def get_tcp_acceleration(self) -> list[float]:
        """Acceleration of the tool's origin, m/s², rad/s²."""
        return self._call("get_tcp_acceleration", ())

    def get_tcp_force(self) -> list[float]:
        """Force at the tool's origin, N, N m; needs a force sensor."""
        return self._call("get_tcp_force", ())

    def get_tcp_force_tool(self, tool: str) -> list[float]:
        """Force in the frame of the tool of this name, N, N m; needs a force sensor."""
        return self._call("get_tcp_force_tool", (tool,))

    def get_tcp_offset(self) -> list[float]:
        """Offset of the present tool from the flange, m, rad."""
        return self._call("get_tcp_offset", ())

    def get_tool_load(self) -> list[float]:
        """Mass and centre of mass of the present tool, kg, m."""
        return self._call("get_tool_load", ())

    def get_wobj(self) -> list[float]:
        """The present work object in the base frame, m, rad."""
        return self._call("get_wobj", ())

    def get_actual_joints_position(self) -> list[float]:
        """Measured joint positions, rad."""
        return self._call("get_actual_joints_position", ())

    def get_target_joints_position(self) -> list[float]:
        """Planned joint positions, rad."""
        return self._call("get_target_joints_position", ())

    def get_actual_joints_speed(self) -> list[float]:
        """Measured joint speeds, rad/s."""
        return self._call("get_actual_joints_speed", ())

    def get_target_joints_speed(self) -> list[float]:
        """Planned joint speeds, rad/s."""
        return self._call("get_target_joints_speed", ())

    def get_actual_joints_acceleration(self) -> list[float]:
        """Measured joint accelerations, rad/s²."""
        return self._call("get_actual_joints_acceleration", ())

    def get_target_joints_acceleration(self) -> list[float]:
        """Planned joint accelerations, rad/s²."""
        return self._call("get_target_joints_acceleration", ())

    def get_actual_joints_torque(self) -> list[float]:
        """Measured joint torques, N m."""
        return self._call("get_actual_joints_torque", ())

    def get_target_joints_torque(self) -> list[float]:
        """Planned joint torques, N m; the manual's text says rad/s²."""
        return self._call("get_target_joints_torque", ())

    def get_flange_pose(self) -> list[float]:
        """Pose of the flange in the base frame, m, rad."""
        return self._call("get_flange_pose", ())

    def get_flange_speed(self) -> list[float]:
        """Speed of the flange in the base frame, m/s, rad/s."""
        return self._call("get_flange_speed", ())

    def get_flange_acceleration(self) -> list[float]:
        """Acceleration of the flange in the base frame, m/s², rad/s²."""
        return self._call("get_flange_acceleration", ())

    def get_robot_state(self) -> list[int]:
        """Four states: robot, program, safety controller, operation mode."""
        return self._call("get_robot_state", ())

    def simulation(self, sim: bool, block: bool) -> int:
        """Switch between simulation and the real arm; the arm must stand."""
        return self._call("simulation", (sim, block))

    def speed(self, val: float) -> int:
        """Set the global speed, 1 to 100 percent."""
        return self._call("speed", (val,))

    def set_load_data(self, value: Sequence[float]) -> int:
        """Set the mass kg and centre m of what the tool holds."""
        return self._call("set_load_data", (value,))

    def start_record_track(
        self,
        name: str,
        mode: int,
        tool: str,
        wobj: str,
        interval: float,
    ) -> int:
        """Start to record a track: mode 0 each `interval` degrees, 1 each `interval` seconds."""
        return self._call("start_record_track", (name, mode, tool, wobj, interval))

    def stop_record_track(self) -> int:
        """End the record of a track."""
        return self._call("stop_record_track", ())

    def collision_detect(self, value: int) -> int:
        """Set the level of collision detection, 0 off, 1 to 5."""
        return self._call("collision_detect", (value,))

    def collision_detection_reset(self) -> int:
        """Clear the collision warning."""
        return self._call("collision_detection_reset", ())

    def set_teach_pendant(self, enable: bool) -> int:
        """Turn the keys of the pendant on or off."""
        return self._call("set_teach_pendant", (enable,))

    def set_teach_speed(self, v: int) -> int:
        """Set the teaching speed, 1 to 100 percent."""
        return self._call("set_teach_speed", (v,))

    def get_teach_speed(self) -> int:
        """Teaching speed, percent."""
        return self._call("get_teach_speed", ())

    def get_global_speed(self) -> int:
        """Global speed, percent."""
        return self._call("get_global_speed", ())

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> ReachabilityParam:
        """Whether poses m, rad can be reached with this base, work object and tool."""
        return self._call("reach_check", (base, wobj, tool, ref_pos, check_points))

    def switch_mode(self, mode: int) -> int:
        """Switch to manual (0) or automatic (1) operation."""
        return self._call("switch_mode", (mode,))

    def getRobotStatus(self) -> RobotStatus:
        """The arm's positions, speeds, currents, temperatures and errors at once."""
        return self._call("getRobotStatus", ())

    def getRobotIOStatus(self) -> IOStatus:
        """All inputs, outputs and registers at once."""
        return self._call("getRobotIOStatus", ())

    def read_encoder_count(self) -> int:
        """Count of the external incremental encoder."""
        return self._call("read_encoder_count", ())

    def get_origin_DH(self) -> list[list[float]]:
        """DH parameters of the model: a m, alpha rad, d m, theta rad per joint."""
        return self._call("get_origin_DH", ())

    def get_calib_DH(self) -> list[list[float]]:
        """DH parameters after calibration: a m, alpha rad, d m, theta rad per joint."""
        return self._call("get_calib_DH", ())

    def get_robot_type(self) -> list[str]:
        """Series, model, extension and serial number."""
        return self._call("get_robot_type", ())

    def get_ext_torque(self) -> list[float]:
        """Observed external joint torques."""
        return self._call("get_ext_torque", ())

    def set_system_value_bool(self, name: str, value: bool) -> int:
        """Set a global variable of type bool."""
        return self._call("set_system_value_bool", (name, value))

    def set_system_value_double(self, name: str, value: float) -> int:
        """Set a global variable of type number."""
        return self._call("set_system_value_double", (name, value))

    def set_system_value_str(self, name: str, value: str) -> int:
        """Set a global variable of type string."""
        return self._call("set_system_value_str", (name, value))

    def set_system_value_list(self, name: str, value: Sequence[float]) -> int:
        """Set a global variable of type list of numbers."""
        return self._call("set_system_value_list", (name, value))

    def get_system_value_bool(self, name: str) -> bool:
        """Read a global variable of type bool."""
        return self._call("get_system_value_bool", (name,))

    def get_system_value_double(self, name: str) -> float:
        """Read a global variable of type number."""
        return self._call("get_system_value_double", (name,))

    def get_system_value_str(self, name: str) -> str:
        """Read a global variable of type string."""
        return self._call("get_system_value_str", (name,))

    def get_system_value_list(self, name: str) -> list[float]:
        """Read a global variable of type list of numbers."""
        return self._call("get_system_value_list", (name,))

    def get_system_value_lists(self, name: str) -> list[list[float]]:
        """Read a global variable of type list of poses. Not in manual 3.8, in 4.3."""
        return self._call("get_system_value_lists", (name,))

    def log_info(self, message: str) -> None:
        """Write a line into the controller's log."""
        return self._call("log_info", (message,))

    def log_error(self, message: str) -> None:
        """Show an error on the pendant and pause all tasks."""
        return self._call("log_error", (message,))

    def get_last_error(self) -> list[str]:
        """The latest errors."""
        return self._call("get_last_error", ())

    def get_noneblock_taskstate(self, id: int) -> int:
        """State of a task by its id."""
        return self._call("get_noneblock_taskstate", (id,))

    def robotmoving(self) -> bool:
        """Whether the arm moves."""
        return self._call("robotmoving", ())

    def modbus_read(self, signal_name: str) -> int:
        """Read a Modbus signal."""
        return self._call("modbus_read", (signal_name,))

    def modbus_write(self, signal_name: str, value: int) -> int:
        """Write a Modbus signal: a register 0 to 65535, a coil 0 or 1."""
        return self._call("modbus_write", (signal_name, value))

    def modbus_set_frequency(self, signal_name: str, frequence: int) -> None:
        """Set how often a Modbus signal is refreshed, 1 to 100 Hz."""
        return self._call("modbus_set_frequency", (signal_name, frequence))

    def modbus_write_multiple_regs(
        self,
        slave_num: int,
        name: str,
        len: int,
        word_list: Sequence[int],
    ) -> int:
        """Write `len` registers of a Modbus unit."""
        return self._call("modbus_write_multiple_regs", (slave_num, name, len, word_list))

    def modbus_write_multiple_coils(
        self,
        slave_num: int,
        name: str,
        len: int,
        byte_list: Sequence[int],
    ) -> int:
        """Write `len` coils of a Modbus unit."""
        return self._call("modbus_write_multiple_coils", (slave_num, name, len, byte_list))

    def modbus_add_signal(
        self,
        ip: str,
        slave_number: int,
        signal_address: int,
        signal_type: int,
        signal_name: str,
    ) -> int:
        """Add a Modbus signal. Not in the manual."""
        return self._call(
            "modbus_add_signal",
            (ip, slave_number, signal_address, signal_type, signal_name),
        )

    def modbus_delete_signal(self, signal_name: str) -> int:
        """Delete a Modbus signal. Not in the manual."""
        return self._call("modbus_delete_signal", (signal_name,))

    def fc_start(self) -> int:
        """Start force control; motions then give way to force."""
        return self._call("fc_start", ())

    def fc_stop(self) -> int:
        """End force control; the arm must stand."""
        return self._call("fc_stop", ())

    def fc_config(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        damp: Sequence[float],
        max_vel: Sequence[float],
        number_list: Sequence[float],
        tool: str,
        wobj: str,
        value: int,
    ) -> int:
        """Set force control: directions, target N, N m, damping, greatest speed, dead band, frame."""
        return self._call(
            "fc_config",
            (direction, ref_ft, damp, max_vel, number_list, tool, wobj, value),
        )

    def fc_move(self, block: bool) -> int:
        """Move by force control alone."""
        return self._call("fc_move", (block,))

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
        return self._call("fc_guard_act", (direction, ref_ft, tool, wobj, type, force_property))

    def fc_guard_deact(self) -> int:
        """End the watch of fc_guard_act."""
        return self._call("fc_guard_deact", ())

    def fc_force_set_value(self, direction: Sequence[bool], ref_ft: Sequence[float]) -> int:
        """Set the readings of the force sensor to these values, N, N m."""
        return self._call("fc_force_set_value", (direction, ref_ft))

    def fc_wait_pos(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a position m, rad held for `duration` ms; give up after `timeout` ms."""
        return self._call("fc_wait_pos", (middle, range, absolute, duration, timeout))

    def fc_wait_vel(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a speed m/s, rad/s held for `duration` ms; give up after `timeout` ms."""
        return self._call("fc_wait_vel", (middle, range, absolute, duration, timeout))

    def fc_wait_ft(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """End the motion at a force N, N m held for `duration` ms; give up after `timeout` ms."""
        return self._call("fc_wait_ft", (middle, range, absolute, duration, timeout))

    def fc_wait_logic(self, value: Sequence[int]) -> int:
        """Combine the conditions position, speed, force: 0 off, 1 and, 2 or. Resets them."""
        return self._call("fc_wait_logic", (value,))

    def fc_get_ft(self) -> list[float]:
        """Readings of the force sensor, N, N m."""
        return self._call("fc_get_ft", ())

    def fc_mode_is_active(self) -> bool:
        """Whether force control is on."""
        return self._call("fc_mode_is_active", ())

    def enable_speed_optimization(self) -> int:
        """Let the controller choose speeds up to the safety limits, in automatic operation."""
        return self._call("enable_speed_optimization", ())

    def disable_speed_optimization(self) -> int:
        """End enable_speed_optimization."""
        return self._call("disable_speed_optimization", ())

    def enable_acc_optimization(self) -> int:
        """Let the controller choose accelerations by the arm's dynamics."""
        return self._call("enable_acc_optimization", ())

    def disable_acc_optimization(self) -> int:
        """End enable_acc_optimization."""
        return self._call("disable_acc_optimization", ())

    def enable_singularity_control(self) -> int:
        """Pass singularities by joint motion, off the path; vibration control must be off."""
        return self._call("enable_singularity_control", ())

    def disable_singularity_control(self) -> int:
        """End enable_singularity_control."""
        return self._call("disable_singularity_control", ())

    def enable_vibration_control(self) -> int:
        """Damp vibration at start and stop; each motion takes 0.2 to 0.4 s longer."""
        return self._call("enable_vibration_control", ())

    def disable_vibration_control(self) -> int:
        """End enable_vibration_control, until it is enabled again."""
        return self._call("disable_vibration_control", ())

    def trackEnqueue(self, track: Sequence[Sequence[float]], block: bool) -> int:
        """Put points, joints rad or poses m, rad, into the pool of 1000. -1 if it is full."""
        return self._call("trackEnqueue", (track, block))

    def trackClearQueue(self) -> int:
        """Empty the pool."""
        return self._call("trackClearQueue", ())

    def getQueueSize(self) -> int:
        """How many points of the pool are still to come."""
        return self._call("getQueueSize", ())

    def trackJointMotion(self, speed: float, acc: float, block: bool) -> int:
        """Follow the pool's points as joints; speed rad/s, acc rad/s²."""
        return self._call("trackJointMotion", (speed, acc, block))

    def trackCartMotion(
        self,
        speed: float,
        acc: float,
        block: bool,
        tool: str,
        wobj: str,
        radius: float,
    ) -> int:
        """Follow the pool's points as poses; speed m/s, acc m/s², radius m."""
        return self._call("trackCartMotion", (speed, acc, block, tool, wobj, radius))

    def trackEnqueueOp(self, track: Sequence[PointOp], block: bool) -> int:
        """Put points with triggers into the pool of 1000. -1 if it is full."""
        return self._call("trackEnqueueOp", (track, block))

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
        return self._call(
            "combine_motion_config",
            (type, ref_plane, fq, amp, el_offset, az_offset, up_height, time, path_dwell, op_list),
        )

    def enable_combine_motion(self) -> int:
        """Lay the weave over the following motions; the arm must stand."""
        return self._call("enable_combine_motion", ())

    def disable_combine_motion(self) -> int:
        """End the weave; the arm must stand."""
        return self._call("disable_combine_motion", ())

    def enable_eaxis_scheme(self, scheme_name: str) -> int:
        """Activate a scheme of external axes."""
        return self._call("enable_eaxis_scheme", (scheme_name,))

    def disable_eaxis_scheme(self, scheme_name: str) -> int:
        """Deactivate a scheme of external axes."""
        return self._call("disable_eaxis_scheme", (scheme_name,))

    def move_eaxis(
        self,
        scheme_name: str,
        epose: Sequence[float],
        v: float,
        block: bool,
        op: Op,
    ) -> int:
        """Move external axes to `epose` rad or m; v rad/s or m/s."""
        return self._call("move_eaxis", (scheme_name, epose, v, block, op))

    def move_jog_eaxis(self, name: str, direction: int, vel: float, block: bool) -> int:
        """Jog an external axis, direction -1 or 1, at `vel` percent."""
        return self._call("move_jog_eaxis", (name, direction, vel, block))

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
        op: Op,
        def_acc: bool,
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
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
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
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
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
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
        mode: int,
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
        qnear: Sequence[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: Sequence[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
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

    def get_eaxis_info(self) -> list[EAxissInfo]:
        """Schemes of external axes: state and position. Not in manual 3.8, in 4.3."""
        return self._call("get_eaxis_info", ())

    def set_eaxis_param(self, num: int, param: EAxisParam, block: bool) -> int:
        """Set the parameters of external axis `num`. Not in the manual."""
        return self._call("set_eaxis_param", (num, param, block))

    def set_eaxiss_scheme_param(self, num: int, param: EAxisSchemeParam, block: bool) -> int:
        """Set the parameters of scheme `num`. Not in the manual."""
        return self._call("set_eaxiss_scheme_param", (num, param, block))

    def add_eaxis_scheme(self, num: int, block: bool) -> int:
        """Add a scheme of external axes. Not in the manual."""
        return self._call("add_eaxis_scheme", (num, block))

    def delete_eaxis_scheme(self, num: int, block: bool) -> int:
        """Delete a scheme of external axes. Not in the manual."""
        return self._call("delete_eaxis_scheme", (num, block))

    def start_realtime_mode(
        self,
        mode: int,
        fileter_bandwidth: float,
        com_lost_time: float,
    ) -> int:
        """Follow the realtime queue; filter Hz, stop without data for com_lost_time s."""
        return self._call("start_realtime_mode", (mode, fileter_bandwidth, com_lost_time))

    def end_realtime_mode(self) -> int:
        """End realtime control."""
        return self._call("end_realtime_mode", ())

    def realtime_data_enqueue(
        self,
        realtime_data: Sequence[RealTimeControlData],
        block: bool,
    ) -> int:
        """Put commands into the realtime queue."""
        return self._call("realtime_data_enqueue", (realtime_data, block))

    def clear_realtime_data_queue(self) -> int:
        """Empty the realtime queue."""
        return self._call("clear_realtime_data_queue", ())

    def get_realtime_data_queue_size(self) -> int:
        """How many commands wait in the realtime queue."""
        return self._call("get_realtime_data_queue_size", ())

    def get_robot_version(self) -> str:
        """Version of the controller's software."""
        return self._call("get_robot_version", ())

    def change_recipe(self) -> None:
        """Change the recipe. Not in the manual."""
        return self._call("change_recipe", ())

    def set_pendant_type(self, type: int) -> int:
        """Set the kind of pendant. Not in the manual."""
        return self._call("set_pendant_type", (type,))

    def set_servo_config(
        self,
        axis_num: int,
        id: int,
        value: int,
        qfmt: int,
        block: bool,
    ) -> int:
        """Set a parameter of an axis' servo drive. Not in the manual."""
        return self._call("set_servo_config", (axis_num, id, value, qfmt, block))

    def apply_servo_config(self, axis_num: int, block: bool) -> int:
        """Apply the parameters of an axis' servo drive. Not in the manual."""
        return self._call("apply_servo_config", (axis_num, block))

    def set_servo_file_params(
        self,
        axis_num: int,
        id: int,
        name: str,
        value: float,
        qfmt: float,
    ) -> int:
        """Set a parameter in an axis' servo file. Not in the manual."""
        return self._call("set_servo_file_params", (axis_num, id, name, value, qfmt))

    def get_axis_motor_kt(self) -> list[float]:
        """Torque constants of the motors. Not in the manual."""
        return self._call("get_axis_motor_kt", ())

    def get_axis_motor_rated_current(self) -> list[float]:
        """Rated currents of the motors. Not in the manual."""
        return self._call("get_axis_motor_rated_current", ())

    def get_axis_ratio(self) -> list[int]:
        """Gear ratios of the axes. Not in the manual."""
        return self._call("get_axis_ratio", ())

    def get_motor_pole_pair_number(self) -> list[int]:
        """Pole pairs of the motors. Not in the manual."""
        return self._call("get_motor_pole_pair_number", ())

    def get_motor_stator_slots(self) -> list[int]:
        """Stator slots of the motors. Not in the manual."""
        return self._call("get_motor_stator_slots", ())

    def get_pos_bias(self) -> list[float]:
        """Position biases of the axes. Not in the manual."""
        return self._call("get_pos_bias", ())

    def get_dynamic_calibration_params(self) -> list[list[float]]:
        """Parameters of the dynamic calibration. Not in the manual."""
        return self._call("get_dynamic_calibration_params", ())

    def set_dynamic_calibration_params(self, params: Sequence[Sequence[float]]) -> int:
        """Set the parameters of the dynamic calibration. Not in the manual."""
        return self._call("set_dynamic_calibration_params", (params,))

    def set_dynamic_calibration_info(self, passwd: str, info: str) -> int:
        """Set the notes of the dynamic calibration. Not in the manual."""
        return self._call("set_dynamic_calibration_info", (passwd, info))

    def save_dynamic_calibration_params(self, passwd: str) -> int:
        """Save the dynamic calibration. Not in the manual."""
        return self._call("save_dynamic_calibration_params", (passwd,))

    def set_kinematic_calibration_params(self, params: Sequence[Sequence[float]]) -> int:
        """Set the parameters of the kinematic calibration. Not in the manual."""
        return self._call("set_kinematic_calibration_params", (params,))

    def set_kinematic_calibration_info(self, passwd: str, info: str) -> int:
        """Set the notes of the kinematic calibration. Not in the manual."""
        return self._call("set_kinematic_calibration_info", (passwd, info))

    def save_kinematic_calibration_params(self, passwd: str) -> int:
        """Save the kinematic calibration. Not in the manual."""
        return self._call("save_kinematic_calibration_params", (passwd,))

    def get_vibration_calibration_params(self) -> list[list[float]]:
        """Parameters of the vibration calibration. Not in the manual."""
        return self._call("get_vibration_calibration_params", ())

    def set_vibration_calibration_info(self, passwd: str, info: str) -> int:
        """Set the notes of the vibration calibration. Not in the manual."""
        return self._call("set_vibration_calibration_info", (passwd, info))

    def upload_robot_param_to_toolboard(self, passwd: str) -> int:
        """Write the robot's parameters to the tool board. Not in the manual."""
        return self._call("upload_robot_param_to_toolboard", (passwd,))


class NewerFunctions(Functions):
    """The same, with those that manual 4.3 adds; older controllers do not have them."""

    __slots__ = ()

    def get_base(self) -> list[float]:
        """Pose of the arm's base, m, rad. Manual 4.3."""
        return self._call("get_base", ())

    def get_home_pose(self) -> list[float]:
        """Joints of the home position, rad. Manual 4.3."""
        return self._call("get_home_pose", ())

    def get_installation(self) -> list[float]:
        """Angles at which the arm is mounted: ry and rz. Manual 4.3."""
        return self._call("get_installation", ())

    def get_tcp_pose_command(self) -> list[float]:
        """Commanded pose of the tool, m, rad. In no manual."""
        return self._call("get_tcp_pose_command", ())

    def get_tcp_speed_command(self) -> list[float]:
        """Commanded speed of the tool, m/s, rad/s. In no manual."""
        return self._call("get_tcp_speed_command", ())

    def enable_laser_track(self) -> int:
        """Let motions track a seam by a laser sensor. Manual 4.3."""
        return self._call("enable_laser_track", ())

    def disable_laser_track(self) -> int:
        """End the tracking of a seam. Manual 4.3."""
        return self._call("disable_laser_track", ())

    def reset_laser_track(self) -> int:
        """Forget the offsets that the laser sensor found. Manual 4.3."""
        return self._call("reset_laser_track", ())

    def get_simulation_state(self) -> bool:
        """Whether the controller simulates the arm. Manual 4.3."""
        return self._call("get_simulation_state", ())

    def clear_error_message(self) -> None:
        """Empty the list of errors. Manual 4.3."""
        return self._call("clear_error_message", ())


class RpcClient(NewerFunctions):
    """Every function of the wire, for callers that own a thread; `call` sends one."""

    __slots__ = ("_send",)

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Any]) -> None:
        self._send = call

    def _call(self, name: str, args: tuple[Any, ...]) -> Any:
        return self._send(name, args)


@dataclass(frozen=True, slots=True)
class WireCall(Generic[R_co]):
    """A call of the wire as a value; `R_co` is the type of its answer.

    Attributes:
        name: the function.
        args: one value per parameter.
    """

    name: str
    args: tuple[Any, ...]


class WireFunction(Protocol[P, R_co]):
    """A function of the wire, as type checkers see it in `AsyncRpc` and in `WireCalls`."""

    @overload
    def __get__(
        self, client: AsyncRpc, kind: type | None = None
    ) -> Callable[P, Coroutine[Any, Any, R_co]]: ...

    @overload
    def __get__(
        self, client: WireCalls, kind: type | None = None
    ) -> Callable[P, WireCall[R_co]]: ...


def taken_over(function: Callable[Concatenate[NewerFunctions, P], R]) -> WireFunction[P, R]:
    """The same function: it returns what `_call` of its new class returns."""
    return cast("WireFunction[P, R]", function)


class _TakenOver:
    """Every function of the wire, for classes whose `_call` returns something else."""

    __slots__ = ()

    rpc_heartbeat: Final = taken_over(Functions.rpc_heartbeat)
    power_on: Final = taken_over(Functions.power_on)
    power_off: Final = taken_over(Functions.power_off)
    enable: Final = taken_over(Functions.enable)
    disable: Final = taken_over(Functions.disable)
    shutdown: Final = taken_over(Functions.shutdown)
    restart: Final = taken_over(Functions.restart)
    stop: Final = taken_over(Functions.stop)
    pause: Final = taken_over(Functions.pause)
    resume: Final = taken_over(Functions.resume)
    abort: Final = taken_over(Functions.abort)
    run_program: Final = taken_over(Functions.run_program)
    get_current_project: Final = taken_over(Functions.get_current_project)
    get_files_list: Final = taken_over(Functions.get_files_list)
    movej2: Final = taken_over(Functions.movej2)
    movej_pose2: Final = taken_over(Functions.movej_pose2)
    movel: Final = taken_over(Functions.movel)
    movec: Final = taken_over(Functions.movec)
    move_circle: Final = taken_over(Functions.move_circle)
    tcp_move: Final = taken_over(Functions.tcp_move)
    tcp_move_2p: Final = taken_over(Functions.tcp_move_2p)
    wobj_move: Final = taken_over(Functions.wobj_move)
    wobj_move_2p: Final = taken_over(Functions.wobj_move_2p)
    speedj: Final = taken_over(Functions.speedj)
    speedl: Final = taken_over(Functions.speedl)
    speed_stop: Final = taken_over(Functions.speed_stop)
    teach_mode: Final = taken_over(Functions.teach_mode)
    end_teach_mode: Final = taken_over(Functions.end_teach_mode)
    set_hand_teach_parameter: Final = taken_over(Functions.set_hand_teach_parameter)
    replay: Final = taken_over(Functions.replay)
    spline: Final = taken_over(Functions.spline)
    spline_op: Final = taken_over(Functions.spline_op)
    servoj: Final = taken_over(Functions.servoj)
    servoj_pose: Final = taken_over(Functions.servoj_pose)
    servo_tcp: Final = taken_over(Functions.servo_tcp)
    servol: Final = taken_over(Functions.servol)
    move_spiral: Final = taken_over(Functions.move_spiral)
    move_jog: Final = taken_over(Functions.move_jog)
    stop_manual_move: Final = taken_over(Functions.stop_manual_move)
    set_blend_ahead: Final = taken_over(Functions.set_blend_ahead)
    movej: Final = taken_over(Functions.movej)
    movej_pose: Final = taken_over(Functions.movej_pose)
    set_baudrate_485: Final = taken_over(Functions.set_baudrate_485)
    read_raw_data_485: Final = taken_over(Functions.read_raw_data_485)
    read_raw_data_485_h: Final = taken_over(Functions.read_raw_data_485_h)
    read_raw_data_485_ht: Final = taken_over(Functions.read_raw_data_485_ht)
    write_raw_data_485: Final = taken_over(Functions.write_raw_data_485)
    write_raw_data_485_h: Final = taken_over(Functions.write_raw_data_485_h)
    write_raw_data_485_ht: Final = taken_over(Functions.write_raw_data_485_ht)
    read_data_485: Final = taken_over(Functions.read_data_485)
    write_data_485: Final = taken_over(Functions.write_data_485)
    tool_read_raw_data_485: Final = taken_over(Functions.tool_read_raw_data_485)
    tool_read_raw_data_485_h: Final = taken_over(Functions.tool_read_raw_data_485_h)
    tool_read_raw_data_485_ht: Final = taken_over(Functions.tool_read_raw_data_485_ht)
    tool_write_raw_data_485: Final = taken_over(Functions.tool_write_raw_data_485)
    tool_write_raw_data_485_h: Final = taken_over(Functions.tool_write_raw_data_485_h)
    tool_write_raw_data_485_ht: Final = taken_over(Functions.tool_write_raw_data_485_ht)
    tool_read_data_485: Final = taken_over(Functions.tool_read_data_485)
    tool_write_data_485: Final = taken_over(Functions.tool_write_data_485)
    set_baudrate_can: Final = taken_over(Functions.set_baudrate_can)
    read_raw_data_can: Final = taken_over(Functions.read_raw_data_can)
    write_raw_data_can: Final = taken_over(Functions.write_raw_data_can)
    read_data_can: Final = taken_over(Functions.read_data_can)
    write_data_can: Final = taken_over(Functions.write_data_can)
    set_digital_output_mode: Final = taken_over(Functions.set_digital_output_mode)
    set_standard_digital_out: Final = taken_over(Functions.set_standard_digital_out)
    get_standard_digital_out: Final = taken_over(Functions.get_standard_digital_out)
    get_standard_digital_in: Final = taken_over(Functions.get_standard_digital_in)
    set_tool_digital_out: Final = taken_over(Functions.set_tool_digital_out)
    get_tool_digital_out: Final = taken_over(Functions.get_tool_digital_out)
    get_tool_digital_in: Final = taken_over(Functions.get_tool_digital_in)
    get_config_digital_in: Final = taken_over(Functions.get_config_digital_in)
    get_function_digital_in: Final = taken_over(Functions.get_function_digital_in)
    get_function_digital_out: Final = taken_over(Functions.get_function_digital_out)
    get_standard_analog_voltage_in: Final = taken_over(Functions.get_standard_analog_voltage_in)
    set_standard_analog_voltage_out: Final = taken_over(Functions.set_standard_analog_voltage_out)
    get_tool_analog_voltage_in: Final = taken_over(Functions.get_tool_analog_voltage_in)
    get_standard_analog_current_in: Final = taken_over(Functions.get_standard_analog_current_in)
    set_standard_analog_current_out: Final = taken_over(Functions.set_standard_analog_current_out)
    set_analog_output_mode: Final = taken_over(Functions.set_analog_output_mode)
    write_bool_reg: Final = taken_over(Functions.write_bool_reg)
    write_word_reg: Final = taken_over(Functions.write_word_reg)
    write_float_reg: Final = taken_over(Functions.write_float_reg)
    read_bool_reg: Final = taken_over(Functions.read_bool_reg)
    read_word_reg: Final = taken_over(Functions.read_word_reg)
    read_float_reg: Final = taken_over(Functions.read_float_reg)
    get_function_reg_in: Final = taken_over(Functions.get_function_reg_in)
    get_function_reg_out: Final = taken_over(Functions.get_function_reg_out)
    set_wobj_offset: Final = taken_over(Functions.set_wobj_offset)
    set_wobj: Final = taken_over(Functions.set_wobj)
    set_tool_data: Final = taken_over(Functions.set_tool_data)
    cal_ikine: Final = taken_over(Functions.cal_ikine)
    cal_fkine: Final = taken_over(Functions.cal_fkine)
    get_tcp_pose: Final = taken_over(Functions.get_tcp_pose)
    get_tcp_pose_coord: Final = taken_over(Functions.get_tcp_pose_coord)
    get_tcp_speed: Final = taken_over(Functions.get_tcp_speed)
    get_tcp_acceleration: Final = taken_over(Functions.get_tcp_acceleration)
    get_tcp_force: Final = taken_over(Functions.get_tcp_force)
    get_tcp_force_tool: Final = taken_over(Functions.get_tcp_force_tool)
    get_tcp_offset: Final = taken_over(Functions.get_tcp_offset)
    get_tool_load: Final = taken_over(Functions.get_tool_load)
    get_wobj: Final = taken_over(Functions.get_wobj)
    get_actual_joints_position: Final = taken_over(Functions.get_actual_joints_position)
    get_target_joints_position: Final = taken_over(Functions.get_target_joints_position)
    get_actual_joints_speed: Final = taken_over(Functions.get_actual_joints_speed)
    get_target_joints_speed: Final = taken_over(Functions.get_target_joints_speed)
    get_actual_joints_acceleration: Final = taken_over(Functions.get_actual_joints_acceleration)
    get_target_joints_acceleration: Final = taken_over(Functions.get_target_joints_acceleration)
    get_actual_joints_torque: Final = taken_over(Functions.get_actual_joints_torque)
    get_target_joints_torque: Final = taken_over(Functions.get_target_joints_torque)
    get_flange_pose: Final = taken_over(Functions.get_flange_pose)
    get_flange_speed: Final = taken_over(Functions.get_flange_speed)
    get_flange_acceleration: Final = taken_over(Functions.get_flange_acceleration)
    get_robot_state: Final = taken_over(Functions.get_robot_state)
    simulation: Final = taken_over(Functions.simulation)
    speed: Final = taken_over(Functions.speed)
    set_load_data: Final = taken_over(Functions.set_load_data)
    start_record_track: Final = taken_over(Functions.start_record_track)
    stop_record_track: Final = taken_over(Functions.stop_record_track)
    collision_detect: Final = taken_over(Functions.collision_detect)
    collision_detection_reset: Final = taken_over(Functions.collision_detection_reset)
    set_teach_pendant: Final = taken_over(Functions.set_teach_pendant)
    set_teach_speed: Final = taken_over(Functions.set_teach_speed)
    get_teach_speed: Final = taken_over(Functions.get_teach_speed)
    get_global_speed: Final = taken_over(Functions.get_global_speed)
    reach_check: Final = taken_over(Functions.reach_check)
    switch_mode: Final = taken_over(Functions.switch_mode)
    getRobotStatus: Final = taken_over(Functions.getRobotStatus)
    getRobotIOStatus: Final = taken_over(Functions.getRobotIOStatus)
    read_encoder_count: Final = taken_over(Functions.read_encoder_count)
    get_origin_DH: Final = taken_over(Functions.get_origin_DH)
    get_calib_DH: Final = taken_over(Functions.get_calib_DH)
    get_robot_type: Final = taken_over(Functions.get_robot_type)
    get_ext_torque: Final = taken_over(Functions.get_ext_torque)
    set_system_value_bool: Final = taken_over(Functions.set_system_value_bool)
    set_system_value_double: Final = taken_over(Functions.set_system_value_double)
    set_system_value_str: Final = taken_over(Functions.set_system_value_str)
    set_system_value_list: Final = taken_over(Functions.set_system_value_list)
    get_system_value_bool: Final = taken_over(Functions.get_system_value_bool)
    get_system_value_double: Final = taken_over(Functions.get_system_value_double)
    get_system_value_str: Final = taken_over(Functions.get_system_value_str)
    get_system_value_list: Final = taken_over(Functions.get_system_value_list)
    get_system_value_lists: Final = taken_over(Functions.get_system_value_lists)
    log_info: Final = taken_over(Functions.log_info)
    log_error: Final = taken_over(Functions.log_error)
    get_last_error: Final = taken_over(Functions.get_last_error)
    get_noneblock_taskstate: Final = taken_over(Functions.get_noneblock_taskstate)
    robotmoving: Final = taken_over(Functions.robotmoving)
    modbus_read: Final = taken_over(Functions.modbus_read)
    modbus_write: Final = taken_over(Functions.modbus_write)
    modbus_set_frequency: Final = taken_over(Functions.modbus_set_frequency)
    modbus_write_multiple_regs: Final = taken_over(Functions.modbus_write_multiple_regs)
    modbus_write_multiple_coils: Final = taken_over(Functions.modbus_write_multiple_coils)
    modbus_add_signal: Final = taken_over(Functions.modbus_add_signal)
    modbus_delete_signal: Final = taken_over(Functions.modbus_delete_signal)
    fc_start: Final = taken_over(Functions.fc_start)
    fc_stop: Final = taken_over(Functions.fc_stop)
    fc_config: Final = taken_over(Functions.fc_config)
    fc_move: Final = taken_over(Functions.fc_move)
    fc_guard_act: Final = taken_over(Functions.fc_guard_act)
    fc_guard_deact: Final = taken_over(Functions.fc_guard_deact)
    fc_force_set_value: Final = taken_over(Functions.fc_force_set_value)
    fc_wait_pos: Final = taken_over(Functions.fc_wait_pos)
    fc_wait_vel: Final = taken_over(Functions.fc_wait_vel)
    fc_wait_ft: Final = taken_over(Functions.fc_wait_ft)
    fc_wait_logic: Final = taken_over(Functions.fc_wait_logic)
    fc_get_ft: Final = taken_over(Functions.fc_get_ft)
    fc_mode_is_active: Final = taken_over(Functions.fc_mode_is_active)
    enable_speed_optimization: Final = taken_over(Functions.enable_speed_optimization)
    disable_speed_optimization: Final = taken_over(Functions.disable_speed_optimization)
    enable_acc_optimization: Final = taken_over(Functions.enable_acc_optimization)
    disable_acc_optimization: Final = taken_over(Functions.disable_acc_optimization)
    enable_singularity_control: Final = taken_over(Functions.enable_singularity_control)
    disable_singularity_control: Final = taken_over(Functions.disable_singularity_control)
    enable_vibration_control: Final = taken_over(Functions.enable_vibration_control)
    disable_vibration_control: Final = taken_over(Functions.disable_vibration_control)
    trackEnqueue: Final = taken_over(Functions.trackEnqueue)
    trackClearQueue: Final = taken_over(Functions.trackClearQueue)
    getQueueSize: Final = taken_over(Functions.getQueueSize)
    trackJointMotion: Final = taken_over(Functions.trackJointMotion)
    trackCartMotion: Final = taken_over(Functions.trackCartMotion)
    trackEnqueueOp: Final = taken_over(Functions.trackEnqueueOp)
    combine_motion_config: Final = taken_over(Functions.combine_motion_config)
    enable_combine_motion: Final = taken_over(Functions.enable_combine_motion)
    disable_combine_motion: Final = taken_over(Functions.disable_combine_motion)
    enable_eaxis_scheme: Final = taken_over(Functions.enable_eaxis_scheme)
    disable_eaxis_scheme: Final = taken_over(Functions.disable_eaxis_scheme)
    move_eaxis: Final = taken_over(Functions.move_eaxis)
    move_jog_eaxis: Final = taken_over(Functions.move_jog_eaxis)
    movej2_eaxis: Final = taken_over(Functions.movej2_eaxis)
    movej2_pose_eaxis: Final = taken_over(Functions.movej2_pose_eaxis)
    movel_eaxis: Final = taken_over(Functions.movel_eaxis)
    movec_eaxis: Final = taken_over(Functions.movec_eaxis)
    move_circle_eaxis: Final = taken_over(Functions.move_circle_eaxis)
    get_eaxis_info: Final = taken_over(Functions.get_eaxis_info)
    set_eaxis_param: Final = taken_over(Functions.set_eaxis_param)
    set_eaxiss_scheme_param: Final = taken_over(Functions.set_eaxiss_scheme_param)
    add_eaxis_scheme: Final = taken_over(Functions.add_eaxis_scheme)
    delete_eaxis_scheme: Final = taken_over(Functions.delete_eaxis_scheme)
    start_realtime_mode: Final = taken_over(Functions.start_realtime_mode)
    end_realtime_mode: Final = taken_over(Functions.end_realtime_mode)
    realtime_data_enqueue: Final = taken_over(Functions.realtime_data_enqueue)
    clear_realtime_data_queue: Final = taken_over(Functions.clear_realtime_data_queue)
    get_realtime_data_queue_size: Final = taken_over(Functions.get_realtime_data_queue_size)
    get_robot_version: Final = taken_over(Functions.get_robot_version)
    change_recipe: Final = taken_over(Functions.change_recipe)
    set_pendant_type: Final = taken_over(Functions.set_pendant_type)
    set_servo_config: Final = taken_over(Functions.set_servo_config)
    apply_servo_config: Final = taken_over(Functions.apply_servo_config)
    set_servo_file_params: Final = taken_over(Functions.set_servo_file_params)
    get_axis_motor_kt: Final = taken_over(Functions.get_axis_motor_kt)
    get_axis_motor_rated_current: Final = taken_over(Functions.get_axis_motor_rated_current)
    get_axis_ratio: Final = taken_over(Functions.get_axis_ratio)
    get_motor_pole_pair_number: Final = taken_over(Functions.get_motor_pole_pair_number)
    get_motor_stator_slots: Final = taken_over(Functions.get_motor_stator_slots)
    get_pos_bias: Final = taken_over(Functions.get_pos_bias)
    get_dynamic_calibration_params: Final = taken_over(Functions.get_dynamic_calibration_params)
    set_dynamic_calibration_params: Final = taken_over(Functions.set_dynamic_calibration_params)
    set_dynamic_calibration_info: Final = taken_over(Functions.set_dynamic_calibration_info)
    save_dynamic_calibration_params: Final = taken_over(Functions.save_dynamic_calibration_params)
    set_kinematic_calibration_params: Final = taken_over(Functions.set_kinematic_calibration_params)
    set_kinematic_calibration_info: Final = taken_over(Functions.set_kinematic_calibration_info)
    save_kinematic_calibration_params: Final = taken_over(Functions.save_kinematic_calibration_params)
    get_vibration_calibration_params: Final = taken_over(Functions.get_vibration_calibration_params)
    set_vibration_calibration_info: Final = taken_over(Functions.set_vibration_calibration_info)
    upload_robot_param_to_toolboard: Final = taken_over(Functions.upload_robot_param_to_toolboard)
    get_base: Final = taken_over(NewerFunctions.get_base)
    get_home_pose: Final = taken_over(NewerFunctions.get_home_pose)
    get_installation: Final = taken_over(NewerFunctions.get_installation)
    get_tcp_pose_command: Final = taken_over(NewerFunctions.get_tcp_pose_command)
    get_tcp_speed_command: Final = taken_over(NewerFunctions.get_tcp_speed_command)
    enable_laser_track: Final = taken_over(NewerFunctions.enable_laser_track)
    disable_laser_track: Final = taken_over(NewerFunctions.disable_laser_track)
    reset_laser_track: Final = taken_over(NewerFunctions.reset_laser_track)
    get_simulation_state: Final = taken_over(NewerFunctions.get_simulation_state)
    clear_error_message: Final = taken_over(NewerFunctions.clear_error_message)


class AsyncRpc(_TakenOver):
    """Every function of the wire, awaited; `call` is a coroutine function."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Coroutine[Any, Any, Any]]) -> None:
        self._call = call

    def send(self, call: WireCall[R]) -> Coroutine[Any, Any, R]:
        """Send a call that was made as a value."""
        return self._call(call.name, call.args)


class WireCalls(_TakenOver):
    """Every function of the wire, as a value: it checks the types, and sends nothing."""

    __slots__ = ()
    _call = WireCall


calls: Final = WireCalls()
