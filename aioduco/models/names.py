"""Place of each function of the manual and of the wire in this package.

The page of functions (`docs/functions.py`) and the errors for a name that is used on the wrong
object both read these tables. A test compares them with the classes and with the manual.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from aioduco.errors import NamedElsewhere

__all__ = ["BY_ITSELF", "CLIENT_SIDE", "SPELLINGS", "ManualNames", "place"]

#: attribute of the robot -> its functions of the wire; "": the robot itself
_SECTIONS: Final = {
    "system": """
        power_on power_off enable disable shutdown restart switch_mode
    """,
    "": """
        stop pause resume abort
    """,
    "program": """
        run_program get_current_project get_files_list
    """,
    "motion": """
        movej2 movej_pose2 movel movec move_circle tcp_move tcp_move_2p wobj_move wobj_move_2p
        speedj speedl speed_stop teach_mode end_teach_mode set_hand_teach_parameter replay
        spline spline_op servoj servoj_pose servo_tcp servol move_spiral move_jog
        stop_manual_move set_blend_ahead movej movej_pose start_record_track stop_record_track
    """,
    "bus": """
        set_baudrate_485 read_raw_data_485 read_raw_data_485_h read_raw_data_485_ht
        write_raw_data_485 write_raw_data_485_h write_raw_data_485_ht read_data_485
        write_data_485 tool_read_raw_data_485 tool_read_raw_data_485_h tool_read_raw_data_485_ht
        tool_write_raw_data_485 tool_write_raw_data_485_h tool_write_raw_data_485_ht
        tool_read_data_485 tool_write_data_485 set_baudrate_can read_raw_data_can
        write_raw_data_can read_data_can write_data_can
    """,
    "io": """
        set_digital_output_mode set_standard_digital_out get_standard_digital_out
        get_standard_digital_in set_tool_digital_out get_tool_digital_out get_tool_digital_in
        get_config_digital_in get_function_digital_in get_function_digital_out
        get_standard_analog_voltage_in set_standard_analog_voltage_out
        get_tool_analog_voltage_in get_standard_analog_current_in
        set_standard_analog_current_out set_analog_output_mode
    """,
    "registers": """
        write_bool_reg write_word_reg write_float_reg read_bool_reg read_word_reg read_float_reg
        get_function_reg_in get_function_reg_out set_system_value_bool set_system_value_double
        set_system_value_str set_system_value_list get_system_value_bool get_system_value_double
        get_system_value_str get_system_value_list get_system_value_lists
    """,
    "frames": """
        set_wobj_offset set_wobj set_tool_data get_tcp_offset get_tool_load get_wobj
        set_load_data
    """,
    "kinematics": """
        cal_ikine cal_fkine reach_check get_origin_DH get_calib_DH
    """,
    "state": """
        get_tcp_pose get_tcp_pose_coord get_tcp_speed get_tcp_acceleration get_tcp_force
        get_tcp_force_tool get_actual_joints_position get_target_joints_position
        get_actual_joints_speed get_target_joints_speed get_actual_joints_acceleration
        get_target_joints_acceleration get_actual_joints_torque get_target_joints_torque
        get_flange_pose get_flange_speed get_flange_acceleration get_robot_state getRobotStatus
        getRobotIOStatus read_encoder_count get_ext_torque get_last_error
        get_noneblock_taskstate robotmoving
    """,
    "settings": """
        simulation speed collision_detect collision_detection_reset set_teach_pendant
        set_teach_speed get_teach_speed get_global_speed
    """,
    "version": """
        get_robot_type get_robot_version
    """,
    "log": """
        log_info log_error
    """,
    "modbus": """
        modbus_read modbus_write modbus_set_frequency modbus_write_multiple_regs
        modbus_write_multiple_coils modbus_add_signal modbus_delete_signal
    """,
    "force": """
        fc_start fc_stop fc_config fc_move fc_guard_act fc_guard_deact fc_force_set_value
        fc_wait_pos fc_wait_vel fc_wait_ft fc_wait_logic fc_get_ft fc_mode_is_active
    """,
    "optimization": """
        enable_speed_optimization disable_speed_optimization enable_acc_optimization
        disable_acc_optimization enable_singularity_control disable_singularity_control
        enable_vibration_control disable_vibration_control
    """,
    "track": """
        trackEnqueue trackClearQueue getQueueSize trackJointMotion trackCartMotion
        trackEnqueueOp
    """,
    "compound": """
        combine_motion_config enable_combine_motion disable_combine_motion
    """,
    "external_axes": """
        enable_eaxis_scheme disable_eaxis_scheme move_eaxis move_jog_eaxis movej2_eaxis
        movej2_pose_eaxis movel_eaxis movec_eaxis move_circle_eaxis get_eaxis_info
        set_eaxis_param set_eaxiss_scheme_param add_eaxis_scheme delete_eaxis_scheme
    """,
    "realtime": """
        start_realtime_mode end_realtime_mode realtime_data_enqueue clear_realtime_data_queue
        get_realtime_data_queue_size
    """,
    "service": """
        change_recipe set_pendant_type set_servo_config apply_servo_config set_servo_file_params
        get_axis_motor_kt get_axis_motor_rated_current get_axis_ratio get_motor_pole_pair_number
        get_motor_stator_slots get_pos_bias get_dynamic_calibration_params
        set_dynamic_calibration_params set_dynamic_calibration_info
        save_dynamic_calibration_params set_kinematic_calibration_params
        set_kinematic_calibration_info save_kinematic_calibration_params
        get_vibration_calibration_params set_vibration_calibration_info
        upload_robot_param_to_toolboard
    """,
}

#: function of the wire -> its notation in a program
_PLACES: Final = {
    name: ".".join(filter(None, ("robot", section, name)))
    for section, names in _SECTIONS.items()
    for name in names.split()
}

#: name in the manual or in the vendor's class, if different from the wire -> name on the wire
SPELLINGS: Final = {
    "move1": "movel",
    "move1_eaxis": "movel_eaxis",
    "set_digital_out_mode": "set_digital_output_mode",
    "get_noblock_taskstate": "get_noneblock_taskstate",
    "enable_combined_motion": "enable_combine_motion",
    "disable_combined_motion": "disable_combine_motion",
}

#: function of the wire that this package calls automatically -> when it calls it
BY_ITSELF: Final = {
    "rpc_heartbeat": "sent by itself while connected",
}

#: function of the manual that is not on the wire -> its replacement in a program
CLIENT_SIDE: Final = {
    "DucoCobot": "`aioduco.connect()`",
    "open": "`async with aioduco.connect() as robot`",
    "close": "the end of `async with`",
    "get_version": "`aioduco.__version__`",
}


def place(name: str) -> str | None:
    """Return the notation of a function in a program, such as `robot.motion.movel`.

    Args:
        name: name of the function on the wire or in the manual.

    Returns:
        The notation; None if there is no such function, or if the robot does not have it.
    """
    return _PLACES.get(SPELLINGS.get(name, name))


def _meant(name: str) -> str:
    """Describe the place of a function; empty if the manual has no such name."""
    where = place(name)
    if where is not None:
        wire = SPELLINGS.get(name)
        return where if wire is None else f"{where}: the controller calls it {wire}"
    return BY_ITSELF.get(name) or CLIENT_SIDE.get(name, "")


class ManualNames:
    """Base class whose error for a missing attribute names the place of a manual's function."""

    __slots__ = ()

    if not TYPE_CHECKING:  # a type checker would otherwise accept every name

        def __getattr__(self, name: str) -> Any:
            meant = "" if name.startswith("_") or hasattr(type(self), name) else _meant(name)
            if meant:
                raise NamedElsewhere(name, meant)
            # raises Python's own error, also an error that a property of this name has raised
            return object.__getattribute__(self, name)
