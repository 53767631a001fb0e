"""Press on a table with 20 N, slide along it under that pressure, and let go.

    python press_on_table.py                      on a simulated arm above a simulated table
    python press_on_table.py 192.168.1.10         on a real one: read the guide on force control

It goes straight down from where the flange is until it feels the table. A real arm needs a force
sensor that is set up, its payload set, nothing but the table under it, and a hand at the stop.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco
from aioduco import mm

ALONG_Z = (False, False, True, False, False, False)
PRESS = (0, 0, -20, 0, 0, 0)  # what the sensor feels: the table presses back [N]
DAMPING = (1000, 1000, 1000, 57, 57, 57)  # 20 N too little is 0.02 m/s
FASTEST = (0.03, 0.03, 0.03, 0.1, 0.1, 0.1)  # and never more than this [m/s, rad/s]
WITHIN = (500, 500, 1, 500, 500, 500)  # 1 N in z; the other directions do not count


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        force = robot.force
        await force.fc_force_set_value((True,) * 6, (0,) * 6)  # nothing touches: tare
        await force.fc_config(ALONG_Z, PRESS, DAMPING, FASTEST)
        await force.fc_guard_act(ALONG_Z, (0, 0, 60, 0, 0, 0))  # an emergency stop above 60 N
        await force.fc_start()
        try:
            await force.fc_wait_ft(PRESS, WITHIN, absolute=True, duration=0.2, timeout=20)
            await force.fc_wait_logic((0, 0, 1))
            await force.fc_move()
            print(f"pressing: {(await force.fc_get_ft())[2]:.0f} N")
            await force.fc_wait_logic((0, 0, 0))
            here = await robot.state.get_tcp_pose()
            await robot.motion.movel(here.shifted(x=mm(50)), v=0.03, a=0.2)
            print(f"moved by 50 mm: {(await force.fc_get_ft())[2]:.0f} N")
        finally:
            with anyio.CancelScope(shield=True):  # the next motion would give way otherwise
                await force.fc_stop()
        await robot.motion.movel(here.shifted(x=mm(50), z=mm(30)), v=0.1, a=0.5)
        print(f"let go: {abs((await force.fc_get_ft())[2]):.0f} N")


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

        # The arm begins with its flange looking down, 20 mm above the table.
        with Simulator(speed=5, scene=[Table(at=(0.5, 0.1405, 0.422))]) as sim:
            anyio.run(main, sim.host, sim.port)
