"""A run goes past each of these mistakes."""

import contextlib

import anyio

import aioduco

HOME, WRIST = aioduco.Joints.deg(0, 0, 90, 0, -90, 0), aioduco.Joints.deg(0, 0, 90, 0, -20, 0)


async def release(robot: aioduco.Robot) -> None:
    robot.io.set_standard_digital_out(1, value=False)  # type: ignore[unused-coroutine]  # FAULT forgotten await


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.system.power_on()
        with contextlib.suppress(aioduco.DucoError):
            await robot.motion.movej2(HOME, v=1.0, a=2.0)  # FAULT wrong mode
        await robot.bring_up()
        far = aioduco.Pose(1.6, 0.0, 0.4, 3.14, 0.0, 0.0)
        await robot.motion.movel(far, v=0.2, a=0.5)  # FAULT unreachable
        await robot.motion.movej2(HOME, v=1.0, a=2.0)
        here = await robot.state.get_tcp_pose()
        above = here.shifted(z=0.05)
        with contextlib.suppress(aioduco.DucoError):
            await robot.motion.movel(above, v=0.2, a=0.5, tool="gripper")  # FAULT unknown tool
        # Each motion is awaited before the next one is sent: the arm stops.
        corner = here.shifted(y=0.1)
        await robot.motion.movel(corner, v=0.2, a=1.0, r=0.02)  # FAULT bad blend
        await robot.motion.movel(corner.shifted(z=0.1), v=0.2, a=1.0)
        await robot.motion.tcp_move((0, 0.1, 0, 0, 0, 0), v=0.2, a=1.0, r=0.02)  # FAULT bad blend
        await robot.motion.wobj_move((0, 0, 0.1, 0, 0, 0), v=0.2, a=1.0, r=0.02)  # FAULT bad blend
        down = ((0, 0, -0.05, 0, 0, 0), (0, 0, -0.1, 0, 0, 0))
        await robot.motion.wobj_move_2p(*down, v=0.2, a=1.0, r=0.01)  # FAULT bad blend
        await robot.motion.movel(corner, v=0.2, a=1.0)
        await release(robot)
        # A straight line through the stretched wrist.
        await robot.motion.movej2(WRIST, v=1.0, a=2.0)
        flange = await robot.kinematics.cal_fkine(aioduco.Joints.deg(0, 0, 90, 0, 20, 0))
        end = aioduco.Pose.of(flange)
        await robot.motion.movel(end, v=0.1, a=0.5)  # FAULT singularity
        await robot.motion.movej2(WRIST, v=1.0, a=2.0)
        begin = aioduco.Pose.of(await robot.kinematics.cal_fkine(WRIST))
        turn = end.rotation @ begin.rotation.T
        way = aioduco.Pose.from_rotation(end.position - begin.position, turn)
        await robot.motion.wobj_move(way, v=0.1, a=0.5)  # FAULT singularity


anyio.run(main)
