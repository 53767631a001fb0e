"""Lead the tool over a red part that a camera on the flange sees, by a stream of set-points.

    python visual_servoing.py                     on a simulated arm with a simulated camera
    python visual_servoing.py 192.168.1.10        on a real one, with the computer's first camera

The camera looks along the flange's z axis, as far right and down in its picture as the flange's x
and y; where it is otherwise, `aioduco.devices.cameras.calibrate_hand_eye` says how. Each picture
says how far the part is beside the tool. The next target is half of that way: what a picture is
late by makes the arm slower, and not restless. The stream brings the few targets to 500 set-points
a second, and when the part is out of sight no target comes, so that the arm stands.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import anyio
import anyio.to_thread
import numpy as np

import aioduco
from aioduco import Pose
from aioduco.devices.cameras import Intrinsics, OpenCvCamera, SimulatedCamera

if TYPE_CHECKING:
    from aioduco.devices.cameras import CameraDevice, CameraFrame

HEIGHT = 0.3  # of the camera over the part, for a camera without depth [m]
THERE = 0.002  # the tool is over the part [m]
STEP = 0.03  # most that a target leads the tool [m]


def aside(frame: CameraFrame) -> np.ndarray | None:
    """How far the red part is beside the camera's axis, along x and y [m]; None if unseen."""
    red, green, blue = np.moveaxis(frame.image.astype(int), -1, 0)
    rows, columns = np.nonzero(red - np.maximum(green, blue) > 60)
    if rows.size < 20:
        return None
    column, row = columns.mean(), rows.mean()
    far = HEIGHT if frame.depth is None else float(frame.depth[round(row), round(column)])
    return frame.intrinsics.point(column, row, far)[:2]


async def main(host: str, port: int, camera: CameraDevice) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        near = 0
        async with robot.servo.pose(
            v=1.0, a=5.0, velocity=(0.1, 0.5), acceleration=(0.5, 2.0), rate=500,
            latest=True, upsample="ruckig", hold=10.0,
        ) as stream:  # fmt: skip
            for count in range(1, 500):
                here = await robot.state.get_tcp_pose()
                frame = await anyio.to_thread.run_sync(camera.read)
                offset = aside(frame)
                if offset is None:
                    continue
                distance = float(np.linalg.norm(offset))
                if count == 1:
                    print(f"the part is {distance * 1e3:.0f} mm beside the tool")
                near = near + 1 if distance < THERE else 0
                if near == 3:
                    print(f"over it within {THERE * 1e3:.0f} mm")
                    return
                half = offset * min(0.5, STEP / distance)
                target = here.matrix @ (*half, 0.0, 1.0)
                await stream.send(Pose(*target[:3].tolist(), *here[3:]))
        print("the part was not reached")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        lens = Intrinsics(width=640, height=480, fx=600.0, fy=600.0, cx=319.5, cy=239.5)
        with OpenCvCamera(0, lens) as real:
            anyio.run(main, given.host, given.port, real)
    else:
        from aioduco.sim import Simulator
        from aioduco.sim.scene import Cylinder

        part = Cylinder(at=(0.56, 0.06, 0.11), radius=0.025, length=0.04, colour=(0.9, 0.1, 0.1))
        eye = '<mujoco><worldbody><camera name="eye" pos="0 0 0.02" quat="0 1 0 0" fovy="60"/>'
        with Simulator(speed=2, scene=[part], tool=f"{eye}</worldbody></mujoco>") as sim:
            simulated = SimulatedCamera(sim, "eye", width=320, height=240, depth=True)
            anyio.run(main, sim.host, sim.port, simulated)
