"""The controller's interface as Python types: structs, clients, the handler protocol.

Generated from `idl/robot.thrift` by `idl/generate.py`; change those, not this. Nothing here
knows Thrift: `aioduco._wire.idl` binds the structs to the loaded IDL.

A field that the other side left out has the zero value of its type, as in the C++ code that
controllers run.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

Spec = dict[int, tuple[Any, ...]]


@dataclass(slots=True)
class Op:
    """Op."""

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
    """PointOp."""

    thrift_spec: ClassVar[Spec] = {}
    pos: list[float] = field(default_factory=list)
    op: Op = field(default_factory=Op)


@dataclass(slots=True)
class RobotStatus:
    """RobotStatus."""

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
    """IOStatus."""

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
    """MoveJogTaskParam."""

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
    """ReachabilityParam."""

    thrift_spec: ClassVar[Spec] = {}
    result: bool = False
    joints_pos: list[list[float]] = field(default_factory=list)


@dataclass(slots=True)
class EAxissInfo:
    """EAxissInfo."""

    thrift_spec: ClassVar[Spec] = {}
    scheme_name: str = ""
    status: int = 0
    pos: float = 0.0


@dataclass(slots=True)
class RealTimeControlData:
    """RealTimeControlData."""

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
    """EAxisParam."""

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
    """EAxisSchemeParam."""

    thrift_spec: ClassVar[Spec] = {}
    type: int = 0
    axis_link: list[int] = field(default_factory=list)
    base: list[float] = field(default_factory=list)
    dh: list[list[float]] = field(default_factory=list)
    install: int = 0


class RpcClient:
    """Every function of the wire, for callers that own a thread; `call` sends one."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Any]) -> None:
        self._call = call

    def abort(self, block: bool) -> int:
        """abort."""
        result: int = self._call("abort", (block,))
        return result

    def add_eaxis_scheme(self, num: int, block: bool) -> int:
        """add_eaxis_scheme."""
        result: int = self._call("add_eaxis_scheme", (num, block))
        return result

    def apply_servo_config(self, axis_num: int, block: bool) -> int:
        """apply_servo_config."""
        result: int = self._call("apply_servo_config", (axis_num, block))
        return result

    def cal_fkine(
        self,
        joints_position: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """cal_fkine."""
        result: list[float] = self._call("cal_fkine", (joints_position, tool, wobj))
        return result

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> list[float]:
        """cal_ikine."""
        result: list[float] = self._call("cal_ikine", (p, q_near, tool, wobj))
        return result

    def change_recipe(self) -> None:
        """change_recipe."""
        self._call("change_recipe", ())

    def clear_realtime_data_queue(self) -> int:
        """clear_realtime_data_queue."""
        result: int = self._call("clear_realtime_data_queue", ())
        return result

    def collision_detect(self, value: int) -> int:
        """collision_detect."""
        result: int = self._call("collision_detect", (value,))
        return result

    def collision_detection_reset(self) -> int:
        """collision_detection_reset."""
        result: int = self._call("collision_detection_reset", ())
        return result

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
        """combine_motion_config."""
        result: int = self._call(
            "combine_motion_config",
            (type, ref_plane, fq, amp, el_offset, az_offset, up_height, time, path_dwell, op_list),
        )
        return result

    def delete_eaxis_scheme(self, num: int, block: bool) -> int:
        """delete_eaxis_scheme."""
        result: int = self._call("delete_eaxis_scheme", (num, block))
        return result

    def disable(self, block: bool) -> int:
        """disable."""
        result: int = self._call("disable", (block,))
        return result

    def disable_acc_optimization(self) -> int:
        """disable_acc_optimization."""
        result: int = self._call("disable_acc_optimization", ())
        return result

    def disable_combine_motion(self) -> int:
        """disable_combine_motion."""
        result: int = self._call("disable_combine_motion", ())
        return result

    def disable_eaxis_scheme(self, scheme_name: str) -> int:
        """disable_eaxis_scheme."""
        result: int = self._call("disable_eaxis_scheme", (scheme_name,))
        return result

    def disable_singularity_control(self) -> int:
        """disable_singularity_control."""
        result: int = self._call("disable_singularity_control", ())
        return result

    def disable_speed_optimization(self) -> int:
        """disable_speed_optimization."""
        result: int = self._call("disable_speed_optimization", ())
        return result

    def disable_vibration_control(self) -> int:
        """disable_vibration_control."""
        result: int = self._call("disable_vibration_control", ())
        return result

    def enable(self, block: bool) -> int:
        """enable."""
        result: int = self._call("enable", (block,))
        return result

    def enable_acc_optimization(self) -> int:
        """enable_acc_optimization."""
        result: int = self._call("enable_acc_optimization", ())
        return result

    def enable_combine_motion(self) -> int:
        """enable_combine_motion."""
        result: int = self._call("enable_combine_motion", ())
        return result

    def enable_eaxis_scheme(self, scheme_name: str) -> int:
        """enable_eaxis_scheme."""
        result: int = self._call("enable_eaxis_scheme", (scheme_name,))
        return result

    def enable_singularity_control(self) -> int:
        """enable_singularity_control."""
        result: int = self._call("enable_singularity_control", ())
        return result

    def enable_speed_optimization(self) -> int:
        """enable_speed_optimization."""
        result: int = self._call("enable_speed_optimization", ())
        return result

    def enable_vibration_control(self) -> int:
        """enable_vibration_control."""
        result: int = self._call("enable_vibration_control", ())
        return result

    def end_realtime_mode(self) -> int:
        """end_realtime_mode."""
        result: int = self._call("end_realtime_mode", ())
        return result

    def end_teach_mode(self, block: bool) -> int:
        """end_teach_mode."""
        result: int = self._call("end_teach_mode", (block,))
        return result

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
        """fc_config."""
        result: int = self._call(
            "fc_config",
            (direction, ref_ft, damp, max_vel, number_list, tool, wobj, value),
        )
        return result

    def fc_force_set_value(self, direction: Sequence[bool], ref_ft: Sequence[float]) -> int:
        """fc_force_set_value."""
        result: int = self._call("fc_force_set_value", (direction, ref_ft))
        return result

    def fc_get_ft(self) -> list[float]:
        """fc_get_ft."""
        result: list[float] = self._call("fc_get_ft", ())
        return result

    def fc_guard_act(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        tool: str,
        wobj: str,
        type: int,
        force_property: int,
    ) -> int:
        """fc_guard_act."""
        result: int = self._call(
            "fc_guard_act",
            (direction, ref_ft, tool, wobj, type, force_property),
        )
        return result

    def fc_guard_deact(self) -> int:
        """fc_guard_deact."""
        result: int = self._call("fc_guard_deact", ())
        return result

    def fc_mode_is_active(self) -> bool:
        """fc_mode_is_active."""
        result: bool = self._call("fc_mode_is_active", ())
        return result

    def fc_move(self, block: bool) -> int:
        """fc_move."""
        result: int = self._call("fc_move", (block,))
        return result

    def fc_start(self) -> int:
        """fc_start."""
        result: int = self._call("fc_start", ())
        return result

    def fc_stop(self) -> int:
        """fc_stop."""
        result: int = self._call("fc_stop", ())
        return result

    def fc_wait_ft(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """fc_wait_ft."""
        result: int = self._call("fc_wait_ft", (middle, range, absolute, duration, timeout))
        return result

    def fc_wait_logic(self, value: Sequence[int]) -> int:
        """fc_wait_logic."""
        result: int = self._call("fc_wait_logic", (value,))
        return result

    def fc_wait_pos(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """fc_wait_pos."""
        result: int = self._call("fc_wait_pos", (middle, range, absolute, duration, timeout))
        return result

    def fc_wait_vel(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int:
        """fc_wait_vel."""
        result: int = self._call("fc_wait_vel", (middle, range, absolute, duration, timeout))
        return result

    def getQueueSize(self) -> int:
        """getQueueSize."""
        result: int = self._call("getQueueSize", ())
        return result

    def getRobotIOStatus(self) -> IOStatus:
        """getRobotIOStatus."""
        result: IOStatus = self._call("getRobotIOStatus", ())
        return result

    def getRobotStatus(self) -> RobotStatus:
        """getRobotStatus."""
        result: RobotStatus = self._call("getRobotStatus", ())
        return result

    def get_actual_joints_acceleration(self) -> list[float]:
        """get_actual_joints_acceleration."""
        result: list[float] = self._call("get_actual_joints_acceleration", ())
        return result

    def get_actual_joints_position(self) -> list[float]:
        """get_actual_joints_position."""
        result: list[float] = self._call("get_actual_joints_position", ())
        return result

    def get_actual_joints_speed(self) -> list[float]:
        """get_actual_joints_speed."""
        result: list[float] = self._call("get_actual_joints_speed", ())
        return result

    def get_actual_joints_torque(self) -> list[float]:
        """get_actual_joints_torque."""
        result: list[float] = self._call("get_actual_joints_torque", ())
        return result

    def get_axis_motor_kt(self) -> list[float]:
        """get_axis_motor_kt."""
        result: list[float] = self._call("get_axis_motor_kt", ())
        return result

    def get_axis_motor_rated_current(self) -> list[float]:
        """get_axis_motor_rated_current."""
        result: list[float] = self._call("get_axis_motor_rated_current", ())
        return result

    def get_axis_ratio(self) -> list[int]:
        """get_axis_ratio."""
        result: list[int] = self._call("get_axis_ratio", ())
        return result

    def get_calib_DH(self) -> list[list[float]]:
        """get_calib_DH."""
        result: list[list[float]] = self._call("get_calib_DH", ())
        return result

    def get_config_digital_in(self, num: int) -> bool:
        """get_config_digital_in."""
        result: bool = self._call("get_config_digital_in", (num,))
        return result

    def get_current_project(self) -> str:
        """get_current_project."""
        result: str = self._call("get_current_project", ())
        return result

    def get_dynamic_calibration_params(self) -> list[list[float]]:
        """get_dynamic_calibration_params."""
        result: list[list[float]] = self._call("get_dynamic_calibration_params", ())
        return result

    def get_eaxis_info(self) -> list[EAxissInfo]:
        """get_eaxis_info."""
        result: list[EAxissInfo] = self._call("get_eaxis_info", ())
        return result

    def get_ext_torque(self) -> list[float]:
        """get_ext_torque."""
        result: list[float] = self._call("get_ext_torque", ())
        return result

    def get_files_list(self, path: str) -> dict[str, int]:
        """get_files_list."""
        result: dict[str, int] = self._call("get_files_list", (path,))
        return result

    def get_flange_acceleration(self) -> list[float]:
        """get_flange_acceleration."""
        result: list[float] = self._call("get_flange_acceleration", ())
        return result

    def get_flange_pose(self) -> list[float]:
        """get_flange_pose."""
        result: list[float] = self._call("get_flange_pose", ())
        return result

    def get_flange_speed(self) -> list[float]:
        """get_flange_speed."""
        result: list[float] = self._call("get_flange_speed", ())
        return result

    def get_function_digital_in(self, num: int) -> bool:
        """get_function_digital_in."""
        result: bool = self._call("get_function_digital_in", (num,))
        return result

    def get_function_digital_out(self, num: int) -> bool:
        """get_function_digital_out."""
        result: bool = self._call("get_function_digital_out", (num,))
        return result

    def get_function_reg_in(self, num: int) -> bool:
        """get_function_reg_in."""
        result: bool = self._call("get_function_reg_in", (num,))
        return result

    def get_function_reg_out(self, num: int) -> bool:
        """get_function_reg_out."""
        result: bool = self._call("get_function_reg_out", (num,))
        return result

    def get_global_speed(self) -> int:
        """get_global_speed."""
        result: int = self._call("get_global_speed", ())
        return result

    def get_last_error(self) -> list[str]:
        """get_last_error."""
        result: list[str] = self._call("get_last_error", ())
        return result

    def get_motor_pole_pair_number(self) -> list[int]:
        """get_motor_pole_pair_number."""
        result: list[int] = self._call("get_motor_pole_pair_number", ())
        return result

    def get_motor_stator_slots(self) -> list[int]:
        """get_motor_stator_slots."""
        result: list[int] = self._call("get_motor_stator_slots", ())
        return result

    def get_noneblock_taskstate(self, id: int) -> int:
        """get_noneblock_taskstate."""
        result: int = self._call("get_noneblock_taskstate", (id,))
        return result

    def get_origin_DH(self) -> list[list[float]]:
        """get_origin_DH."""
        result: list[list[float]] = self._call("get_origin_DH", ())
        return result

    def get_pos_bias(self) -> list[float]:
        """get_pos_bias."""
        result: list[float] = self._call("get_pos_bias", ())
        return result

    def get_realtime_data_queue_size(self) -> int:
        """get_realtime_data_queue_size."""
        result: int = self._call("get_realtime_data_queue_size", ())
        return result

    def get_robot_state(self) -> list[int]:
        """get_robot_state."""
        result: list[int] = self._call("get_robot_state", ())
        return result

    def get_robot_type(self) -> list[str]:
        """get_robot_type."""
        result: list[str] = self._call("get_robot_type", ())
        return result

    def get_robot_version(self) -> str:
        """get_robot_version."""
        result: str = self._call("get_robot_version", ())
        return result

    def get_standard_analog_current_in(self, num: int) -> float:
        """get_standard_analog_current_in."""
        result: float = self._call("get_standard_analog_current_in", (num,))
        return result

    def get_standard_analog_voltage_in(self, num: int) -> float:
        """get_standard_analog_voltage_in."""
        result: float = self._call("get_standard_analog_voltage_in", (num,))
        return result

    def get_standard_digital_in(self, num: int) -> bool:
        """get_standard_digital_in."""
        result: bool = self._call("get_standard_digital_in", (num,))
        return result

    def get_standard_digital_out(self, num: int) -> bool:
        """get_standard_digital_out."""
        result: bool = self._call("get_standard_digital_out", (num,))
        return result

    def get_system_value_bool(self, name: str) -> bool:
        """get_system_value_bool."""
        result: bool = self._call("get_system_value_bool", (name,))
        return result

    def get_system_value_double(self, name: str) -> float:
        """get_system_value_double."""
        result: float = self._call("get_system_value_double", (name,))
        return result

    def get_system_value_list(self, name: str) -> list[float]:
        """get_system_value_list."""
        result: list[float] = self._call("get_system_value_list", (name,))
        return result

    def get_system_value_lists(self, name: str) -> list[list[float]]:
        """get_system_value_lists."""
        result: list[list[float]] = self._call("get_system_value_lists", (name,))
        return result

    def get_system_value_str(self, name: str) -> str:
        """get_system_value_str."""
        result: str = self._call("get_system_value_str", (name,))
        return result

    def get_target_joints_acceleration(self) -> list[float]:
        """get_target_joints_acceleration."""
        result: list[float] = self._call("get_target_joints_acceleration", ())
        return result

    def get_target_joints_position(self) -> list[float]:
        """get_target_joints_position."""
        result: list[float] = self._call("get_target_joints_position", ())
        return result

    def get_target_joints_speed(self) -> list[float]:
        """get_target_joints_speed."""
        result: list[float] = self._call("get_target_joints_speed", ())
        return result

    def get_target_joints_torque(self) -> list[float]:
        """get_target_joints_torque."""
        result: list[float] = self._call("get_target_joints_torque", ())
        return result

    def get_tcp_acceleration(self) -> list[float]:
        """get_tcp_acceleration."""
        result: list[float] = self._call("get_tcp_acceleration", ())
        return result

    def get_tcp_force(self) -> list[float]:
        """get_tcp_force."""
        result: list[float] = self._call("get_tcp_force", ())
        return result

    def get_tcp_force_tool(self, tool: str) -> list[float]:
        """get_tcp_force_tool."""
        result: list[float] = self._call("get_tcp_force_tool", (tool,))
        return result

    def get_tcp_offset(self) -> list[float]:
        """get_tcp_offset."""
        result: list[float] = self._call("get_tcp_offset", ())
        return result

    def get_tcp_pose(self) -> list[float]:
        """get_tcp_pose."""
        result: list[float] = self._call("get_tcp_pose", ())
        return result

    def get_tcp_pose_coord(self, tool: str, wobj: str) -> list[float]:
        """get_tcp_pose_coord."""
        result: list[float] = self._call("get_tcp_pose_coord", (tool, wobj))
        return result

    def get_tcp_speed(self) -> list[float]:
        """get_tcp_speed."""
        result: list[float] = self._call("get_tcp_speed", ())
        return result

    def get_teach_speed(self) -> int:
        """get_teach_speed."""
        result: int = self._call("get_teach_speed", ())
        return result

    def get_tool_analog_voltage_in(self, num: int) -> float:
        """get_tool_analog_voltage_in."""
        result: float = self._call("get_tool_analog_voltage_in", (num,))
        return result

    def get_tool_digital_in(self, num: int) -> bool:
        """get_tool_digital_in."""
        result: bool = self._call("get_tool_digital_in", (num,))
        return result

    def get_tool_digital_out(self, num: int) -> bool:
        """get_tool_digital_out."""
        result: bool = self._call("get_tool_digital_out", (num,))
        return result

    def get_tool_load(self) -> list[float]:
        """get_tool_load."""
        result: list[float] = self._call("get_tool_load", ())
        return result

    def get_vibration_calibration_params(self) -> list[list[float]]:
        """get_vibration_calibration_params."""
        result: list[list[float]] = self._call("get_vibration_calibration_params", ())
        return result

    def get_wobj(self) -> list[float]:
        """get_wobj."""
        result: list[float] = self._call("get_wobj", ())
        return result

    def log_error(self, message: str) -> None:
        """log_error."""
        self._call("log_error", (message,))

    def log_info(self, message: str) -> None:
        """log_info."""
        self._call("log_info", (message,))

    def modbus_add_signal(
        self,
        ip: str,
        slave_number: int,
        signal_address: int,
        signal_type: int,
        signal_name: str,
    ) -> int:
        """modbus_add_signal."""
        result: int = self._call(
            "modbus_add_signal",
            (ip, slave_number, signal_address, signal_type, signal_name),
        )
        return result

    def modbus_delete_signal(self, signal_name: str) -> int:
        """modbus_delete_signal."""
        result: int = self._call("modbus_delete_signal", (signal_name,))
        return result

    def modbus_read(self, signal_name: str) -> int:
        """modbus_read."""
        result: int = self._call("modbus_read", (signal_name,))
        return result

    def modbus_set_frequency(self, signal_name: str, frequence: int) -> None:
        """modbus_set_frequency."""
        self._call("modbus_set_frequency", (signal_name, frequence))

    def modbus_write(self, signal_name: str, value: int) -> int:
        """modbus_write."""
        result: int = self._call("modbus_write", (signal_name, value))
        return result

    def modbus_write_multiple_coils(
        self,
        slave_num: int,
        name: str,
        len: int,
        byte_list: Sequence[int],
    ) -> int:
        """modbus_write_multiple_coils."""
        result: int = self._call("modbus_write_multiple_coils", (slave_num, name, len, byte_list))
        return result

    def modbus_write_multiple_regs(
        self,
        slave_num: int,
        name: str,
        len: int,
        word_list: Sequence[int],
    ) -> int:
        """modbus_write_multiple_regs."""
        result: int = self._call("modbus_write_multiple_regs", (slave_num, name, len, word_list))
        return result

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
        """move_circle."""
        result: int = self._call(
            "move_circle",
            (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc),
        )
        return result

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
        """move_circle_eaxis."""
        result: int = self._call(
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
        return result

    def move_eaxis(
        self,
        scheme_name: str,
        epose: Sequence[float],
        v: float,
        block: bool,
        op: Op,
    ) -> int:
        """move_eaxis."""
        result: int = self._call("move_eaxis", (scheme_name, epose, v, block, op))
        return result

    def move_jog(self, param: MoveJogTaskParam, block: bool) -> int:
        """move_jog."""
        result: int = self._call("move_jog", (param, block))
        return result

    def move_jog_eaxis(self, name: str, direction: int, vel: float, block: bool) -> int:
        """move_jog_eaxis."""
        result: int = self._call("move_jog_eaxis", (name, direction, vel, block))
        return result

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
        """move_spiral."""
        result: int = self._call(
            "move_spiral",
            (p1, p2, rev, len, r, mode, v, a, q_near, tool, wobj, block, op, def_acc),
        )
        return result

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
        """movec."""
        result: int = self._call(
            "movec",
            (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc),
        )
        return result

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
        """movec_eaxis."""
        result: int = self._call(
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
        return result

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
        """movej."""
        result: int = self._call("movej", (joints_list, v, a, r, block, op, def_acc))
        return result

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
        """movej2."""
        result: int = self._call("movej2", (joints_list, v, a, r, block, op, def_acc))
        return result

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
        """movej2_eaxis."""
        result: int = self._call(
            "movej2_eaxis",
            (joints_list, v, a, rad, scheme_name, epose, eaxis_v, block, op, def_acc),
        )
        return result

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
        """movej2_pose_eaxis."""
        result: int = self._call(
            "movej2_pose_eaxis",
            (p, v, a, rad, qnear, tool, wobj, scheme_name, epose, eaxis_v, block, op, def_acc),
        )
        return result

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
        """movej_pose."""
        result: int = self._call("movej_pose", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))
        return result

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
        """movej_pose2."""
        result: int = self._call(
            "movej_pose2",
            (p, v, a, r, q_near, tool, wobj, block, op, def_acc),
        )
        return result

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
        """movel."""
        result: int = self._call("movel", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))
        return result

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
        """movel_eaxis."""
        result: int = self._call(
            "movel_eaxis",
            (p, v, a, rad, qnear, tool, wobj, scheme_name, epose, eaxis_v, block, op, def_acc),
        )
        return result

    def pause(self, block: bool) -> int:
        """pause."""
        result: int = self._call("pause", (block,))
        return result

    def power_off(self, block: bool) -> int:
        """power_off."""
        result: int = self._call("power_off", (block,))
        return result

    def power_on(self, block: bool) -> int:
        """power_on."""
        result: int = self._call("power_on", (block,))
        return result

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> ReachabilityParam:
        """reach_check."""
        result: ReachabilityParam = self._call(
            "reach_check",
            (base, wobj, tool, ref_pos, check_points),
        )
        return result

    def read_bool_reg(self, num: int) -> bool:
        """read_bool_reg."""
        result: bool = self._call("read_bool_reg", (num,))
        return result

    def read_data_485(self) -> list[int]:
        """read_data_485."""
        result: list[int] = self._call("read_data_485", ())
        return result

    def read_data_can(self) -> list[int]:
        """read_data_can."""
        result: list[int] = self._call("read_data_can", ())
        return result

    def read_encoder_count(self) -> int:
        """read_encoder_count."""
        result: int = self._call("read_encoder_count", ())
        return result

    def read_float_reg(self, num: int) -> float:
        """read_float_reg."""
        result: float = self._call("read_float_reg", (num,))
        return result

    def read_raw_data_485(self, len: int) -> list[int]:
        """read_raw_data_485."""
        result: list[int] = self._call("read_raw_data_485", (len,))
        return result

    def read_raw_data_485_h(self, head: Sequence[int], len: int) -> list[int]:
        """read_raw_data_485_h."""
        result: list[int] = self._call("read_raw_data_485_h", (head, len))
        return result

    def read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> list[int]:
        """read_raw_data_485_ht."""
        result: list[int] = self._call("read_raw_data_485_ht", (head, tail))
        return result

    def read_raw_data_can(self) -> list[int]:
        """read_raw_data_can."""
        result: list[int] = self._call("read_raw_data_can", ())
        return result

    def read_word_reg(self, num: int) -> int:
        """read_word_reg."""
        result: int = self._call("read_word_reg", (num,))
        return result

    def realtime_data_enqueue(
        self,
        realtime_data: Sequence[RealTimeControlData],
        block: bool,
    ) -> int:
        """realtime_data_enqueue."""
        result: int = self._call("realtime_data_enqueue", (realtime_data, block))
        return result

    def replay(self, name: str, value: int, mode: int) -> int:
        """replay."""
        result: int = self._call("replay", (name, value, mode))
        return result

    def restart(self, block: bool) -> int:
        """restart."""
        result: int = self._call("restart", (block,))
        return result

    def resume(self, block: bool) -> int:
        """resume."""
        result: int = self._call("resume", (block,))
        return result

    def robotmoving(self) -> bool:
        """robotmoving."""
        result: bool = self._call("robotmoving", ())
        return result

    def rpc_heartbeat(self, time: int) -> None:
        """rpc_heartbeat."""
        self._call("rpc_heartbeat", (time,))

    def run_program(self, name: str, block: bool) -> int:
        """run_program."""
        result: int = self._call("run_program", (name, block))
        return result

    def save_dynamic_calibration_params(self, passwd: str) -> int:
        """save_dynamic_calibration_params."""
        result: int = self._call("save_dynamic_calibration_params", (passwd,))
        return result

    def save_kinematic_calibration_params(self, passwd: str) -> int:
        """save_kinematic_calibration_params."""
        result: int = self._call("save_kinematic_calibration_params", (passwd,))
        return result

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
        """servo_tcp."""
        result: int = self._call(
            "servo_tcp",
            (pose_offset, v, a, tool, block, kp, kd, smooth_vel, smooth_acc),
        )
        return result

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
        """servoj."""
        result: int = self._call(
            "servoj",
            (joints_list, v, a, block, kp, kd, smooth_vel, smooth_acc),
        )
        return result

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
        """servoj_pose."""
        result: int = self._call(
            "servoj_pose",
            (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc),
        )
        return result

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
        """servol."""
        result: int = self._call(
            "servol",
            (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc),
        )
        return result

    def set_analog_output_mode(self, num: int, mode: int, block: bool) -> int:
        """set_analog_output_mode."""
        result: int = self._call("set_analog_output_mode", (num, mode, block))
        return result

    def set_baudrate_485(self, value: int, block: bool) -> int:
        """set_baudrate_485."""
        result: int = self._call("set_baudrate_485", (value, block))
        return result

    def set_baudrate_can(self, value: int, block: bool) -> int:
        """set_baudrate_can."""
        result: int = self._call("set_baudrate_can", (value, block))
        return result

    def set_blend_ahead(self, per: int, num: int) -> int:
        """set_blend_ahead."""
        result: int = self._call("set_blend_ahead", (per, num))
        return result

    def set_digital_output_mode(self, num: int, type: int, freq: int, duty_cycle: int) -> int:
        """set_digital_output_mode."""
        result: int = self._call("set_digital_output_mode", (num, type, freq, duty_cycle))
        return result

    def set_dynamic_calibration_info(self, passwd: str, info: str) -> int:
        """set_dynamic_calibration_info."""
        result: int = self._call("set_dynamic_calibration_info", (passwd, info))
        return result

    def set_dynamic_calibration_params(self, params: Sequence[Sequence[float]]) -> int:
        """set_dynamic_calibration_params."""
        result: int = self._call("set_dynamic_calibration_params", (params,))
        return result

    def set_eaxis_param(self, num: int, param: EAxisParam, block: bool) -> int:
        """set_eaxis_param."""
        result: int = self._call("set_eaxis_param", (num, param, block))
        return result

    def set_eaxiss_scheme_param(self, num: int, param: EAxisSchemeParam, block: bool) -> int:
        """set_eaxiss_scheme_param."""
        result: int = self._call("set_eaxiss_scheme_param", (num, param, block))
        return result

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: Sequence[int],
        cart_scale: Sequence[int],
        coord_type: int,
        direction: Sequence[bool],
    ) -> int:
        """set_hand_teach_parameter."""
        result: int = self._call(
            "set_hand_teach_parameter",
            (space, joint_scale, cart_scale, coord_type, direction),
        )
        return result

    def set_kinematic_calibration_info(self, passwd: str, info: str) -> int:
        """set_kinematic_calibration_info."""
        result: int = self._call("set_kinematic_calibration_info", (passwd, info))
        return result

    def set_kinematic_calibration_params(self, params: Sequence[Sequence[float]]) -> int:
        """set_kinematic_calibration_params."""
        result: int = self._call("set_kinematic_calibration_params", (params,))
        return result

    def set_load_data(self, value: Sequence[float]) -> int:
        """set_load_data."""
        result: int = self._call("set_load_data", (value,))
        return result

    def set_pendant_type(self, type: int) -> int:
        """set_pendant_type."""
        result: int = self._call("set_pendant_type", (type,))
        return result

    def set_servo_config(
        self,
        axis_num: int,
        id: int,
        value: int,
        qfmt: int,
        block: bool,
    ) -> int:
        """set_servo_config."""
        result: int = self._call("set_servo_config", (axis_num, id, value, qfmt, block))
        return result

    def set_servo_file_params(
        self,
        axis_num: int,
        id: int,
        name: str,
        value: float,
        qfmt: float,
    ) -> int:
        """set_servo_file_params."""
        result: int = self._call("set_servo_file_params", (axis_num, id, name, value, qfmt))
        return result

    def set_standard_analog_current_out(self, num: int, value: float, block: bool) -> int:
        """set_standard_analog_current_out."""
        result: int = self._call("set_standard_analog_current_out", (num, value, block))
        return result

    def set_standard_analog_voltage_out(self, num: int, value: float, block: bool) -> int:
        """set_standard_analog_voltage_out."""
        result: int = self._call("set_standard_analog_voltage_out", (num, value, block))
        return result

    def set_standard_digital_out(self, num: int, value: bool, block: bool) -> int:
        """set_standard_digital_out."""
        result: int = self._call("set_standard_digital_out", (num, value, block))
        return result

    def set_system_value_bool(self, name: str, value: bool) -> int:
        """set_system_value_bool."""
        result: int = self._call("set_system_value_bool", (name, value))
        return result

    def set_system_value_double(self, name: str, value: float) -> int:
        """set_system_value_double."""
        result: int = self._call("set_system_value_double", (name, value))
        return result

    def set_system_value_list(self, name: str, value: Sequence[float]) -> int:
        """set_system_value_list."""
        result: int = self._call("set_system_value_list", (name, value))
        return result

    def set_system_value_str(self, name: str, value: str) -> int:
        """set_system_value_str."""
        result: int = self._call("set_system_value_str", (name, value))
        return result

    def set_teach_pendant(self, enable: bool) -> int:
        """set_teach_pendant."""
        result: int = self._call("set_teach_pendant", (enable,))
        return result

    def set_teach_speed(self, v: int) -> int:
        """set_teach_speed."""
        result: int = self._call("set_teach_speed", (v,))
        return result

    def set_tool_data(
        self,
        name: str,
        tool_offset: Sequence[float],
        payload: Sequence[float],
        inertia_tensor: Sequence[float],
    ) -> int:
        """set_tool_data."""
        result: int = self._call("set_tool_data", (name, tool_offset, payload, inertia_tensor))
        return result

    def set_tool_digital_out(self, num: int, value: bool, block: bool) -> int:
        """set_tool_digital_out."""
        result: int = self._call("set_tool_digital_out", (num, value, block))
        return result

    def set_vibration_calibration_info(self, passwd: str, info: str) -> int:
        """set_vibration_calibration_info."""
        result: int = self._call("set_vibration_calibration_info", (passwd, info))
        return result

    def set_wobj(self, name: str, wobj: Sequence[float]) -> int:
        """set_wobj."""
        result: int = self._call("set_wobj", (name, wobj))
        return result

    def set_wobj_offset(self, wobj: Sequence[float], active: bool) -> int:
        """set_wobj_offset."""
        result: int = self._call("set_wobj_offset", (wobj, active))
        return result

    def shutdown(self, block: bool) -> int:
        """shutdown."""
        result: int = self._call("shutdown", (block,))
        return result

    def simulation(self, sim: bool, block: bool) -> int:
        """simulation."""
        result: int = self._call("simulation", (sim, block))
        return result

    def speed(self, val: float) -> int:
        """speed."""
        result: int = self._call("speed", (val,))
        return result

    def speed_stop(self, block: bool) -> int:
        """speed_stop."""
        result: int = self._call("speed_stop", (block,))
        return result

    def speedj(self, joints_list: Sequence[float], a: float, time: int, block: bool) -> int:
        """speedj."""
        result: int = self._call("speedj", (joints_list, a, time, block))
        return result

    def speedl(self, pose_list: Sequence[float], a: float, time: int, block: bool) -> int:
        """speedl."""
        result: int = self._call("speedl", (pose_list, a, time, block))
        return result

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
        """spline."""
        result: int = self._call("spline", (pose_list, v, a, tool, wobj, block, op, r, def_acc))
        return result

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
        """spline_op."""
        result: int = self._call("spline_op", (pose_list, v, a, tool, wobj, block, op, r, def_acc))
        return result

    def start_realtime_mode(
        self,
        mode: int,
        fileter_bandwidth: float,
        com_lost_time: float,
    ) -> int:
        """start_realtime_mode."""
        result: int = self._call("start_realtime_mode", (mode, fileter_bandwidth, com_lost_time))
        return result

    def start_record_track(
        self,
        name: str,
        mode: int,
        tool: str,
        wobj: str,
        interval: float,
    ) -> int:
        """start_record_track."""
        result: int = self._call("start_record_track", (name, mode, tool, wobj, interval))
        return result

    def stop(self, block: bool) -> int:
        """stop."""
        result: int = self._call("stop", (block,))
        return result

    def stop_manual_move(self, block: bool) -> int:
        """stop_manual_move."""
        result: int = self._call("stop_manual_move", (block,))
        return result

    def stop_record_track(self) -> int:
        """stop_record_track."""
        result: int = self._call("stop_record_track", ())
        return result

    def switch_mode(self, mode: int) -> int:
        """switch_mode."""
        result: int = self._call("switch_mode", (mode,))
        return result

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
        """tcp_move."""
        result: int = self._call("tcp_move", (pose_offset, v, a, r, tool, block, op, def_acc))
        return result

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
        """tcp_move_2p."""
        result: int = self._call("tcp_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))
        return result

    def teach_mode(self, block: bool) -> int:
        """teach_mode."""
        result: int = self._call("teach_mode", (block,))
        return result

    def tool_read_data_485(self) -> list[int]:
        """tool_read_data_485."""
        result: list[int] = self._call("tool_read_data_485", ())
        return result

    def tool_read_raw_data_485(self, len: int) -> list[int]:
        """tool_read_raw_data_485."""
        result: list[int] = self._call("tool_read_raw_data_485", (len,))
        return result

    def tool_read_raw_data_485_h(self, head: Sequence[int], len: int) -> list[int]:
        """tool_read_raw_data_485_h."""
        result: list[int] = self._call("tool_read_raw_data_485_h", (head, len))
        return result

    def tool_read_raw_data_485_ht(self, head: Sequence[int], tail: Sequence[int]) -> list[int]:
        """tool_read_raw_data_485_ht."""
        result: list[int] = self._call("tool_read_raw_data_485_ht", (head, tail))
        return result

    def tool_write_data_485(self, data: Sequence[int]) -> bool:
        """tool_write_data_485."""
        result: bool = self._call("tool_write_data_485", (data,))
        return result

    def tool_write_raw_data_485(self, data: Sequence[int]) -> bool:
        """tool_write_raw_data_485."""
        result: bool = self._call("tool_write_raw_data_485", (data,))
        return result

    def tool_write_raw_data_485_h(self, data: Sequence[int], head: Sequence[int]) -> bool:
        """tool_write_raw_data_485_h."""
        result: bool = self._call("tool_write_raw_data_485_h", (data, head))
        return result

    def tool_write_raw_data_485_ht(
        self,
        data: Sequence[int],
        head: Sequence[int],
        tail: Sequence[int],
    ) -> bool:
        """tool_write_raw_data_485_ht."""
        result: bool = self._call("tool_write_raw_data_485_ht", (data, head, tail))
        return result

    def trackCartMotion(
        self,
        speed: float,
        acc: float,
        block: bool,
        tool: str,
        wobj: str,
        radius: float,
    ) -> int:
        """trackCartMotion."""
        result: int = self._call("trackCartMotion", (speed, acc, block, tool, wobj, radius))
        return result

    def trackClearQueue(self) -> int:
        """trackClearQueue."""
        result: int = self._call("trackClearQueue", ())
        return result

    def trackEnqueue(self, track: Sequence[Sequence[float]], block: bool) -> int:
        """trackEnqueue."""
        result: int = self._call("trackEnqueue", (track, block))
        return result

    def trackEnqueueOp(self, track: Sequence[PointOp], block: bool) -> int:
        """trackEnqueueOp."""
        result: int = self._call("trackEnqueueOp", (track, block))
        return result

    def trackJointMotion(self, speed: float, acc: float, block: bool) -> int:
        """trackJointMotion."""
        result: int = self._call("trackJointMotion", (speed, acc, block))
        return result

    def upload_robot_param_to_toolboard(self, passwd: str) -> int:
        """upload_robot_param_to_toolboard."""
        result: int = self._call("upload_robot_param_to_toolboard", (passwd,))
        return result

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
        """wobj_move."""
        result: int = self._call("wobj_move", (pose_offset, v, a, r, wobj, block, op, def_acc))
        return result

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
        """wobj_move_2p."""
        result: int = self._call("wobj_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))
        return result

    def write_bool_reg(self, num: int, value: bool) -> int:
        """write_bool_reg."""
        result: int = self._call("write_bool_reg", (num, value))
        return result

    def write_data_485(self, data: Sequence[int]) -> bool:
        """write_data_485."""
        result: bool = self._call("write_data_485", (data,))
        return result

    def write_data_can(self, id: int, data: Sequence[int]) -> bool:
        """write_data_can."""
        result: bool = self._call("write_data_can", (id, data))
        return result

    def write_float_reg(self, num: int, value: float) -> int:
        """write_float_reg."""
        result: int = self._call("write_float_reg", (num, value))
        return result

    def write_raw_data_485(self, data: Sequence[int]) -> bool:
        """write_raw_data_485."""
        result: bool = self._call("write_raw_data_485", (data,))
        return result

    def write_raw_data_485_h(self, data: Sequence[int], head: Sequence[int]) -> bool:
        """write_raw_data_485_h."""
        result: bool = self._call("write_raw_data_485_h", (data, head))
        return result

    def write_raw_data_485_ht(
        self,
        data: Sequence[int],
        head: Sequence[int],
        tail: Sequence[int],
    ) -> bool:
        """write_raw_data_485_ht."""
        result: bool = self._call("write_raw_data_485_ht", (data, head, tail))
        return result

    def write_raw_data_can(self, id: int, data: Sequence[int]) -> bool:
        """write_raw_data_can."""
        result: bool = self._call("write_raw_data_can", (id, data))
        return result

    def write_word_reg(self, num: int, value: int) -> int:
        """write_word_reg."""
        result: int = self._call("write_word_reg", (num, value))
        return result


class AsyncRpc:
    """Every function of the wire, awaited; `call` is a coroutine function."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[[str, tuple[Any, ...]], Coroutine[Any, Any, Any]]) -> None:
        self._call = call

    def abort(self, block: bool) -> Coroutine[Any, Any, int]:
        """abort."""
        return self._call("abort", (block,))

    def add_eaxis_scheme(self, num: int, block: bool) -> Coroutine[Any, Any, int]:
        """add_eaxis_scheme."""
        return self._call("add_eaxis_scheme", (num, block))

    def apply_servo_config(self, axis_num: int, block: bool) -> Coroutine[Any, Any, int]:
        """apply_servo_config."""
        return self._call("apply_servo_config", (axis_num, block))

    def cal_fkine(
        self,
        joints_position: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> Coroutine[Any, Any, list[float]]:
        """cal_fkine."""
        return self._call("cal_fkine", (joints_position, tool, wobj))

    def cal_ikine(
        self,
        p: Sequence[float],
        q_near: Sequence[float],
        tool: Sequence[float],
        wobj: Sequence[float],
    ) -> Coroutine[Any, Any, list[float]]:
        """cal_ikine."""
        return self._call("cal_ikine", (p, q_near, tool, wobj))

    def change_recipe(self) -> Coroutine[Any, Any, None]:
        """change_recipe."""
        return self._call("change_recipe", ())

    def clear_realtime_data_queue(self) -> Coroutine[Any, Any, int]:
        """clear_realtime_data_queue."""
        return self._call("clear_realtime_data_queue", ())

    def collision_detect(self, value: int) -> Coroutine[Any, Any, int]:
        """collision_detect."""
        return self._call("collision_detect", (value,))

    def collision_detection_reset(self) -> Coroutine[Any, Any, int]:
        """collision_detection_reset."""
        return self._call("collision_detection_reset", ())

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
    ) -> Coroutine[Any, Any, int]:
        """combine_motion_config."""
        return self._call(
            "combine_motion_config",
            (type, ref_plane, fq, amp, el_offset, az_offset, up_height, time, path_dwell, op_list),
        )

    def delete_eaxis_scheme(self, num: int, block: bool) -> Coroutine[Any, Any, int]:
        """delete_eaxis_scheme."""
        return self._call("delete_eaxis_scheme", (num, block))

    def disable(self, block: bool) -> Coroutine[Any, Any, int]:
        """disable."""
        return self._call("disable", (block,))

    def disable_acc_optimization(self) -> Coroutine[Any, Any, int]:
        """disable_acc_optimization."""
        return self._call("disable_acc_optimization", ())

    def disable_combine_motion(self) -> Coroutine[Any, Any, int]:
        """disable_combine_motion."""
        return self._call("disable_combine_motion", ())

    def disable_eaxis_scheme(self, scheme_name: str) -> Coroutine[Any, Any, int]:
        """disable_eaxis_scheme."""
        return self._call("disable_eaxis_scheme", (scheme_name,))

    def disable_singularity_control(self) -> Coroutine[Any, Any, int]:
        """disable_singularity_control."""
        return self._call("disable_singularity_control", ())

    def disable_speed_optimization(self) -> Coroutine[Any, Any, int]:
        """disable_speed_optimization."""
        return self._call("disable_speed_optimization", ())

    def disable_vibration_control(self) -> Coroutine[Any, Any, int]:
        """disable_vibration_control."""
        return self._call("disable_vibration_control", ())

    def enable(self, block: bool) -> Coroutine[Any, Any, int]:
        """enable."""
        return self._call("enable", (block,))

    def enable_acc_optimization(self) -> Coroutine[Any, Any, int]:
        """enable_acc_optimization."""
        return self._call("enable_acc_optimization", ())

    def enable_combine_motion(self) -> Coroutine[Any, Any, int]:
        """enable_combine_motion."""
        return self._call("enable_combine_motion", ())

    def enable_eaxis_scheme(self, scheme_name: str) -> Coroutine[Any, Any, int]:
        """enable_eaxis_scheme."""
        return self._call("enable_eaxis_scheme", (scheme_name,))

    def enable_singularity_control(self) -> Coroutine[Any, Any, int]:
        """enable_singularity_control."""
        return self._call("enable_singularity_control", ())

    def enable_speed_optimization(self) -> Coroutine[Any, Any, int]:
        """enable_speed_optimization."""
        return self._call("enable_speed_optimization", ())

    def enable_vibration_control(self) -> Coroutine[Any, Any, int]:
        """enable_vibration_control."""
        return self._call("enable_vibration_control", ())

    def end_realtime_mode(self) -> Coroutine[Any, Any, int]:
        """end_realtime_mode."""
        return self._call("end_realtime_mode", ())

    def end_teach_mode(self, block: bool) -> Coroutine[Any, Any, int]:
        """end_teach_mode."""
        return self._call("end_teach_mode", (block,))

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
    ) -> Coroutine[Any, Any, int]:
        """fc_config."""
        return self._call(
            "fc_config",
            (direction, ref_ft, damp, max_vel, number_list, tool, wobj, value),
        )

    def fc_force_set_value(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
    ) -> Coroutine[Any, Any, int]:
        """fc_force_set_value."""
        return self._call("fc_force_set_value", (direction, ref_ft))

    def fc_get_ft(self) -> Coroutine[Any, Any, list[float]]:
        """fc_get_ft."""
        return self._call("fc_get_ft", ())

    def fc_guard_act(
        self,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        tool: str,
        wobj: str,
        type: int,
        force_property: int,
    ) -> Coroutine[Any, Any, int]:
        """fc_guard_act."""
        return self._call("fc_guard_act", (direction, ref_ft, tool, wobj, type, force_property))

    def fc_guard_deact(self) -> Coroutine[Any, Any, int]:
        """fc_guard_deact."""
        return self._call("fc_guard_deact", ())

    def fc_mode_is_active(self) -> Coroutine[Any, Any, bool]:
        """fc_mode_is_active."""
        return self._call("fc_mode_is_active", ())

    def fc_move(self, block: bool) -> Coroutine[Any, Any, int]:
        """fc_move."""
        return self._call("fc_move", (block,))

    def fc_start(self) -> Coroutine[Any, Any, int]:
        """fc_start."""
        return self._call("fc_start", ())

    def fc_stop(self) -> Coroutine[Any, Any, int]:
        """fc_stop."""
        return self._call("fc_stop", ())

    def fc_wait_ft(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> Coroutine[Any, Any, int]:
        """fc_wait_ft."""
        return self._call("fc_wait_ft", (middle, range, absolute, duration, timeout))

    def fc_wait_logic(self, value: Sequence[int]) -> Coroutine[Any, Any, int]:
        """fc_wait_logic."""
        return self._call("fc_wait_logic", (value,))

    def fc_wait_pos(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> Coroutine[Any, Any, int]:
        """fc_wait_pos."""
        return self._call("fc_wait_pos", (middle, range, absolute, duration, timeout))

    def fc_wait_vel(
        self,
        middle: Sequence[float],
        range: Sequence[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> Coroutine[Any, Any, int]:
        """fc_wait_vel."""
        return self._call("fc_wait_vel", (middle, range, absolute, duration, timeout))

    def getQueueSize(self) -> Coroutine[Any, Any, int]:
        """getQueueSize."""
        return self._call("getQueueSize", ())

    def getRobotIOStatus(self) -> Coroutine[Any, Any, IOStatus]:
        """getRobotIOStatus."""
        return self._call("getRobotIOStatus", ())

    def getRobotStatus(self) -> Coroutine[Any, Any, RobotStatus]:
        """getRobotStatus."""
        return self._call("getRobotStatus", ())

    def get_actual_joints_acceleration(self) -> Coroutine[Any, Any, list[float]]:
        """get_actual_joints_acceleration."""
        return self._call("get_actual_joints_acceleration", ())

    def get_actual_joints_position(self) -> Coroutine[Any, Any, list[float]]:
        """get_actual_joints_position."""
        return self._call("get_actual_joints_position", ())

    def get_actual_joints_speed(self) -> Coroutine[Any, Any, list[float]]:
        """get_actual_joints_speed."""
        return self._call("get_actual_joints_speed", ())

    def get_actual_joints_torque(self) -> Coroutine[Any, Any, list[float]]:
        """get_actual_joints_torque."""
        return self._call("get_actual_joints_torque", ())

    def get_axis_motor_kt(self) -> Coroutine[Any, Any, list[float]]:
        """get_axis_motor_kt."""
        return self._call("get_axis_motor_kt", ())

    def get_axis_motor_rated_current(self) -> Coroutine[Any, Any, list[float]]:
        """get_axis_motor_rated_current."""
        return self._call("get_axis_motor_rated_current", ())

    def get_axis_ratio(self) -> Coroutine[Any, Any, list[int]]:
        """get_axis_ratio."""
        return self._call("get_axis_ratio", ())

    def get_calib_DH(self) -> Coroutine[Any, Any, list[list[float]]]:
        """get_calib_DH."""
        return self._call("get_calib_DH", ())

    def get_config_digital_in(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_config_digital_in."""
        return self._call("get_config_digital_in", (num,))

    def get_current_project(self) -> Coroutine[Any, Any, str]:
        """get_current_project."""
        return self._call("get_current_project", ())

    def get_dynamic_calibration_params(self) -> Coroutine[Any, Any, list[list[float]]]:
        """get_dynamic_calibration_params."""
        return self._call("get_dynamic_calibration_params", ())

    def get_eaxis_info(self) -> Coroutine[Any, Any, list[EAxissInfo]]:
        """get_eaxis_info."""
        return self._call("get_eaxis_info", ())

    def get_ext_torque(self) -> Coroutine[Any, Any, list[float]]:
        """get_ext_torque."""
        return self._call("get_ext_torque", ())

    def get_files_list(self, path: str) -> Coroutine[Any, Any, dict[str, int]]:
        """get_files_list."""
        return self._call("get_files_list", (path,))

    def get_flange_acceleration(self) -> Coroutine[Any, Any, list[float]]:
        """get_flange_acceleration."""
        return self._call("get_flange_acceleration", ())

    def get_flange_pose(self) -> Coroutine[Any, Any, list[float]]:
        """get_flange_pose."""
        return self._call("get_flange_pose", ())

    def get_flange_speed(self) -> Coroutine[Any, Any, list[float]]:
        """get_flange_speed."""
        return self._call("get_flange_speed", ())

    def get_function_digital_in(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_function_digital_in."""
        return self._call("get_function_digital_in", (num,))

    def get_function_digital_out(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_function_digital_out."""
        return self._call("get_function_digital_out", (num,))

    def get_function_reg_in(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_function_reg_in."""
        return self._call("get_function_reg_in", (num,))

    def get_function_reg_out(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_function_reg_out."""
        return self._call("get_function_reg_out", (num,))

    def get_global_speed(self) -> Coroutine[Any, Any, int]:
        """get_global_speed."""
        return self._call("get_global_speed", ())

    def get_last_error(self) -> Coroutine[Any, Any, list[str]]:
        """get_last_error."""
        return self._call("get_last_error", ())

    def get_motor_pole_pair_number(self) -> Coroutine[Any, Any, list[int]]:
        """get_motor_pole_pair_number."""
        return self._call("get_motor_pole_pair_number", ())

    def get_motor_stator_slots(self) -> Coroutine[Any, Any, list[int]]:
        """get_motor_stator_slots."""
        return self._call("get_motor_stator_slots", ())

    def get_noneblock_taskstate(self, id: int) -> Coroutine[Any, Any, int]:
        """get_noneblock_taskstate."""
        return self._call("get_noneblock_taskstate", (id,))

    def get_origin_DH(self) -> Coroutine[Any, Any, list[list[float]]]:
        """get_origin_DH."""
        return self._call("get_origin_DH", ())

    def get_pos_bias(self) -> Coroutine[Any, Any, list[float]]:
        """get_pos_bias."""
        return self._call("get_pos_bias", ())

    def get_realtime_data_queue_size(self) -> Coroutine[Any, Any, int]:
        """get_realtime_data_queue_size."""
        return self._call("get_realtime_data_queue_size", ())

    def get_robot_state(self) -> Coroutine[Any, Any, list[int]]:
        """get_robot_state."""
        return self._call("get_robot_state", ())

    def get_robot_type(self) -> Coroutine[Any, Any, list[str]]:
        """get_robot_type."""
        return self._call("get_robot_type", ())

    def get_robot_version(self) -> Coroutine[Any, Any, str]:
        """get_robot_version."""
        return self._call("get_robot_version", ())

    def get_standard_analog_current_in(self, num: int) -> Coroutine[Any, Any, float]:
        """get_standard_analog_current_in."""
        return self._call("get_standard_analog_current_in", (num,))

    def get_standard_analog_voltage_in(self, num: int) -> Coroutine[Any, Any, float]:
        """get_standard_analog_voltage_in."""
        return self._call("get_standard_analog_voltage_in", (num,))

    def get_standard_digital_in(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_standard_digital_in."""
        return self._call("get_standard_digital_in", (num,))

    def get_standard_digital_out(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_standard_digital_out."""
        return self._call("get_standard_digital_out", (num,))

    def get_system_value_bool(self, name: str) -> Coroutine[Any, Any, bool]:
        """get_system_value_bool."""
        return self._call("get_system_value_bool", (name,))

    def get_system_value_double(self, name: str) -> Coroutine[Any, Any, float]:
        """get_system_value_double."""
        return self._call("get_system_value_double", (name,))

    def get_system_value_list(self, name: str) -> Coroutine[Any, Any, list[float]]:
        """get_system_value_list."""
        return self._call("get_system_value_list", (name,))

    def get_system_value_lists(self, name: str) -> Coroutine[Any, Any, list[list[float]]]:
        """get_system_value_lists."""
        return self._call("get_system_value_lists", (name,))

    def get_system_value_str(self, name: str) -> Coroutine[Any, Any, str]:
        """get_system_value_str."""
        return self._call("get_system_value_str", (name,))

    def get_target_joints_acceleration(self) -> Coroutine[Any, Any, list[float]]:
        """get_target_joints_acceleration."""
        return self._call("get_target_joints_acceleration", ())

    def get_target_joints_position(self) -> Coroutine[Any, Any, list[float]]:
        """get_target_joints_position."""
        return self._call("get_target_joints_position", ())

    def get_target_joints_speed(self) -> Coroutine[Any, Any, list[float]]:
        """get_target_joints_speed."""
        return self._call("get_target_joints_speed", ())

    def get_target_joints_torque(self) -> Coroutine[Any, Any, list[float]]:
        """get_target_joints_torque."""
        return self._call("get_target_joints_torque", ())

    def get_tcp_acceleration(self) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_acceleration."""
        return self._call("get_tcp_acceleration", ())

    def get_tcp_force(self) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_force."""
        return self._call("get_tcp_force", ())

    def get_tcp_force_tool(self, tool: str) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_force_tool."""
        return self._call("get_tcp_force_tool", (tool,))

    def get_tcp_offset(self) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_offset."""
        return self._call("get_tcp_offset", ())

    def get_tcp_pose(self) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_pose."""
        return self._call("get_tcp_pose", ())

    def get_tcp_pose_coord(self, tool: str, wobj: str) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_pose_coord."""
        return self._call("get_tcp_pose_coord", (tool, wobj))

    def get_tcp_speed(self) -> Coroutine[Any, Any, list[float]]:
        """get_tcp_speed."""
        return self._call("get_tcp_speed", ())

    def get_teach_speed(self) -> Coroutine[Any, Any, int]:
        """get_teach_speed."""
        return self._call("get_teach_speed", ())

    def get_tool_analog_voltage_in(self, num: int) -> Coroutine[Any, Any, float]:
        """get_tool_analog_voltage_in."""
        return self._call("get_tool_analog_voltage_in", (num,))

    def get_tool_digital_in(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_tool_digital_in."""
        return self._call("get_tool_digital_in", (num,))

    def get_tool_digital_out(self, num: int) -> Coroutine[Any, Any, bool]:
        """get_tool_digital_out."""
        return self._call("get_tool_digital_out", (num,))

    def get_tool_load(self) -> Coroutine[Any, Any, list[float]]:
        """get_tool_load."""
        return self._call("get_tool_load", ())

    def get_vibration_calibration_params(self) -> Coroutine[Any, Any, list[list[float]]]:
        """get_vibration_calibration_params."""
        return self._call("get_vibration_calibration_params", ())

    def get_wobj(self) -> Coroutine[Any, Any, list[float]]:
        """get_wobj."""
        return self._call("get_wobj", ())

    def log_error(self, message: str) -> Coroutine[Any, Any, None]:
        """log_error."""
        return self._call("log_error", (message,))

    def log_info(self, message: str) -> Coroutine[Any, Any, None]:
        """log_info."""
        return self._call("log_info", (message,))

    def modbus_add_signal(
        self,
        ip: str,
        slave_number: int,
        signal_address: int,
        signal_type: int,
        signal_name: str,
    ) -> Coroutine[Any, Any, int]:
        """modbus_add_signal."""
        return self._call(
            "modbus_add_signal",
            (ip, slave_number, signal_address, signal_type, signal_name),
        )

    def modbus_delete_signal(self, signal_name: str) -> Coroutine[Any, Any, int]:
        """modbus_delete_signal."""
        return self._call("modbus_delete_signal", (signal_name,))

    def modbus_read(self, signal_name: str) -> Coroutine[Any, Any, int]:
        """modbus_read."""
        return self._call("modbus_read", (signal_name,))

    def modbus_set_frequency(
        self,
        signal_name: str,
        frequence: int,
    ) -> Coroutine[Any, Any, None]:
        """modbus_set_frequency."""
        return self._call("modbus_set_frequency", (signal_name, frequence))

    def modbus_write(self, signal_name: str, value: int) -> Coroutine[Any, Any, int]:
        """modbus_write."""
        return self._call("modbus_write", (signal_name, value))

    def modbus_write_multiple_coils(
        self,
        slave_num: int,
        name: str,
        len: int,
        byte_list: Sequence[int],
    ) -> Coroutine[Any, Any, int]:
        """modbus_write_multiple_coils."""
        return self._call("modbus_write_multiple_coils", (slave_num, name, len, byte_list))

    def modbus_write_multiple_regs(
        self,
        slave_num: int,
        name: str,
        len: int,
        word_list: Sequence[int],
    ) -> Coroutine[Any, Any, int]:
        """modbus_write_multiple_regs."""
        return self._call("modbus_write_multiple_regs", (slave_num, name, len, word_list))

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
    ) -> Coroutine[Any, Any, int]:
        """move_circle."""
        return self._call(
            "move_circle",
            (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc),
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
    ) -> Coroutine[Any, Any, int]:
        """move_circle_eaxis."""
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

    def move_eaxis(
        self,
        scheme_name: str,
        epose: Sequence[float],
        v: float,
        block: bool,
        op: Op,
    ) -> Coroutine[Any, Any, int]:
        """move_eaxis."""
        return self._call("move_eaxis", (scheme_name, epose, v, block, op))

    def move_jog(self, param: MoveJogTaskParam, block: bool) -> Coroutine[Any, Any, int]:
        """move_jog."""
        return self._call("move_jog", (param, block))

    def move_jog_eaxis(
        self,
        name: str,
        direction: int,
        vel: float,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """move_jog_eaxis."""
        return self._call("move_jog_eaxis", (name, direction, vel, block))

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
    ) -> Coroutine[Any, Any, int]:
        """move_spiral."""
        return self._call(
            "move_spiral",
            (p1, p2, rev, len, r, mode, v, a, q_near, tool, wobj, block, op, def_acc),
        )

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
    ) -> Coroutine[Any, Any, int]:
        """movec."""
        return self._call("movec", (p1, p2, v, a, r, mode, q_near, tool, wobj, block, op, def_acc))

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
    ) -> Coroutine[Any, Any, int]:
        """movec_eaxis."""
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

    def movej(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> Coroutine[Any, Any, int]:
        """movej."""
        return self._call("movej", (joints_list, v, a, r, block, op, def_acc))

    def movej2(
        self,
        joints_list: Sequence[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> Coroutine[Any, Any, int]:
        """movej2."""
        return self._call("movej2", (joints_list, v, a, r, block, op, def_acc))

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
    ) -> Coroutine[Any, Any, int]:
        """movej2_eaxis."""
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
    ) -> Coroutine[Any, Any, int]:
        """movej2_pose_eaxis."""
        return self._call(
            "movej2_pose_eaxis",
            (p, v, a, rad, qnear, tool, wobj, scheme_name, epose, eaxis_v, block, op, def_acc),
        )

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
    ) -> Coroutine[Any, Any, int]:
        """movej_pose."""
        return self._call("movej_pose", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

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
    ) -> Coroutine[Any, Any, int]:
        """movej_pose2."""
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
    ) -> Coroutine[Any, Any, int]:
        """movel."""
        return self._call("movel", (p, v, a, r, q_near, tool, wobj, block, op, def_acc))

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
    ) -> Coroutine[Any, Any, int]:
        """movel_eaxis."""
        return self._call(
            "movel_eaxis",
            (p, v, a, rad, qnear, tool, wobj, scheme_name, epose, eaxis_v, block, op, def_acc),
        )

    def pause(self, block: bool) -> Coroutine[Any, Any, int]:
        """pause."""
        return self._call("pause", (block,))

    def power_off(self, block: bool) -> Coroutine[Any, Any, int]:
        """power_off."""
        return self._call("power_off", (block,))

    def power_on(self, block: bool) -> Coroutine[Any, Any, int]:
        """power_on."""
        return self._call("power_on", (block,))

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> Coroutine[Any, Any, ReachabilityParam]:
        """reach_check."""
        return self._call("reach_check", (base, wobj, tool, ref_pos, check_points))

    def read_bool_reg(self, num: int) -> Coroutine[Any, Any, bool]:
        """read_bool_reg."""
        return self._call("read_bool_reg", (num,))

    def read_data_485(self) -> Coroutine[Any, Any, list[int]]:
        """read_data_485."""
        return self._call("read_data_485", ())

    def read_data_can(self) -> Coroutine[Any, Any, list[int]]:
        """read_data_can."""
        return self._call("read_data_can", ())

    def read_encoder_count(self) -> Coroutine[Any, Any, int]:
        """read_encoder_count."""
        return self._call("read_encoder_count", ())

    def read_float_reg(self, num: int) -> Coroutine[Any, Any, float]:
        """read_float_reg."""
        return self._call("read_float_reg", (num,))

    def read_raw_data_485(self, len: int) -> Coroutine[Any, Any, list[int]]:
        """read_raw_data_485."""
        return self._call("read_raw_data_485", (len,))

    def read_raw_data_485_h(
        self,
        head: Sequence[int],
        len: int,
    ) -> Coroutine[Any, Any, list[int]]:
        """read_raw_data_485_h."""
        return self._call("read_raw_data_485_h", (head, len))

    def read_raw_data_485_ht(
        self,
        head: Sequence[int],
        tail: Sequence[int],
    ) -> Coroutine[Any, Any, list[int]]:
        """read_raw_data_485_ht."""
        return self._call("read_raw_data_485_ht", (head, tail))

    def read_raw_data_can(self) -> Coroutine[Any, Any, list[int]]:
        """read_raw_data_can."""
        return self._call("read_raw_data_can", ())

    def read_word_reg(self, num: int) -> Coroutine[Any, Any, int]:
        """read_word_reg."""
        return self._call("read_word_reg", (num,))

    def realtime_data_enqueue(
        self,
        realtime_data: Sequence[RealTimeControlData],
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """realtime_data_enqueue."""
        return self._call("realtime_data_enqueue", (realtime_data, block))

    def replay(self, name: str, value: int, mode: int) -> Coroutine[Any, Any, int]:
        """replay."""
        return self._call("replay", (name, value, mode))

    def restart(self, block: bool) -> Coroutine[Any, Any, int]:
        """restart."""
        return self._call("restart", (block,))

    def resume(self, block: bool) -> Coroutine[Any, Any, int]:
        """resume."""
        return self._call("resume", (block,))

    def robotmoving(self) -> Coroutine[Any, Any, bool]:
        """robotmoving."""
        return self._call("robotmoving", ())

    def rpc_heartbeat(self, time: int) -> Coroutine[Any, Any, None]:
        """rpc_heartbeat."""
        return self._call("rpc_heartbeat", (time,))

    def run_program(self, name: str, block: bool) -> Coroutine[Any, Any, int]:
        """run_program."""
        return self._call("run_program", (name, block))

    def save_dynamic_calibration_params(self, passwd: str) -> Coroutine[Any, Any, int]:
        """save_dynamic_calibration_params."""
        return self._call("save_dynamic_calibration_params", (passwd,))

    def save_kinematic_calibration_params(self, passwd: str) -> Coroutine[Any, Any, int]:
        """save_kinematic_calibration_params."""
        return self._call("save_kinematic_calibration_params", (passwd,))

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
    ) -> Coroutine[Any, Any, int]:
        """servo_tcp."""
        return self._call(
            "servo_tcp",
            (pose_offset, v, a, tool, block, kp, kd, smooth_vel, smooth_acc),
        )

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
    ) -> Coroutine[Any, Any, int]:
        """servoj."""
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
    ) -> Coroutine[Any, Any, int]:
        """servoj_pose."""
        return self._call(
            "servoj_pose",
            (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc),
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
    ) -> Coroutine[Any, Any, int]:
        """servol."""
        return self._call(
            "servol",
            (pose_list, v, a, q_near, tool, wobj, block, kp, kd, smooth_vel, smooth_acc),
        )

    def set_analog_output_mode(
        self,
        num: int,
        mode: int,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_analog_output_mode."""
        return self._call("set_analog_output_mode", (num, mode, block))

    def set_baudrate_485(self, value: int, block: bool) -> Coroutine[Any, Any, int]:
        """set_baudrate_485."""
        return self._call("set_baudrate_485", (value, block))

    def set_baudrate_can(self, value: int, block: bool) -> Coroutine[Any, Any, int]:
        """set_baudrate_can."""
        return self._call("set_baudrate_can", (value, block))

    def set_blend_ahead(self, per: int, num: int) -> Coroutine[Any, Any, int]:
        """set_blend_ahead."""
        return self._call("set_blend_ahead", (per, num))

    def set_digital_output_mode(
        self,
        num: int,
        type: int,
        freq: int,
        duty_cycle: int,
    ) -> Coroutine[Any, Any, int]:
        """set_digital_output_mode."""
        return self._call("set_digital_output_mode", (num, type, freq, duty_cycle))

    def set_dynamic_calibration_info(self, passwd: str, info: str) -> Coroutine[Any, Any, int]:
        """set_dynamic_calibration_info."""
        return self._call("set_dynamic_calibration_info", (passwd, info))

    def set_dynamic_calibration_params(
        self,
        params: Sequence[Sequence[float]],
    ) -> Coroutine[Any, Any, int]:
        """set_dynamic_calibration_params."""
        return self._call("set_dynamic_calibration_params", (params,))

    def set_eaxis_param(
        self,
        num: int,
        param: EAxisParam,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_eaxis_param."""
        return self._call("set_eaxis_param", (num, param, block))

    def set_eaxiss_scheme_param(
        self,
        num: int,
        param: EAxisSchemeParam,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_eaxiss_scheme_param."""
        return self._call("set_eaxiss_scheme_param", (num, param, block))

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: Sequence[int],
        cart_scale: Sequence[int],
        coord_type: int,
        direction: Sequence[bool],
    ) -> Coroutine[Any, Any, int]:
        """set_hand_teach_parameter."""
        return self._call(
            "set_hand_teach_parameter",
            (space, joint_scale, cart_scale, coord_type, direction),
        )

    def set_kinematic_calibration_info(
        self,
        passwd: str,
        info: str,
    ) -> Coroutine[Any, Any, int]:
        """set_kinematic_calibration_info."""
        return self._call("set_kinematic_calibration_info", (passwd, info))

    def set_kinematic_calibration_params(
        self,
        params: Sequence[Sequence[float]],
    ) -> Coroutine[Any, Any, int]:
        """set_kinematic_calibration_params."""
        return self._call("set_kinematic_calibration_params", (params,))

    def set_load_data(self, value: Sequence[float]) -> Coroutine[Any, Any, int]:
        """set_load_data."""
        return self._call("set_load_data", (value,))

    def set_pendant_type(self, type: int) -> Coroutine[Any, Any, int]:
        """set_pendant_type."""
        return self._call("set_pendant_type", (type,))

    def set_servo_config(
        self,
        axis_num: int,
        id: int,
        value: int,
        qfmt: int,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_servo_config."""
        return self._call("set_servo_config", (axis_num, id, value, qfmt, block))

    def set_servo_file_params(
        self,
        axis_num: int,
        id: int,
        name: str,
        value: float,
        qfmt: float,
    ) -> Coroutine[Any, Any, int]:
        """set_servo_file_params."""
        return self._call("set_servo_file_params", (axis_num, id, name, value, qfmt))

    def set_standard_analog_current_out(
        self,
        num: int,
        value: float,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_standard_analog_current_out."""
        return self._call("set_standard_analog_current_out", (num, value, block))

    def set_standard_analog_voltage_out(
        self,
        num: int,
        value: float,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_standard_analog_voltage_out."""
        return self._call("set_standard_analog_voltage_out", (num, value, block))

    def set_standard_digital_out(
        self,
        num: int,
        value: bool,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_standard_digital_out."""
        return self._call("set_standard_digital_out", (num, value, block))

    def set_system_value_bool(self, name: str, value: bool) -> Coroutine[Any, Any, int]:
        """set_system_value_bool."""
        return self._call("set_system_value_bool", (name, value))

    def set_system_value_double(self, name: str, value: float) -> Coroutine[Any, Any, int]:
        """set_system_value_double."""
        return self._call("set_system_value_double", (name, value))

    def set_system_value_list(
        self,
        name: str,
        value: Sequence[float],
    ) -> Coroutine[Any, Any, int]:
        """set_system_value_list."""
        return self._call("set_system_value_list", (name, value))

    def set_system_value_str(self, name: str, value: str) -> Coroutine[Any, Any, int]:
        """set_system_value_str."""
        return self._call("set_system_value_str", (name, value))

    def set_teach_pendant(self, enable: bool) -> Coroutine[Any, Any, int]:
        """set_teach_pendant."""
        return self._call("set_teach_pendant", (enable,))

    def set_teach_speed(self, v: int) -> Coroutine[Any, Any, int]:
        """set_teach_speed."""
        return self._call("set_teach_speed", (v,))

    def set_tool_data(
        self,
        name: str,
        tool_offset: Sequence[float],
        payload: Sequence[float],
        inertia_tensor: Sequence[float],
    ) -> Coroutine[Any, Any, int]:
        """set_tool_data."""
        return self._call("set_tool_data", (name, tool_offset, payload, inertia_tensor))

    def set_tool_digital_out(
        self,
        num: int,
        value: bool,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """set_tool_digital_out."""
        return self._call("set_tool_digital_out", (num, value, block))

    def set_vibration_calibration_info(
        self,
        passwd: str,
        info: str,
    ) -> Coroutine[Any, Any, int]:
        """set_vibration_calibration_info."""
        return self._call("set_vibration_calibration_info", (passwd, info))

    def set_wobj(self, name: str, wobj: Sequence[float]) -> Coroutine[Any, Any, int]:
        """set_wobj."""
        return self._call("set_wobj", (name, wobj))

    def set_wobj_offset(self, wobj: Sequence[float], active: bool) -> Coroutine[Any, Any, int]:
        """set_wobj_offset."""
        return self._call("set_wobj_offset", (wobj, active))

    def shutdown(self, block: bool) -> Coroutine[Any, Any, int]:
        """shutdown."""
        return self._call("shutdown", (block,))

    def simulation(self, sim: bool, block: bool) -> Coroutine[Any, Any, int]:
        """simulation."""
        return self._call("simulation", (sim, block))

    def speed(self, val: float) -> Coroutine[Any, Any, int]:
        """speed."""
        return self._call("speed", (val,))

    def speed_stop(self, block: bool) -> Coroutine[Any, Any, int]:
        """speed_stop."""
        return self._call("speed_stop", (block,))

    def speedj(
        self,
        joints_list: Sequence[float],
        a: float,
        time: int,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """speedj."""
        return self._call("speedj", (joints_list, a, time, block))

    def speedl(
        self,
        pose_list: Sequence[float],
        a: float,
        time: int,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """speedl."""
        return self._call("speedl", (pose_list, a, time, block))

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
    ) -> Coroutine[Any, Any, int]:
        """spline."""
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
    ) -> Coroutine[Any, Any, int]:
        """spline_op."""
        return self._call("spline_op", (pose_list, v, a, tool, wobj, block, op, r, def_acc))

    def start_realtime_mode(
        self,
        mode: int,
        fileter_bandwidth: float,
        com_lost_time: float,
    ) -> Coroutine[Any, Any, int]:
        """start_realtime_mode."""
        return self._call("start_realtime_mode", (mode, fileter_bandwidth, com_lost_time))

    def start_record_track(
        self,
        name: str,
        mode: int,
        tool: str,
        wobj: str,
        interval: float,
    ) -> Coroutine[Any, Any, int]:
        """start_record_track."""
        return self._call("start_record_track", (name, mode, tool, wobj, interval))

    def stop(self, block: bool) -> Coroutine[Any, Any, int]:
        """stop."""
        return self._call("stop", (block,))

    def stop_manual_move(self, block: bool) -> Coroutine[Any, Any, int]:
        """stop_manual_move."""
        return self._call("stop_manual_move", (block,))

    def stop_record_track(self) -> Coroutine[Any, Any, int]:
        """stop_record_track."""
        return self._call("stop_record_track", ())

    def switch_mode(self, mode: int) -> Coroutine[Any, Any, int]:
        """switch_mode."""
        return self._call("switch_mode", (mode,))

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
    ) -> Coroutine[Any, Any, int]:
        """tcp_move."""
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
    ) -> Coroutine[Any, Any, int]:
        """tcp_move_2p."""
        return self._call("tcp_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))

    def teach_mode(self, block: bool) -> Coroutine[Any, Any, int]:
        """teach_mode."""
        return self._call("teach_mode", (block,))

    def tool_read_data_485(self) -> Coroutine[Any, Any, list[int]]:
        """tool_read_data_485."""
        return self._call("tool_read_data_485", ())

    def tool_read_raw_data_485(self, len: int) -> Coroutine[Any, Any, list[int]]:
        """tool_read_raw_data_485."""
        return self._call("tool_read_raw_data_485", (len,))

    def tool_read_raw_data_485_h(
        self,
        head: Sequence[int],
        len: int,
    ) -> Coroutine[Any, Any, list[int]]:
        """tool_read_raw_data_485_h."""
        return self._call("tool_read_raw_data_485_h", (head, len))

    def tool_read_raw_data_485_ht(
        self,
        head: Sequence[int],
        tail: Sequence[int],
    ) -> Coroutine[Any, Any, list[int]]:
        """tool_read_raw_data_485_ht."""
        return self._call("tool_read_raw_data_485_ht", (head, tail))

    def tool_write_data_485(self, data: Sequence[int]) -> Coroutine[Any, Any, bool]:
        """tool_write_data_485."""
        return self._call("tool_write_data_485", (data,))

    def tool_write_raw_data_485(self, data: Sequence[int]) -> Coroutine[Any, Any, bool]:
        """tool_write_raw_data_485."""
        return self._call("tool_write_raw_data_485", (data,))

    def tool_write_raw_data_485_h(
        self,
        data: Sequence[int],
        head: Sequence[int],
    ) -> Coroutine[Any, Any, bool]:
        """tool_write_raw_data_485_h."""
        return self._call("tool_write_raw_data_485_h", (data, head))

    def tool_write_raw_data_485_ht(
        self,
        data: Sequence[int],
        head: Sequence[int],
        tail: Sequence[int],
    ) -> Coroutine[Any, Any, bool]:
        """tool_write_raw_data_485_ht."""
        return self._call("tool_write_raw_data_485_ht", (data, head, tail))

    def trackCartMotion(
        self,
        speed: float,
        acc: float,
        block: bool,
        tool: str,
        wobj: str,
        radius: float,
    ) -> Coroutine[Any, Any, int]:
        """trackCartMotion."""
        return self._call("trackCartMotion", (speed, acc, block, tool, wobj, radius))

    def trackClearQueue(self) -> Coroutine[Any, Any, int]:
        """trackClearQueue."""
        return self._call("trackClearQueue", ())

    def trackEnqueue(
        self,
        track: Sequence[Sequence[float]],
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """trackEnqueue."""
        return self._call("trackEnqueue", (track, block))

    def trackEnqueueOp(self, track: Sequence[PointOp], block: bool) -> Coroutine[Any, Any, int]:
        """trackEnqueueOp."""
        return self._call("trackEnqueueOp", (track, block))

    def trackJointMotion(
        self,
        speed: float,
        acc: float,
        block: bool,
    ) -> Coroutine[Any, Any, int]:
        """trackJointMotion."""
        return self._call("trackJointMotion", (speed, acc, block))

    def upload_robot_param_to_toolboard(self, passwd: str) -> Coroutine[Any, Any, int]:
        """upload_robot_param_to_toolboard."""
        return self._call("upload_robot_param_to_toolboard", (passwd,))

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
    ) -> Coroutine[Any, Any, int]:
        """wobj_move."""
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
    ) -> Coroutine[Any, Any, int]:
        """wobj_move_2p."""
        return self._call("wobj_move_2p", (p1, p2, v, a, r, tool, wobj, block, op, def_acc))

    def write_bool_reg(self, num: int, value: bool) -> Coroutine[Any, Any, int]:
        """write_bool_reg."""
        return self._call("write_bool_reg", (num, value))

    def write_data_485(self, data: Sequence[int]) -> Coroutine[Any, Any, bool]:
        """write_data_485."""
        return self._call("write_data_485", (data,))

    def write_data_can(self, id: int, data: Sequence[int]) -> Coroutine[Any, Any, bool]:
        """write_data_can."""
        return self._call("write_data_can", (id, data))

    def write_float_reg(self, num: int, value: float) -> Coroutine[Any, Any, int]:
        """write_float_reg."""
        return self._call("write_float_reg", (num, value))

    def write_raw_data_485(self, data: Sequence[int]) -> Coroutine[Any, Any, bool]:
        """write_raw_data_485."""
        return self._call("write_raw_data_485", (data,))

    def write_raw_data_485_h(
        self,
        data: Sequence[int],
        head: Sequence[int],
    ) -> Coroutine[Any, Any, bool]:
        """write_raw_data_485_h."""
        return self._call("write_raw_data_485_h", (data, head))

    def write_raw_data_485_ht(
        self,
        data: Sequence[int],
        head: Sequence[int],
        tail: Sequence[int],
    ) -> Coroutine[Any, Any, bool]:
        """write_raw_data_485_ht."""
        return self._call("write_raw_data_485_ht", (data, head, tail))

    def write_raw_data_can(self, id: int, data: Sequence[int]) -> Coroutine[Any, Any, bool]:
        """write_raw_data_can."""
        return self._call("write_raw_data_can", (id, data))

    def write_word_reg(self, num: int, value: int) -> Coroutine[Any, Any, int]:
        """write_word_reg."""
        return self._call("write_word_reg", (num, value))


class Handler(Protocol):
    """What a server answers: one method per function."""

    def abort(self, block: bool) -> int: ...

    def add_eaxis_scheme(self, num: int, block: bool) -> int: ...

    def apply_servo_config(self, axis_num: int, block: bool) -> int: ...

    def cal_fkine(
        self,
        joints_position: list[float],
        tool: list[float],
        wobj: list[float],
    ) -> list[float]: ...

    def cal_ikine(
        self,
        p: list[float],
        q_near: list[float],
        tool: list[float],
        wobj: list[float],
    ) -> list[float]: ...

    def change_recipe(self) -> None: ...

    def clear_realtime_data_queue(self) -> int: ...

    def collision_detect(self, value: int) -> int: ...

    def collision_detection_reset(self) -> int: ...

    def combine_motion_config(
        self,
        type: int,
        ref_plane: int,
        fq: float,
        amp: float,
        el_offset: float,
        az_offset: float,
        up_height: float,
        time: list[int],
        path_dwell: bool,
        op_list: list[Op],
    ) -> int: ...

    def delete_eaxis_scheme(self, num: int, block: bool) -> int: ...

    def disable(self, block: bool) -> int: ...

    def disable_acc_optimization(self) -> int: ...

    def disable_combine_motion(self) -> int: ...

    def disable_eaxis_scheme(self, scheme_name: str) -> int: ...

    def disable_singularity_control(self) -> int: ...

    def disable_speed_optimization(self) -> int: ...

    def disable_vibration_control(self) -> int: ...

    def enable(self, block: bool) -> int: ...

    def enable_acc_optimization(self) -> int: ...

    def enable_combine_motion(self) -> int: ...

    def enable_eaxis_scheme(self, scheme_name: str) -> int: ...

    def enable_singularity_control(self) -> int: ...

    def enable_speed_optimization(self) -> int: ...

    def enable_vibration_control(self) -> int: ...

    def end_realtime_mode(self) -> int: ...

    def end_teach_mode(self, block: bool) -> int: ...

    def fc_config(
        self,
        direction: list[bool],
        ref_ft: list[float],
        damp: list[float],
        max_vel: list[float],
        number_list: list[float],
        tool: str,
        wobj: str,
        value: int,
    ) -> int: ...

    def fc_force_set_value(self, direction: list[bool], ref_ft: list[float]) -> int: ...

    def fc_get_ft(self) -> list[float]: ...

    def fc_guard_act(
        self,
        direction: list[bool],
        ref_ft: list[float],
        tool: str,
        wobj: str,
        type: int,
        force_property: int,
    ) -> int: ...

    def fc_guard_deact(self) -> int: ...

    def fc_mode_is_active(self) -> bool: ...

    def fc_move(self, block: bool) -> int: ...

    def fc_start(self) -> int: ...

    def fc_stop(self) -> int: ...

    def fc_wait_ft(
        self,
        middle: list[float],
        range: list[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int: ...

    def fc_wait_logic(self, value: list[int]) -> int: ...

    def fc_wait_pos(
        self,
        middle: list[float],
        range: list[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int: ...

    def fc_wait_vel(
        self,
        middle: list[float],
        range: list[float],
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> int: ...

    def getQueueSize(self) -> int: ...

    def getRobotIOStatus(self) -> IOStatus: ...

    def getRobotStatus(self) -> RobotStatus: ...

    def get_actual_joints_acceleration(self) -> list[float]: ...

    def get_actual_joints_position(self) -> list[float]: ...

    def get_actual_joints_speed(self) -> list[float]: ...

    def get_actual_joints_torque(self) -> list[float]: ...

    def get_axis_motor_kt(self) -> list[float]: ...

    def get_axis_motor_rated_current(self) -> list[float]: ...

    def get_axis_ratio(self) -> list[int]: ...

    def get_calib_DH(self) -> list[list[float]]: ...

    def get_config_digital_in(self, num: int) -> bool: ...

    def get_current_project(self) -> str: ...

    def get_dynamic_calibration_params(self) -> list[list[float]]: ...

    def get_eaxis_info(self) -> list[EAxissInfo]: ...

    def get_ext_torque(self) -> list[float]: ...

    def get_files_list(self, path: str) -> dict[str, int]: ...

    def get_flange_acceleration(self) -> list[float]: ...

    def get_flange_pose(self) -> list[float]: ...

    def get_flange_speed(self) -> list[float]: ...

    def get_function_digital_in(self, num: int) -> bool: ...

    def get_function_digital_out(self, num: int) -> bool: ...

    def get_function_reg_in(self, num: int) -> bool: ...

    def get_function_reg_out(self, num: int) -> bool: ...

    def get_global_speed(self) -> int: ...

    def get_last_error(self) -> list[str]: ...

    def get_motor_pole_pair_number(self) -> list[int]: ...

    def get_motor_stator_slots(self) -> list[int]: ...

    def get_noneblock_taskstate(self, id: int) -> int: ...

    def get_origin_DH(self) -> list[list[float]]: ...

    def get_pos_bias(self) -> list[float]: ...

    def get_realtime_data_queue_size(self) -> int: ...

    def get_robot_state(self) -> list[int]: ...

    def get_robot_type(self) -> list[str]: ...

    def get_robot_version(self) -> str: ...

    def get_standard_analog_current_in(self, num: int) -> float: ...

    def get_standard_analog_voltage_in(self, num: int) -> float: ...

    def get_standard_digital_in(self, num: int) -> bool: ...

    def get_standard_digital_out(self, num: int) -> bool: ...

    def get_system_value_bool(self, name: str) -> bool: ...

    def get_system_value_double(self, name: str) -> float: ...

    def get_system_value_list(self, name: str) -> list[float]: ...

    def get_system_value_lists(self, name: str) -> list[list[float]]: ...

    def get_system_value_str(self, name: str) -> str: ...

    def get_target_joints_acceleration(self) -> list[float]: ...

    def get_target_joints_position(self) -> list[float]: ...

    def get_target_joints_speed(self) -> list[float]: ...

    def get_target_joints_torque(self) -> list[float]: ...

    def get_tcp_acceleration(self) -> list[float]: ...

    def get_tcp_force(self) -> list[float]: ...

    def get_tcp_force_tool(self, tool: str) -> list[float]: ...

    def get_tcp_offset(self) -> list[float]: ...

    def get_tcp_pose(self) -> list[float]: ...

    def get_tcp_pose_coord(self, tool: str, wobj: str) -> list[float]: ...

    def get_tcp_speed(self) -> list[float]: ...

    def get_teach_speed(self) -> int: ...

    def get_tool_analog_voltage_in(self, num: int) -> float: ...

    def get_tool_digital_in(self, num: int) -> bool: ...

    def get_tool_digital_out(self, num: int) -> bool: ...

    def get_tool_load(self) -> list[float]: ...

    def get_vibration_calibration_params(self) -> list[list[float]]: ...

    def get_wobj(self) -> list[float]: ...

    def log_error(self, message: str) -> None: ...

    def log_info(self, message: str) -> None: ...

    def modbus_add_signal(
        self,
        ip: str,
        slave_number: int,
        signal_address: int,
        signal_type: int,
        signal_name: str,
    ) -> int: ...

    def modbus_delete_signal(self, signal_name: str) -> int: ...

    def modbus_read(self, signal_name: str) -> int: ...

    def modbus_set_frequency(self, signal_name: str, frequence: int) -> None: ...

    def modbus_write(self, signal_name: str, value: int) -> int: ...

    def modbus_write_multiple_coils(
        self,
        slave_num: int,
        name: str,
        len: int,
        byte_list: list[int],
    ) -> int: ...

    def modbus_write_multiple_regs(
        self,
        slave_num: int,
        name: str,
        len: int,
        word_list: list[int],
    ) -> int: ...

    def move_circle(
        self,
        p1: list[float],
        p2: list[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def move_circle_eaxis(
        self,
        p1: list[float],
        p2: list[float],
        v: float,
        a: float,
        rad: float,
        mode: int,
        qnear: list[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: list[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def move_eaxis(
        self,
        scheme_name: str,
        epose: list[float],
        v: float,
        block: bool,
        op: Op,
    ) -> int: ...

    def move_jog(self, param: MoveJogTaskParam, block: bool) -> int: ...

    def move_jog_eaxis(self, name: str, direction: int, vel: float, block: bool) -> int: ...

    def move_spiral(
        self,
        p1: list[float],
        p2: list[float],
        rev: float,
        len: float,
        r: float,
        mode: int,
        v: float,
        a: float,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movec(
        self,
        p1: list[float],
        p2: list[float],
        v: float,
        a: float,
        r: float,
        mode: int,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movec_eaxis(
        self,
        p1: list[float],
        p2: list[float],
        v: float,
        a: float,
        rad: float,
        qnear: list[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: list[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
        mode: int,
    ) -> int: ...

    def movej(
        self,
        joints_list: list[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movej2(
        self,
        joints_list: list[float],
        v: float,
        a: float,
        r: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movej2_eaxis(
        self,
        joints_list: list[float],
        v: float,
        a: float,
        rad: float,
        scheme_name: str,
        epose: list[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movej2_pose_eaxis(
        self,
        p: list[float],
        v: float,
        a: float,
        rad: float,
        qnear: list[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: list[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movej_pose(
        self,
        p: list[float],
        v: float,
        a: float,
        r: float,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movej_pose2(
        self,
        p: list[float],
        v: float,
        a: float,
        r: float,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movel(
        self,
        p: list[float],
        v: float,
        a: float,
        r: float,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def movel_eaxis(
        self,
        p: list[float],
        v: float,
        a: float,
        rad: float,
        qnear: list[float],
        tool: str,
        wobj: str,
        scheme_name: str,
        epose: list[float],
        eaxis_v: float,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def pause(self, block: bool) -> int: ...

    def power_off(self, block: bool) -> int: ...

    def power_on(self, block: bool) -> int: ...

    def reach_check(
        self,
        base: list[float],
        wobj: list[float],
        tool: list[float],
        ref_pos: list[float],
        check_points: list[list[float]],
    ) -> ReachabilityParam: ...

    def read_bool_reg(self, num: int) -> bool: ...

    def read_data_485(self) -> list[int]: ...

    def read_data_can(self) -> list[int]: ...

    def read_encoder_count(self) -> int: ...

    def read_float_reg(self, num: int) -> float: ...

    def read_raw_data_485(self, len: int) -> list[int]: ...

    def read_raw_data_485_h(self, head: list[int], len: int) -> list[int]: ...

    def read_raw_data_485_ht(self, head: list[int], tail: list[int]) -> list[int]: ...

    def read_raw_data_can(self) -> list[int]: ...

    def read_word_reg(self, num: int) -> int: ...

    def realtime_data_enqueue(
        self,
        realtime_data: list[RealTimeControlData],
        block: bool,
    ) -> int: ...

    def replay(self, name: str, value: int, mode: int) -> int: ...

    def restart(self, block: bool) -> int: ...

    def resume(self, block: bool) -> int: ...

    def robotmoving(self) -> bool: ...

    def rpc_heartbeat(self, time: int) -> None: ...

    def run_program(self, name: str, block: bool) -> int: ...

    def save_dynamic_calibration_params(self, passwd: str) -> int: ...

    def save_kinematic_calibration_params(self, passwd: str) -> int: ...

    def servo_tcp(
        self,
        pose_offset: list[float],
        v: float,
        a: float,
        tool: str,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int: ...

    def servoj(
        self,
        joints_list: list[float],
        v: float,
        a: float,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int: ...

    def servoj_pose(
        self,
        pose_list: list[float],
        v: float,
        a: float,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int: ...

    def servol(
        self,
        pose_list: list[float],
        v: float,
        a: float,
        q_near: list[float],
        tool: str,
        wobj: str,
        block: bool,
        kp: float,
        kd: float,
        smooth_vel: float,
        smooth_acc: float,
    ) -> int: ...

    def set_analog_output_mode(self, num: int, mode: int, block: bool) -> int: ...

    def set_baudrate_485(self, value: int, block: bool) -> int: ...

    def set_baudrate_can(self, value: int, block: bool) -> int: ...

    def set_blend_ahead(self, per: int, num: int) -> int: ...

    def set_digital_output_mode(self, num: int, type: int, freq: int, duty_cycle: int) -> int: ...

    def set_dynamic_calibration_info(self, passwd: str, info: str) -> int: ...

    def set_dynamic_calibration_params(self, params: list[list[float]]) -> int: ...

    def set_eaxis_param(self, num: int, param: EAxisParam, block: bool) -> int: ...

    def set_eaxiss_scheme_param(self, num: int, param: EAxisSchemeParam, block: bool) -> int: ...

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: list[int],
        cart_scale: list[int],
        coord_type: int,
        direction: list[bool],
    ) -> int: ...

    def set_kinematic_calibration_info(self, passwd: str, info: str) -> int: ...

    def set_kinematic_calibration_params(self, params: list[list[float]]) -> int: ...

    def set_load_data(self, value: list[float]) -> int: ...

    def set_pendant_type(self, type: int) -> int: ...

    def set_servo_config(
        self,
        axis_num: int,
        id: int,
        value: int,
        qfmt: int,
        block: bool,
    ) -> int: ...

    def set_servo_file_params(
        self,
        axis_num: int,
        id: int,
        name: str,
        value: float,
        qfmt: float,
    ) -> int: ...

    def set_standard_analog_current_out(self, num: int, value: float, block: bool) -> int: ...

    def set_standard_analog_voltage_out(self, num: int, value: float, block: bool) -> int: ...

    def set_standard_digital_out(self, num: int, value: bool, block: bool) -> int: ...

    def set_system_value_bool(self, name: str, value: bool) -> int: ...

    def set_system_value_double(self, name: str, value: float) -> int: ...

    def set_system_value_list(self, name: str, value: list[float]) -> int: ...

    def set_system_value_str(self, name: str, value: str) -> int: ...

    def set_teach_pendant(self, enable: bool) -> int: ...

    def set_teach_speed(self, v: int) -> int: ...

    def set_tool_data(
        self,
        name: str,
        tool_offset: list[float],
        payload: list[float],
        inertia_tensor: list[float],
    ) -> int: ...

    def set_tool_digital_out(self, num: int, value: bool, block: bool) -> int: ...

    def set_vibration_calibration_info(self, passwd: str, info: str) -> int: ...

    def set_wobj(self, name: str, wobj: list[float]) -> int: ...

    def set_wobj_offset(self, wobj: list[float], active: bool) -> int: ...

    def shutdown(self, block: bool) -> int: ...

    def simulation(self, sim: bool, block: bool) -> int: ...

    def speed(self, val: float) -> int: ...

    def speed_stop(self, block: bool) -> int: ...

    def speedj(self, joints_list: list[float], a: float, time: int, block: bool) -> int: ...

    def speedl(self, pose_list: list[float], a: float, time: int, block: bool) -> int: ...

    def spline(
        self,
        pose_list: list[list[float]],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        r: float,
        def_acc: bool,
    ) -> int: ...

    def spline_op(
        self,
        pose_list: list[PointOp],
        v: float,
        a: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        r: float,
        def_acc: bool,
    ) -> int: ...

    def start_realtime_mode(
        self,
        mode: int,
        fileter_bandwidth: float,
        com_lost_time: float,
    ) -> int: ...

    def start_record_track(
        self,
        name: str,
        mode: int,
        tool: str,
        wobj: str,
        interval: float,
    ) -> int: ...

    def stop(self, block: bool) -> int: ...

    def stop_manual_move(self, block: bool) -> int: ...

    def stop_record_track(self) -> int: ...

    def switch_mode(self, mode: int) -> int: ...

    def tcp_move(
        self,
        pose_offset: list[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def tcp_move_2p(
        self,
        p1: list[float],
        p2: list[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def teach_mode(self, block: bool) -> int: ...

    def tool_read_data_485(self) -> list[int]: ...

    def tool_read_raw_data_485(self, len: int) -> list[int]: ...

    def tool_read_raw_data_485_h(self, head: list[int], len: int) -> list[int]: ...

    def tool_read_raw_data_485_ht(self, head: list[int], tail: list[int]) -> list[int]: ...

    def tool_write_data_485(self, data: list[int]) -> bool: ...

    def tool_write_raw_data_485(self, data: list[int]) -> bool: ...

    def tool_write_raw_data_485_h(self, data: list[int], head: list[int]) -> bool: ...

    def tool_write_raw_data_485_ht(
        self,
        data: list[int],
        head: list[int],
        tail: list[int],
    ) -> bool: ...

    def trackCartMotion(
        self,
        speed: float,
        acc: float,
        block: bool,
        tool: str,
        wobj: str,
        radius: float,
    ) -> int: ...

    def trackClearQueue(self) -> int: ...

    def trackEnqueue(self, track: list[list[float]], block: bool) -> int: ...

    def trackEnqueueOp(self, track: list[PointOp], block: bool) -> int: ...

    def trackJointMotion(self, speed: float, acc: float, block: bool) -> int: ...

    def upload_robot_param_to_toolboard(self, passwd: str) -> int: ...

    def wobj_move(
        self,
        pose_offset: list[float],
        v: float,
        a: float,
        r: float,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def wobj_move_2p(
        self,
        p1: list[float],
        p2: list[float],
        v: float,
        a: float,
        r: float,
        tool: str,
        wobj: str,
        block: bool,
        op: Op,
        def_acc: bool,
    ) -> int: ...

    def write_bool_reg(self, num: int, value: bool) -> int: ...

    def write_data_485(self, data: list[int]) -> bool: ...

    def write_data_can(self, id: int, data: list[int]) -> bool: ...

    def write_float_reg(self, num: int, value: float) -> int: ...

    def write_raw_data_485(self, data: list[int]) -> bool: ...

    def write_raw_data_485_h(self, data: list[int], head: list[int]) -> bool: ...

    def write_raw_data_485_ht(self, data: list[int], head: list[int], tail: list[int]) -> bool: ...

    def write_raw_data_can(self, id: int, data: list[int]) -> bool: ...

    def write_word_reg(self, num: int, value: int) -> int: ...
