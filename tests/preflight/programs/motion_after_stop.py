"""A watcher stops the arm between two motions; the other task does not notice."""

import anyio

import aioduco

LEFT, RIGHT = aioduco.Joints.deg(20, 0, 90, 0, -90, 0), aioduco.Joints.deg(-20, 0, 90, 0, -90, 0)


async def watch(robot: aioduco.Robot, seen: anyio.Event) -> None:
    await seen.wait()
    await anyio.sleep(0.2)
    await robot.stop()


async def main() -> None:
    seen = anyio.Event()
    async with aioduco.connect("192.168.1.10") as robot, anyio.create_task_group() as tasks:
        tasks.start_soon(watch, robot, seen)
        await robot.bring_up()
        await robot.motion.movej2(LEFT, v=1.0, a=2.0)
        seen.set()
        await anyio.sleep(1.0)  # the gripper closes
        await robot.motion.movej2(RIGHT, v=1.0, a=2.0)  # FAULT motion after a stop


anyio.run(main)
