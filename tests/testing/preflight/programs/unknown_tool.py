"""A tool that nobody has set up."""

import anyio

import aioduco


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        here = await robot.state.get_tcp_pose()
        above = here.shifted(z=0.05)
        await robot.motion.movel(above, v=0.2, a=0.5, tool="gripper")  # FAULT unknown tool


anyio.run(main)
