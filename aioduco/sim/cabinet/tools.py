"""Tools and work objects by name (manual 1.3.7, set_tool_data, set_wobj)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from aioduco.models.load import Load
from aioduco.models.pose import Pose
from aioduco.sim.refusal import Rejected, illegal

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.models.rotation import Array


DEFAULT = "default"
MAX_NAME = 32
NO_LOAD = Load(0.0)
_ORIGIN = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class NamedFrame:
    """The frame of a tool at the flange, or of a work object at the base.

    Attributes:
        name: up to 32 bytes.
        pose: its place; that of a work object with the offset in use.
        matrix: the same as a matrix. Shape (4, 4).
        inverse: the flange, or the base, in it. Shape (4, 4).
        load: what a tool weighs, with its centre in the flange's frame.
    """

    name: str
    pose: Pose
    matrix: Array
    inverse: Array
    load: Load = NO_LOAD

    @classmethod
    def at(cls, pose: Pose, name: str = "", load: Load = NO_LOAD) -> NamedFrame:
        """Make a frame at a pose."""
        return cls(name, pose, _frozen(pose.matrix), _frozen(pose.inverse().matrix), load)


class FrameTable:
    """The defined tools and work objects, and those in use.

    At first there is one of each, named "default": the flange and the base.

    Attributes:
        current_tool: the tool in use.
        current_wobj: the work object in use, with the offset in use.
    """

    def __init__(self) -> None:
        self._tools = {DEFAULT: NamedFrame.at(_ORIGIN, DEFAULT)}
        self._wobjs = self._tools.copy()
        self.current_tool: NamedFrame = self._tools[DEFAULT]
        self._wobj = self._wobjs[DEFAULT]
        self._offset: Pose | None = None
        self.current_wobj: NamedFrame = self._wobj

    def tool(self, name: str = "") -> NamedFrame:
        """Find a tool by its name; an empty name means the tool in use.

        Raises:
            Rejected: No tool has this name.
        """
        if not name:
            return self.current_tool
        if name not in self._tools:
            raise _unknown(f"there is no tool {name!r}", self._tools)
        return self._tools[name]

    def wobj(self, name: str = "") -> NamedFrame:
        """Find a work object by its name, with the offset in use; no name means the one in use.

        Raises:
            Rejected: No work object has this name.
        """
        if name and name not in self._wobjs:
            raise _unknown(f"there is no work object {name!r}", self._wobjs)
        return self._moved(self._wobjs[name]) if name else self.current_wobj

    def set_tool(self, tool: NamedFrame) -> None:
        """Define a tool, and use it."""
        self._tools[tool.name] = self.current_tool = tool

    def set_wobj(self, name: str, pose: Pose) -> None:
        """Define a work object, and use it."""
        self._wobjs[name] = self._wobj = NamedFrame.at(pose, name)
        self.current_wobj = self._moved(self._wobj)

    def set_wobj_offset(self, offset: Pose | None) -> None:
        """Move the frame of every work object by an offset in it; None for no offset."""
        self._offset = offset
        self.current_wobj = self._moved(self._wobj)

    def _moved(self, wobj: NamedFrame) -> NamedFrame:
        if self._offset is None:
            return wobj
        return NamedFrame.at(wobj.pose @ self._offset, wobj.name)


def _unknown(message: str, known: Iterable[str]) -> Rejected:
    return illegal(f"{message}; there are: {', '.join(known)}")


def _frozen(matrix: Array) -> Array:
    matrix.flags.writeable = False
    return matrix
