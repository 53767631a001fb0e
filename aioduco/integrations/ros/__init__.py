"""The core of a ROS driver of an arm; `ros1` and `ros2` are the shells.

`trajectory_goals` and `goal_queue` make decisions, without I/O and clock. `trajectory_server`,
`joint_commands`, `arm_services` and `arm_node` carry them out, on the event loop of one robot. None
of these needs ROS. `shared_messages` and `topics` are what both shells publish and take: they need
the messages of one ROS or the other. A shell has what is different in its ROS.
"""
