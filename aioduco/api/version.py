"""Type of the arm, and version of its controller (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aioduco.api.section import Section

if TYPE_CHECKING:
    from aioduco.models.version import ControllerVersion


class RobotType(NamedTuple):
    """Type of the arm (get_robot_type).

    Attributes:
        series: its series.
        model: its model.
        extension: further letters of the model.
        serial_number: its serial number.
    """

    series: str
    model: str
    extension: str
    serial_number: str


class Version(Section):
    """Type of the arm, version of the controller's software (manual 1.3.7)."""

    __slots__ = ()

    @property
    def controller(self) -> ControllerVersion:
        """The version of the controller's software, which was read while connecting.

        Unknown before that, and if the controller does not report it.
        """
        return self._supervisor.version

    async def get_robot_version(self) -> str:
        """Read the version of the controller's software (控制器版本).

        `controller` has the version already. Manual section 1.3.16.
        """
        return await self._rpc.get_robot_version()

    async def get_robot_type(self) -> RobotType:
        """Read series, model, extension and serial number (机器人系列号, 型号, SN).

        A value that the controller leaves out is empty. Manual section 1.3.7.
        """
        parts = [*await self._rpc.get_robot_type(), "", "", "", ""][:4]
        return RobotType(*parts)
