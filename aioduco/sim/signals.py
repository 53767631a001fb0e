"""Inputs and outputs of the cabinet and of the tool (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco.sim.bank import Bank
from aioduco.sim.outputs import Outputs

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Bank", "Signals"]


class Signals:
    """Every signal of a controller.

    The cabinet has 16 general inputs and outputs and 8 function inputs and outputs, the tool 2
    of each and the buttons T and S. Of the 8 configurable inputs the manual says nothing: their
    number is an assumption.

    Attributes:
        events: what a trigger's event does, by its name (用户自定义事件, manual 1.3.5). It is
            called within the controller's cycle, so it must not wait.
    """

    def __init__(self) -> None:
        self.events: dict[str, Callable[[], None]] = {}
        self.standard_in: Bank[bool] = Bank(16, False)
        self.standard_out: Outputs = Outputs(16)
        self.function_in: Bank[bool] = Bank(8, False)
        self.function_out: Bank[bool] = Bank(8, False)
        self.config_in: Bank[bool] = Bank(8, False)
        self.tool_in: Bank[bool] = Bank(2, False)
        self.tool_out: Bank[bool] = Bank(2, False)
        self.tool_buttons: Bank[bool] = Bank(2, False)
        self.voltage_in: Bank[float] = Bank(4, 0.0)
        self.voltage_out: Bank[float] = Bank(4, 0.0)
        self.current_in: Bank[float] = Bank(4, 0.0)
        self.current_out: Bank[float] = Bank(4, 0.0)
        self.analog_mode: Bank[int] = Bank(4, 0)
        self.tool_voltage_in: Bank[float] = Bank(2, 0.0)
        self.function_reg_in: Bank[bool] = Bank(16, False)
        self.function_reg_out: Bank[bool] = Bank(16, False)
        self.bool_in: Bank[bool] = Bank(64, False)
        self.bool_out: Bank[bool] = Bank(64, False)
        self.word_in: Bank[int] = Bank(32, 0)
        self.word_out: Bank[int] = Bank(32, 0)
        self.float_in: Bank[float] = Bank(32, 0.0)
        self.float_out: Bank[float] = Bank(32, 0.0)
