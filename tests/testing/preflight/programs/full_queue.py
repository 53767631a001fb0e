"""A vendor's program turns the third joint further than it can, and fills the queue of motions."""

from aioduco.compat import DucoCobot

robot = DucoCobot("192.168.1.10", 7003)
robot.open()
robot.power_on(True)
robot.enable(True)
robot.movej2([0.0, 0.0, 1.57, 0.0, -1.57, 0.0], 1.0, 2.0, 0.0, True)
robot.movej2([0.0, 0.0, 7.5, 0.0, -1.57, 0.0], 1.0, 2.0, 0.0, True)  # FAULT joint limit
for number in range(1010):
    turn = 0.1 if number % 2 else 0.2
    robot.movej2([turn, 0.0, 1.57, 0.0, -1.57, 0.0], 0.1, 1.0, 0.0, False)  # FAULT full queue
robot.stop(True)
robot.close()
