"""A motion before the arm is enabled."""

import anyio

import aioduco


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.system.power_on()
        home = aioduco.Joints.deg(0, 0, 90, 0, -90, 0)
        await robot.motion.movej2(home, v=1.0, a=2.0)  # FAULT wrong mode


anyio.run(main)
