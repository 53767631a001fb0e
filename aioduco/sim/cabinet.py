"""What the controller keeps besides the arm: variables, settings, ports, files."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

from aioduco.sim.buses import CanPort, SerialPort
from aioduco.sim.modbus import ModbusSignals
from aioduco.sim.values import SystemValues

__all__ = ["Cabinet"]


@dataclass(slots=True)
class Cabinet:
    """Everything in the cabinet that no motion needs.

    Attributes:
        values: system values.
        serial: the cabinet's RS-485 port.
        tool_serial: the tool's.
        can: the CAN bus.
        modbus: signals and slaves of the controller's Modbus.
        lock: held while a bus is used: several programs share it, and peers know no threads.
    """

    values: SystemValues = field(default_factory=SystemValues)
    serial: SerialPort = field(default_factory=SerialPort)
    tool_serial: SerialPort = field(default_factory=SerialPort)
    can: CanPort = field(default_factory=CanPort)
    modbus: ModbusSignals = field(default_factory=ModbusSignals)
    lock: threading.Lock = field(default_factory=threading.Lock)
