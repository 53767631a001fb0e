"""The shell for ROS 2: `aioduco ros2`. It needs rclpy and messages of the ROS installed.

`conversions` fills messages, `node` is the managed node, `process` runs it. The repository's folder
`ros2/` has the packages of ROS: messages of the driver's own, launch files, parameters.
"""
