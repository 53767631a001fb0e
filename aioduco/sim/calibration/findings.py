"""What an estimator returns: values that the data carry, and words for what they do not."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Self

    from aioduco.sim.profile import Estimate

__all__ = ["Findings"]


@dataclass(frozen=True)
class Findings:
    """The result of one estimator.

    Attributes:
        section: section of the profile.
        values: estimates by name.
        notes: what was judged, and how.
        missing: what was left out, why, and what would help.
    """

    section: str
    values: Mapping[str, Estimate] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()

    @classmethod
    def none(cls, section: str, missing: str) -> Self:
        """Nothing was found, and why."""
        return cls(section, missing=(missing,))
