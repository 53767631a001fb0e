"""A watcher stops the arm between two motions; the other task does not notice."""

import anyio

import aioduco

LEFT = aioduco.Joints.deg(20, 0, 90, 0, -90, 0)
UP = (0.0, 0.0, 0.02, 0.0, 0.0, 0.0)


async def watch(robot: aioduco.Robot, seen: anyio.Event, closed: anyio.Event) -> None:
    await seen.wait()
    await robot.stop()
    closed.set()


async def main() -> None:
    seen, closed = anyio.Event(), anyio.Event()
    async with aioduco.connect("192.168.1.10") as robot, anyio.create_task_group() as tasks:
        tasks.start_soon(watch, robot, seen, closed)
        await robot.bring_up()
        await robot.motion.movej2(LEFT, v=1.0, a=2.0)
        seen.set()
        await closed.wait()  # the gripper
        await robot.motion.wobj_move(UP, v=0.1, a=1.0)  # FAULT motion after a stop


anyio.run(main)
