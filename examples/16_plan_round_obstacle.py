"""Plan a way round an obstacle, carry it out, and plan anew when something comes into the way.

    python 16_plan_round_obstacle.py                        on a simulated arm
    python 16_plan_round_obstacle.py 192.168.1.10           on a real GCR5-910: keep clear of it

Needs `pip install 'aioduco[plan]'`. On a real arm the board must stand there, or be taken out of
the scene below: the arm knows of nothing but what the scene says.
"""

from __future__ import annotations

import argparse

import anyio
import anyio.to_thread

import aioduco
from aioduco import Joints
from aioduco.planning import Planner, Scene
from aioduco.sim.scene import Box, Sphere

BOARD = Box(at=(0.55, 0.0, 0.35), size=(0.5, 0.04, 0.7), name="board")
LEFT = Joints.deg(50, 0, 90, 0, -90, 0)
RIGHT = Joints.deg(-50, 0, 90, 0, -90, 0)


async def main(host: str, port: int) -> None:
    scene = Scene("gcr5_910", [BOARD])
    async with aioduco.connect(host, port) as robot, Planner(scene) as planner:
        await robot.bring_up()
        here = await robot.state.get_actual_joints_position()
        await robot.motion.execute(await planner.plan(here, LEFT, v=1.0, a=3.0))

        plan = await planner.plan(LEFT, RIGHT, v=1.0, a=3.0)
        print(f"planned: {plan.duration:.1f} s, {plan.clearance * 1e3:.0f} mm clear")
        found = await anyio.to_thread.run_sync(plan.check, scene)
        print(f"checked: {found}")
        await robot.motion.execute(plan, watch=scene)
        print("on the right side")

        back = await planner.plan(RIGHT, LEFT, v=0.6, a=2.0)
        ahead = back.pose(0.75 * back.duration)

        def appear(_: object) -> None:
            if "ball" not in scene:
                scene.add(Sphere(at=ahead[:3], radius=0.03, name="ball"))

        await robot.motion.execute(back, watch=scene, planner=planner, feedback=appear)
        print("on the left side again, round a ball that was not there before")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("--port", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator(scene=[BOARD], joints=LEFT) as sim:
            anyio.run(main, sim.host, sim.port)
