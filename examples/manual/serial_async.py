"""The manual's examples on RS-485 (1.3.6), by `aioduco`."""

from __future__ import annotations

import anyio
from cabinet import run

import aioduco


async def read_by_head(robot: aioduco.Robot) -> bytes:
    """1.3.6-1: ten bytes that begin with 255, 1."""
    head = [255, 1]
    return await robot.bus.read_raw_data_485_h(head, 10)


async def read_between(robot: aioduco.Robot) -> bytes:
    """1.3.6-2: what stands between 255, 1 and 255, 1, with both."""
    head = [255, 1]
    tail = [255, 1]
    return await robot.bus.read_raw_data_485_ht(head, tail)


async def write(robot: aioduco.Robot) -> None:
    """1.3.6-3: two bytes."""
    data = [255, 1]
    await robot.bus.write_raw_data_485(data)


async def write_with_head(robot: aioduco.Robot) -> None:
    """1.3.6-4: three bytes behind 255, 255."""
    data = [1, 2, 3]
    head = [255, 255]
    await robot.bus.write_raw_data_485_h(data, head)


async def write_with_ends(robot: aioduco.Robot) -> None:
    """1.3.6-5: three bytes between 255, 255 and 255, 255."""
    data = [1, 2, 3]
    head = [255, 255]
    tail = [255, 255]
    await robot.bus.write_raw_data_485_ht(data, head, tail)


async def tool_read(robot: aioduco.Robot) -> bytes:
    """1.3.6-6: ten bytes from the tool's port."""
    return await robot.bus.tool_read_raw_data_485(10)


async def tool_read_by_head(robot: aioduco.Robot) -> bytes:
    """1.3.6-7: ten bytes from the tool's port that begin with 255, 255."""
    head = [255, 255]
    return await robot.bus.tool_read_raw_data_485_h(head, 10)


async def tool_read_between(robot: aioduco.Robot) -> bytes:
    """1.3.6-8: what stands between 255, 1 and 1, 255 at the tool's port."""
    head = [255, 1]
    tail = [1, 255]
    return await robot.bus.tool_read_raw_data_485_ht(head, tail)


async def tool_write(robot: aioduco.Robot) -> None:
    """1.3.6-9: three bytes to the tool's port."""
    data = [1, 2, 3]
    await robot.bus.tool_write_raw_data_485(data)


async def tool_write_with_head(robot: aioduco.Robot) -> None:
    """1.3.6-10: three bytes behind 255, 1 to the tool's port."""
    data = [1, 2, 3]
    head = [255, 1]
    await robot.bus.tool_write_raw_data_485_h(data, head)


async def tool_write_with_ends(robot: aioduco.Robot) -> None:
    """1.3.6-11: three bytes between 255, 1 and 1, 255 to the tool's port."""
    data = [1, 2, 3]
    head = [255, 1]
    tail = [1, 255]
    await robot.bus.tool_write_raw_data_485_ht(data, head, tail)


async def main(host: str, port: int) -> dict[str, object]:
    results: dict[str, object] = {}
    async with aioduco.connect(host, port) as robot:
        results["1.3.6-1"] = await read_by_head(robot)
        results["1.3.6-2"] = await read_between(robot)
        await write(robot)
        await write_with_head(robot)
        await write_with_ends(robot)
        results["1.3.6-6"] = await tool_read(robot)
        results["1.3.6-7"] = await tool_read_by_head(robot)
        results["1.3.6-8"] = await tool_read_between(robot)
        await tool_write(robot)
        await tool_write_with_head(robot)
        await tool_write_with_ends(robot)
    return results


if __name__ == "__main__":
    run(lambda host, port: anyio.run(main, host, port))
