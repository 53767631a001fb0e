"""Blend radii, but each motion is awaited before the next one is sent: the arm stops."""

import anyio

import aioduco


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        here = await robot.state.get_tcp_pose()
        corner = here.shifted(y=0.1)
        await robot.motion.movel(corner, v=0.2, a=1.0, r=0.02)  # FAULT bad blend
        await robot.motion.movel(corner.shifted(z=0.1), v=0.2, a=1.0)


anyio.run(main)
