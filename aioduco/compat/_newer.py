"""A struct of the vendor's newer class, with a field that its manual spells otherwise."""

from __future__ import annotations

from typing import Any

from aioduco._wire.rpc import MoveJogTaskParam as _MoveJogTaskParam


class MoveJogTaskParam(_MoveJogTaskParam):
    """One jog, whose last field section 1.3.5 of the manual spells `step_cartValue`."""

    __slots__ = ()

    def __init__(self, *args: Any, **fields: Any) -> None:
        if "step_cartValue" in fields:
            if "step_cartvalue" in fields:
                raise TypeError("step_cartValue is another name of step_cartvalue; give one")
            fields["step_cartvalue"] = fields.pop("step_cartValue")
        super().__init__(*args, **fields)

    @property
    def step_cartValue(self) -> float:  # noqa: N802 - the manual's name
        """The field `step_cartvalue`."""
        return self.step_cartvalue

    @step_cartValue.setter
    def step_cartValue(self, value: float) -> None:  # noqa: N802
        self.step_cartvalue = value
