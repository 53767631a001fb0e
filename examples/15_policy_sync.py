"""Follow a 30 Hz policy from a plain loop: no `async`, and still a set-point every 2 ms.

    python 15_policy_sync.py                  on a simulated arm
    python 15_policy_sync.py 192.168.1.10     on a real one: keep clear; joint 6 turns by 25 degrees

As notebooks and learning code are written: look, think, send. The stream's worker brings the
targets up to 500 Hz within limits of speed, acceleration and jerk. When the loop hangs, the arm
comes to rest.
"""

from __future__ import annotations

import argparse
import math

import aioduco.sync
from aioduco import Joints


def policy(start: Joints, moment: float, seen: Joints) -> Joints:
    """Stands for a network: where to go, by the time and by where the arm is seen."""
    wanted = start.j6 + 0.22 * (1 - math.cos(1.5 * moment))
    step = min(0.05, max(-0.05, wanted - seen.j6))  # a policy that was trained to be careful
    return Joints.of([*start[:5], seen.j6 + step])


def main(host: str, port: int, seconds: float) -> None:
    with aioduco.sync.connect(host, port) as robot:
        robot.bring_up()
        start = robot.state.get_actual_joints_position()

        with robot.servo.joints(
            v=1.5, a=8.0, jerk=150.0, rate=500, latest=True, upsample="ruckig", hold=0.3
        ) as stream:
            for tick in stream.ticks(30):
                seen = robot.state.get_actual_joints_position()
                stream.send(policy(start, tick.time, seen))
                if tick.time >= seconds:
                    break

        print(stream.statistics())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    parser.add_argument("--seconds", type=float, default=4.0)
    given = parser.parse_args()
    if given.host:
        main(given.host, given.port, given.seconds)
    else:
        from aioduco.sim import Simulator

        with Simulator.spawn() as sim:
            main(sim.host, sim.port, given.seconds)
