"""Move an arm from a plain script: no async, no await. Ctrl-C stops the arm.

    python 07_plain_script.py                  on a simulated arm
    python 07_plain_script.py 192.168.1.10     on a real one: keep clear of it

The same lines work in a notebook, cell by cell, with robot.open() and robot.close().
"""

from __future__ import annotations

import argparse

import aioduco.sync
from aioduco import Joints, mm

HOME = Joints.deg(30, -15, 105, 0, -90, 0)


def main(host: str, port: int) -> None:
    with aioduco.sync.connect(host, port) as robot:
        print("ready:", robot.bring_up())

        # A call returns when the motion has ended.
        print("at home:", robot.motion.movej2(HOME, v=0.8, a=1.5).value)

        # .start returns when the controller has accepted it.
        here = robot.state.get_tcp_pose()
        down = robot.motion.movel.start(here.shifted(z=-mm(50)), v=0.1, a=0.5)
        lowest = here.z
        while not down.done:
            lowest = min(lowest, robot.feed.latest().status.pose.z)
        print(f"down: {down.wait().value}, {(here.z - lowest) * 1000:.0f} mm")

        # Motions made beforehand are sent ahead, so that they blend.
        legs = [here.shifted(x=mm(40)), here.shifted(x=mm(40), y=mm(40)), here]
        motions = [
            robot.motion.movel.prepare(leg, v=0.1, a=0.5, r=0.0 if leg is here else mm(10))
            for leg in legs
        ]
        print("round:", ", ".join(outcome.value for outcome in robot.motion.run(*motions)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        main(given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator() as sim:
            main(sim.host, sim.port)
