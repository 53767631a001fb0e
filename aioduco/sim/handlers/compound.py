"""Combined motion: a weave that is added to later paths (复合运动, manual 1.3.13)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.models.weave import WeavePlane, WeaveShape
from aioduco.sim.controller.triggers import point_trigger
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.planner.weaving import Weave
from aioduco.sim.refusal import illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import Op
    from aioduco.sim.controller.state_machine import Controller

_HIGHEST = 1e6  # stands for a frequency without a limit [Hz]
_WIDEST = 10.0  # stands for an amplitude without a limit [m]


class CompoundHandlers(HandlerSection):
    """combine_motion_config, enable_combine_motion, disable_combine_motion."""

    @task()
    def combine_motion_config(
        self,
        controller: Controller,
        type: int,  # noqa: A002 - the name on the wire
        ref_plane: int,
        fq: float,
        amp: float,
        el_offset: float,
        az_offset: float,
        up_height: float,
        time: Sequence[int],
        path_dwell: bool,
        op_list: Sequence[Op],
    ) -> None:
        """Set the weave that the next enable_combine_motion switches on."""
        arguments.choice("type", type, tuple(WeaveShape), "from 1 to 5")
        arguments.choice("ref_plane", ref_plane, tuple(WeavePlane), "from 0 to 5")
        if not all(map(math.isfinite, (el_offset, az_offset, up_height))):
            raise mismatch("el_offset, az_offset and up_height must be finite")
        left, right = _dwells(time)
        for op in op_list:
            # No source says when they are due: they are only checked.
            point_trigger(op, self._signals, self._forgiving)
        controller.weaving.chosen = Weave(
            WeaveShape(type),
            WeavePlane(ref_plane),
            arguments.positive("fq", fq, _HIGHEST, "Hz"),
            arguments.number("amp", amp, 0.0, _WIDEST, "m"),
            left,
            right,
            path_dwell,
        )

    @task()
    def enable_combine_motion(self, controller: Controller) -> None:
        """Add the weave that was set last to later paths."""
        _check_idle(controller)
        if controller.weaving.chosen is None:
            raise illegal("no combined motion has been set")
        controller.weaving.active = controller.weaving.chosen

    @task()
    def disable_combine_motion(self, controller: Controller) -> None:
        """Add no weave to later paths."""
        _check_idle(controller)
        controller.weaving.active = None


def _check_idle(controller: Controller) -> None:
    """Check that no motion runs: the manual allows the switch only while the robot is stopped."""
    if not controller.idle:
        raise illegal("motions are running")


def _dwells(milliseconds: Sequence[int]) -> tuple[float, float]:
    """Dwell times on the left and on the right [s]; zero when the list is left out."""
    if len(milliseconds) not in (0, 2) or any(each < 0 for each in milliseconds):
        raise mismatch(f"time is {list(milliseconds)}, but must be two numbers from 0 ms")
    left, right = milliseconds or (0, 0)
    return left / 1000.0, right / 1000.0
