"""Which named rule checks which of the manual's parameters, as function.parameter."""

from __future__ import annotations

#: which rule checks which of the manual's parameters
USES = {
    "HEARTBEAT": "rpc_heartbeat.time",
    "JOINTS": "movej2.joints_list servoj.joints_list movej2_eaxis.joints_list "
    "cal_fkine.joints_position reach_check.ref_pos",
    "JOINTS_NEAR": "movej_pose2.q_near move1.q_near movec.q_near move_circle.qnear "
    "servoj_pose.qnear servol.q_near move_spiral.qnear cal_ikine.q_near "
    "movej2_pose_eaxis.q_near move1_eaxis.q_near movec_eaxis.q_near",
    "POSE": "movej_pose2.p move1.p movec.p1 movec.p2 move_circle.p1 move_circle.p2 "
    "tcp_move.pose_offset tcp_move_2p.p1 tcp_move_2p.p2 wobj_move.pose_offset wobj_move_2p.p1 "
    "wobj_move_2p.p2 servoj_pose.p servo_tcp.pose_offset servol.pose_list move_spiral.p1 "
    "move_spiral.p2 set_wobj_offset.wobj set_tool_data.tool_offset cal_ikine.p "
    "reach_check.base reach_check.wobj reach_check.tool movej2_pose_eaxis.p move1_eaxis.p "
    "movec_eaxis.p1 movec_eaxis.p2",
    "POSE_OR_CURRENT": "cal_ikine.tool cal_ikine.wobj cal_fkine.tool cal_fkine.wobj",
    "JOINT_SPEED": "movej2.v movej_pose2.v servoj.v servoj_pose.v movej2_eaxis.v "
    "movej2_pose_eaxis.v",
    "JOINT_ACCELERATION": "movej2.a movej_pose2.a speedj.a servoj.a servoj_pose.a movej2_eaxis.a "
    "movej2_pose_eaxis.a",
    "SERVO_SPEED": "servo_tcp.v servol.v",
    "SERVO_ACCELERATION": "servo_tcp.a servol.a",
    "LINE_SPEED": "move1.v movec.v move_circle.v tcp_move.v tcp_move_2p.v wobj_move.v "
    "wobj_move_2p.v spline.v move_spiral.v",
    "LINE_ACCELERATION": "move1.a movec.a move_circle.a tcp_move.a tcp_move_2p.a wobj_move.a "
    "wobj_move_2p.a spline.a move_spiral.a",
    "FINE_SPEED": "spline_op.v",
    "FINE_ACCELERATION": "spline_op.a speedl.a",
    "BLEND_RADIUS": "movej2.rad movej_pose2.r move1.rad movec.r move_circle.rad tcp_move.r "
    "tcp_move_2p.r wobj_move.r wobj_move_2p.r spline.r spline_op.r movej2_eaxis.rad "
    "movej2_pose_eaxis.rad move1_eaxis.rad movec_eaxis.rad",
    "ARC_MODE": "movec.mode",
    "CIRCLE_MODE": "move_circle.mode",
    "SPIRAL_MODE": "move_spiral.mode",
    "SPIRAL_TURNS": "move_spiral.rev",
    "SPIRAL_LENGTH": "move_spiral.len",
    "SPIRAL_RADIUS": "move_spiral.rad",
    "JOINT_VELOCITIES": "speedj.joints_list",
    "TWIST": "speedl.pose_list",
    "RUN_TIME": "speedj.time speedl.time",
    "SPLINE_POINTS": "spline.p_list",
    "SPLINE_COUNT": "spline_op.pose_list",
    "SERVO_KP": "servoj.kp servoj_pose.kp servo_tcp.kp servol.kp",
    "SERVO_KD": "servoj.kd servoj_pose.kd servo_tcp.kd servol.kd",
    "SERVO_SMOOTH_VELOCITY": "servoj.smooth_vel servoj_pose.smooth_vel servo_tcp.smooth_vel "
    "servol.smooth_vel",
    "SERVO_SMOOTH_ACCELERATION": "servoj.smooth_acc servoj_pose.smooth_acc servo_tcp.smooth_acc "
    "servol.smooth_acc",
    "JOG_DIRECTION": "move_jog_eaxis.direction",
    "JOG_SPEED": "move_jog_eaxis.vel",
    "FRAME_TYPE": "set_hand_teach_parameter.coord_type",
    "TEACH_SPACE": "set_hand_teach_parameter.space",
    "TEACH_SCALE": "set_hand_teach_parameter.joint_scale set_hand_teach_parameter.cart_scale",
    "TEACH_DIRECTIONS": "set_hand_teach_parameter.direction",
    "REPLAY_SPEED": "replay.v",
    "REPLAY_MODE": "replay.mode",
    "BLEND_AHEAD": "set_blend_ahead.per",
    "BLEND_AHEAD_MOVES": "set_blend_ahead.num",
    "BAUD_RATE": "set_baudrate_485.value set_baudrate_can.value",
    "READ_LENGTH": "read_raw_data_485.len read_raw_data_485_h.len tool_read_raw_data_485.len "
    "tool_read_raw_data_485_h.len",
    "BYTES": "read_raw_data_485_h.head read_raw_data_485_ht.head read_raw_data_485_ht.tail "
    "write_raw_data_485.value write_raw_data_485_h.value write_raw_data_485_h.head "
    "write_raw_data_485_ht.value write_raw_data_485_ht.head write_raw_data_485_ht.tail "
    "tool_read_raw_data_485_h.head tool_read_raw_data_485_ht.head tool_read_raw_data_485_ht.tail "
    "tool_write_raw_data_485.data tool_write_raw_data_485_h.value tool_write_raw_data_485_h.head "
    "tool_write_raw_data_485_ht.value tool_write_raw_data_485_ht.head "
    "tool_write_raw_data_485_ht.tail",
    "CAN_DATA": "write_raw_data_can.data",
    "CAN_ID": "write_raw_data_can.id",
    "STANDARD_IO": "set_digital_out_mode.num set_standard_digital_out.num "
    "get_standard_digital_out.num get_standard_digital_in.num",
    "TOOL_IO": "set_tool_digital_out.num get_tool_digital_out.num get_tool_digital_in.num",
    "FUNCTION_IO": "get_function_digital_in.portnum get_function_digital_out.portnum",
    "FUNCTION_REGISTER": "get_function_reg_in.num get_function_reg_out.num",
    "ANALOG_IO": "get_standard_analog_voltage_in.num set_standard_analog_voltage_out.num "
    "get_standard_analog_current_in.num set_standard_analog_current_out.num",
    "TOOL_ANALOG_IO": "get_tool_analog_voltage_in.num",
    "OUTPUT_MODE": "set_digital_out_mode.type",
    "PULSE_FREQUENCY": "set_digital_out_mode.freq",
    "PULSE_DUTY": "set_digital_out_mode.duty_cycle",
    "VOLTAGE": "set_standard_analog_voltage_out.value",
    "CURRENT": "set_standard_analog_current_out.value",
    "BOOL_REGISTER": "write_bool_reg.num read_bool_reg.num",
    "WORD_REGISTER": "write_word_reg.num read_word_reg.num",
    "FLOAT_REGISTER": "write_float_reg.num read_float_reg.num",
    "WORD": "write_word_reg.value",
    "FINITE": "write_float_reg.value set_system_value_double.value",
    "FINITES": "set_system_value_list.value",
    "PAYLOAD": "set_tool_data.payload",
    "LOAD": "set_load_data.load",
    "INERTIA": "set_tool_data.inertia_tensor",
    "CHECK_POINTS": "reach_check.check_points",
    "GLOBAL_SPEED": "speed.val",
    "TEACH_SPEED": "set_teach_speed.v",
    "TRACK_MODE": "start_record_track.mode",
    "COLLISION_LEVEL": "collision_detect.level",
    "SWITCH_MODE": "switch_mode.mode",
    "TASK_ID": "get_noblock_taskstate.id",
    "MODBUS_VALUE": "modbus_write.value",
    "MODBUS_FREQUENCY": "modbus_set_frequency.frequency",
    "MODBUS_UNIT": "modbus_write_multiple_regs.slave_num modbus_write_multiple_coils.slave_num",
    "MODBUS_WORDS": "modbus_write_multiple_regs.word_list",
    "MODBUS_COILS": "modbus_write_multiple_coils.byte_list",
    "DIRECTIONS": "fc_config.direction fc_guard_act.direction fc_force_set_value.direction",
    "WRENCH": "fc_config.ref_ft",
    "FORCE_DEAD_BAND": "fc_config.number_list",
    "GUARD_WRENCH": "fc_guard_act.ref_ft",
    "SENSOR_WRENCH": "fc_force_set_value.ref_ft",
    "DAMPING": "fc_config.damp",
    "FORCE_SPEED": "fc_config.max_vel",
    "FORCE_FRAME": "fc_config.type fc_guard_act.type",
    "FORCE_PROPERTY": "fc_guard_act.force_property",
    "WAIT_POSITION": "fc_wait_pos.middle_value",
    "WAIT_VELOCITY": "fc_wait_vel.middle_value",
    "WAIT_WRENCH": "fc_wait_ft.middle_value",
    "WAIT_POSITION_RANGE": "fc_wait_pos.range",
    "WAIT_VELOCITY_RANGE": "fc_wait_vel.range",
    "WAIT_WRENCH_RANGE": "fc_wait_ft.range",
    "WAIT_DURATION": "fc_wait_pos.duration fc_wait_vel.duration fc_wait_ft.duration",
    "WAIT_TIMEOUT": "fc_wait_pos.timeout fc_wait_vel.timeout fc_wait_ft.timeout",
    "WAIT_LOGIC": "fc_wait_logic.logic",
    "TRACK_POINTS": "trackEnqueue.points",
    "TEXT": "log_info.message log_error.message set_system_value_str.value",
    "TRACK_COUNT": "trackEnqueueOp.points",
    "TRACK_JOINT_SPEED": "trackJointMotion.speed",
    "TRACK_JOINT_ACCELERATION": "trackJointMotion.acc",
    "TRACK_SPEED": "trackCartMotion.speed",
    "TRACK_ACCELERATION": "trackCartMotion.acc",
    "WEAVE_TYPE": "combine_motion_config.type",
    "WEAVE_PLANE": "combine_motion_config.ref_plane",
    "WEAVE_FREQUENCY": "combine_motion_config.fq",
    "WEAVE_AMPLITUDE": "combine_motion_config.amp",
    "WEAVE_OFFSET": "combine_motion_config.el_offset combine_motion_config.az_offset "
    "combine_motion_config.up_height",
    "WEAVE_DWELL": "combine_motion_config.time",
    "EAXIS_POSITION": "move_eaxis.epose movej2_eaxis.epos movej2_pose_eaxis.epos move1_eaxis.epos "
    "movec_eaxis.epos",
    "EAXIS_SPEED": "move_eaxis.vel movej2_eaxis.eaxis_v movej2_pose_eaxis.eaxis_v "
    "move1_eaxis.eaxis_v movec_eaxis.eaxis_v",
    "EAXIS_LINE_SPEED": "move1_eaxis.v movec_eaxis.v",
    "EAXIS_LINE_ACCELERATION": "move1_eaxis.a movec_eaxis.a",
    "REALTIME_MODE": "start_realtime_mode.mode",
    "REALTIME_BANDWIDTH": "start_realtime_mode.filter_bandwidth",
    "REALTIME_LOST_TIME": "start_realtime_mode.com_lost_time",
}
#: by the parameter's name in any function that the table above does not name
COMMON = {
    "block": "FLAG",
    "def_acc": "FLAG",
    "tool": "FRAME",
    "wobj": "FRAME",
    "signal_name": "LONG_NAME",
    "scheme_name": "LONG_NAME",
    "path": "PATH",
}
NAMES = {
    "set_tool_data": "NAME",
    "replay": "LONG_NAME",
    "start_record_track": "LONG_NAME",
    "run_program": "LONG_NAME",
    "modbus_write_multiple_regs": "LONG_NAME",
    "modbus_write_multiple_coils": "LONG_NAME",
    **{
        f"{verb}_system_value_{kind}": "LONG_NAME"
        for verb in ("get", "set")
        for kind in ("bool", "double", "str", "list")
    },
}
#: rules for what the manual does not describe, and why they are there all the same
BEYOND = {
    "TIMEOUT": "how long this program waits, which never goes onto the wire",
    "WAIT": "how long this program waits, which may be no time",
    "ABOVE": "amounts of this package, of which nothing else is known",
    "FROM_0": "the same, or none",
    "PORT": "where this package's servers listen",
    "LISTEN_HOST": "likewise",
    "LISTEN_PORT": "likewise",
    "FILE": "files of this computer",
    "STATE_RATE": "how often this program reads the state",
    "INT_32": "service functions, which are only on the wire",
    "PERCENT": "movej and movej_pose, which are only on the wire",
    "CONFIG_IO": "get_config_digital_in, which is only on the wire",
    "TRACK_INTERVAL": "fifth parameter of start_record_track, which is only on the wire",
    "TRACK_RADIUS": "sixth parameter of trackCartMotion, which is only on the wire",
    "TRACK_JOINTS": "trackEnqueue for joints alone",
    "TRACK_POSES": "trackEnqueue for poses alone",
    "EAXIS_JOINT_SPEED": "another name of JOINT_SPEED",
    "EAXIS_JOINT_ACCELERATION": "another name of JOINT_ACCELERATION",
    "EAXIS_NUMBER": "the schemes' parameters, which are only on the wire",
    "AXIS_NUMBER": "service functions, which are only on the wire",
    "MATRIX": "service functions, which are only on the wire",
}
#: the manual prints ranges of amounts, the value has a sign
AMOUNTS = {"speedj.joints_list", "speedl.pose_list"}
#: the manual and the rule have another unit
OTHER_UNITS = {
    "servo_tcp.v": "manual 4.3 has m/s",
    "servol.v": "manual 4.3 has m/s",
    "servo_tcp.a": "manual 4.3 has m/s²",
    "servol.a": "manual 4.3 has m/s²",
}
#: checked by a builder, not by a rule
BUILT = {"op", "op_list", "param", "realtime_data"}
#: rules whose section is that of a struct, which the functions of another section share
STRUCTS = {"JOG_DIRECTION": "1.3.14", "JOG_SPEED": "1.3.14"}
