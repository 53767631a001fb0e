"""What an estimator returns: values that the data carry, and words for what they do not.

The intervals of the values are those of 95 %.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np

from aioduco.sim.profile import RANGES, Estimate

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence


def deviations(free: float) -> float:
    """Half width of an interval in standard deviations, by its degrees of freedom."""
    from scipy.special import stdtrit  # noqa: PLC0415 - an extra, and quicker to load than scipy.stats

    return float(stdtrit(free, 0.975))


def mean_of(values: Sequence[float], least: float) -> Estimate:
    """The mean of some values, with an interval by their spread and a least half width."""
    half = deviations(len(values) - 1) * float(np.std(values, ddof=1)) / len(values) ** 0.5
    return Estimate.around(float(np.mean(values)), half + least)


def played(section: str, name: str, found: Estimate) -> Estimate | None:
    """An estimate with a value that a profile may have; None if its interval has none."""
    low, high, _ = RANGES[section][name]
    if found.high < low or found.low > high:
        return None
    return found._replace(value=min(max(found.value, low), high))


def not_played(section: str, name: str, found: Estimate) -> str:
    """What is said of an estimate that no profile may have."""
    low, high, unit = RANGES[section][name]
    what = f"{section}, {name}: {found.value:.3g} {unit}"
    return f"{what}, which the simulator does not play: {low:g} to {high:g} {unit}"


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
