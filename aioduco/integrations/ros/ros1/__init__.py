"""The shell for ROS 1: `aioduco ros1`. It needs rospy, actionlib and genpy of an installed ROS.

`definitions` has the messages as text, `message_classes` makes their classes, `conversions` fills
them, `node` is the process.
"""
