"""What the tool carries is longer than the program thinks."""

import anyio

import aioduco


# SCENE table
# TOOL part
async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        above = await robot.state.get_tcp_pose()
        await robot.motion.movel(above.shifted(z=-0.1), v=0.2, a=0.5)  # FAULT collision of the tool


anyio.run(main)
