"""The gripper of a cell: its kind, the arguments of its driver, and the driver."""

from __future__ import annotations

import inspect
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from aioduco.api.bus import Bus
from aioduco.devices.grippers import DhGripper, DigitalGripper, Robotiq, VacuumGripper
from aioduco.models.gripper_models import GRIPPERS
from aioduco.planning.cell.sections import at, kind_of, only, table, wrong

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.devices.grippers import PolledGripper
    from aioduco.robot import Robot


#: arguments of drivers that the cell gives itself
_OWN = ("self", "robot", "model")


@dataclass(frozen=True, slots=True)
class CellGripper:
    """The gripper of a cell.

    Attributes:
        kind: its model, such as "robotiq_2f85".
        options: further arguments of its driver.
    """

    kind: str
    options: dict[str, Any] = field(default_factory=dict)

    def driver(self, robot: Robot) -> PolledGripper:
        """Make its driver for a robot."""
        made: PolledGripper = _maker(self.kind)(robot, model=self.kind, **self.options)
        return made


def gripper(value: Any) -> CellGripper:
    """`[gripper]`: its kind, and the arguments of the driver, which is made once to check them."""
    found = table(("gripper",), value)
    kind = found.pop("kind", None)
    kind_of(("gripper", "kind"), kind, GRIPPERS)
    known = [each for each in inspect.signature(_maker(kind)).parameters if each not in _OWN]
    only(("gripper",), found, ("kind", *known))
    made = CellGripper(kind, found)
    # No `Robot`: a preflight would start its own simulator for it, before the program starts one.
    nowhere: Any = SimpleNamespace(bus=Bus.__new__(Bus))
    with at("gripper"):
        try:
            made.driver(nowhere)
        except TypeError as error:
            wrong(("gripper",), f"a {kind} cannot be made of {found}: {error}")
    return made


def _maker(kind: str) -> Callable[..., PolledGripper]:
    if kind.startswith("robotiq"):
        return Robotiq.at_tool
    if kind.startswith("dh"):
        return DhGripper.at_tool
    return VacuumGripper if kind == "vacuum" else DigitalGripper
