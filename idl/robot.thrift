/**
 * The RPC interface of DUCO (SIASUN) controllers.
 *
 * Unframed strict TBinaryProtocol on TCP 7003. Field ids and types are read off the
 * public generated vendor clients; none is invented.
 */
namespace py duco

/** Outputs that a motion sets: 1 after its start, 2 around its end, 3 when it pauses or stops. */
struct Op {
  1: byte time_or_dist_1  // 0 off, 1 by time, 2 by distance
  2: byte trig_io_1  // 1-16 cabinet output, 101-127 bool register 1-27; no more fits
  3: bool trig_value_1
  4: double trig_time_1  // ms after the start
  5: double trig_dist_1  // m after the start
  6: string trig_event_1  // name of an event; goes before the output; empty for the output
  7: byte time_or_dist_2  // 0 off, 1 by time, 2 by distance
  8: byte trig_io_2
  9: bool trig_value_2
  10: double trig_time_2  // ms before the end, negative for after it
  11: double trig_dist_2  // m before the end, negative for after it
  12: string trig_event_2
  13: byte time_or_dist_3  // 0 off, 1 by time
  14: byte trig_io_3
  15: bool trig_value_3
  16: double trig_time_3  // ms before standstill, negative for after it
  17: double trig_dist_3  // without effect
  18: string trig_event_3
}

/** A point of a spline or of the track pool, with what is triggered there. */
struct PointOp {
  1: list<double> pos  // six: a pose m, rad; in the track pool also joints rad
  2: Op op
}

/** The arm at one moment; Cartesian values are the tool's in the world frame. */
struct RobotStatus {
  1: list<double> jointExpectPosition  // rad
  2: list<double> jointExpectVelocity  // rad/s
  3: list<double> jointExpectAccelera  // rad/s²
  4: list<double> jointActualPosition  // rad
  5: list<double> jointActualVelocity  // rad/s
  6: list<double> jointActualAccelera  // rad/s²
  7: list<double> jointActualCurrent  // thousandths of the motor's rated current
  8: list<double> jointTemperature  // °C
  9: list<double> driverTemperature  // °C
  10: list<double> cartExpectPosition  // m, rad
  11: list<double> cartExpectVelocity  // m/s, rad/s
  12: list<double> cartExpectAccelera  // m/s², rad/s²
  13: list<double> cartActualPosition  // m, rad
  14: list<double> cartActualVelocity  // m/s, rad/s
  15: list<double> cartActualAccelera  // m/s², rad/s²
  16: list<bool> slaveReady  // per joint: enabled
  17: bool collision  // a collision was seen and not reset
  18: byte collisionAxis  // joint of the collision, 0 for none
  19: bool emcStopSignal  // an emergency stop is pressed
  20: byte robotState  // StateRobot
  21: i32 robotError  // error code
}

/** All inputs, outputs and registers at one moment. */
struct IOStatus {
  1: list<double> analogCurrentOutputs  // mA
  2: list<double> analogVoltageOutputs  // V
  3: list<double> analogCurrentInputs  // mA
  4: list<double> analogVoltageInputs  // V
  5: list<bool> digitalInputs
  6: list<bool> digitalOutputs
  7: list<bool> toolIOIn
  8: list<bool> toolIOOut
  9: list<bool> toolButton  // buttons T and S at the tool
  10: list<bool> funRegisterInputs
  11: list<bool> funRegisterOutputs
  12: list<bool> boolRegisterInputs
  13: list<bool> boolRegisterOutputs
  14: list<i16> wordRegisterInputs
  15: list<i16> wordRegisterOutputs
  16: list<double> floatRegisterInputs
  17: list<double> floatRegisterOutputs
}

/** One jog. */
struct MoveJogTaskParam {
  1: i32 jog_direction  // -1 or 1; in manual 4.3 0 positive, 1 negative
  2: i32 jog_type  // 1 Cartesian, 2 joint
  3: i32 axis_num  // joint, or direction x to rz; 0-5 in manual 4.3
  4: double vel  // percent
  5: i32 jog_coordinate  // 0 world, 1 base, 2 tool, 3 work object
  6: bool use_step  // true: one step, false: until stop_manual_move
  7: double step_jointValue  // rad
  8: double step_cartvalue  // m or rad
}

/** What reach_check found. */
struct ReachabilityParam {
  1: bool result  // whether all can be reached
  2: list<list<double>> joints_pos  // joints rad for each pose, if so
}

/** A scheme of external axes. */
struct EAxissInfo {
  1: string scheme_name
  2: i32 status  // whether it is active
  3: double pos  // rad or m
}

/** One command of realtime control; only the list of the chosen mode counts. */
struct RealTimeControlData {
  1: list<double> joint_pos_cmd  // rad, mode 0
  2: list<double> joint_vel_cmd  // rad/s, mode 1
  3: list<double> joint_torq_cmd  // mode 2, reserved
  4: list<double> cart_pos_tool_wobj_cmd  // m, rad, mode 3
  5: list<double> cart_vel_tool_wobj_cmd  // m/s, rad/s, mode 4
  6: list<double> cart_ft_cmd  // reserved
  7: bool status  // true: a fresh command
}

