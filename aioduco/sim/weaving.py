"""Whether a weave is laid over the paths that come (复合运动, manual 1.3.13)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aioduco.sim.planner.weaving import Weave

__all__ = ["Weaving"]


@dataclass(slots=True)
class Weaving:
    """The weave that was set, and the one that is in use.

    Attributes:
        chosen: the latest that was set; it is used from the next `enable` on.
        active: laid over the paths that come; None while it is switched off.
    """

    chosen: Weave | None = None
    active: Weave | None = None
