"""External axes: their state, their parameters, the parameters of their schemes."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models.rules import Flag, Integer, Integers, Number, Points, Vector

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


_SOURCE = "EAxisParam and EAxisSchemeParam on the wire"
_WHOLE = Integer(-(2**31), 2**31 - 1, source=_SOURCE)
_FINITES = Vector(Number(source=_SOURCE), source=_SOURCE)
#: by the types of the attributes
_RULES: dict[Any, Callable[[str, Any], Any]] = {
    "int": _WHOLE,
    "float": Number(source=_SOURCE),
    "bool": Flag(source=_SOURCE),
    "Sequence[int]": Integers(_WHOLE, source=_SOURCE),
    "Sequence[float]": _FINITES,
    "Sequence[Sequence[float]]": Points(_FINITES, 0, 2**31 - 1, source=_SOURCE),
}


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
        return rpc.EAxisParam(**_checked(self))


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
        return rpc.EAxisSchemeParam(**_checked(self))


def _checked(given: ExternalAxis | ExternalAxisScheme) -> dict[str, Any]:
    """The attributes by name, each checked by the rule for its type."""
    return {
        each.name: _RULES[each.type](each.name, getattr(given, each.name)) for each in fields(given)
    }


def checked(name: str, value: object, kind: type[ExternalAxis] | type[ExternalAxisScheme]) -> None:
    """Check the class of a parameter.

    Raises:
        ParameterError: `value` is not a `kind`.
    """
    if not isinstance(value, kind):
        raise ParameterError(name, value, f"an {kind.__name__}")