/** Parameters of an external axis. Not in the manual. */
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

/** Parameters of a scheme of external axes. Not in the manual. */
struct EAxisSchemeParam {
  1: i32 type
  2: list<i32> axis_link
  3: list<double> base
  4: list<list<double>> dh
  5: i32 install
}

service RPCRobot {

  // 1.3.1 connection (实例连接控制)

  /** Report that this client lives; the arm stops if none follows within `time` ms. */
  void rpc_heartbeat(1: i32 time)

  // 1.3.2 system control (系统控制)

  /** Power the arm on. Returns the task's end state if `block`, else its id. */
  i32 power_on(1: bool block)
  /** Power the arm off. Returns the task's end state if `block`, else its id. */
  i32 power_off(1: bool block)
  /** Enable the servos. Returns the task's end state if `block`, else its id. */
  i32 enable(1: bool block)
  /** Disable the servos. Returns the task's end state if `block`, else its id. */
  i32 disable(1: bool block)
  /** Shut the controller down. Returns the task's end state if `block`, else its id. */
  i32 shutdown(1: bool block)
  /** Restart the controller. Returns the task's end state if `block`, else its id. */
  i32 restart(1: bool block)

  // 1.3.3 task control (任务控制)

  /** Stop all tasks. Returns the end state if `block`, else a task id. */
  i32 stop(1: bool block)
  /** Pause all tasks. Returns the end state if `block`, else a task id. */
  i32 pause(1: bool block)
  /** Resume all paused tasks. Returns the end state if `block`, else a task id. */
  i32 resume(1: bool block)
  /** End the running motion and those read ahead. Not in manual 3.8, in 4.3. */
  i32 abort(1: bool block)

  // 1.3.4 programs (脚本控制)

  /** Run a program of the controller by name. Returns end state or task id. */
  i32 run_program(1: string name, 2: bool block)
  /** Path of the project that is loaded. */
  string get_current_project()
  /** Files below `path`: name to kind, 0 a folder, 1 a file. */
  map<string,i32> get_files_list(1: string path)

  // 1.3.5 motion (移动控制)

  /** Move the joints to `joints_list` rad; v rad/s, a rad/s², r m of blending. */
  i32 movej2(
      1: list<double> joints_list, 2: double v, 3: double a, 4: double r, 5: bool block, 6: Op op,
      7: bool def_acc
  )
  /** Move the joints to the pose p m, rad; v rad/s, a rad/s², r m of blending. */
  i32 movej_pose2(
      1: list<double> p, 2: double v, 3: double a, 4: double r, 5: list<double> q_near,
      6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc
  )
  /** Move the tool along a line to the pose p m, rad; v m/s, a m/s², r m of blending. */
  i32 movel(
      1: list<double> p, 2: double v, 3: double a, 4: double r, 5: list<double> q_near,
      6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc
  )
  /** Move the tool along an arc through p1 to p2 m, rad; v m/s, a m/s², r m of blending. */
  i32 movec(
      1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r, 6: i32 mode,
      7: list<double> q_near, 8: string tool, 9: string wobj, 10: bool block, 11: Op op,
      12: bool def_acc
  )
  /** Move the tool along the full circle through p1 and p2; v m/s, a m/s², r m. */
  i32 move_circle(
      1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r, 6: i32 mode,
      7: list<double> q_near, 8: string tool, 9: string wobj, 10: bool block, 11: Op op,
      12: bool def_acc
  )
  /** Move along a line by an offset m, rad in the tool's frame; v m/s, a m/s², r m. */
  i32 tcp_move(
      1: list<double> pose_offset, 2: double v, 3: double a, 4: double r, 5: string tool,
      6: bool block, 7: Op op, 8: bool def_acc
  )
  /** Move along a line by the offset from p1 to p2 in the tool's frame; v m/s, a m/s². */
  i32 tcp_move_2p(
      1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r,
      6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc
  )
  /** Move along a line by an offset m, rad in the work object's frame; v m/s, a m/s². */
  i32 wobj_move(
      1: list<double> pose_offset, 2: double v, 3: double a, 4: double r, 5: string wobj,
      6: bool block, 7: Op op, 8: bool def_acc
  )
  /** Move along a line by the offset from p1 to p2 in the work object's frame. */
  i32 wobj_move_2p(
      1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double r,
      6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc
  )
  /** Turn the joints at `joints_list` rad/s for `time` ms, -1 for no end; a rad/s². */
  i32 speedj(1: list<double> joints_list, 2: double a, 3: i32 time, 4: bool block)
  /** Move the tool at `pose_list` m/s, rad/s in its frame for `time` ms, -1 for no end; a m/s². */
  i32 speedl(1: list<double> pose_list, 2: double a, 3: i32 time, 4: bool block)
  /** End speedj and speedl. */
  i32 speed_stop(1: bool block)
  /** Enter hand guiding. */
  i32 teach_mode(1: bool block)
  /** Leave hand guiding. */
  i32 end_teach_mode(1: bool block)
  /** Set hand guiding: space, compliance of joints or of x to rz, frame, directions. */
  i32 set_hand_teach_parameter(
      1: i32 space, 2: list<i32> joint_scale, 3: list<i32> cart_scale, 4: i32 coord_type,
      5: list<bool> direction
  )
  /** Run a recorded track at `value` percent; mode 0 by joints, 1 by poses. */
  i32 replay(1: string name, 2: i32 value, 3: i32 mode)
  /** Move the tool along a spline through up to 50 poses m, rad; v m/s, a m/s², r m. */
  i32 spline(
      1: list<list<double>> pose_list, 2: double v, 3: double a, 4: string tool, 5: string wobj,
      6: bool block, 7: Op op, 8: double r, 9: bool def_acc
  )
  /** Move along a spline of up to 50 poses with triggers at the points; v m/s, a m/s². */
  i32 spline_op(
      1: list<PointOp> pose_list, 2: double v, 3: double a, 4: string tool, 5: string wobj,
      6: bool block, 7: Op op, 8: double r, 9: bool def_acc
  )
  /** Follow joint targets rad that come one after another; v rad/s, a rad/s². */
  i32 servoj(
      1: list<double> joints_list, 2: double v, 3: double a, 4: bool block, 5: double kp,
      6: double kd, 7: double smooth_vel, 8: double smooth_acc
  )
  /** Follow poses m, rad that come one after another, by the joints; v rad/s, a rad/s². */
  i32 servoj_pose(
      1: list<double> pose_list, 2: double v, 3: double a, 4: list<double> q_near, 5: string tool,
      6: string wobj, 7: bool block, 8: double kp, 9: double kd, 10: double smooth_vel,
      11: double smooth_acc
  )
  /** Follow offsets m, rad in the tool's frame that come one after another. */
  i32 servo_tcp(
      1: list<double> pose_offset, 2: double v, 3: double a, 4: string tool, 5: bool block,
      6: double kp, 7: double kd, 8: double smooth_vel, 9: double smooth_acc
  )
  /** Follow poses m, rad that come one after another, by the Cartesian directions. */
  i32 servol(
      1: list<double> pose_list, 2: double v, 3: double a, 4: list<double> q_near, 5: string tool,
      6: string wobj, 7: bool block, 8: double kp, 9: double kd, 10: double smooth_vel,
      11: double smooth_acc
  )
  /** Move along a spiral: `rev` turns, `len` m along the axis, `r` m; v m/s, a m/s². */
  i32 move_spiral(
      1: list<double> p1, 2: list<double> p2, 3: double rev, 4: double len, 5: double r,
      6: i32 mode, 7: double v, 8: double a, 9: list<double> q_near, 10: string tool,
      11: string wobj, 12: bool block, 13: Op op, 14: bool def_acc
  )
  /** Jog one joint or one Cartesian direction, continuously or by a step. */
  i32 move_jog(1: MoveJogTaskParam param, 2: bool block)
  /** End move_jog. */
  i32 stop_manual_move(1: bool block)
  /** Read following motions ahead at `per` percent of the path, or `num` of them. */
  i32 set_blend_ahead(1: i32 per, 2: i32 num)
  /** Move the joints to `joints_list` rad; v, a and r in percent. Not in the manual. */
  i32 movej(
      1: list<double> joints_list, 2: double v, 3: double a, 4: double r, 5: bool block, 6: Op op,
      7: bool def_acc
  )
  /** Move the joints to the pose p m, rad; v, a and r in percent. Not in the manual. */
  i32 movej_pose(
      1: list<double> p, 2: double v, 3: double a, 4: double r, 5: list<double> q_near,
      6: string tool, 7: string wobj, 8: bool block, 9: Op op, 10: bool def_acc
  )

  // 1.3.6 CAN and RS-485 (can 及 485 总线)

  /** Set the rate of the cabinet's RS-485 port, bit/s. */
  i32 set_baudrate_485(1: i32 value, 2: bool block)
  /** Read `len` bytes from RS-485; empty if there is nothing. */
  list<byte> read_raw_data_485(1: i32 len)
  /** Read a frame of `len` bytes that starts with `head` from RS-485. */
  list<byte> read_raw_data_485_h(1: list<byte> head, 2: i32 len)
  /** Read a frame from `head` to `tail` from RS-485. */
  list<byte> read_raw_data_485_ht(1: list<byte> head, 2: list<byte> tail)
  /** Write bytes to RS-485. */
  bool write_raw_data_485(1: list<byte> data)
  /** Write `head` and bytes to RS-485. */
  bool write_raw_data_485_h(1: list<byte> data, 2: list<byte> head)
  /** Write `head`, bytes and `tail` to RS-485. */
  bool write_raw_data_485_ht(1: list<byte> data, 2: list<byte> head, 3: list<byte> tail)
  /** Read from RS-485. Not in the manual. */
  list<byte> read_data_485()
  /** Write to RS-485. Not in the manual. */
  bool write_data_485(1: list<byte> data)
  /** Read `len` bytes from the tool's RS-485; empty if there is nothing. */
  list<byte> tool_read_raw_data_485(1: i32 len)
  /** Read a frame of `len` bytes that starts with `head` from the tool's RS-485. */
  list<byte> tool_read_raw_data_485_h(1: list<byte> head, 2: i32 len)
  /** Read a frame from `head` to `tail` from the tool's RS-485. */
  list<byte> tool_read_raw_data_485_ht(1: list<byte> head, 2: list<byte> tail)
  /** Write bytes to the tool's RS-485. */
  bool tool_write_raw_data_485(1: list<byte> data)
  /** Write `head` and bytes to the tool's RS-485. */
  bool tool_write_raw_data_485_h(1: list<byte> data, 2: list<byte> head)
  /** Write `head`, bytes and `tail` to the tool's RS-485. */
  bool tool_write_raw_data_485_ht(1: list<byte> data, 2: list<byte> head, 3: list<byte> tail)
  /** Read from the tool's RS-485. Not in the manual. */
  list<byte> tool_read_data_485()
  /** Write to the tool's RS-485. Not in the manual. */
  bool tool_write_data_485(1: list<byte> data)
  /** Set the rate of the CAN bus, bit/s. */
  i32 set_baudrate_can(1: i32 value, 2: bool block)
  /** Read one CAN frame: the sender's id, then the bytes; empty if there is none. */
  list<byte> read_raw_data_can()
  /** Write one CAN frame. */
  bool write_raw_data_can(1: i32 id, 2: list<byte> data)
  /** Read from CAN. Not in the manual. */
  list<byte> read_data_can()
  /** Write to CAN. Not in the manual. */
  bool write_data_can(1: i32 id, 2: list<byte> data)

  // 1.3.7 system functions and peripherals (系统函数及外设)

  /** Make a cabinet output a level (type 0) or pulses (1) at freq Hz, duty_cycle percent. */
  i32 set_digital_output_mode(1: i16 num, 2: i16 type, 3: i32 freq, 4: i32 duty_cycle)
  /** Set cabinet output 1 to 16. */
  i32 set_standard_digital_out(1: i16 num, 2: bool value, 3: bool block)
  /** Level of cabinet output 1 to 16. */
  bool get_standard_digital_out(1: i16 num)
  /** Level of cabinet input 1 to 16. */
  bool get_standard_digital_in(1: i16 num)
  /** Set tool output 1 or 2. */
  i32 set_tool_digital_out(1: i16 num, 2: bool value, 3: bool block)
  /** Level of tool output 1 or 2. */
  bool get_tool_digital_out(1: i16 num)
  /** Level of tool input 1 or 2. */
  bool get_tool_digital_in(1: i16 num)
  /** Level of a configurable cabinet input. Not in the manual. */
  bool get_config_digital_in(1: i16 num)
  /** Level of function input 1 to 8. */
  bool get_function_digital_in(1: i16 num)
  /** Level of function output 1 to 8. */
  bool get_function_digital_out(1: i16 num)
  /** Voltage at cabinet channel 1 to 4, V. */
  double get_standard_analog_voltage_in(1: i16 num)
  /** Set the voltage of cabinet channel 1 to 4, 0 to 10 V. */
  i32 set_standard_analog_voltage_out(1: i16 num, 2: double value, 3: bool block)
  /** Voltage at tool channel 1 or 2, V. */
  double get_tool_analog_voltage_in(1: i16 num)
  /** Current at cabinet channel 1 to 4, mA. */
  double get_standard_analog_current_in(1: i16 num)
  /** Set the current of cabinet channel 1 to 4, 4 to 20 mA. */
  i32 set_standard_analog_current_out(1: i16 num, 2: double value, 3: bool block)
  /** Set the kind of an analog output. Not in the manual. */
  i32 set_analog_output_mode(1: i16 num, 2: i32 mode, 3: bool block)
  /** Write bool register 1 to 64. */
  i32 write_bool_reg(1: i16 num, 2: bool value)
  /** Write word register 1 to 32. */
  i32 write_word_reg(1: i16 num, 2: i32 value)
  /** Write float register 1 to 32. */
  i32 write_float_reg(1: i16 num, 2: double value)
  /** Read bool register 1 to 64. */
  bool read_bool_reg(1: i16 num)
  /** Read word register 1 to 32. */
  i32 read_word_reg(1: i16 num)
  /** Read float register 1 to 32. */
  double read_float_reg(1: i16 num)
  /** Read function input register 1 to 16. */
  bool get_function_reg_in(1: i16 num)
  /** Read function output register 1 to 16. */
  bool get_function_reg_out(1: i16 num)
  /** Add an offset m, rad to the work object of all following motions, or take it away. */
  i32 set_wobj_offset(1: list<double> wobj, 2: bool active)
  /** Set a work object by name, m, rad. Not in the manual. */
  i32 set_wobj(1: string name, 2: list<double> wobj)
  /** Set a tool: offset m, rad from the flange, payload kg, m, inertia kg m². */
  i32 set_tool_data(
      1: string name, 2: list<double> tool_offset, 3: list<double> payload,
      4: list<double> inertia_tensor
  )
  /** Joints rad for the pose p m, rad, near q_near; empty lists mean the present values. */
  list<double> cal_ikine(
      1: list<double> p, 2: list<double> q_near, 3: list<double> tool, 4: list<double> wobj
  )
  /** Pose m, rad for joints rad; empty tool and wobj mean the present ones. */
  list<double> cal_fkine(
      1: list<double> joints_position, 2: list<double> tool, 3: list<double> wobj
  )
  /** Pose of the tool in the base frame, m, rad. */
  list<double> get_tcp_pose()
  /** Pose m, rad with the tool and the work object of these names. */
  list<double> get_tcp_pose_coord(1: string tool, 2: string wobj)
  /** Speed of the tool's origin, m/s, rad/s. */
  list<double> get_tcp_speed()
  /** Acceleration of the tool's origin, m/s², rad/s². */
  list<double> get_tcp_acceleration()
  /** Force at the tool's origin, N, N m; needs a force sensor. */
  list<double> get_tcp_force()
  /** Force in the frame of the tool of this name, N, N m; needs a force sensor. */
  list<double> get_tcp_force_tool(1: string tool)
  /** Offset of the present tool from the flange, m, rad. */
  list<double> get_tcp_offset()
  /** Mass and centre of mass of the present tool, kg, m. */
  list<double> get_tool_load()
  /** The present work object in the base frame, m, rad. */
  list<double> get_wobj()
  /** Measured joint positions, rad. */
  list<double> get_actual_joints_position()
  /** Planned joint positions, rad. */
  list<double> get_target_joints_position()
  /** Measured joint speeds, rad/s. */
  list<double> get_actual_joints_speed()
  /** Planned joint speeds, rad/s. */
  list<double> get_target_joints_speed()
  /** Measured joint accelerations, rad/s². */
  list<double> get_actual_joints_acceleration()
  /** Planned joint accelerations, rad/s². */
  list<double> get_target_joints_acceleration()
  /** Measured joint torques, N m. */
  list<double> get_actual_joints_torque()
  /** Planned joint torques, N m; the manual's text says rad/s². */
  list<double> get_target_joints_torque()
  /** Pose of the flange in the base frame, m, rad. */
  list<double> get_flange_pose()
  /** Speed of the flange in the base frame, m/s, rad/s. */
  list<double> get_flange_speed()
  /** Acceleration of the flange in the base frame, m/s², rad/s². */
  list<double> get_flange_acceleration()
  /** Four states: robot, program, safety controller, operation mode. */
  list<byte> get_robot_state()
  /** Switch between simulation and the real arm; the arm must stand. */
  i32 simulation(1: bool sim, 2: bool block)
  /** Set the global speed, 1 to 100 percent. */
  i32 speed(1: double val)
  /** Set the mass kg and centre m of what the tool holds. */
  i32 set_load_data(1: list<double> value)
  /** Start to record a track: mode 0 each `interval` degrees, 1 each `interval` seconds. */
  i32 start_record_track(
      1: string name, 2: i32 mode, 3: string tool, 4: string wobj, 5: double interval
  )
  /** End the record of a track. */
  i32 stop_record_track()
  /** Set the level of collision detection, 0 off, 1 to 5. */
  i32 collision_detect(1: i32 value)
  /** Clear the collision warning. */
  i32 collision_detection_reset()
  /** Turn the keys of the pendant on or off. */
  i32 set_teach_pendant(1: bool enable)
  /** Set the teaching speed, 1 to 100 percent. */
  i32 set_teach_speed(1: i32 v)
  /** Teaching speed, percent. */
  i32 get_teach_speed()
  /** Global speed, percent. */
  i32 get_global_speed()
  /** Whether poses m, rad can be reached with this base, work object and tool. */
  ReachabilityParam reach_check(
      1: list<double> base, 2: list<double> wobj, 3: list<double> tool, 4: list<double> ref_pos,
      5: list<list<double>> check_points
  )
  /** Switch to manual (0) or automatic (1) operation. */
  i32 switch_mode(1: i32 mode)
  /** The arm's positions, speeds, currents, temperatures and errors at once. */
  RobotStatus getRobotStatus()
  /** All inputs, outputs and registers at once. */
  IOStatus getRobotIOStatus()
  /** Count of the external incremental encoder. */
  i64 read_encoder_count()
  /** DH parameters of the model: a m, alpha rad, d m, theta rad per joint. */
  list<list<double>> get_origin_DH()
  /** DH parameters after calibration: a m, alpha rad, d m, theta rad per joint. */
  list<list<double>> get_calib_DH()
  /** Series, model, extension and serial number. */
  list<string> get_robot_type()
  /** Observed external joint torques. */
  list<double> get_ext_torque()
  /** Set a global variable of type bool. */
  i32 set_system_value_bool(1: string name, 2: bool value)
  /** Set a global variable of type number. */
  i32 set_system_value_double(1: string name, 2: double value)
  /** Set a global variable of type string. */
  i32 set_system_value_str(1: string name, 2: string value)
  /** Set a global variable of type list of numbers. */
  i32 set_system_value_list(1: string name, 2: list<double> value)
  /** Read a global variable of type bool. */
  bool get_system_value_bool(1: string name)
  /** Read a global variable of type number. */
  double get_system_value_double(1: string name)
  /** Read a global variable of type string. */
  string get_system_value_str(1: string name)
  /** Read a global variable of type list of numbers. */
  list<double> get_system_value_list(1: string name)
  /** Read a global variable of type list of poses. Not in manual 3.8, in 4.3. */
  list<list<double>> get_system_value_lists(1: string name)

  // 1.3.8 diagnosis (调试相关)

  /** Write a line into the controller's log. */
  void log_info(1: string message)
  /** Show an error on the pendant and pause all tasks. */
  void log_error(1: string message)
  /** The latest errors. */
  list<string> get_last_error()
  /** State of a task by its id. */
  i32 get_noneblock_taskstate(1: i32 id)
  /** Whether the arm moves. */
  bool robotmoving()

  // 1.3.9 Modbus

  /** Read a Modbus signal. */
  i32 modbus_read(1: string signal_name)
  /** Write a Modbus signal: a register 0 to 65535, a coil 0 or 1. */
  i32 modbus_write(1: string signal_name, 2: i32 value)
  /** Set how often a Modbus signal is refreshed, 1 to 100 Hz. */
  void modbus_set_frequency(1: string signal_name, 2: i32 frequence)
  /** Write `len` registers of a Modbus unit. */
  i32 modbus_write_multiple_regs(
      1: i32 slave_num, 2: string name, 3: i32 len, 4: list<i16> word_list
  )
  /** Write `len` coils of a Modbus unit. */
  i32 modbus_write_multiple_coils(
      1: i32 slave_num, 2: string name, 3: i32 len, 4: list<byte> byte_list
  )
  /** Add a Modbus signal. Not in the manual. */
  i32 modbus_add_signal(
      1: string ip, 2: i32 slave_number, 3: i32 signal_address, 4: i32 signal_type,
      5: string signal_name
  )
  /** Delete a Modbus signal. Not in the manual. */
  i32 modbus_delete_signal(1: string signal_name)

  // 1.3.10 force control (力控函数)

  /** Start force control; motions then give way to force. */
  i32 fc_start()
  /** End force control; the arm must stand. */
  i32 fc_stop()
  /** Set force control: directions, target N, N m, damping, greatest speed, dead band, frame. */
  i32 fc_config(
      1: list<bool> direction, 2: list<double> ref_ft, 3: list<double> damp,
      4: list<double> max_vel, 5: list<double> number_list, 6: string tool, 7: string wobj,
      8: i32 value
  )
  /** Move by force control alone. */
  i32 fc_move(1: bool block)
  /** Watch the force, N, N m: the arm stops with an alarm when it is exceeded. */
  i32 fc_guard_act(
      1: list<bool> direction, 2: list<double> ref_ft, 3: string tool, 4: string wobj, 5: i32 type,
      6: i32 force_property
  )
  /** End the watch of fc_guard_act. */
  i32 fc_guard_deact()
  /** Set the readings of the force sensor to these values, N, N m. */
  i32 fc_force_set_value(1: list<bool> direction, 2: list<double> ref_ft)
  /** End the motion at a position m, rad held for `duration` ms; give up after `timeout` ms. */
  i32 fc_wait_pos(
      1: list<double> middle, 2: list<double> range, 3: bool absolute, 4: i32 duration,
      5: i32 timeout
  )
  /** End the motion at a speed m/s, rad/s held for `duration` ms; give up after `timeout` ms. */
  i32 fc_wait_vel(
      1: list<double> middle, 2: list<double> range, 3: bool absolute, 4: i32 duration,
      5: i32 timeout
  )
  /** End the motion at a force N, N m held for `duration` ms; give up after `timeout` ms. */
  i32 fc_wait_ft(
      1: list<double> middle, 2: list<double> range, 3: bool absolute, 4: i32 duration,
      5: i32 timeout
  )
  /** Combine the conditions position, speed, force: 0 off, 1 and, 2 or. Resets them. */
  i32 fc_wait_logic(1: list<i32> value)
  /** Readings of the force sensor, N, N m. */
  list<double> fc_get_ft()
  /** Whether force control is on. */
  bool fc_mode_is_active()

  // 1.3.11 motion optimization (运动优化函数)

  /** Let the controller choose speeds up to the safety limits, in automatic operation. */
  i32 enable_speed_optimization()
  /** End enable_speed_optimization. */
  i32 disable_speed_optimization()
  /** Let the controller choose accelerations by the arm's dynamics. */
  i32 enable_acc_optimization()
  /** End enable_acc_optimization. */
  i32 disable_acc_optimization()
  /** Pass singularities by joint motion, off the path; vibration control must be off. */
  i32 enable_singularity_control()
  /** End enable_singularity_control. */
  i32 disable_singularity_control()
  /** Damp vibration at start and stop; each motion takes 0.2 to 0.4 s longer. */
  i32 enable_vibration_control()
  /** End enable_vibration_control, until it is enabled again. */
  i32 disable_vibration_control()

  // 1.3.12 track pool (轨迹池函数)

  /** Put points, joints rad or poses m, rad, into the pool of 1000. -1 if it is full. */
  i32 trackEnqueue(1: list<list<double>> track, 2: bool block)
  /** Empty the pool. */
  i32 trackClearQueue()
  /** How many points of the pool are still to come. */
  i32 getQueueSize()
  /** Follow the pool's points as joints; speed rad/s, acc rad/s². */
  i32 trackJointMotion(1: double speed, 2: double acc, 3: bool block)
  /** Follow the pool's points as poses; speed m/s, acc m/s², radius m. */
  i32 trackCartMotion(
      1: double speed, 2: double acc, 3: bool block, 4: string tool, 5: string wobj,
      6: double radius
  )
  /** Put points with triggers into the pool of 1000. -1 if it is full. */
  i32 trackEnqueueOp(1: list<PointOp> track, 2: bool block)

  // 1.3.13 combined motion (复合运动函数)

  /** Set the weave that is laid over motions: shape, plane, fq Hz, amp m, dwell ms. */
  i32 combine_motion_config(
      1: i32 type, 2: i32 ref_plane, 3: double fq, 4: double amp, 5: double el_offset,
      6: double az_offset, 7: double up_height, 8: list<i32> time, 9: bool path_dwell,
      10: list<Op> op_list
  )
  /** Lay the weave over the following motions; the arm must stand. */
  i32 enable_combine_motion()
  /** End the weave; the arm must stand. */
  i32 disable_combine_motion()

  // 1.3.14 external axes (外部轴控制函数说明)

  /** Activate a scheme of external axes. */
  i32 enable_eaxis_scheme(1: string scheme_name)
  /** Deactivate a scheme of external axes. */
  i32 disable_eaxis_scheme(1: string scheme_name)
  /** Move external axes to `epose` rad or m; v rad/s or m/s. */
  i32 move_eaxis(1: string scheme_name, 2: list<double> epose, 3: double v, 4: bool block, 5: Op op)
  /** Jog an external axis, direction -1 or 1, at `vel` percent. */
  i32 move_jog_eaxis(1: string name, 2: i32 direction, 3: double vel, 4: bool block)
  /** movej2 together with external axes: epose rad or m, eaxis_v rad/s or m/s. */
  i32 movej2_eaxis(
      1: list<double> joints_list, 2: double v, 3: double a, 4: double rad, 5: string scheme_name,
      6: list<double> epose, 7: double eaxis_v, 8: bool block, 9: Op op, 10: bool def_acc
  )
  /** movej_pose2 together with external axes: epose rad or m, eaxis_v rad/s or m/s. */
  i32 movej2_pose_eaxis(
      1: list<double> p, 2: double v, 3: double a, 4: double rad, 5: list<double> qnear,
      6: string tool, 7: string wobj, 8: string scheme_name, 9: list<double> epose,
      10: double eaxis_v, 11: bool block, 12: Op op, 13: bool def_acc
  )
  /** movel together with external axes: epose rad or m, eaxis_v rad/s or m/s. */
  i32 movel_eaxis(
      1: list<double> p, 2: double v, 3: double a, 4: double rad, 5: list<double> qnear,
      6: string tool, 7: string wobj, 8: string scheme_name, 9: list<double> epose,
      10: double eaxis_v, 11: bool block, 12: Op op, 13: bool def_acc
  )
  /** movec together with external axes: epose rad or m, eaxis_v rad/s or m/s. */
  i32 movec_eaxis(
      1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double rad,
      6: list<double> qnear, 7: string tool, 8: string wobj, 9: string scheme_name,
      10: list<double> epose, 11: double eaxis_v, 12: bool block, 13: Op op, 14: bool def_acc,
      15: i32 mode
  )
  /** move_circle together with external axes. Not in the manual. */
  i32 move_circle_eaxis(
      1: list<double> p1, 2: list<double> p2, 3: double v, 4: double a, 5: double rad, 6: i32 mode,
      7: list<double> qnear, 8: string tool, 9: string wobj, 10: string scheme_name,
      11: list<double> epose, 12: double eaxis_v, 13: bool block, 14: Op op, 15: bool def_acc
  )
  /** Schemes of external axes: state and position. Not in manual 3.8, in 4.3. */
  list<EAxissInfo> get_eaxis_info()
  /** Set the parameters of external axis `num`. Not in the manual. */
  i32 set_eaxis_param(1: i32 num, 2: EAxisParam param, 3: bool block)
  /** Set the parameters of scheme `num`. Not in the manual. */
  i32 set_eaxiss_scheme_param(1: i32 num, 2: EAxisSchemeParam param, 3: bool block)
  /** Add a scheme of external axes. Not in the manual. */
  i32 add_eaxis_scheme(1: i32 num, 2: bool block)
  /** Delete a scheme of external axes. Not in the manual. */
  i32 delete_eaxis_scheme(1: i32 num, 2: bool block)

  // 1.3.15 realtime control (实时控制函数)

  /** Follow the realtime queue; filter Hz, stop without data for com_lost_time s. */
  i32 start_realtime_mode(1: i32 mode, 2: double fileter_bandwidth, 3: double com_lost_time)
  /** End realtime control. */
  i32 end_realtime_mode()
  /** Put commands into the realtime queue. */
  i32 realtime_data_enqueue(1: list<RealTimeControlData> realtime_data, 2: bool block)
  /** Empty the realtime queue. */
  i32 clear_realtime_data_queue()
  /** How many commands wait in the realtime queue. */
  i32 get_realtime_data_queue_size()

  // 1.3.16 other (其他信息)

  /** Version of the controller's software. */
  string get_robot_version()

  // service: on the wire, not in the manual

  /** Change the recipe. Not in the manual. */
  void change_recipe()
  /** Set the kind of pendant. Not in the manual. */
  i32 set_pendant_type(1: i32 type)
  /** Set a parameter of an axis' servo drive. Not in the manual. */
  i32 set_servo_config(1: i32 axis_num, 2: i32 id, 3: i32 value, 4: i32 qfmt, 5: bool block)
  /** Apply the parameters of an axis' servo drive. Not in the manual. */
  i32 apply_servo_config(1: i32 axis_num, 2: bool block)
  /** Set a parameter in an axis' servo file. Not in the manual. */
  i32 set_servo_file_params(
      1: i32 axis_num, 2: i32 id, 3: string name, 4: double value, 5: double qfmt
  )
  /** Torque constants of the motors. Not in the manual. */
  list<double> get_axis_motor_kt()
  /** Rated currents of the motors. Not in the manual. */
  list<double> get_axis_motor_rated_current()
  /** Gear ratios of the axes. Not in the manual. */
  list<i16> get_axis_ratio()
  /** Pole pairs of the motors. Not in the manual. */
  list<i16> get_motor_pole_pair_number()
  /** Stator slots of the motors. Not in the manual. */
  list<i16> get_motor_stator_slots()
  /** Position biases of the axes. Not in the manual. */
  list<double> get_pos_bias()
  /** Parameters of the dynamic calibration. Not in the manual. */
  list<list<double>> get_dynamic_calibration_params()
  /** Set the parameters of the dynamic calibration. Not in the manual. */
  i32 set_dynamic_calibration_params(1: list<list<double>> params)
  /** Set the notes of the dynamic calibration. Not in the manual. */
  i32 set_dynamic_calibration_info(1: string passwd, 2: string info)
  /** Save the dynamic calibration. Not in the manual. */
  i32 save_dynamic_calibration_params(1: string passwd)
  /** Set the parameters of the kinematic calibration. Not in the manual. */
  i32 set_kinematic_calibration_params(1: list<list<double>> params)
  /** Set the notes of the kinematic calibration. Not in the manual. */
  i32 set_kinematic_calibration_info(1: string passwd, 2: string info)
  /** Save the kinematic calibration. Not in the manual. */
  i32 save_kinematic_calibration_params(1: string passwd)
  /** Parameters of the vibration calibration. Not in the manual. */
  list<list<double>> get_vibration_calibration_params()
  /** Set the notes of the vibration calibration. Not in the manual. */
  i32 set_vibration_calibration_info(1: string passwd, 2: string info)
  /** Write the robot's parameters to the tool board. Not in the manual. */
  i32 upload_robot_param_to_toolboard(1: string passwd)
}

