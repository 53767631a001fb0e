"""Tools, work objects and loads (manual 1.3.7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.models import ranges
from aioduco.models.load import Load
from aioduco.models.samples import pose, some

if TYPE_CHECKING:
    from aioduco.models.pose import Pose, PoseLike
    from aioduco.models.rules import VectorLike


class Frames(Section):
    """Tools (工具), work objects (工件坐标系) and loads (负载), manual 1.3.7.

        await robot.frames.set_tool_data("grip", [0, 0, 0.12, 0, 0, 0], Load(0.8, z=0.05))
        await robot.frames.set_load_data(Load(1.5))      # what the gripper holds from now on

    Motions take the names of a tool and a work object, or use those that were set last. The
    controller uses the masses to hold the arm up in hand guiding and to detect collisions: set the
    real ones.
    """

    __slots__ = ()

    async def set_tool_data(
        self,
        name: str,
        tool_offset: PoseLike,
        payload: Load | VectorLike,
        *,
        inertia_tensor: VectorLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Define a tool (设置工具末端相对于法兰面坐标系的偏移), and use it from now on.

        Motions that name it, or name no tool, use it.

        Args:
            name: its name, 1 to 32 bytes of UTF-8.
            tool_offset: pose of its tip in the flange's frame [m, rad].
            payload: mass of the tool, from 0, and its centre [kg, m]. A `Load`, or shape (4,).
            inertia_tensor: xx, xy, xz, yy, yz, zz [kg·m²]. Shape (6,).

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not defined.

        Manual section 1.3.7.
        """
        call = calls.set_tool_data(
            ranges.NAME("name", name),
            ranges.TOOL_OFFSET("tool_offset", tool_offset),
            ranges.PAYLOAD("payload", payload),
            ranges.INERTIA("inertia_tensor", inertia_tensor),
        )
        with self._supervisor.envelope.redefining():
            await self._finish(call)

    async def set_load_data(self, load: Load | VectorLike) -> None:
        """Set the load that the tool holds (设置抓取负载); this works while a program runs, too.

        Args:
            load: its mass, 0 to 35, and its centre in the tool's frame [kg, m]. A `Load`, or
                shape (4,).

        Raises:
            ParameterError: a number is out of range; nothing was sent.
            TaskError, Refused: it was not set. The manual says that the function returns nothing,
                so an answer of 0 is no refusal.

        Manual section 1.3.7.
        """
        await self._accept(calls.set_load_data(ranges.LOAD("load", load)))

    async def set_wobj(self, name: str, wobj: PoseLike) -> None:
        """Define a work object (工件坐标系), and use it from now on.

        Motions that name it, or name no work object, take their poses in it, also those of later
        programs. `get_tcp_pose` stays in the base frame. `wobj="default"` is the base.

        Not in the manual, which has only `set_wobj_offset`.

        Args:
            name: its name, 1 to 32 bytes of UTF-8.
            wobj: its pose in the base frame [m, rad].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not defined. No manual gives 0 a meaning here, so an answer
                of 0 is no refusal; `get_wobj` reads the work object in use.
        """
        name_, wobj_ = ranges.NAME("name", name), ranges.POSE("wobj", wobj)
        with self._supervisor.envelope.redefining():
            await self._accept(calls.set_wobj(name_, wobj_))

    async def set_wobj_offset(self, wobj: PoseLike, active: bool) -> None:
        """Shift the work object of all later motions (工件坐标系偏移量), or end the shift.

        The work object's pose is multiplied by the offset from the right, so the offset is along
        the work object's own axes. It holds until it is ended, also for other programs.

        Args:
            wobj: the offset [m, rad].
            active: true to apply it, false for no offset.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set. The manual says that the function returns nothing,
                so an answer of 0 is no refusal.

        Manual section 1.3.7.
        """
        wobj_, active_ = ranges.POSE("wobj", wobj), ranges.FLAG("active", active)
        # the oldest controllers do not know `active`, and apply any offset
        sent = wobj_ if active_ else [0.0] * 6
        with self._supervisor.envelope.redefining():
            await self._accept(calls.set_wobj_offset(sent, active_))

    async def get_tcp_offset(self) -> Pose:
        """Read the pose of the tool in use in the flange's frame (工具的偏移量) [m, rad].

        Manual section 1.3.7.
        """
        return pose(await self._rpc.get_tcp_offset())

    async def get_tool_load(self) -> Load:
        """Read mass and centre of mass of the tool in use (工具的负载质量及质心位置) [kg, m].

        Manual section 1.3.7.
        """
        return Load(*some(await self._rpc.get_tool_load(), 4, "numbers of a load"))

    async def get_wobj(self) -> Pose:
        """Read the pose of the work object in use in the base frame (工件坐标系的值) [m, rad].

        Manual section 1.3.7.
        """
        return pose(await self._rpc.get_wobj())

    async def get_base(self) -> Pose:
        """Read the pose of the arm's base (基坐标系) [m, rad].

        Raises:
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        return pose(await self._rpc.get_base())
