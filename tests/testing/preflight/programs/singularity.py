"""A straight line through the stretched wrist."""

import aioduco.sync

with aioduco.sync.connect("192.168.1.10") as robot:
    robot.bring_up()
    robot.motion.movej2(aioduco.Joints.deg(0, 0, 90, 0, -20, 0), v=1.0, a=2.0)
    here = robot.state.get_tcp_pose()
    there = aioduco.Joints.deg(0, 0, 90, 0, 20, 0)
    flange = aioduco.Pose.of(robot.kinematics.cal_fkine(there))
    robot.motion.movel(flange, v=0.1, a=0.5)  # FAULT singularity
