"""Mass and centre of what the arm carries, by the torques of its joints at eight poses.

python measure_payload.py 192.168.1.10     the arm moves: keep out of its reach
"""

import argparse

import anyio
import numpy as np

import aioduco
from aioduco import Joints
from aioduco.kinematics import arm, identify_load_by_torques

#: from the first pose on, the wrist turns to several sides, and the elbow bends
HOME = (30, -15, 105, 0, -90, 0)
TURNS = [
    *[(0, 0, 0, 0, 0, 0), (0, -23, 17, 34, 29, 0), (0, 17, -23, -34, -29, 46)],
    *[(0, -23, 34, 11, -40, 92), (0, 23, -11, -40, 34, -46), (0, 17, 17, 34, -29, -92)],
    *[(0, -17, -17, -17, 46, 46), (0, 0, 29, -46, 0, 90)],
]


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        told = await robot.version.get_robot_type()
        joints, torques = [], []
        for turn in TURNS:
            pose = Joints.deg(*np.add(HOME, turn))
            await robot.motion.movej2(pose, v=0.5, a=0.5)
            await anyio.sleep(0.5)  # the arm comes to rest
            joints.append(await robot.state.get_actual_joints_position())
            read = [await robot.state.get_ext_torque() for _ in range(20)]
            torques.append(np.mean(read, axis=0))
        known = await robot.frames.get_tool_load()
        kind = arm(f"{told.series}_{told.model}")
        found = identify_load_by_torques(kind, joints, torques, known=known)
        mass, centre = found.uncertainty
        print(f"{found.load} within {mass:.3f} kg and {centre * 1e3:.1f} mm")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    anyio.run(main, given.host, given.port)
