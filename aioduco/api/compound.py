"""Combined motion: a weave laid over the path (复合运动, manual 1.3.13)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section, checked_task_id
from aioduco.models import ranges
from aioduco.models.op import Op, wire_op
from aioduco.models.rules import listed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire import rpc
    from aioduco.models.rules import Real, VectorLike
    from aioduco.models.weave import WeavePlane, WeaveShape


class Compound(Section):
    """Combined motion (复合运动, manual 1.3.13): a weave laid over the motions that follow.

        await robot.compound.combine_motion_config(WeaveShape.SINE, WeavePlane.TOOL_XY, 2.0, 0.003)
        await robot.compound.enable_combine_motion()
        await robot.motion.movel(end_of_seam, v=0.01, a=0.1)
        await robot.compound.disable_combine_motion()

    The weave can be switched on and off only while the arm stands. It stays on after the program
    has ended.
    """

    __slots__ = ()

    async def combine_motion_config(
        self,
        type: WeaveShape | int,  # noqa: A002  # the name on the wire
        ref_plane: WeavePlane | int,
        fq: Real,
        amp: Real,
        *,
        el_offset: Real = 0.0,
        az_offset: Real = 0.0,
        up_height: Real = 0.0,
        time: VectorLike = (0.0, 0.0),
        path_dwell: bool = False,
        op_list: Sequence[Op] = (),
    ) -> None:
        """Set the weave (复合运动设置); it takes effect at the next `enable_combine_motion`.

        Args:
            type: shape of the weave, a `WeaveShape`: 1 triangle, 2 sine, 3 circle, 4 trapezoid,
                5 figure of eight.
            ref_plane: plane of the weave, a `WeavePlane`: 0 to 2 XY, XZ, YZ of the tool, 3 to 5
                of the work object.
            fq: frequency, above 0 [Hz].
            amp: amplitude, from 0 [m].
            el_offset: offset in elevation [m]; reserved.
            az_offset: offset in azimuth [m]; reserved.
            up_height: rise of the middle [m]; reserved.
            time: dwell times on the left and on the right, from 0 [s]. Shape (2,).
            path_dwell: whether the motion along the path pauses during a dwell.
            op_list: outputs set on the way. The manual calls the list two-dimensional; on the
                wire it has one dimension.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: it was not set.

        Manual section 1.3.13. It prints no unit for `time`. Manual 4.3 prints milliseconds, so
        the times are sent in milliseconds.
        """
        await self._finish(
            calls.combine_motion_config(
                ranges.WEAVE_TYPE("type", type),
                ranges.WEAVE_PLANE("ref_plane", ref_plane),
                ranges.WEAVE_FREQUENCY("fq", fq),
                ranges.WEAVE_AMPLITUDE("amp", amp),
                ranges.WEAVE_OFFSET("el_offset", el_offset),
                ranges.WEAVE_OFFSET("az_offset", az_offset),
                ranges.WEAVE_OFFSET("up_height", up_height),
                ranges.weave_dwells("time", time),
                ranges.FLAG("path_dwell", path_dwell),
                _ops(op_list),
            )
        )

    async def enable_combine_motion(self) -> None:
        """Lay the weave over the motions that follow (开启复合运动); the arm must stand.

        Raises:
            TaskError, Refused: it was not switched on.

        Manual section 1.3.13, which prints its name as enable_combined_motion.
        """
        # before it is sent, since its answer may be lost
        self._supervisor.envelope.strays("enable_combine_motion")
        await self._finish(calls.enable_combine_motion())

    async def disable_combine_motion(self) -> None:
        """End the weave (结束复合运动); the arm must stand.

        Raises:
            TaskError, Refused: it was not switched off.

        Manual section 1.3.13, which prints its name as disable_combined_motion.
        """
        await self._finish(calls.disable_combine_motion())
        self._supervisor.envelope.strays("enable_combine_motion", on=False)

    async def enable_laser_track(self) -> int:
        """Let the motions that follow track a seam by a laser sensor (激光跟踪).

        Its parameters are set at the pendant: where the wire has them is not known.

        Returns:
            The id that the controller gives; no task is followed.

        Raises:
            Refused: it was not switched on.
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        self._supervisor.envelope.strays("enable_laser_track")
        answer = await self._rpc.enable_laser_track()
        return checked_task_id("enable_laser_track", answer)

    async def disable_laser_track(self) -> None:
        """End the tracking of a seam.

        Raises:
            TaskError, Refused: it was not switched off.
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        await self._accept(calls.disable_laser_track())
        self._supervisor.envelope.strays("enable_laser_track", on=False)

    async def reset_laser_track(self) -> None:
        """Forget the offsets that the laser sensor found.

        Raises:
            TaskError, Refused: it was not done.
            UnknownFunction: the controller is older than manual 4.3, which adds the function.

        Not in manual 3.8; manual 4.3 describes it.
        """
        await self._accept(calls.reset_laser_track())


def _ops(ops: Sequence[Op]) -> list[rpc.Op]:
    given = listed("op_list", ops, "a list of Op")
    return [wire_op(f"op_list[{number}]", op) for number, op in enumerate(given)]
