"""RS-485 and CAN (can 及 485 总线, manual 1.3.6)."""

from __future__ import annotations

from aioduco.api.bus.cabinet import CabinetPort
from aioduco.api.bus.can import CanBus, CanFrame
from aioduco.api.bus.tool import ToolPort

__all__ = ["Bus", "CanFrame"]


class Bus(CabinetPort, ToolPort, CanBus):
    """RS-485 of the cabinet and of the tool, and CAN (can 及 485 总线, manual 1.3.6).

        await robot.bus.tool_write_raw_data_485(b"\\x01\\x06\\x01\\x00\\x00\\x01\\x49\\xf6")
        answer = await robot.bus.tool_read_raw_data_485(8)

    Functions take bytes as `bytes` or as numbers; 255 and -1 are the same byte. They return
    `bytes`. Data from a bus stays in the controller's buffer until it is read. Before a request
    whose answer matters, read until the buffer is empty.
    """

    __slots__ = ()
