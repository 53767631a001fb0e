"""Nobody ever sets the event."""

import anyio

import aioduco


async def main() -> None:
    async with aioduco.connect("192.168.1.10") as robot:
        await robot.bring_up()
        part = anyio.Event()
        await part.wait()  # FAULT endless wait


anyio.run(main)
