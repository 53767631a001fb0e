"""What the vendor's newer class has: functions of manual 4.3 without arguments, and a spelling.

A call without arguments is its name alone, so these can be sent (`aioduco._wire.newer`). A
controller that does not know one answers "unknown function": `UnknownFunction`. Of the other
functions that manual 4.3 adds, the numbers of the fields are not known.
"""

from __future__ import annotations

from typing import Any

from aioduco._wire.rpc import MoveJogTaskParam as _MoveJogTaskParam
from aioduco.compat._generated import ManualFunctions


class NewerFunctions(ManualFunctions):
    """Functions of manual 4.3 that take no arguments."""

    def get_base(self) -> list[float]:
        """Pose of the arm's base m, rad."""
        return list(self._call("get_base", ()))

    def get_home_pose(self) -> list[float]:
        """Joints rad of the home position."""
        return list(self._call("get_home_pose", ()))

    def get_installation(self) -> list[float]:
        """Angles of the mounting."""
        return list(self._call("get_installation", ()))

    def get_tcp_pose_command(self) -> list[float]:
        """Commanded pose of the tool m, rad."""
        return list(self._call("get_tcp_pose_command", ()))

    def get_tcp_speed_command(self) -> list[float]:
        """Commanded speed of the tool m/s, rad/s."""
        return list(self._call("get_tcp_speed_command", ()))

    def get_simulation_state(self) -> bool:
        """Whether the controller simulates."""
        return bool(self._call("get_simulation_state", ()))

    def clear_error_message(self) -> None:
        """Clear the list of errors."""
        self._call("clear_error_message", ())

    def enable_laser_track(self) -> int:
        """Turn the tracking of a seam by laser on."""
        return int(self._call("enable_laser_track", ()))

    def disable_laser_track(self) -> int:
        """Turn the tracking of a seam by laser off."""
        return int(self._call("disable_laser_track", ()))

    def reset_laser_track(self) -> int:
        """Forget the offsets that the laser found."""
        return int(self._call("reset_laser_track", ()))


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
