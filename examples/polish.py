"""Polish a flat part: press on it with 15 N, and go over it in lines.

    python polish.py                      on a simulated arm above a simulated part
    python polish.py 192.168.1.10         on a real one: read the guide on force control

A real arm needs a force sensor that is set up, its payload set, and a hand at the stop.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco import mm

ALONG_Z = (False, False, True, False, False, False)
PRESS = (0, 0, -15, 0, 0, 0)  # what the sensor feels [N]
DAMPING = (1000, 1000, 1000, 57, 57, 57)
FASTEST = (0.03, 0.03, 0.03, 0.1, 0.1, 0.1)  # [m/s, rad/s]
WITHIN = (500, 500, 1.5, 500, 500, 500)
LINES, LENGTH, APART = 4, mm(60), mm(10)


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        force = robot.force
        await force.fc_force_set_value((True,) * 6, (0,) * 6)  # nothing touches: tare
        await force.fc_config(ALONG_Z, PRESS, DAMPING, FASTEST)
        await force.fc_guard_act(ALONG_Z, (0, 0, 60, 0, 0, 0))  # an emergency stop above 60 N
        await force.fc_start()
        pressed = []
        try:
            await force.fc_wait_ft(PRESS, WITHIN, absolute=True, duration=0.2, timeout=20)
            await force.fc_wait_logic((0, 0, 1))
            await force.fc_move()
            await force.fc_wait_logic((0, 0, 0))
            start = await robot.state.get_tcp_pose()
            for number in range(LINES):
                ends = (LENGTH, 0.0) if number % 2 == 0 else (0.0, LENGTH)
                for along in ends:
                    goal = start.shifted(x=along, y=number * APART)
                    await robot.motion.movel(goal, v=0.04, a=0.3)
                    pressed.append((await force.fc_get_ft())[2])
        finally:
            with anyio.CancelScope(shield=True):  # the next motion would give way otherwise
                await force.fc_stop()
        here = await robot.state.get_tcp_pose()
        await robot.motion.movel(here.shifted(z=mm(30)), v=0.1, a=0.5)
        print(f"{LINES} lines, {min(pressed):.0f} to {max(pressed):.0f} N")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.sim import Simulator
        from aioduco.sim.scene import Table

        # The arm begins with its flange looking down, 20 mm above the part.
        with Simulator(speed=5, scene=[Table(at=(0.5, 0.1405, 0.422))]) as sim:
            anyio.run(main, sim.host, sim.port)
