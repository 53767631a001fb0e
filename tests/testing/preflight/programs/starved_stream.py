"""The controller's queue of set-points runs dry while the program looks for the next one."""

import time

from aioduco.compat import DucoCobot, RealTimeData

robot = DucoCobot("192.168.1.10", 7003)
robot.open()
robot.power_on(True)
robot.enable(True)
speeds = RealTimeData(joint_vel_cmd=[0.0, 0.0, 0.0, 0.0, 0.0, 0.05], status=True)
robot.clear_realtime_data_queue()
robot.realtime_data_enqueue([speeds] * 100, True)
robot.start_realtime_mode(1, 100, 0.04)
time.sleep(0.3)  # FAULT starved stream
robot.realtime_data_enqueue([speeds] * 100, True)
robot.end_realtime_mode()
robot.close()
