"""Load of an arm."""

from __future__ import annotations

from typing import NamedTuple

from aioduco.errors import ParameterError
from aioduco.models.pose import Pose, PoseLike
from aioduco.models.ranges import POSE


class Load(NamedTuple):
    """Mass and centre of mass of a load (负载质量, 质心). A sequence of four numbers.

    Attributes:
        mass: mass [kg].
        x: centre of mass along x [m].
        y: centre of mass along y [m].
        z: centre of mass along z [m].
    """

    mass: float
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0

    def with_load(self, other: Load) -> Load:
        """Return this load and another one in the same frame together.

        Raises:
            ParameterError: the other one is no `Load`.
        """
        return self._sum(_checked(other), 1.0)

    def without_load(self, other: Load) -> Load:
        """Return what remains of this load without a part of it, in the same frame.

        Raises:
            ParameterError: the part is no `Load`, as heavy as this load, or heavier.
        """
        if _checked(other).mass >= self.mass:
            raise ParameterError("other", other, f"lighter than the whole, {self.mass:g} kg")
        return self._sum(other, -1.0)

    def in_tool(self, tool_offset: PoseLike) -> Load:
        """Return this load, given in the flange's frame, with its centre in a tool's frame.

        Args:
            tool_offset: the tool in the flange's frame [m, rad], as of `get_tcp_offset`.

        Raises:
            ParameterError: the offset is no pose, or out of range.
        """
        tool = Pose(*POSE("tool_offset", tool_offset))
        centre = tool.inverse() @ Pose(self.x, self.y, self.z, 0.0, 0.0, 0.0)
        return Load(self.mass, *centre[:3])

    def in_flange(self, tool_offset: PoseLike) -> Load:
        """Return this load, given in a tool's frame, with its centre in the flange's frame.

        Args:
            tool_offset: the tool in the flange's frame [m, rad], as of `get_tcp_offset`.

        Raises:
            ParameterError: the offset is no pose, or out of range.
        """
        tool = Pose(*POSE("tool_offset", tool_offset))
        centre = tool @ Pose(self.x, self.y, self.z, 0.0, 0.0, 0.0)
        return Load(self.mass, *centre[:3])

    def _sum(self, other: Load, sign: float) -> Load:
        mass = self.mass + sign * other.mass
        if mass == 0.0:
            return Load(0.0)
        pairs = zip(self[1:], other[1:], strict=True)
        return Load(mass, *((self.mass * a + sign * other.mass * b) / mass for a, b in pairs))


def _checked(other: Load) -> Load:
    if not isinstance(other, Load):
        raise ParameterError("other", other, "a Load")
    return other
