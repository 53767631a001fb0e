"""Lag, gain and noise of the drives, from samples of set-points and joints of one instant.

A position loop (see `physics.drives`) trails its set-point by
e = lag·(speed of the set-point) + (speed of the joint - speed of the set-point)/gain,
which is linear in lag and 1/gain, and needs no times: samples at any rate will do. What is left is
the noise of the measured joint.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from aioduco.sim.calibration.findings import Findings, deviations, not_played, played
from aioduco.sim.profile import Estimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.models.rotation import Array
    from aioduco.sim.calibration.evidence import Motions


#: steps of recorded joints [rad] and speeds [rad/s]: `recording.channels.ANGLE` and `SPEED`
ANGLE_STEP: Final = 2.0**-17
SPEED_STEP: Final = 2.0**-10
#: speed of a set-point that counts as a motion [rad/s], and the pause that ends one [s]
_MOVING: Final = 0.02
_PAUSE: Final = 0.15
#: motions of a joint that are needed, and the least samples of all of them together
_MOTIONS: Final = 6
_SAMPLES: Final = 100
#: least half width of a lag: the two readings of a sample may be a part of a cycle apart [s]
_LEAST_LAG: Final = 1e-4
#: time by which the speeds of a sample may be apart, such as one at the end of a cycle and a mean
#: over it [s]; while the speed changes, 1/gain seems to change by that share of the lag
_APART: Final = 1e-3
#: half width of a gain's interval as a share of it, beyond which it is left out
_LOOSE: Final = 0.2
#: error of held-out motions as a multiple of the others' that refuses the fit
_WORSE: Final = 2.0


class _Joint:
    """The motions of one joint: errors [rad], and what they depend on."""

    def __init__(self, sets: Sequence[Motions], joint: int) -> None:
        errors, terms, groups = [], [], []
        count = 0
        for motions in sets:
            moves = np.abs(motions.wanted_speed[:, joint]) > _MOVING
            gaps = np.diff(motions.time[moves]) > _PAUSE
            wanted, actual = motions.wanted_speed[moves, joint], motions.speed[moves, joint]
            errors.append((motions.wanted - motions.joints)[moves, joint])
            terms.append(np.stack([wanted, actual - wanted], axis=1))
            if len(wanted):
                groups.append(count + np.concatenate([[0], np.cumsum(gaps)]))
                count = int(groups[-1][-1]) + 1
        self.error: Array = np.concatenate([np.zeros(0), *errors])
        self.terms: Array = np.concatenate([np.zeros((0, 2)), *terms])
        self.group: NDArray[np.intp] = np.concatenate([np.zeros(0), *groups]).astype(np.intp)
        self.motions = count

    @property
    def enough(self) -> bool:
        return self.motions >= _MOTIONS and len(self.error) >= _SAMPLES

    def fit(self, chosen: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Lag and 1/gain [s], and the inverse of what determines them, from chosen samples."""
        terms, error = self.terms[chosen], self.error[chosen]
        # The recorded speeds are rounded: without the rounding's part, the fit would be too flat.
        matrix = terms.T @ terms - len(terms) * _ROUNDING
        inverse: Array = np.asarray(np.linalg.pinv(matrix), dtype=np.float64)
        return inverse @ (terms.T @ error), inverse

    def residual(self, found: Array) -> Array:
        left: Array = self.error - self.terms @ found
        return left

    def spread(self, found: Array, inverse: Array) -> Array:
        """Covariance of lag and 1/gain, from how much the motions differ from each other."""
        left = self.residual(found)
        scores = np.zeros((self.motions, 2))
        np.add.at(scores, self.group, self.terms * left[:, None] + _ROUNDING @ found)
        middle = scores.T @ scores * self.motions / (self.motions - 2)
        covariance: Array = inverse @ middle @ inverse
        return covariance


_ROUNDING: Final = SPEED_STEP**2 / 12 * np.array([[1.0, -1.0], [-1.0, 2.0]])


