"""Arguments of the functions that make streams: keywords, gains, limits per group."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from aioduco.api.arguments import gains
from aioduco.errors import ParameterError
from aioduco.models.numpy_on_use import is_number
from aioduco.models.rules import Number, Real
from aioduco.streaming.shared.space import JERK, Limits

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.streaming.shared.options import Upsampling


_LIMIT = Number(0.0, open_low=True, source="this package")


class FeedingOptions(TypedDict, total=False):
    """Keywords for how the program feeds a stream; `Feeding` describes them."""

    source_rate: float | None
    latest: bool
    upsample: Upsampling
    hold: float
    ahead: int | None


class ServoOptions(FeedingOptions, total=False):
    """The same keywords for streams of positions, with a rate, and with chunks of actions."""

    rate: float
    chunks: bool
    blend: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ServoGains:
    """How closely the controller follows a servo's set-points (manual 1.3.5, servoj).

    Attributes:
        kp: proportional gain, from 0; the manual advises its default.
        kd: derivative gain, from 0; the manual advises its default.
        smooth_vel: smoothing of the velocity, 1 to 100; larger is smoother and lags more.
        smooth_acc: smoothing of the acceleration, 0 to 1; larger is smoother and lags more.
    """

    kp: float = 200.0
    kd: float = 25.0
    smooth_vel: float = 10.0
    smooth_acc: float = 1.0

    def wire(self) -> list[float]:
        """Check the four gains and return them in the order of a servo call's last arguments.

        Raises:
            ParameterError: a gain is out of range.
        """
        return gains(self.kp, self.kd, self.smooth_vel, self.smooth_acc)


def per_group(name: str, value: Real | Sequence[Real], groups: int) -> tuple[float, ...]:
    """A limit for each group, from one number or one per group.

    Raises:
        ParameterError: the value has another shape, or is not above zero.
    """
    given: Any = value
    if is_number(given) or not isinstance(given, (list, tuple, np.ndarray)):
        return (_LIMIT(name, given),) * groups
    if np.shape(given) != (groups,):
        raise ParameterError(name, given, f"one number, or {groups}")
    return tuple(_LIMIT(f"{name}[{group}]", each) for group, each in enumerate(given))


def motion_limits(
    v: Real | Sequence[Real],
    a: Real | Sequence[Real],
    jerk: Real | Sequence[Real] | None,
    groups: int,
    *,
    names: tuple[str, str] = ("v", "a"),
) -> Limits:
    """The limits of a stream, each one number or one per group; the jerk's default is 10 a.

    Raises:
        ParameterError: one of them has another shape, or is not above zero.
    """
    top, change = per_group(names[0], v, groups), per_group(names[1], a, groups)
    jerks = tuple(JERK * c for c in change) if jerk is None else per_group("jerk", jerk, groups)
    return Limits(top, change, jerks)
