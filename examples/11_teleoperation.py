"""Drive the tool by the keyboard or a gamepad, at a speed, for as long as a key is held.

    python 11_teleoperation.py                                      on a simulated arm
    python 11_teleoperation.py 192.168.1.10                         on a real one: keep clear of it
    python 11_teleoperation.py 192.168.1.10 --pad /dev/input/js0    by a gamepad

Keys: w s forward and back, a d left and right, r f up and down, j l i k u o turn; any other stands;
q ends. Sticks of a gamepad lead while a shoulder button is held; Start ends. Directions are those
of the base, as somebody sees them who stands behind the arm, however the tool is turned: its x
leads forward, its z up.

When nothing comes from the keyboard any more, the tool slows down and stands. When this program
dies, so it does; and if the network is lost, the controller ends the motion 0.2 s later by itself.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco.devices.teleoperation import TeleopScale, open_device, teleoperate


async def main(host: str, port: int, pad: str | None) -> None:
    slow = TeleopScale(speed=0.05, turn_speed=0.2)
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        with open_device("gamepad" if pad else "keyboard", pad) as device:
            print("w s a d r f move the tool; q ends", flush=True)
            report = await teleoperate(robot, device, slow, frame="base")
        print(f"led {report.held} times, {report.seconds:.1f} s in all")
        print("the tool stands at", await robot.state.get_tcp_pose())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    parser.add_argument("--pad", help="a gamepad, such as /dev/input/js0")
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port, given.pad)
    else:
        from aioduco.sim import Simulator

        with Simulator.spawn() as sim:
            anyio.run(main, sim.host, sim.port, given.pad)
