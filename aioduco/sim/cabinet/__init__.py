"""State of the controller besides the arm: signals, values, ports, tools, files, external axes.

Nothing here moves. The modules may import `planner` (for moves of external axes) and `refusal`.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from aioduco._process.copying import Uncopied
from aioduco.sim.cabinet.axis_schemes import Axis
from aioduco.sim.cabinet.modbus import ModbusSignals, ModbusSlave, RtuSlave, ScriptedGripper
from aioduco.sim.cabinet.ports import CanPort, SerialPort
from aioduco.sim.cabinet.project import Project
from aioduco.sim.cabinet.tools import NO_LOAD
from aioduco.sim.cabinet.values import SystemValues

if TYPE_CHECKING:
    from aioduco.models.load import Load
    from aioduco.sim.planner.guiding import Giving

__all__ = [
    "Axis",
    "Cabinet",
    "CanPort",
    "ModbusSlave",
    "Project",
    "RtuSlave",
    "ScriptedGripper",
    "SerialPort",
    "SystemValues",
]


@dataclass(slots=True)
class Cabinet(Uncopied):
    """Everything in the cabinet that no motion needs.

    Attributes:
        values: system values.
        serial: the cabinet's RS-485 port.
        tool_serial: the tool's RS-485 port.
        can: the CAN bus.
        modbus: signals and slaves of the controller's Modbus.
        project: its files, programs and tracks.
        teach_speed: speed of jogs [%].
        pendant_enabled: whether the pendant's keys are enabled.
        empty_statuses: how many of the next answers to getRobotStatus have empty lists, as a
            controller has been seen to send just after connecting.
        mode_switch: whether a switch at the cabinet, and not a program, decides the mode.
        encoder_count: count of the external encoder.
        dynamics: parameters of the dynamic calibration, as they were set.
        hand_teaching: which motions hand guiding allows; None for all.
        held: the load of set_load_data.
        tooled: whether the simulator has a model of a tool; without one, the payload of the tool in
            use is mounted instead.
        force_sensor: whether a force sensor is set up.
        lock: held while a bus is used: several programs share it, and peers are not thread-safe.
    """

    values: SystemValues = field(default_factory=SystemValues)
    serial: SerialPort = field(default_factory=SerialPort)
    tool_serial: SerialPort = field(default_factory=SerialPort)
    can: CanPort = field(default_factory=CanPort)
    modbus: ModbusSignals = field(default_factory=ModbusSignals)
    project: Project = field(default_factory=Project)
    teach_speed: int = 100
    pendant_enabled: bool = True
    empty_statuses: int = 0
    mode_switch: bool = False
    encoder_count: int = 0
    dynamics: list[list[float]] = field(default_factory=list)
    hand_teaching: Giving | None = None
    held: Load = NO_LOAD
    tooled: bool = False
    force_sensor: bool = True
    lock: threading.Lock = field(default_factory=threading.Lock)

    def restart(self) -> None:
        """Begin a run: its time starts at 0, and the arm carries nothing."""
        self.held = NO_LOAD
        self.serial.restart()
        self.tool_serial.restart()
        self.modbus.restart()
