"""Whether the arm kept the promise, by its positions alone; `.ci/freeze-matrix` states the rule."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .arm import Seen
from .cells import CYCLE, Cell

HOLDS, GOES_ON, BREAKS, ERROR = "holds", "goes on", "BREAK", "error"

#: way from which an arm has moved [rad]
MOVED = 2e-3
#: way within which an arm stands [rad], and for how long before the thaw, and at rest [s]
_STILL, _BEFORE, _REST = 5e-4, 0.1, 0.3
#: time from the thaw within which a moving arm must have come to rest [s]
REST_LIMIT = 3.0

#: defaults of `loop_stall_limit`, of a worker's `away_limit`, and of a stream's `hold`, for which
#: its program may be late [s]
_STALL, _AWAY, _HOLD, _SPEED_HOLD = 1.0, 0.25, 0.5, 0.1
#: heartbeat time and slack, after which the controller stops the arm [s]
_HEARTBEAT = 1.5


class Line(NamedTuple):
    """What the program said: when [s], the kind, and more about it."""

    at: float
    what: str
    text: str = ""


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of a run.

    Attributes:
        kind: HOLDS, GOES_ON, BREAKS or ERROR.
        text: the figures, for people.
        stood: whether the arm stood at the thaw.
        moved: largest way of a joint from where it was at the thaw [rad].
        rest: time from the thaw until the arm came to rest [s]; infinite if it did not.
    """

    kind: str
    text: str
    stood: bool = False
    moved: float = 0.0
    rest: float = math.inf


def limit(cell: Cell, variant: int) -> float:
    """The shortest time after which what is frozen counts as gone, by the documentation [s]."""
    # of a stream through the queue in points, one a millisecond
    queued = (_HOLD, _SPEED_HOLD)[variant] * CYCLE / 1e-3
    program = {"servo": _HOLD, "realtime": min(queued, _STALL), "speed": _SPEED_HOLD}
    limits = {"program": program.get(cell.scene, _STALL), "worker": _AWAY, "guard": _HEARTBEAT}
    return min(limits[role] for role in cell.roles)


def goes_on_by_design(cell: Cell, variant: int, seconds: float) -> bool:
    """Whether the arm may move after the thaw as if nothing had been: no limit has passed."""
    frozen = cell.how not in ("killed", "suspended")
    return frozen and seconds < limit(cell, variant)


class Way:
    """What was seen of an arm."""

    def __init__(self, seen: Seen) -> None:
        self.times: NDArray[np.float64] = seen[:, 0]
        self._joints: NDArray[np.float64] = seen[:, 2:]
        self._lags: NDArray[np.float64] = seen[:, 0] - seen[:, 1]

    def index(self, at: float) -> int:
        """The last cycle that had been seen at a time."""
        return max(int(np.searchsorted(self.times, at, "right")) - 1, 0)

    def spread(self, begin: float, end: float) -> float:
        """Largest way of a joint from where it was at `begin`, until `end` [rad]."""
        return float(self.away(begin)[: self.index(end) - self.index(begin) + 1].max(initial=0.0))

    def away(self, begin: float) -> NDArray[np.float64]:
        """The same in each cycle from `begin` on [rad]."""
        first = self.index(begin)
        away: NDArray[np.float64] = np.abs(self._joints[first:] - self._joints[first]).max(axis=1)
        return away

    def left(self, begin: float) -> float:
        """When it had moved since `begin`; infinite if it has not [s]."""
        beyond = np.flatnonzero(self.away(begin) >= MOVED)
        return float(self.times[self.index(begin) + beyond[0]]) if beyond.size else math.inf

    def rests(self, begin: float) -> float:
        """When it first stood still for a while since `begin`; infinite if it did not [s]."""
        while begin + _REST <= self.times[-1]:
            if self.spread(begin, begin + _REST) <= _STILL:
                return begin
            begin += 0.02
        return math.inf

    def moved_last(self, begin: float) -> float:
        """Time after `begin` from which it has not left its last place; 0: it never did [s]."""
        first = self.index(begin)
        away = np.abs(self._joints[first:] - self._joints[-1]).max(axis=1)
        beyond = np.flatnonzero(away > _STILL)
        return float(self.times[first + beyond[-1]] - begin) if beyond.size else 0.0

    def speed(self) -> float:
        """Speed of the fastest joint when it was last seen [rad/s]; 0 if it was not."""
        if not self.times.size:
            return 0.0
        end = float(self.times[-1])
        return self.spread(end - _BEFORE, end) / _BEFORE

    def late(self, begin: float, end: float) -> float:
        """By how much the simulator fell behind, or was not seen, from `begin` to `end` [s]."""
        part = slice(self.index(begin), self.index(end) + 2)  # and what came next
        gaps = np.diff(self.times[part])
        return float(max(np.ptp(self._lags[part]), gaps.max(initial=0.0)))


def judge(
    cell: Cell,
    variant: int,
    way: Way,
    moments: tuple[float, float],
    said: Sequence[Line],
    rest_limit: float = REST_LIMIT,
) -> Verdict:
    """Judge a run."""
    frozen, thawed = moments
    stood = way.spread(thawed - _BEFORE, thawed) <= _STILL
    moved = way.spread(thawed, way.times[-1])
    began = thawed if stood else way.rests(thawed)
    rest = began - thawed
    if rest > rest_limit:
        what, onset = f"still moving {rest_limit:g} s after the thaw", thawed + rest_limit
    elif (onset := way.left(began)) < math.inf:
        what = f"{'stood' if stood else 'came to rest'}, and moved after {onset - thawed:.2f} s"
    elif stood:
        return Verdict(HOLDS, f"stood, {1e3 * moved:.1f} mrad", stood, moved, rest)
    else:
        text = f"came to rest in {rest:.2f} s, {1e3 * moved:.0f} mrad"
        return Verdict(HOLDS, text, stood, moved, rest)
    text = f"moved {1e3 * moved:.0f} mrad"
    if goes_on_by_design(cell, variant, thawed - frozen):
        return Verdict(GOES_ON, f"{text}, no limit has passed", stood, moved, rest)
    if _commanded(cell, frozen, onset, said):
        return Verdict(GOES_ON, f"{text}, commanded meanwhile", stood, moved, rest)
    return Verdict(BREAKS, f"{what}: {text}", stood, moved, rest)


def _commanded(cell: Cell, frozen: float, onset: float, said: Sequence[Line]) -> bool:
    """Whether a program that ran all the time had commanded the motion since, and was not told."""
    if "program" in cell.roles or cell.how == "killed":
        return False
    told = min((line.at for line in said if line.what == "told"), default=math.inf)
    return any(line.what == "command" and frozen < line.at <= onset < told for line in said)
