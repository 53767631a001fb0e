"""The manual's examples on RS-485 (1.3.6), by `aioduco.sync`."""

from __future__ import annotations

from cabinet import run

import aioduco.sync


def read_by_head(robot: aioduco.sync.Robot) -> bytes:
    """1.3.6-1: ten bytes that begin with 255, 1."""
    head = [255, 1]
    return robot.bus.read_raw_data_485_h(head, 10)


def read_between(robot: aioduco.sync.Robot) -> bytes:
    """1.3.6-2: what stands between 255, 1 and 255, 1, with both."""
    head = [255, 1]
    tail = [255, 1]
    return robot.bus.read_raw_data_485_ht(head, tail)


def write(robot: aioduco.sync.Robot) -> None:
    """1.3.6-3: two bytes."""
    data = [255, 1]
    robot.bus.write_raw_data_485(data)


def write_with_head(robot: aioduco.sync.Robot) -> None:
    """1.3.6-4: three bytes behind 255, 255."""
    data = [1, 2, 3]
    head = [255, 255]
    robot.bus.write_raw_data_485_h(data, head)


def write_with_ends(robot: aioduco.sync.Robot) -> None:
    """1.3.6-5: three bytes between 255, 255 and 255, 255."""
    data = [1, 2, 3]
    head = [255, 255]
    tail = [255, 255]
    robot.bus.write_raw_data_485_ht(data, head, tail)


def tool_read(robot: aioduco.sync.Robot) -> bytes:
    """1.3.6-6: ten bytes from the tool's port."""
    return robot.bus.tool_read_raw_data_485(10)


def tool_read_by_head(robot: aioduco.sync.Robot) -> bytes:
    """1.3.6-7: ten bytes from the tool's port that begin with 255, 255."""
    head = [255, 255]
    return robot.bus.tool_read_raw_data_485_h(head, 10)


def tool_read_between(robot: aioduco.sync.Robot) -> bytes:
    """1.3.6-8: what stands between 255, 1 and 1, 255 at the tool's port."""
    head = [255, 1]
    tail = [1, 255]
    return robot.bus.tool_read_raw_data_485_ht(head, tail)


def tool_write(robot: aioduco.sync.Robot) -> None:
    """1.3.6-9: three bytes to the tool's port."""
    data = [1, 2, 3]
    robot.bus.tool_write_raw_data_485(data)


def tool_write_with_head(robot: aioduco.sync.Robot) -> None:
    """1.3.6-10: three bytes behind 255, 1 to the tool's port."""
    data = [1, 2, 3]
    head = [255, 1]
    robot.bus.tool_write_raw_data_485_h(data, head)


def tool_write_with_ends(robot: aioduco.sync.Robot) -> None:
    """1.3.6-11: three bytes between 255, 1 and 1, 255 to the tool's port."""
    data = [1, 2, 3]
    head = [255, 1]
    tail = [1, 255]
    robot.bus.tool_write_raw_data_485_ht(data, head, tail)


def main(host: str, port: int) -> dict[str, object]:
    results: dict[str, object] = {}
    with aioduco.sync.connect(host, port) as robot:
        results["1.3.6-1"] = read_by_head(robot)
        results["1.3.6-2"] = read_between(robot)
        write(robot)
        write_with_head(robot)
        write_with_ends(robot)
        results["1.3.6-6"] = tool_read(robot)
        results["1.3.6-7"] = tool_read_by_head(robot)
        results["1.3.6-8"] = tool_read_between(robot)
        tool_write(robot)
        tool_write_with_head(robot)
        tool_write_with_ends(robot)
    return results


if __name__ == "__main__":
    run(main)
