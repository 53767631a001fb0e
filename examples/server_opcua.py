"""An arm as an OPC UA server: variables for its joints and states, methods to move and to stop it.

    python server_opcua.py                      a simulated arm, on opc.tcp://127.0.0.1:4840
    python server_opcua.py 192.168.1.10         a real one

Without users and certificates it listens on loopback only. Needs asyncua.
"""

from __future__ import annotations

import argparse
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import anyio
from asyncua import ua
from asyncua.common.methods import uamethod
from asyncua.server.server import Server

import aioduco
from aioduco import Joints

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Coroutine

NAMESPACE = "urn:example:duco"


@asynccontextmanager
async def served(robot: aioduco.Robot, endpoint: str) -> AsyncIterator[Server]:
    """A server whose variables follow the robot until the block is left."""
    server = Server()
    await server.init()
    server.set_endpoint(endpoint)
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    space = await server.register_namespace(NAMESPACE)
    arm = await server.nodes.objects.add_object(space, "Arm")
    joints = await arm.add_variable(space, "Joints", [0.0] * 6)
    state = await arm.add_variable(space, "State", "")
    moving = await arm.add_variable(space, "Moving", False)
    # why the last motion that ended did not get there; empty if it did
    failed = await arm.add_variable(space, "Failed", "")

    async def carry_out(start: Coroutine[Any, Any, aioduco.Task]) -> None:
        why = ""
        try:
            await (await start)
        except aioduco.DucoError as error:
            why = str(error)
        await failed.write_value(why)

    @uamethod
    async def move(_: Any, angles: list[float], speed: float) -> str:
        """Send a motion to joints [rad]; an empty text if its numbers are right, else why not."""
        try:
            start = robot.motion.movej2(Joints.of(angles), v=speed, a=1.5).start()
        except (aioduco.DucoError, ValueError) as error:
            return str(error)
        # not awaited here: a session's calls are served one by one, and Stop would wait for it
        tasks.start_soon(carry_out, start)
        return ""

    @uamethod
    async def stop(_: Any) -> None:
        await robot.stop()

    floats, number, text = ua.VariantType.Double, ua.VariantType.Double, ua.VariantType.String
    await arm.add_method(space, "Move", move, [floats, number], [text])
    await arm.add_method(space, "Stop", stop, [], [])

    async def follow() -> None:
        with robot.feed.subscribe() as samples:
            async for sample in samples:
                await joints.write_value(list(sample.status.joints))
                await state.write_value(sample.states.robot.name)
                await moving.write_value(bool(robot.tasks))

    async with server, anyio.create_task_group() as tasks:
        # making the server holds the event loop, on a busy computer for as long as a program hangs
        await robot.rearm_heartbeat()
        tasks.start_soon(follow)
        yield server
        tasks.cancel_scope.cancel()


async def main(host: str, port: int) -> None:
    async with aioduco.connect(host, port) as robot:
        await robot.bring_up()
        async with served(robot, "opc.tcp://127.0.0.1:4840"):
            print("serving; Ctrl-C ends it")
            await anyio.sleep_forever()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host", nargs="?")
    parser.add_argument("port", nargs="?", type=int, default=7003)
    given = parser.parse_args()
    if given.host:
        anyio.run(main, given.host, given.port)
    else:
        from aioduco.sim import Simulator

        with Simulator() as sim:
            anyio.run(main, sim.host, sim.port)
