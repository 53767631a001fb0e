"""The manual's examples on Modbus (1.3.9), by the vendor's class."""

from __future__ import annotations

from cabinet import DEVICE, run

from aioduco.compat import DucoCobot

#: kinds of a signal as the simulated controller numbers them: no manual does
COIL, REGISTER = 1, 3


def refresh(robot: DucoCobot) -> None:
    """1.3.9-1: the signal mbus1 is read 20 times a second."""
    robot.modbus_set_frequency("mbus1", 20)


def write_registers(robot: DucoCobot) -> int:
    """1.3.9-2: five registers of unit 1, from the signal mbus1 on."""
    return robot.modbus_write_multiple_regs(1, "mbus1", 5, [1, 2, 3, 4, 5])


def write_coils(robot: DucoCobot) -> int:
    """1.3.9-3: five coils of unit 2, from the signal mbus1 on."""
    return robot.modbus_write_multiple_coils(2, "mbus1", 5, [1, 1, 1, 1, 1])


def main(host: str, port: int) -> dict[str, object]:
    results: dict[str, object] = {}
    with DucoCobot(host, port) as robot:
        # The manual calls registers and coils by one name, which is one signal at a time.
        robot.modbus_add_signal(DEVICE, 1, 0, REGISTER, "mbus1")
        refresh(robot)
        results["1.3.9-2"] = write_registers(robot)
        results["mbus1"] = robot.modbus_read("mbus1")
        robot.modbus_delete_signal("mbus1")
        robot.modbus_add_signal(DEVICE, 2, 0, COIL, "mbus1")
        results["1.3.9-3"] = write_coils(robot)
        robot.modbus_delete_signal("mbus1")
    return results


if __name__ == "__main__":
    run(main)
