/**
 * The RPC interface of DUCO (SIASUN) controllers.
 *
 * Unframed strict TBinaryProtocol on TCP 7003. Field ids and types are read off the
 * public generated vendor clients; none is invented.
 */
namespace py duco

/** Op. */
struct Op {
  1: byte time_or_dist_1
  2: byte trig_io_1
  3: bool trig_value_1
  4: double trig_time_1
  5: double trig_dist_1
  6: string trig_event_1
  7: byte time_or_dist_2
  8: byte trig_io_2
  9: bool trig_value_2
  10: double trig_time_2
  11: double trig_dist_2
  12: string trig_event_2
  13: byte time_or_dist_3
  14: byte trig_io_3
  15: bool trig_value_3
  16: double trig_time_3
  17: double trig_dist_3
  18: string trig_event_3
}

/** PointOp. */
struct PointOp {
  1: list<double> pos
  2: Op op
}

/** RobotStatus. */
struct RobotStatus {
  1: list<double> jointExpectPosition
  2: list<double> jointExpectVelocity
  3: list<double> jointExpectAccelera
  4: list<double> jointActualPosition
  5: list<double> jointActualVelocity
  6: list<double> jointActualAccelera
  7: list<double> jointActualCurrent
  8: list<double> jointTemperature
  9: list<double> driverTemperature
  10: list<double> cartExpectPosition
  11: list<double> cartExpectVelocity
  12: list<double> cartExpectAccelera
  13: list<double> cartActualPosition
  14: list<double> cartActualVelocity
  15: list<double> cartActualAccelera
  16: list<bool> slaveReady
  17: bool collision
  18: byte collisionAxis
  19: bool emcStopSignal
  20: byte robotState
  21: i32 robotError
}

/** IOStatus. */
struct IOStatus {
  1: list<double> analogCurrentOutputs
  2: list<double> analogVoltageOutputs
  3: list<double> analogCurrentInputs
  4: list<double> analogVoltageInputs
  5: list<bool> digitalInputs
  6: list<bool> digitalOutputs
  7: list<bool> toolIOIn
  8: list<bool> toolIOOut
  9: list<bool> toolButton
  10: list<bool> funRegisterInputs
  11: list<bool> funRegisterOutputs
  12: list<bool> boolRegisterInputs
  13: list<bool> boolRegisterOutputs
  14: list<i16> wordRegisterInputs
  15: list<i16> wordRegisterOutputs
  16: list<double> floatRegisterInputs
  17: list<double> floatRegisterOutputs
}

/** MoveJogTaskParam. */
struct MoveJogTaskParam {
  1: i32 jog_direction
  2: i32 jog_type
  3: i32 axis_num
  4: double vel
  5: i32 jog_coordinate
  6: bool use_step
  7: double step_jointValue
  8: double step_cartvalue
}

/** ReachabilityParam. */
struct ReachabilityParam {
  1: bool result
  2: list<list<double>> joints_pos
}

/** EAxissInfo. */
struct EAxissInfo {
  1: string scheme_name
  2: i32 status
  3: double pos
}

/** RealTimeControlData. */
struct RealTimeControlData {
  1: list<double> joint_pos_cmd
  2: list<double> joint_vel_cmd
  3: list<double> joint_torq_cmd
  4: list<double> cart_pos_tool_wobj_cmd
  5: list<double> cart_vel_tool_wobj_cmd
  6: list<double> cart_ft_cmd
  7: bool status
}

/** EAxisParam. */
struct EAxisParam {
  1: i32 type
  2: i32 mode
  3: double ref_velo
  4: double ref_acc
  5: double ref_jerk
  6: double max_velo
  7: double max_acc
  8: i32 encoder_type
  9: i32 encoder_resolution
  10: double position_bias
  11: double screw_lead
  12: bool invert
  13: list<double> position_limit
}

/** EAxisSchemeParam. */
struct EAxisSchemeParam {
  1: i32 type
  2: list<i32> axis_link
  3: list<double> base
  4: list<list<double>> dh
  5: i32 install
}

