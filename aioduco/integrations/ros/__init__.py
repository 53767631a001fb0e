"""What a ROS driver of an arm does, without ROS; `ros1` and `ros2` are the shells.

`trajectory_goals` and `goal_queue` decide, without I/O and clock. `trajectory_server`,
`joint_commands`, `arm_services` and `arm_node` carry out, on the event loop of one robot.
A shell turns messages into the values of this folder, and these into messages.
"""
