"""What may be sent twice: every function of the wire by name."""

from __future__ import annotations

import pytest

from aioduco._wire import idl
from aioduco._wire.failures import may_send_again
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.lifecycle import Progress

#: written out, so that a function that is added to the wire has to be thought about
READS = {
    "cal_fkine",
    "cal_ikine",
    "fc_get_ft",
    "fc_mode_is_active",
    "getQueueSize",
    "getRobotIOStatus",
    "getRobotStatus",
    "get_actual_joints_acceleration",
    "get_actual_joints_position",
    "get_actual_joints_speed",
    "get_actual_joints_torque",
    "get_axis_motor_kt",
    "get_axis_motor_rated_current",
    "get_axis_ratio",
    "get_calib_DH",
    "get_config_digital_in",
    "get_current_project",
    "get_dynamic_calibration_params",
    "get_eaxis_info",
    "get_ext_torque",
    "get_files_list",
    "get_flange_acceleration",
    "get_flange_pose",
    "get_flange_speed",
    "get_function_digital_in",
    "get_function_digital_out",
    "get_function_reg_in",
    "get_function_reg_out",
    "get_global_speed",
    "get_last_error",
    "get_motor_pole_pair_number",
    "get_motor_stator_slots",
    "get_noneblock_taskstate",
    "get_origin_DH",
    "get_pos_bias",
    "get_realtime_data_queue_size",
    "get_robot_state",
    "get_robot_type",
    "get_robot_version",
    "get_standard_analog_current_in",
    "get_standard_analog_voltage_in",
    "get_standard_digital_in",
    "get_standard_digital_out",
    "get_system_value_bool",
    "get_system_value_double",
    "get_system_value_list",
    "get_system_value_lists",
    "get_system_value_str",
    "get_target_joints_acceleration",
    "get_target_joints_position",
    "get_target_joints_speed",
    "get_target_joints_torque",
    "get_tcp_acceleration",
    "get_tcp_force",
    "get_tcp_force_tool",
    "get_tcp_offset",
    "get_tcp_pose",
    "get_tcp_pose_coord",
    "get_tcp_speed",
    "get_teach_speed",
    "get_tool_analog_voltage_in",
    "get_tool_digital_in",
    "get_tool_digital_out",
    "get_tool_load",
    "get_vibration_calibration_params",
    "get_wobj",
    "modbus_read",
    "reach_check",
    "read_bool_reg",
    "read_encoder_count",
    "read_float_reg",
    "read_word_reg",
    "robotmoving",
    "rpc_heartbeat",
}


def test_every_function_has_the_kind_that_was_thought_about() -> None:
    kinds = {name: call_kind(name) for name in idl.functions()}
    assert len(kinds) == 226
    assert {name for name, its in kinds.items() if its is CallKind.READ} == READS
    assert {name for name, its in kinds.items() if its is CallKind.STOP} == {"stop"}


@pytest.mark.parametrize(
    "name",
    [
        # they take bytes out of the controller's buffer
        "read_data_485",
        "read_data_can",
        "read_raw_data_485",
        "read_raw_data_485_h",
        "read_raw_data_485_ht",
        "read_raw_data_can",
        "tool_read_data_485",
        "tool_read_raw_data_485",
        "tool_read_raw_data_485_h",
        "tool_read_raw_data_485_ht",
        # they measure from the moment of the call
        "fc_wait_pos",
        "fc_wait_vel",
        "fc_wait_ft",
        "fc_wait_logic",
        # a second one drops what others have queued since
        "abort",
        "pause",
        "resume",
    ],
)
def test_what_looks_harmless_and_is_not_is_a_command(name: str) -> None:
    assert name in idl.functions()
    assert call_kind(name) is CallKind.COMMAND


@pytest.mark.parametrize("progress", Progress)
@pytest.mark.parametrize("name", ["movej2", "get_tcp_pose", "stop", "read_raw_data_485"])
def test_a_call_is_sent_again_only_if_the_first_did_nothing_more(
    name: str, progress: Progress
) -> None:
    again = may_send_again(idl.functions()[name], progress)
    if progress is Progress.NOTHING_SENT:
        assert again
    elif progress is Progress.ANSWERING:
        assert again is (name == "stop")
    else:
        assert again is (name in ("get_tcp_pose", "stop"))