def estimate_drives(sets: Sequence[Motions]) -> Findings:
    """Estimate lag and gain of each joint.

    Args:
        sets: samples of one or more recordings.
    """
    values: dict[str, Estimate] = {}
    missing: list[str] = []
    judged = []
    for joint in range(6):
        name, data = f"joint {joint + 1}", _Joint(sets, joint)
        if not data.enough:
            missing.append(
                f"drives, {name}: {data.motions} motions are too few, {_MOTIONS} are needed"
            )
            continue
        every = np.ones(len(data.error), dtype=bool)
        found, inverse = data.fit(every)
        ratio = _held_out(data)
        if ratio > _WORSE:
            missing.append(
                f"drives, {name}: motions that were held out differ by {ratio:.1f} times the "
                "error of the others: this arm's drive does not trail by a constant time"
            )
            continue
        judged.append(ratio)
        halves = deviations(data.motions - 2) * np.sqrt(np.diag(data.spread(found, inverse)))
        lag = Estimate.around(float(found[0]), max(float(halves[0]), _LEAST_LAG))
        lag = lag._replace(value=max(lag.value, 0.0), high=max(lag.high, 0.0))
        if played("drives", f"lag{joint + 1}", lag) is None:  # nor can its gain be played
            missing.append(not_played("drives", f"lag{joint + 1}", lag))
            continue
        values[f"lag{joint + 1}"] = lag
        time = float(found[1])
        half = float(halves[1]) + time * _APART / max(lag.value, _LEAST_LAG)
        if time <= 0.0 or half > _LOOSE * time:
            missing.append(f"drives, gain of {name}: motions with more acceleration would show it")
            continue
        gain = Estimate(1.0 / time, 1.0 / (time + half), 1.0 / (time - half))
        if gain.value * lag.value > 1.0:  # by its uncertainty: a loop cannot trail by less
            value = 1.0 / lag.value
            gain = Estimate(value, min(gain.low, value), gain.high)
        values[f"gain{joint + 1}"] = gain
    notes: tuple[str, ...] = ()
    if judged:
        notes = (f"held-out motions: errors at most {max(judged):.2f} times those of the others",)
    return Findings("drives", values, notes, tuple(missing))


def _held_out(data: _Joint) -> float:
    """Error of every second motion in a fit of the others, as a multiple of theirs."""
    ratios = []
    for held in (data.group % 2 == 1, data.group % 2 == 0):
        found, _ = data.fit(~held)
        left = data.residual(found)
        one = max(float(np.sqrt((left[~held] ** 2).mean())), ANGLE_STEP)
        ratios.append(float(np.sqrt((left[held] ** 2).mean())) / one)
    return max(ratios)


def estimate_noise(sets: Sequence[Motions]) -> Findings:
    """Estimate the noise of each measured joint, from what lag and gain leave over.

    Args:
        sets: samples of one or more recordings.
    """
    values: dict[str, Estimate] = {}
    missing: list[str] = []
    for joint in range(6):
        data = _Joint(sets, joint)
        if not data.enough:
            continue
        found, _ = data.fit(np.ones(len(data.error), dtype=bool))
        left = data.residual(found)
        weights = np.array([found[0] - found[1], found[1]])
        rounding = 2 * ANGLE_STEP**2 / 12 + float(weights @ weights) * SPEED_STEP**2 / 12
        variance = float(left @ left) / (len(left) - 2)
        # Groups differ if the error is not white; their means of squares say how much.
        squares = np.bincount(data.group, left**2) / np.bincount(data.group)
        spread = max(
            float(np.std(squares)) / np.sqrt(data.motions), variance * np.sqrt(2 / len(left))
        )
        if variance - 2 * spread < 2 * rounding:
            missing.append(f"noise of joint {joint + 1}: not above the steps of the recording")
            continue
        low, value, high = (
            float(np.sqrt(max(variance + k * spread - rounding, 0.0))) for k in (-2.2, 0.0, 2.2)
        )
        values[f"joint{joint + 1}"] = Estimate(value, low, high)
    return Findings("noise", values, (), tuple(missing))
