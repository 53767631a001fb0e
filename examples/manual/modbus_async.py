"""The manual's examples on Modbus (1.3.9), by `aioduco`."""

from __future__ import annotations

import anyio
from cabinet import DEVICE, run

import aioduco

#: kinds of a signal as the simulated controller numbers them: no manual does
COIL, REGISTER = 1, 3


async def refresh(robot: aioduco.Robot) -> None:
    """1.3.9-1: the signal mbus1 is read 20 times a second."""
    await robot.modbus.modbus_set_frequency("mbus1", 20)


async def write_registers(robot: aioduco.Robot) -> None:
    """1.3.9-2: five registers of unit 1, from the signal mbus1 on."""
    await robot.modbus.modbus_write_multiple_regs(1, "mbus1", [1, 2, 3, 4, 5])


async def write_coils(robot: aioduco.Robot) -> None:
    """1.3.9-3: five coils of unit 2, from the signal mbus1 on."""
    await robot.modbus.modbus_write_multiple_coils(2, "mbus1", [1, 1, 1, 1, 1])


async def main(host: str, port: int) -> dict[str, object]:
    results: dict[str, object] = {}
    async with aioduco.connect(host, port) as robot:
        # The manual calls registers and coils by one name, which is one signal at a time.
        await robot.modbus.modbus_add_signal(DEVICE, 1, 0, REGISTER, "mbus1")
        await refresh(robot)
        await write_registers(robot)
        results["mbus1"] = await robot.modbus.modbus_read("mbus1")
        await robot.modbus.modbus_delete_signal("mbus1")
        await robot.modbus.modbus_add_signal(DEVICE, 2, 0, COIL, "mbus1")
        await write_coils(robot)
        await robot.modbus.modbus_delete_signal("mbus1")
    return results


if __name__ == "__main__":
    run(lambda host, port: anyio.run(main, host, port))
