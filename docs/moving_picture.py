"""Draw the README's animation: an arm that picks up a box and puts it down elsewhere.

    python docs/moving_picture.py [FILE.gif]      needs the extras sim and cli, and OpenGL

What is drawn is what happened: the demo's plan, on a simulated arm with a gripper whose fingers
hold the box by friction.
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
import anyio.to_thread

import aioduco
from aioduco.cli.demo_run import GRIPPER_NAME, Choreography, scene
from aioduco.cli.picture import save
from aioduco.devices.grippers import DigitalGripper
from aioduco.kinematics import arm as arm_of
from aioduco.sim import Simulator
from aioduco.sim.view.camera import Camera
from aioduco.sim.view.film import Film

if TYPE_CHECKING:
    from aioduco.models.pose import Pose
    from aioduco.sim.process import SimulatorProcess

SIZE = (640, 400)
#: simulated seconds in a real one, slow enough for a machine that has other work, too
SPEED = 0.25
#: simulated seconds from one frame to the next
EVERY = 0.08


async def perform(sim: SimulatorProcess, plan: Choreography) -> None:
    """Pick the box up, put it down on the other side, and go back."""
    async with (
        aioduco.connect(
            sim.host, sim.port, clock=sim.clock, heartbeat=20.0, loop_stall_limit=15.0
        ) as robot,
        DigitalGripper(robot, 1, holds=1, opened=2, travel_time=10.0, timeout=60.0) as gripper,
    ):
        await robot.bring_up()
        start = await robot.state.get_tcp_pose()

        async def line(to: Pose) -> None:
            await robot.motion.movel(to, v=plan.line_speed, a=plan.line_acceleration)

        for side, act in ((-1, gripper.close), (1, gripper.open)):
            over = replace(start, y=start.y + side * plan.width)
            await line(over)
            await line(over.shifted(z=-plan.depth + (0.001 if side > 0 else 0.0)))
            await act()
            await line(over)
        await line(start)


async def watch(sim: SimulatorProcess, film: Film) -> None:
    """Look at everything that moves, again and again."""
    begun = anyio.current_time()
    due = begun
    while True:
        at = anyio.current_time()
        film.add(SPEED * (at - begun), await anyio.to_thread.run_sync(lambda: sim.positions))
        due = max(due + EVERY / SPEED, at)
        await anyio.sleep_until(due)


async def record(sim: SimulatorProcess, plan: Choreography, film: Film) -> None:
    """Let it happen while it is watched."""
    async with anyio.create_task_group() as watching:
        watching.start_soon(watch, sim, film)
        await perform(sim, plan)
        watching.cancel_scope.cancel()


def main() -> None:
    """Let it happen, then draw it."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images/moving.gif"
    arm = arm_of("gcr5_910")
    plan = Choreography(arm.reach, careful=False)
    camera = Camera(
        target=(0.35, 0.1, 0.28), distance=1.5, azimuth=math.radians(160.0),
        elevation=math.radians(-20.0),
    )  # fmt: skip
    film = Film(limit=120, rest=0.6)
    cell = {"scene": scene(arm, plan), "gripper": GRIPPER_NAME}
    with Simulator.spawn(speed=SPEED, joints=tuple(plan.start), **cell) as sim:
        anyio.run(record, sim, plan, film)
    frames = film.frames
    cell = {"scene": scene(arm, plan), "gripper": GRIPPER_NAME}
    with Simulator(**cell) as sim:  # to draw what has happened
        pictures = [
            sim.render(width=SIZE[0], height=SIZE[1], camera=camera, positions=frame.positions)
            for frame in frames
        ]
    save(path, pictures, [frame.duration for frame in frames])


if __name__ == "__main__":
    main()
