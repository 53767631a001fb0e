"""Follow an array of joint positions from a .npy file, and check that the arm kept to it.

    python 13_play_npy.py                                   a file made here, on a simulated arm
    python 13_play_npy.py path.npy 192.168.1.10             on a real one: keep clear of it

The array has a row for each point: its time [s], then six joint angles [rad]. The arm is led to its
first point, follows it through the controller's realtime queue (through servoj where there is
none), and is brought to rest if it strays from the path.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import anyio
import numpy as np

import aioduco
from aioduco import JointTrajectory, Tolerances


def made(folder: str, seconds: float) -> Path:
    """A file to begin with: a slow nod."""
    times = np.linspace(0.0, seconds, 200)
    rows = np.tile([0.0, 0.0, np.pi / 2, 0.0, -np.pi / 2, 0.0], (200, 1))
    rows[:, 4] += 0.15 * (1 - np.cos(2 * np.pi * times / seconds))
    path = Path(folder) / "nod.npy"
    np.save(path, np.column_stack([times, rows]))
    return path


async def main(path: Path, host: str, port: int) -> None:
    rows = np.load(path)
    trajectory = JointTrajectory(rows[:, 1:], rows[:, 0] - rows[0, 0])
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        await robot.motion.movej2(trajectory.positions[0], v=0.5, a=1.0)
        result = await robot.motion.follow_joint_trajectory(
            trajectory, v=1.5, a=10.0, tolerances=Tolerances(path=0.05, goal=0.005)
        )
        print(f"{len(rows)} points in {result.duration:.2f} s")
        print(f"largest distance from the path: {np.abs(result.path_error).max():.5f} rad")
        print(f"largest distance from the goal: {np.abs(result.goal_error).max():.5f} rad")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    parser.add_argument("--seconds", type=float, default=4.0)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = given.file or made(folder, given.seconds)
        if given.host:
            anyio.run(main, file, given.host, given.port)
        else:
            from aioduco.sim import Simulator

            with Simulator.spawn() as sim:
                anyio.run(main, file, sim.host, sim.port)
