"""The manual's example of realtime control (1.3.15): joint speeds, a row for each millisecond.

    python 14_realtime_velocity.py                  on a simulated arm
    python 14_realtime_velocity.py 192.168.1.10     on a real one: keep clear of it, it moves slowly

The manual fills the controller's queue by hand and then sends a point, sleeps for a millisecond,
and hopes. The stream keeps the queue at a depth instead, from a process of its own; it leads up to
the first row, and at the end down to standstill, before it leaves realtime mode.
"""

from __future__ import annotations

import argparse

import anyio

import aioduco

#: rad/s, as printed in the manual
ROWS = [
    [-6.700e-04, -4.072e-03, 7.066e-03, -2.978e-03, 2.183e-05, -6.698e-04],
    [-1.589e-03, -1.011e-02, 1.754e-02, -7.390e-03, 5.177e-05, -1.588e-03],
    [-2.755e-03, -1.811e-02, 3.140e-02, -1.322e-02, 8.975e-05, -2.754e-03],
    [-3.442e-03, -2.315e-02, 4.013e-02, -1.690e-02, 1.121e-04, -3.441e-03],
    [-3.157e-03, -2.189e-02, 3.793e-02, -1.597e-02, 1.028e-04, -3.156e-03],
    [-2.864e-03, -2.071e-02, 3.588e-02, -1.510e-02, 9.330e-05, -2.863e-03],
    [-2.820e-03, -2.131e-02, 3.692e-02, -1.553e-02, 9.184e-05, -2.819e-03],
    [-2.812e-03, -2.205e-02, 3.818e-02, -1.606e-02, 9.158e-05, -2.811e-03],
    [-2.728e-03, -2.205e-02, 3.818e-02, -1.606e-02, 8.884e-05, -2.727e-03],
    [-1.936e-03, -2.279e-02, 3.938e-02, -1.654e-02, 6.304e-05, -1.936e-03],
]


async def main(host: str, port: int, seconds: float) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        before = await robot.state.get_actual_joints_position()

        async with robot.realtime.stream(
            "joint_velocity", v=0.1, a=20.0, depth=100, com_lost_time=0.04
        ) as stream:
            # The manual goes on with the last row `while not stop_realtime_control`.
            await stream.play(ROWS + [ROWS[-1]] * round(seconds * 1000))

        after = await robot.state.get_actual_joints_position()
        moved = [f"{b - a:+.4f}" for a, b in zip(before, after, strict=True)]
        print("moved by", *moved, "rad")
        print(stream.statistics())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    parser.add_argument("--seconds", type=float, default=2.0)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port, given.seconds)
    else:
        from aioduco.sim import Simulator

        with Simulator.spawn() as sim:
            anyio.run(main, sim.host, sim.port, given.seconds)
