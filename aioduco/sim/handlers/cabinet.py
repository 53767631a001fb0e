"""Everything of the wire that the cabinet answers without the arm's motion."""

from __future__ import annotations

from aioduco.sim.handlers.buses import CanHandlers, ModbusHandlers
from aioduco.sim.handlers.load import LoadHandlers
from aioduco.sim.handlers.program import ProgramHandlers
from aioduco.sim.handlers.registers import RegisterHandlers
from aioduco.sim.handlers.signals import SignalHandlers
from aioduco.sim.handlers.upkeep import SettingsHandlers

__all__ = ["CabinetHandlers"]


class CabinetHandlers(
    SignalHandlers,
    RegisterHandlers,
    CanHandlers,
    ModbusHandlers,
    SettingsHandlers,
    ProgramHandlers,
    LoadHandlers,
):
    """Signals, registers, system values, buses, settings, programs and files."""
