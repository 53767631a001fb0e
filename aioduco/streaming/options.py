"""Arguments of the functions that make streams: keywords, limits per group, worker options."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypedDict

import numpy as np

from aioduco.errors import ParameterError
from aioduco.models.rules import Number
from aioduco.streaming.shared.options import Feeding, Upsampling, WorkerOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = [
    "Feeding",
    "FeedingOptions",
    "PacedOptions",
    "ServoOptions",
    "Upsampling",
    "WorkerOptions",
    "checked",
    "per_group",
]

_LIMIT = Number(0.0, open_low=True, source="this package")


class FeedingOptions(TypedDict, total=False):
    """Keywords for how the program feeds a stream; `Feeding` describes them."""

    source_rate: float | None
    latest: bool
    upsample: Upsampling
    hold: float
    ahead: int | None


class PacedOptions(FeedingOptions, total=False):
    """The same keywords for streams whose rate to the controller can be chosen."""

    rate: float


class ServoOptions(PacedOptions, total=False):
    """The same keywords for streams of positions, which also take chunks of actions."""

    chunks: bool
    blend: float


def per_group(name: str, value: float | Sequence[float], groups: int) -> tuple[float, ...]:
    """A limit for each group, from one number or one per group.

    Raises:
        ParameterError: the value has another shape, or is not above zero.
    """
    one: Any = value
    if isinstance(value, (list, tuple, np.ndarray)):
        if np.shape(value) != (groups,):
            raise ParameterError(name, value, f"one number, or {groups}")
        return tuple(_LIMIT(f"{name}[{group}]", each) for group, each in enumerate(value))
    return (_LIMIT(name, one),) * groups


def checked(options: WorkerOptions | None) -> WorkerOptions:
    """The options of a worker; the defaults for None.

    Raises:
        ParameterError: `options` has another type.
    """
    if options is None:
        return WorkerOptions()
    if not isinstance(options, WorkerOptions):
        raise ParameterError("options", options, "WorkerOptions, or None")
    return options
