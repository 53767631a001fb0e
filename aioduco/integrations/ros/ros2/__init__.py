"""The shell for ROS 2: `aioduco ros2`. It needs rclpy and messages of an installed ROS.

`conversions` has what is different in messages of ROS 2, `_driver_node` is the managed node,
`driver_process` runs it. The repository's folder `integrations/ros2/` has the packages of ROS: the
driver's own messages, launch files, parameters.
"""
