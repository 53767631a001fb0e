"""The core of a ROS driver of an arm, without ROS; `ros1` and `ros2` are the shells.

`trajectory_goals` and `goal_queue` make decisions, without I/O and clock. `trajectory_server`,
`joint_commands`, `arm_services` and `arm_node` carry them out, on the event loop of one robot.
A shell converts messages to the values of this folder, and these values to messages.
"""
