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

#: rad/s: all ten rows, as printed in the manual
# fmt: off
ROWS = [
    [-6.7002174600742719e-04, -4.0721372542184987e-03, 7.0665930312668931e-03,
     -2.9787351905711541e-03, 2.1830944423519741e-05, -6.6985045290627080e-04],
    [-1.5891541090040343e-03, -1.0114218338103347e-02, 1.7541932653317018e-02,
     -7.3904210550071606e-03, 5.1773291252107102e-05, -1.5887482801976820e-03],
    [-2.7553057157664517e-03, -1.8112094694616328e-02, 3.1401501708864799e-02,
     -1.3224738086167568e-02, 8.9758915773767897e-05, -2.7546026409985300e-03],
    [-3.4427379904307014e-03, -2.3156000089445513e-02, 4.0137470694385204e-02,
     -1.6900659075688367e-02, 1.1214749835959385e-04, -3.4418596922477667e-03],
    [-3.1575883469106602e-03, -2.1892451233751688e-02, 3.7939070588137447e-02,
     -1.5972491709149134e-02, 1.0285214449526589e-04, -3.1567826456455192e-03],
    [-2.8646075990168916e-03, -2.0715223675258472e-02, 3.5888618218687413e-02,
     -1.5106135304886531e-02, 9.3301593429508489e-05, -2.8638776835253773e-03],
    [-2.8201404240522708e-03, -2.1317610077761021e-02, 3.6921162918095912e-02,
     -1.5537330282381656e-02, 9.1846820282434941e-05, -2.8194243928403914e-03],
    [-2.8122501634553669e-03, -2.2055522897489042e-02, 3.8189959175650906e-02,
     -1.6068391144064810e-02, 9.1584440350471740e-05, -2.8115360452647714e-03],
    [-2.7284266547891135e-03, -2.2056170434007521e-02, 3.8183763952978497e-02,
     -1.6063506271527264e-02, 8.8849675017042400e-05, -2.7277289846721628e-03],
    [-1.9369380974611262e-03, -2.2791942648747513e-02, 3.9382309299547516e-02,
     -1.6544795029390425e-02, 6.3047797784967667e-05, -1.9363935261341432e-03],
]
# fmt: on


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
