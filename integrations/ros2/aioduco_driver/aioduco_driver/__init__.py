"""The driver of DUCO arms as an executable of ROS 2; the node is that of aioduco."""
