"""The shell for ROS 1: `aioduco ros1`. It needs rospy, actionlib and genpy of an installed ROS.

`definitions` has the messages as text, `message_classes` makes their classes, `conversions` has
what is different in those of ROS 1, `node` is the process.
"""
