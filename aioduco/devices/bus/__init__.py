"""Devices on the buses of the arm: Modbus RTU over the RS-485 of the tool or of the cabinet."""

from __future__ import annotations

from aioduco.devices.bus.modbus_rtu import ModbusRtu, Port

__all__ = ["ModbusRtu", "Port"]
