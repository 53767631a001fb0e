"""The elbow bends until the wrist meets the shoulder."""

import anyio

import aioduco


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        folded = aioduco.Joints.deg(0, -20, 165, 0, -90, 0)
        await robot.motion.movej2(folded, v=1.0, a=2.0)  # FAULT self-collision


anyio.run(main)
