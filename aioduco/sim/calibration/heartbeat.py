"""The slack of a heartbeat: how much later than its time a controller stops the arm.

It shows where a heartbeat ended in mid motion: the time from the last beat to the moment at which
the set-points slow down, less the heartbeat time that the beat announced.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from aioduco.sim.calibration.findings import Findings
from aioduco.sim.profile import Estimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.calibration.evidence import Evidence, TimedCall


#: longest slack that is looked for [s]
_LONGEST: Final = 10.0
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
    window = (time > due - 0.2) & (time < due + _LONGEST)
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
