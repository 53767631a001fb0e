"""What a ROS driver of an arm does, without ROS; `ros1` is the shell for ROS 1.

`trajectory_goals` and `goal_queue` decide, without I/O and clock. `trajectory_server`,
`arm_services` and `arm_node` carry out, on the event loop of one robot. A shell turns messages into
the values of this folder, and these into messages.
"""
