"""Times of a controller: power, readings, heartbeat; and the precision of its numbers.

Calls and reads have a begin and an end, between which the controller acted. So each observation
bounds a time from both sides, however late this computer was: the bounds of several are combined.

The slack of a heartbeat is how much later than its time a controller stops the arm. It shows where
a heartbeat ended in mid motion: the time from the last beat to the moment at which the set-points
slow down, less the heartbeat time that the beat announced.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from aioduco.models.enums import RobotState
from aioduco.sim.calibration.findings import Findings, mean_of
from aioduco.sim.profile import Estimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array
    from aioduco.sim.calibration.evidence import Evidence, Reads, StateRead, TimedCall


#: state at the end of each change
_ENDS: Final = {
    "power_on": RobotState.DISABLE,
    "enable": RobotState.ENABLE,
    "disable": RobotState.DISABLE,
    "power_off": RobotState.POWER_OFF,
}
#: longest change [s]
_LONGEST: Final = 60.0
#: half width of the interval, as a share of the time, beyond which it is left out
_LOOSE: Final = 0.05
#: time that a controller may take besides: it takes the call, sees that the arm stands, and shows
#: the new state, each in a cycle of its own [s]
_BESIDES: Final = 3e-3
#: changes of readings that are needed in a window, and the windows
_UPDATES: Final = 30
_WINDOWS: Final = 3
#: length of a window, and the longest time between two reads of it [s]
_WINDOW: Final = 1.0
_GAP: Final = 0.05
#: share of reads that may show a change, if their period is longer than that of the reads
_CHANGED: Final = 0.85
#: power of a rhythm, from 0 to 1, above that of chance; and how far windows may differ in it
_NEAR: Final = 0.05
_ALIKE: Final = 0.02
#: longest period that is looked for, and least half width of its interval [s]
_LONGEST_PERIOD: Final = 0.1
_LEAST_PERIOD: Final = 1e-5


def estimate_times(runs: Sequence[Evidence]) -> Findings:
    """Estimate how long changes of power take.

    Args:
        runs: what the recordings say.
    """
    values: dict[str, Estimate] = {}
    missing, notes = [], []
    for name, end in _ENDS.items():
        bounds = [
            found
            for run in runs
            for call in run.calls
            if call.name == name and (found := _bounds(call, end, run.calls, run.states))
        ]
        if not bounds:
            missing.append(f"times, {name}: no such change was recorded with its states")
            continue
        estimate = _combined(bounds)
        half = 0.5 * (estimate.high - estimate.low)
        if half > _LOOSE * estimate.value:
            missing.append(
                f"times, {name}: known to {1000 * half:.0f} ms of {1000 * estimate.value:.0f} ms "
                f"by {len(bounds)} changes: more of them, or more reads of the state, would help"
            )
            continue
        values[name] = estimate
        notes.append(f"{name}: {len(bounds)} changes")
    return Findings("times", values, (", ".join(notes),) if notes else (), tuple(missing))


def _bounds(
    call: TimedCall, end: RobotState, calls: Sequence[TimedCall], states: Sequence[StateRead]
) -> tuple[float, float] | None:
    """Bounds of the time from a call to its state; None if it is not seen before the next call."""
    later = [each.begin for each in calls if each.begin > call.begin]
    limit = min([call.begin + _LONGEST, *later])
    within = [each for each in states if each.end > call.begin and each.begin < limit]
    there = [each for each in within if each.state is end and each.begin >= call.begin]
    if not there:
        return None
    first = min(there, key=lambda each: each.end)
    before = [each.begin for each in within if each.state is not end and each.begin < first.end]
    if not before:
        return None  # it was there already
    # The controller began between begin and end of the call.
    low, high = max(before) - call.end, first.end - call.begin
    return max(low, 0.0), high


def _combined(bounds: Sequence[tuple[float, float]]) -> Estimate:
    # Changes that were watched most closely; a controller that was busy can only have been late.
    close = sorted(bounds, key=lambda each: each[1] - each[0])[: max(3, len(bounds) // 2)]
    lows, highs = np.array(close).T
    low, high = float(lows.min()) - _BESIDES, float(highs.min())
    return Estimate(0.5 * (low + high), low, high)


def estimate_period(sets: Sequence[Reads]) -> Findings:
    """Estimate the period in which a controller updates its readings, from reads in a motion.

    Args:
        sets: reads of the joints, of one or more recordings.
    """
    name = "readings, period"
    windows: list[Array] = []
    interval = 0.0
    for reads in sets:
        for piece in _quick(reads) if len(reads.begin) >= _UPDATES else ():
            moved = np.flatnonzero((np.diff(reads.values[piece], axis=0) != 0.0).any(axis=1))
            begin, end = reads.begin[piece], reads.end[piece]
            interval = max(interval, float(np.median(np.diff(begin))))
            if _UPDATES <= len(moved) < _CHANGED * (len(begin) - 1):
                # The update came after the read before began, and before the read after ended.
                windows.append(0.5 * (begin[moved] + end[moved + 1]))
    periods = _periods(windows, 0.8 / interval) if len(windows) >= _WINDOWS else []
    if periods:
        return Findings("readings", {"period": mean_of(periods, _LEAST_PERIOD)})
    if not interval:
        return Findings.none("readings", f"{name}: too few reads of the joints in one motion")
    return Findings.none(
        "readings", f"{name}: none above twice the {1000 * interval:.1f} ms between two reads"
    )


def _quick(reads: Reads) -> list[slice]:
    """Parts of reads in which one follows the other, and the joints move."""
    moving = np.abs(np.diff(reads.values, axis=0)).max(axis=1) > 0.0
    gaps = np.flatnonzero(np.diff(reads.begin) > _GAP) + 1
    parts = []
    for first, last in zip([0, *gaps], [*gaps, len(reads.begin)], strict=True):
        changes = np.flatnonzero(moving[first : last - 1])
        if len(changes) < _UPDATES:
            continue
        at = first + changes
        # Windows in which the two computers' clocks run alike.
        count = max(1, int((reads.begin[at[-1]] - reads.begin[at[0]]) / _WINDOW))
        edges = np.linspace(at[0], at[-1] + 2, count + 1).astype(int)
        parts += [slice(int(a), int(b)) for a, b in pairwise(edges) if b - a > _UPDATES]
    return parts


def _periods(windows: Sequence[Array], fastest: float) -> list[float]:
    """The period of the rhythm that is in all windows, from each of them; none if there is none."""
    tried = np.arange(1.0 / _LONGEST_PERIOD, fastest, 0.05 / _WINDOW)
    if not len(tried):
        return []
    power = np.array(
        [np.abs(np.exp(-2j * np.pi * np.outer(tried, at)).mean(axis=1)) ** 2 for at in windows]
    )
    mean = power.mean(axis=0)
    best = float(tried[int(mean.argmax())])
    # By chance, the power of n times is 1/n in the mean.
    chance = float(np.mean([1.0 / len(at) for at in windows]))
    if mean.max() < _NEAR + chance * (1.0 + 6.0 / math.sqrt(len(windows))):
        return []
    near = np.abs(tried - best) < _ALIKE * best
    return [1.0 / float(tried[near][int(each[near].argmax())]) for each in power]


def single_precision(sets: Sequence[Reads]) -> bool | None:
    """Whether readings are 32-bit floats; None if there are too few of them."""
    numbers = [each.values.ravel() for each in sets if len(each.begin)]
    if not numbers:
        return None
    values = np.concatenate(numbers)
    values = values[values != 0.0]
    if len(values) < 30:
        return None
    return bool((values.astype(np.float32).astype(float) == values).all())


#: longest slack that is looked for [s]
_LONGEST_SLACK: Final = 10.0
#: share of its speed below which a motion slows down, and least speed of it [rad/s]
_SLOWER: Final = 0.98
_MOVING: Final = 0.03
#: interval of samples above which the moment is not known closely enough [s]
_COARSE: Final = 0.05


def estimate_slack(runs: Sequence[Evidence]) -> Findings:
    """Estimate the slack of the heartbeat from lapses in mid motion.

    Args:
        runs: what the recordings say.
    """
    bounds = [found for run in runs for beat in _last_beats(run) if (found := _lapse(run, beat))]
    if not bounds:
        return Findings.none("heartbeat", "heartbeat, slack: no heartbeat lapsed in mid motion")
    lows, highs = np.array(bounds).T
    # Lapses may differ; the interval holds all of them if they do.
    low, high = float(lows.max()), float(highs.min())
    if low > high:
        low, high = float(lows.min()), float(highs.max())
    return Findings(
        "heartbeat",
        {"slack": Estimate(max(0.5 * (low + high), 0.0), low, max(high, 0.0))},
        (f"heartbeat: {len(bounds)} lapses in mid motion",),
    )


def _last_beats(run: Evidence) -> list[tuple[TimedCall, float]]:
    """Beats after which none came for longer than any slack, with the heartbeat time [s]."""
    beats = sorted(run.beats, key=lambda beat: beat[0].begin)
    following = [*(beat[0].begin for beat in beats[1:]), float("inf")][: len(beats)]
    return [
        (call, time)
        for (call, time), after in zip(beats, following, strict=True)
        if after > call.end + time + 0.05
    ]


def _lapse(run: Evidence, beat: tuple[TimedCall, float]) -> tuple[float, float] | None:
    """Bounds of the slack after a last beat; None if the arm did not stop in mid motion."""
    call, announced = beat
    time = run.motions.time
    speed = np.abs(run.motions.wanted_speed).max(axis=1)
    due = call.begin + announced
    window = (time > due - 0.2) & (time < due + _LONGEST_SLACK)
    at, fast = time[window], speed[window]
    if len(at) < 5 or np.median(np.diff(at)) > _COARSE or fast[0] < _MOVING:
        return None
    cruise = float(np.median(fast[at < due])) if (at < due).any() else float(fast[0])
    slower = np.flatnonzero((fast < _SLOWER * cruise) & (at >= due - 0.02))
    # It must come to rest, and be even before.
    if not len(slower) or slower[0] == 0 or not (fast[slower[0] :] < 0.01).any():
        return None
    first = int(slower[0])
    if fast[:first].min() < _SLOWER * cruise:
        return None
    # The set-point may have begun to slow down up to the part that is allowed above, and what a
    # sample says may be older than the sample by the time between two.
    return float(at[max(first - 3, 0)] - call.end - announced), float(
        at[first] - call.begin - announced
    )