service RPCRobot {
  /** abort. */
  i32 abort(1: bool block)
  /** add_eaxis_scheme. */
  i32 add_eaxis_scheme(1: i32 num, 2: bool block)
  /** apply_servo_config. */
  i32 apply_servo_config(1: i32 axis_num, 2: bool block)
  /** cal_fkine. */
  list<double> cal_fkine(1: list<double> joints_position, 2: list<double> tool, 3: list<double> wobj)
  /** cal_ikine. */
  list<double> cal_ikine(1: list<double> p, 2: list<double> q_near, 3: list<double> tool, 4: list<double> wobj)
  /** change_recipe. */
  void change_recipe()
  /** clear_realtime_data_queue. */
  i32 clear_realtime_data_queue()
  /** collision_detect. */
  i32 collision_detect(1: i32 value)
  /** collision_detection_reset. */
  i32 collision_detection_reset()
  /** combine_motion_config. */
  i32 combine_motion_config(1: i32 type, 2: i32 ref_plane, 3: double fq, 4: double amp, 5: double el_offset, 6: double az_offset, 7: double up_height, 8: list<i32> time, 9: bool path_dwell, 10: list<Op> op_list)
  /** delete_eaxis_scheme. */
  i32 delete_eaxis_scheme(1: i32 num, 2: bool block)
  /** disable. */
  i32 disable(1: bool block)
  /** disable_acc_optimization. */
  i32 disable_acc_optimization()
  /** disable_combine_motion. */
  i32 disable_combine_motion()
  /** disable_eaxis_scheme. */
  i32 disable_eaxis_scheme(1: string scheme_name)
  /** disable_singularity_control. */
  i32 disable_singularity_control()
  /** disable_speed_optimization. */
  i32 disable_speed_optimization()
  /** disable_vibration_control. */
  i32 disable_vibration_control()
  /** enable. */
  i32 enable(1: bool block)
  /** enable_acc_optimization. */
  i32 enable_acc_optimization()
  /** enable_combine_motion. */
  i32 enable_combine_motion()
  /** enable_eaxis_scheme. */
  i32 enable_eaxis_scheme(1: string scheme_name)
  /** enable_singularity_control. */
  i32 enable_singularity_control()
  /** enable_speed_optimization. */
  i32 enable_speed_optimization()
  /** enable_vibration_control. */
  i32 enable_vibration_control()
  /** end_realtime_mode. */
  i32 end_realtime_mode()
  /** end_teach_mode. */
  i32 end_teach_mode(1: bool block)
  /** fc_config. */
  i32 fc_config(1: list<bool> direction, 2: list<double> ref_ft, 3: list<double> damp, 4: list<double> max_vel, 5: list<double> number_list, 6: string tool, 7: string wobj, 8: i32 value)
  /** fc_force_set_value. */
  i32 fc_force_set_value(1: list<bool> direction, 2: list<double> ref_ft)
  /** fc_get_ft. */
  list<double> fc_get_ft()
  /** fc_guard_act. */
  i32 fc_guard_act(1: list<bool> direction, 2: list<double> ref_ft, 3: string tool, 4: string wobj, 5: i32 type, 6: i32 force_property)
  /** fc_guard_deact. */
  i32 fc_guard_deact()
  /** fc_mode_is_active. */
  bool fc_mode_is_active()
  /** fc_move. */
  i32 fc_move(1: bool block)
  /** fc_start. */
  i32 fc_start()
  /** fc_stop. */
  i32 fc_stop()
  /** fc_wait_ft. */
  i32 fc_wait_ft(1: list<double> middle, 2: list<double> range, 3: bool absolute, 4: i32 duration, 5: i32 timeout)
  /** fc_wait_logic. */
  i32 fc_wait_logic(1: list<i32> value)
  /** fc_wait_pos. */
  i32 fc_wait_pos(1: list<double> middle, 2: list<double> range, 3: bool absolute, 4: i32 duration, 5: i32 timeout)
  /** fc_wait_vel. */
  i32 fc_wait_vel(1: list<double> middle, 2: list<double> range, 3: bool absolute, 4: i32 duration, 5: i32 timeout)
  /** getQueueSize. */
  i32 getQueueSize()
  /** getRobotIOStatus. */
  IOStatus getRobotIOStatus()
  /** getRobotStatus. */
  RobotStatus getRobotStatus()
  /** get_actual_joints_acceleration. */
  list<double> get_actual_joints_acceleration()
  /** get_actual_joints_position. */
  list<double> get_actual_joints_position()
  /** get_actual_joints_speed. */
  list<double> get_actual_joints_speed()
  /** get_actual_joints_torque. */
  list<double> get_actual_joints_torque()
  /** get_axis_motor_kt. */
  list<double> get_axis_motor_kt()
  /** get_axis_motor_rated_current. */
  list<double> get_axis_motor_rated_current()
  /** get_axis_ratio. */
  list<i16> get_axis_ratio()
  /** get_calib_DH. */
  list<list<double>> get_calib_DH()
  /** get_config_digital_in. */
  bool get_config_digital_in(1: i16 num)
  /** get_current_project. */
  string get_current_project()
  /** get_dynamic_calibration_params. */
  list<list<double>> get_dynamic_calibration_params()
  /** get_eaxis_info. */
  list<EAxissInfo> get_eaxis_info()
  /** get_ext_torque. */
  list<double> get_ext_torque()
  /** get_files_list. */
  map<string,i32> get_files_list(1: string path)
  /** get_flange_acceleration. */
  list<double> get_flange_acceleration()
  /** get_flange_pose. */
  list<double> get_flange_pose()
  /** get_flange_speed. */
  list<double> get_flange_speed()
  /** get_function_digital_in. */
  bool get_function_digital_in(1: i16 num)
  /** get_function_digital_out. */
  bool get_function_digital_out(1: i16 num)
  /** get_function_reg_in. */
  bool get_function_reg_in(1: i16 num)
  /** get_function_reg_out. */
  bool get_function_reg_out(1: i16 num)
  /** get_global_speed. */
  i32 get_global_speed()
  /** get_last_error. */
  list<string> get_last_error()
  /** get_motor_pole_pair_number. */
  list<i16> get_motor_pole_pair_number()
  /** get_motor_stator_slots. */
  list<i16> get_motor_stator_slots()
  /** get_noneblock_taskstate. */
  i32 get_noneblock_taskstate(1: i32 id)
  /** get_origin_DH. */
  list<list<double>> get_origin_DH()
  /** get_pos_bias. */
  list<double> get_pos_bias()
  /** get_realtime_data_queue_size. */
  i32 get_realtime_data_queue_size()
  /** get_robot_state. */
  list<byte> get_robot_state()
  /** get_robot_type. */
  list<string> get_robot_type()
  /** get_robot_version. */
  string get_robot_version()
  /** get_standard_analog_current_in. */
  double get_standard_analog_current_in(1: i16 num)
  /** get_standard_analog_voltage_in. */
  double get_standard_analog_voltage_in(1: i16 num)
  /** get_standard_digital_in. */
  bool get_standard_digital_in(1: i16 num)
  /** get_standard_digital_out. */
  bool get_standard_digital_out(1: i16 num)
  /** get_system_value_bool. */
  bool get_system_value_bool(1: string name)
  /** get_system_value_double. */
  double get_system_value_double(1: string name)
  /** get_system_value_list. */
  list<double> get_system_value_list(1: string name)
  /** get_system_value_lists. */
  list<list<double>> get_system_value_lists(1: string name)
  /** get_system_value_str. */
  string get_system_value_str(1: string name)
  /** get_target_joints_acceleration. */
  list<double> get_target_joints_acceleration()
  /** get_target_joints_position. */
  list<double> get_target_joints_position()
  /** get_target_joints_speed. */
  list<double> get_target_joints_speed()
  /** get_target_joints_torque. */
  list<double> get_target_joints_torque()
  /** get_tcp_acceleration. */
  list<double> get_tcp_acceleration()
  /** get_tcp_force. */
  list<double> get_tcp_force()
  /** get_tcp_force_tool. */
  list<double> get_tcp_force_tool(1: string tool)
  /** get_tcp_offset. */
  list<double> get_tcp_offset()
  /** get_tcp_pose. */
  list<double> get_tcp_pose()
  /** get_tcp_pose_coord. */
  list<double> get_tcp_pose_coord(1: string tool, 2: string wobj)
  /** get_tcp_speed. */
  list<double> get_tcp_speed()
  /** get_teach_speed. */
  i32 get_teach_speed()
  /** get_tool_analog_voltage_in. */
  double get_tool_analog_voltage_in(1: i16 num)
  /** get_tool_digital_in. */
  bool get_tool_digital_in(1: i16 num)
  /** get_tool_digital_out. */
  bool get_tool_digital_out(1: i16 num)
  /** get_tool_load. */
  list<double> get_tool_load()
  /** get_vibration_calibration_params. */
  list<list<double>> get_vibration_calibration_params()
  /** get_wobj. */
  list<double> get_wobj()
  /** log_error. */
  void log_error(1: string message)
  /** log_info. */
  void log_info(1: string message)
  /** modbus_add_signal. */
  i32 modbus_add_signal(1: string ip, 2: i32 slave_number, 3: i32 signal_address, 4: i32 signal_type, 5: string signal_name)
  /** modbus_delete_signal. */
  i32 modbus_delete_signal(1: string signal_name)
  /** modbus_read. */
  i32 modbus_read(1: string signal_name)
  /** modbus_set_frequency. */
  void modbus_set_frequency(1: string signal_name, 2: i32 frequence)
  /** modbus_write. */
  i32 modbus_write(1: string signal_name, 2: i32 value)
  /** modbus_write_multiple_coils. */
  i32 modbus_write_multiple_coils(1: i32 slave_num, 2: string name, 3: i32 len, 4: list<byte> byte_list)
  /** modbus_write_multiple_regs. */
  i32 modbus_write_multiple_regs(1: i32 slave_num, 2: string name, 3: i32 len, 4: list<i16> word_list)
  /** move_circle. */
  i32 move_circle(1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r, 6: i32 mode, 7: list<double> q_near, 8: string tool, 9: string wobj, 10: bool block, 11: Op op, 12: bool def_acc)
  /** move_circle_eaxis. */
  i32 move_circle_eaxis(1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double rad, 6: i32 mode, 7: list<double> qnear, 8: string tool, 9: string wobj, 10: string scheme_name, 11: list<double> epose, 12: double eaxis_v, 13: bool block, 14: Op op, 15: bool def_acc)
  /** move_eaxis. */
  i32 move_eaxis(1: string scheme_name, 2: list<double> epose, 3: double v, 4: bool block, 5: Op op)
  /** move_jog. */
  i32 move_jog(1: MoveJogTaskParam param, 2: bool block)
  /** move_jog_eaxis. */
  i32 move_jog_eaxis(1: string name, 2: i32 direction, 3: double vel, 4: bool block)
  /** move_spiral. */
  i32 move_spiral(1: list<double> p1, 2: list<double> p2, 3: double rev, 4: double len, 5: double r, 6: i32 mode, 7: double v, 8: double a, 9: list<double> q_near, 10: string tool, 11: string wobj, 12: bool block, 13: Op op, 14: bool def_acc)
  /** movec. */
  i32 movec(1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r, 6: i32 mode, 7: list<double> q_near, 8: string tool, 9: string wobj, 10: bool block, 11: Op op, 12: bool def_acc)
  /** movec_eaxis. */
  i32 movec_eaxis(1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double rad, 6: list<double> qnear, 7: string tool, 8: string wobj, 9: string scheme_name, 10: list<double> epose, 11: double eaxis_v, 12: bool block, 13: Op op, 14: bool def_acc, 15: i32 mode)
  /** movej. */
  i32 movej(1: list<double> joints_list, 2: double v, 3: double a, 4: double r, 5: bool block, 6: Op op, 7: bool def_acc)
  /** movej2. */
  i32 movej2(1: list<double> joints_list, 2: double v, 3: double a, 4: double r, 5: bool block, 6: Op op, 7: bool def_acc)
  /** movej2_eaxis. */
  i32 movej2_eaxis(1: list<double> joints_list, 2: double v, 3: double a, 4: double rad, 5: string scheme_name, 6: list<double> epose, 7: double eaxis_v, 8: bool block, 9: Op op, 10: bool def_acc)
  /** movej2_pose_eaxis. */
  i32 movej2_pose_eaxis(1: list<double> p, 2: double v, 3: double a, 4: double rad, 5: list<double> qnear, 6: string tool, 7: string wobj, 8: string scheme_name, 9: list<double> epose, 10: double eaxis_v, 11: bool block, 12: Op op, 13: bool def_acc)
  /** movej_pose. */
  i32 movej_pose(1: list<double> p, 2: double v, 3: double a, 4: double r, 5: list<double> q_near, 6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc)
  /** movej_pose2. */
  i32 movej_pose2(1: list<double> p, 2: double v, 3: double a, 4: double r, 5: list<double> q_near, 6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc)
  /** movel. */
  i32 movel(1: list<double> p, 2: double v, 3: double a, 4: double r, 5: list<double> q_near, 6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc)
  /** movel_eaxis. */
  i32 movel_eaxis(1: list<double> p, 2: double v, 3: double a, 4: double rad, 5: list<double> qnear, 6: string tool, 7: string wobj, 8: string scheme_name, 9: list<double> epose, 10: double eaxis_v, 11: bool block, 12: Op op, 13: bool def_acc)
  /** pause. */
  i32 pause(1: bool block)
  /** power_off. */
  i32 power_off(1: bool block)
  /** power_on. */
  i32 power_on(1: bool block)
  /** reach_check. */
  ReachabilityParam reach_check(1: list<double> base, 2: list<double> wobj, 3: list<double> tool, 4: list<double> ref_pos, 5: list<list<double>> check_points)
  /** read_bool_reg. */
  bool read_bool_reg(1: i16 num)
  /** read_data_485. */
  list<byte> read_data_485()
  /** read_data_can. */
  list<byte> read_data_can()
  /** read_encoder_count. */
  i64 read_encoder_count()
  /** read_float_reg. */
  double read_float_reg(1: i16 num)
  /** read_raw_data_485. */
  list<byte> read_raw_data_485(1: i32 len)
  /** read_raw_data_485_h. */
  list<byte> read_raw_data_485_h(1: list<byte> head, 2: i32 len)
  /** read_raw_data_485_ht. */
  list<byte> read_raw_data_485_ht(1: list<byte> head, 2: list<byte> tail)
  /** read_raw_data_can. */
  list<byte> read_raw_data_can()
  /** read_word_reg. */
  i32 read_word_reg(1: i16 num)
  /** realtime_data_enqueue. */
  i32 realtime_data_enqueue(1: list<RealTimeControlData> realtime_data, 2: bool block)
  /** replay. */
  i32 replay(1: string name, 2: i32 value, 3: i32 mode)
  /** restart. */
  i32 restart(1: bool block)
  /** resume. */
  i32 resume(1: bool block)
  /** robotmoving. */
  bool robotmoving()
  /** rpc_heartbeat. */
  void rpc_heartbeat(1: i32 time)
  /** run_program. */
  i32 run_program(1: string name, 2: bool block)
  /** save_dynamic_calibration_params. */
  i32 save_dynamic_calibration_params(1: string passwd)
  /** save_kinematic_calibration_params. */
  i32 save_kinematic_calibration_params(1: string passwd)
  /** servo_tcp. */
  i32 servo_tcp(1: list<double> pose_offset, 2: double v, 3: double a, 4: string tool, 5: bool block, 6: double kp, 7: double kd, 8: double smooth_vel, 9: double smooth_acc)
  /** servoj. */
  i32 servoj(1: list<double> joints_list, 2: double v, 3: double a, 4: bool block, 5: double kp, 6: double kd, 7: double smooth_vel, 8: double smooth_acc)
  /** servoj_pose. */
  i32 servoj_pose(1: list<double> pose_list, 2: double v, 3: double a, 4: list<double> q_near, 5: string tool, 6: string wobj, 7: bool block, 8: double kp, 9: double kd, 10: double smooth_vel, 11: double smooth_acc)
  /** servol. */
  i32 servol(1: list<double> pose_list, 2: double v, 3: double a, 4: list<double> q_near, 5: string tool, 6: string wobj, 7: bool block, 8: double kp, 9: double kd, 10: double smooth_vel, 11: double smooth_acc)
  /** set_analog_output_mode. */
  i32 set_analog_output_mode(1: i16 num, 2: i32 mode, 3: bool block)
  /** set_baudrate_485. */
  i32 set_baudrate_485(1: i32 value, 2: bool block)
  /** set_baudrate_can. */
  i32 set_baudrate_can(1: i32 value, 2: bool block)
  /** set_blend_ahead. */
  i32 set_blend_ahead(1: i32 per, 2: i32 num)
  /** set_digital_output_mode. */
  i32 set_digital_output_mode(1: i16 num, 2: i16 type, 3: i32 freq, 4: i32 duty_cycle)
  /** set_dynamic_calibration_info. */
  i32 set_dynamic_calibration_info(1: string passwd, 2: string info)
  /** set_dynamic_calibration_params. */
  i32 set_dynamic_calibration_params(1: list<list<double>> params)
  /** set_eaxis_param. */
  i32 set_eaxis_param(1: i32 num, 2: EAxisParam param, 3: bool block)
  /** set_eaxiss_scheme_param. */
  i32 set_eaxiss_scheme_param(1: i32 num, 2: EAxisSchemeParam param, 3: bool block)
  /** set_hand_teach_parameter. */
  i32 set_hand_teach_parameter(1: i32 space, 2: list<i32> joint_scale, 3: list<i32> cart_scale, 4: i32 coord_type, 5: list<bool> direction)
  /** set_kinematic_calibration_info. */
  i32 set_kinematic_calibration_info(1: string passwd, 2: string info)
  /** set_kinematic_calibration_params. */
  i32 set_kinematic_calibration_params(1: list<list<double>> params)
  /** set_load_data. */
  i32 set_load_data(1: list<double> value)
  /** set_pendant_type. */
  i32 set_pendant_type(1: i32 type)
  /** set_servo_config. */
  i32 set_servo_config(1: i32 axis_num, 2: i32 id, 3: i32 value, 4: i32 qfmt, 5: bool block)
  /** set_servo_file_params. */
  i32 set_servo_file_params(1: i32 axis_num, 2: i32 id, 3: string name, 4: double value, 5: double qfmt)
  /** set_standard_analog_current_out. */
  i32 set_standard_analog_current_out(1: i16 num, 2: double value, 3: bool block)
  /** set_standard_analog_voltage_out. */
  i32 set_standard_analog_voltage_out(1: i16 num, 2: double value, 3: bool block)
  /** set_standard_digital_out. */
  i32 set_standard_digital_out(1: i16 num, 2: bool value, 3: bool block)
  /** set_system_value_bool. */
  i32 set_system_value_bool(1: string name, 2: bool value)
  /** set_system_value_double. */
  i32 set_system_value_double(1: string name, 2: double value)
  /** set_system_value_list. */
  i32 set_system_value_list(1: string name, 2: list<double> value)
  /** set_system_value_str. */
  i32 set_system_value_str(1: string name, 2: string value)
  /** set_teach_pendant. */
  i32 set_teach_pendant(1: bool enable)
  /** set_teach_speed. */
  i32 set_teach_speed(1: i32 v)
  /** set_tool_data. */
  i32 set_tool_data(1: string name, 2: list<double> tool_offset, 3: list<double> payload, 4: list<double> inertia_tensor)
  /** set_tool_digital_out. */
  i32 set_tool_digital_out(1: i16 num, 2: bool value, 3: bool block)
  /** set_vibration_calibration_info. */
  i32 set_vibration_calibration_info(1: string passwd, 2: string info)
  /** set_wobj. */
  i32 set_wobj(1: string name, 2: list<double> wobj)
  /** set_wobj_offset. */
  i32 set_wobj_offset(1: list<double> wobj, 2: bool active)
  /** shutdown. */
  i32 shutdown(1: bool block)
  /** simulation. */
  i32 simulation(1: bool sim, 2: bool block)
  /** speed. */
  i32 speed(1: double val)
  /** speed_stop. */
  i32 speed_stop(1: bool block)
  /** speedj. */
  i32 speedj(1: list<double> joints_list, 2: double a, 3: i32 time, 4: bool block)
  /** speedl. */
  i32 speedl(1: list<double> pose_list, 2: double a, 3: i32 time, 4: bool block)
  /** spline. */
  i32 spline(1: list<list<double>> pose_list, 2: double v, 3: double a, 4: string tool, 5: string wobj, 6: bool block, 7: Op op, 8: double r, 9: bool def_acc)
  /** spline_op. */
  i32 spline_op(1: list<PointOp> pose_list, 2: double v, 3: double a, 4: string tool, 5: string wobj, 6: bool block, 7: Op op, 8: double r, 9: bool def_acc)
  /** start_realtime_mode. */
  i32 start_realtime_mode(1: i32 mode, 2: double fileter_bandwidth, 3: double com_lost_time)
  /** start_record_track. */
  i32 start_record_track(1: string name, 2: i32 mode, 3: string tool, 4: string wobj, 5: double interval)
  /** stop. */
  i32 stop(1: bool block)
  /** stop_manual_move. */
  i32 stop_manual_move(1: bool block)
  /** stop_record_track. */
  i32 stop_record_track()
  /** switch_mode. */
  i32 switch_mode(1: i32 mode)
  /** tcp_move. */
  i32 tcp_move(1: list<double> pose_offset, 2: double v, 3: double a, 4: double r, 5: string tool, 6: bool block, 7: Op op, 8: bool def_acc)
  /** tcp_move_2p. */
  i32 tcp_move_2p(1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r, 6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc)
  /** teach_mode. */
  i32 teach_mode(1: bool block)
  /** tool_read_data_485. */
  list<byte> tool_read_data_485()
  /** tool_read_raw_data_485. */
  list<byte> tool_read_raw_data_485(1: i32 len)
  /** tool_read_raw_data_485_h. */
  list<byte> tool_read_raw_data_485_h(1: list<byte> head, 2: i32 len)
  /** tool_read_raw_data_485_ht. */
  list<byte> tool_read_raw_data_485_ht(1: list<byte> head, 2: list<byte> tail)
  /** tool_write_data_485. */
  bool tool_write_data_485(1: list<byte> data)
  /** tool_write_raw_data_485. */
  bool tool_write_raw_data_485(1: list<byte> data)
  /** tool_write_raw_data_485_h. */
  bool tool_write_raw_data_485_h(1: list<byte> data, 2: list<byte> head)
  /** tool_write_raw_data_485_ht. */
  bool tool_write_raw_data_485_ht(1: list<byte> data, 2: list<byte> head, 3: list<byte> tail)
  /** trackCartMotion. */
  i32 trackCartMotion(1: double speed, 2: double acc, 3: bool block, 4: string tool, 5: string wobj, 6: double radius)
  /** trackClearQueue. */
  i32 trackClearQueue()
  /** trackEnqueue. */
  i32 trackEnqueue(1: list<list<double>> track, 2: bool block)
  /** trackEnqueueOp. */
  i32 trackEnqueueOp(1: list<PointOp> track, 2: bool block)
  /** trackJointMotion. */
  i32 trackJointMotion(1: double speed, 2: double acc, 3: bool block)
  /** upload_robot_param_to_toolboard. */
  i32 upload_robot_param_to_toolboard(1: string passwd)
  /** wobj_move. */
  i32 wobj_move(1: list<double> pose_offset, 2: double v, 3: double a, 4: double r, 5: string wobj, 6: bool block, 7: Op op, 8: bool def_acc)
  /** wobj_move_2p. */
  i32 wobj_move_2p(1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r, 6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc)
  /** write_bool_reg. */
  i32 write_bool_reg(1: i16 num, 2: bool value)
  /** write_data_485. */
  bool write_data_485(1: list<byte> data)
  /** write_data_can. */
  bool write_data_can(1: i32 id, 2: list<byte> data)
  /** write_float_reg. */
  i32 write_float_reg(1: i16 num, 2: double value)
  /** write_raw_data_485. */
  bool write_raw_data_485(1: list<byte> data)
  /** write_raw_data_485_h. */
  bool write_raw_data_485_h(1: list<byte> data, 2: list<byte> head)
  /** write_raw_data_485_ht. */
  bool write_raw_data_485_ht(1: list<byte> data, 2: list<byte> head, 3: list<byte> tail)
  /** write_raw_data_can. */
  bool write_raw_data_can(1: i32 id, 2: list<byte> data)
  /** write_word_reg. */
  i32 write_word_reg(1: i16 num, 2: i32 value)
}
