"""The gripper is never told to open."""

import anyio

import aioduco


async def release(robot: aioduco.Robot) -> None:
    robot.io.set_standard_digital_out(1, value=False)  # type: ignore[unused-coroutine]  # FAULT forgotten await


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        await release(robot)
        await robot.motion.movej2(aioduco.Joints.deg(10, 0, 90, 0, -90, 0), v=1.0, a=2.0)


anyio.run(main)
