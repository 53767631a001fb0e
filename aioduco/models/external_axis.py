"""External axes: their state, their parameters, the parameters of their schemes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models.rules import Flag, Integer, Integers, Number, Points, Vector

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["ExternalAxis", "ExternalAxisScheme", "ExternalAxisState"]

_SOURCE = "EAxisParam and EAxisSchemeParam on the wire"
_WHOLE = Integer(-(2**31), 2**31 - 1, source=_SOURCE)
_WHOLES = Integers(_WHOLE, source=_SOURCE)
_FINITE = Number(source=_SOURCE)
_FINITES = Vector(_FINITE, source=_SOURCE)
_ROWS = Points(_FINITES, 0, 2**31 - 1, source=_SOURCE)
_FLAG = Flag(source=_SOURCE)


@dataclass(frozen=True, slots=True)
class ExternalAxisState:
    """State of a scheme of external axes (外部轴反馈信息, EAxisInfo in the manual's section 1.2).

    Attributes:
        scheme_name: name of the scheme.
        status: activation state as the controller's number (激活状态); the manual does not list
            the numbers.
        position: position [rad or m, depending on the scheme].
        vel: speed [rad/s or m/s]; NaN if the controller is older than manual 4.3.
        acc: acceleration [rad/s² or m/s²]; NaN likewise.
    """

    scheme_name: str
    status: int
    position: float
    vel: float = math.nan
    acc: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class ExternalAxis:
    """Parameters of an external axis.

    No document describes them: names and types are the wire's, and the units are those of the
    controller's own page for external axes. Numbers are only checked to be finite.

    Attributes:
        type: kind of axis.
        mode: drive mode.
        ref_velo: reference speed.
        ref_acc: reference acceleration.
        ref_jerk: reference jerk.
        max_velo: maximum speed.
        max_acc: maximum acceleration.
        encoder_type: kind of encoder.
        encoder_resolution: resolution of the encoder.
        position_bias: position of its zero.
        screw_lead: lead of its screw.
        invert: whether its direction is inverted.
        position_limit: limits of its position.
    """

    type: int
    mode: int
    ref_velo: float
    ref_acc: float
    ref_jerk: float
    max_velo: float
    max_acc: float
    encoder_type: int
    encoder_resolution: int
    position_bias: float
    screw_lead: float
    invert: bool
    position_limit: Sequence[float]

    def wire(self) -> rpc.EAxisParam:
        """Return the struct of the wire.

        Raises:
            ParameterError: a value is of another type, or not finite.
        """
        return rpc.EAxisParam(
            type=_WHOLE("type", self.type),
            mode=_WHOLE("mode", self.mode),
            ref_velo=_FINITE("ref_velo", self.ref_velo),
            ref_acc=_FINITE("ref_acc", self.ref_acc),
            ref_jerk=_FINITE("ref_jerk", self.ref_jerk),
            max_velo=_FINITE("max_velo", self.max_velo),
            max_acc=_FINITE("max_acc", self.max_acc),
            encoder_type=_WHOLE("encoder_type", self.encoder_type),
            encoder_resolution=_WHOLE("encoder_resolution", self.encoder_resolution),
            position_bias=_FINITE("position_bias", self.position_bias),
            screw_lead=_FINITE("screw_lead", self.screw_lead),
            invert=_FLAG("invert", self.invert),
            position_limit=_FINITES("position_limit", self.position_limit),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ExternalAxisScheme:
    """Parameters of a scheme of external axes.

    No document describes them: names and types are the wire's, and the units are those of the
    controller's own page for external axes. Numbers are only checked to be finite.

    Attributes:
        type: kind of scheme.
        axis_link: the axes that belong to it.
        base: position of its base.
        dh: its Denavit-Hartenberg parameters, a row for each axis.
        install: kind of mounting.
    """

    type: int
    axis_link: Sequence[int]
    base: Sequence[float]
    dh: Sequence[Sequence[float]]
    install: int

    def wire(self) -> rpc.EAxisSchemeParam:
        """Return the struct of the wire.

        Raises:
            ParameterError: a value is of another type, or not finite.
        """
        return rpc.EAxisSchemeParam(
            type=_WHOLE("type", self.type),
            axis_link=_WHOLES("axis_link", self.axis_link),
            base=_FINITES("base", self.base),
            dh=_ROWS("dh", self.dh),
            install=_WHOLE("install", self.install),
        )


def checked(name: str, value: object, kind: type[ExternalAxis] | type[ExternalAxisScheme]) -> None:
    """Check the class of a parameter.

    Raises:
        ParameterError: `value` is not a `kind`.
    """
    if not isinstance(value, kind):
        raise ParameterError(name, value, f"an {kind.__name__}")
