"""Goal: pause the arm when it carries something else than the program thinks.

A twin, a simulated arm, gets the same commands. Where the two part, it says what, where and why.
Limits come from a good run: `aioduco twin --learn good.mcap --limits limits.json`.

    python examples/twin_beside_arm.py 192.168.1.10 limits.json
"""

import argparse
import asyncio

import aioduco
from aioduco import Joints
from aioduco.sim.twin import TwinLimits

LEFT = Joints.deg(30, -15, 105, 0, -90, 0)
RIGHT = Joints.deg(-30, -15, 105, 0, -90, 0)


async def tell(robot: aioduco.Robot) -> None:
    """Print where the arm and its twin part."""
    with robot.events.subscribe() as events:
        async for event in events:
            if isinstance(event, aioduco.events.TwinDiverged):
                print(f"{event.quantity} at {event.where}: {event.cause} {event.estimate}")


async def main(host: str, limits: str | None, port: int = 7003) -> None:
    known = None if limits is None else TwinLimits.load(limits)
    async with aioduco.connect(host, port, state_rate=125.0) as robot:
        await robot.bring_up()
        async with robot.twin(known, action="pause") as twin:
            telling = asyncio.create_task(tell(robot))
            try:
                for goal in (LEFT, RIGHT) * 2:
                    await robot.motion.movej2(goal, v=0.5, a=1.0)
            finally:
                telling.cancel()
            print(twin.statistics())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("host")
    parser.add_argument("limits", nargs="?")
    given = parser.parse_args()
    asyncio.run(main(given.host, given.limits))
