"""A box stands where the arm turns."""

import anyio

import aioduco

# SCENE box
HOME = aioduco.Joints.deg(0, 0, 90, 0, -90, 0)
ASIDE = aioduco.Joints.deg(90, 0, 90, 0, -90, 0)


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await robot.motion.movej2(HOME, v=1.0, a=2.0)
        await robot.motion.movej2(ASIDE, v=1.0, a=2.0)  # FAULT collision


anyio.run(main)
