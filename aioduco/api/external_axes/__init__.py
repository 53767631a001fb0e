"""External axes (外部轴, manual 1.3.14)."""

from __future__ import annotations

from aioduco.api.external_axes.motions import AxisMotions
from aioduco.api.external_axes.schemes import Schemes

__all__ = ["ExternalAxes"]


class ExternalAxes(Schemes, AxisMotions):
    """External axes (外部轴, manual 1.3.14): turntables, rails, in schemes of up to three values.

        await robot.external_axes.enable_eaxis_scheme("rail")
        await robot.external_axes.movel_eaxis(
            target, v=0.2, a=0.5, scheme_name="rail", epose=[1.5, 0, 0], eaxis_v=0.1
        )

    A stop stops the arm and these axes. But the wire does not report whether an axis stands: where
    this package says that the arm stands, that says nothing about the axes.
    """

    __slots__ = ()
