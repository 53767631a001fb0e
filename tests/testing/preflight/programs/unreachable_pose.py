"""A pose beyond the arm's reach."""

import anyio

import aioduco


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        far = aioduco.Pose(1.6, 0.0, 0.4, 3.14, 0.0, 0.0)
        await robot.motion.movel(far, v=0.2, a=0.5)  # FAULT unreachable


anyio.run(main)
