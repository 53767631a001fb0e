"""Digital inputs and outputs (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import IOStatus
from aioduco.sim.handlers.base import Section, mismatch

if TYPE_CHECKING:
    from aioduco.sim.controller import Controller
    from aioduco.sim.signals import Bank


class SignalHandlers(Section):
    """Signals of the cabinet and the tool.

    Reading a signal that does not exist gives False (manual 1.3.7); setting one changes nothing.
    """

    def set_standard_digital_out(self, num: int, value: bool, block: bool) -> int:
        """通用 IO 输出."""
        return self._set("set_standard_digital_out", self._signals.standard_out, num, value, block)

    def set_tool_digital_out(self, num: int, value: bool, block: bool) -> int:
        """末端 IO 输出."""
        return self._set("set_tool_digital_out", self._signals.tool_out, num, value, block)

    def get_standard_digital_out(self, num: int) -> bool:
        """通用 IO 输出."""
        return self._signals.standard_out[num]

    def get_standard_digital_in(self, num: int) -> bool:
        """通用 IO 输入."""
        return self._signals.standard_in[num]

    def get_tool_digital_out(self, num: int) -> bool:
        """末端 IO 输出."""
        return self._signals.tool_out[num]

    def get_tool_digital_in(self, num: int) -> bool:
        """末端 IO 输入."""
        return self._signals.tool_in[num]

    def get_function_digital_in(self, num: int) -> bool:
        """功能 IO 输入."""
        return self._signals.function_in[num]

    def get_function_digital_out(self, num: int) -> bool:
        """功能 IO 输出."""
        return self._signals.function_out[num]

    def get_config_digital_in(self, num: int) -> bool:
        """Configurable input; on the wire, not in the manual."""
        return self._signals.config_in[num]

    def getRobotIOStatus(self) -> IOStatus:  # noqa: N802 - the name on the wire
        """All signals and registers."""
        signals = self._signals
        return IOStatus(
            analogCurrentOutputs=signals.current_out.all(),
            analogVoltageOutputs=signals.voltage_out.all(),
            analogCurrentInputs=signals.current_in.all(),
            analogVoltageInputs=signals.voltage_in.all(),
            digitalInputs=signals.standard_in.all(),
            digitalOutputs=signals.standard_out.all(),
            toolIOIn=signals.tool_in.all(),
            toolIOOut=signals.tool_out.all(),
            toolButton=signals.tool_buttons.all(),
            funRegisterInputs=signals.function_reg_in.all(),
            funRegisterOutputs=signals.function_reg_out.all(),
            boolRegisterInputs=signals.bool_in.all(),
            boolRegisterOutputs=signals.bool_out.all(),
            wordRegisterInputs=signals.word_in.all(),
            wordRegisterOutputs=signals.word_out.all(),
            floatRegisterInputs=signals.float_in.all(),
            floatRegisterOutputs=signals.float_out.all(),
        )

    def _set(self, name: str, bank: Bank[bool], num: int, value: bool, block: bool) -> int:
        def command(controller: Controller) -> int:
            if num not in bank:
                raise mismatch(f"there is no output {num}; there are 1 to {len(bank)}")
            bank[num] = value
            return controller.finish(name)

        return self._task(name, block, command)