/**
 * What manual 4.3 adds without arguments. A call without arguments is its name alone, so these can be
 * sent to a controller of 4.3; others do not have them. What they return follows from that manual, and
 * is an assumption for the two commanded values, which only the vendor's newest headers have.
 */
service RPCRobotNewer extends RPCRobot {
  /** Pose of the arm's base, m, rad. Manual 4.3. */
  list<double> get_base()
  /** Joints of the home position, rad. Manual 4.3. */
  list<double> get_home_pose()
  /** Angles at which the arm is mounted: ry and rz. Manual 4.3. */
  list<double> get_installation()
  /** Commanded pose of the tool, m, rad. In no manual. */
  list<double> get_tcp_pose_command()
  /** Commanded speed of the tool, m/s, rad/s. In no manual. */
  list<double> get_tcp_speed_command()
  /** Let motions track a seam by a laser sensor. Manual 4.3. */
  i32 enable_laser_track()
  /** End the tracking of a seam. Manual 4.3. */
  i32 disable_laser_track()
  /** Forget the offsets that the laser sensor found. Manual 4.3. */
  i32 reset_laser_track()
  /** Whether the controller simulates the arm. Manual 4.3. */
  bool get_simulation_state()
  /** Empty the list of errors. Manual 4.3. */
  void clear_error_message()
}
