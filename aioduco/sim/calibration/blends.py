"""How a controller cuts the corner between two motions that blend.

Motions are lines, of the joints or of the tip. In the plane of a corner, what is left of the first
line and what was gone of the second are seen in each set-point. The simulator (`planner.blending`)
lets one fade out evenly while the other fades in, which is a parabola: the sum of the roots of
both, each as a share of the reach, is one. So each set-point says the reach, and its speed says how
fast the corner is passed. No times are needed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from aioduco.sim.calibration.findings import Findings, mean_of, not_played, played

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.calibration.evidence import Corner, Evidence
    from aioduco.sim.profile import Estimate


#: corners that are needed, and the largest of their radii as a multiple of the smallest
_CORNERS: Final = 4
_APART: Final = 1.3
#: parts of a corner that count, from 0 to 1 along it: all for its shape, the middle for its size
_WHOLE, _MIDDLE = (0.15, 0.85), (0.35, 0.65)
#: set-points that are needed in the middle of a corner
_FEWEST: Final = 3
#: distance of a set-point from the plane of a corner as a share of the radius
_OFF: Final = 0.03
#: what a corner may differ from a parabola, and from the other corners, as shares of the radius
_SHAPE: Final = 0.05
_ALIKE: Final = 0.1
#: share of the speed that a motion must reach, and that a corner limited by acceleration has not
_CRUISE: Final = 0.98
_FREE: Final = 0.95
#: step by which a speed is applied to a set-point [s], and the largest speed at rest [rad/s]
_STEP: Final = 1e-3
_REST: Final = 1e-3
#: cosine of the angle between two lines that are one
_ONE_LINE: Final = 0.9
#: places on a line at which distances are computed, and rounds in which a reach is found
_GRID, _ROUNDS = 65, 6
#: least half widths of a reach and of a share
_LEAST: Final = (2e-3, 1e-2)


class _Cut(NamedTuple):
    """How one corner was cut.

    Attributes:
        reach: where the tool left its path, as a share of the radius.
        share: share of the acceleration; None if the speed was the limit.
        shape: largest distance from a parabola, as a share of the radius.
    """

    reach: float
    share: float | None
    shape: float


def estimate_blends(arm: Arm, runs: Sequence[Evidence]) -> Findings:
    """Estimate how corners are cut, between joint moves and between lines.

    Args:
        arm: the arm, with the lengths that are known of it.
        runs: what the recordings say.
    """
    values: dict[str, Estimate] = {}
    notes: list[str] = []
    missing: list[str] = []
    for kind in ("joint", "line"):
        corners = [(run, each) for run in runs for each in run.corners if each.kind == kind]
        cuts = [(each, cut) for run, each in corners if (cut := _cut(arm, run, each)) is not None]
        radii = [each.radius for each, _ in cuts]
        if len(cuts) < _CORNERS or max(radii) < _APART * min(radii):
            missing.append(
                f"blends, {kind}: {len(corners)} corners were recorded, and {len(cuts)} of them "
                f"cut; {_CORNERS} of two radii or more are needed"
            )
            continue
        found = [cut for _, cut in cuts]
        worst, held = max(cut.shape for cut in found), _held_out([cut.reach for cut in found])
        if worst > _SHAPE or held > _ALIKE:
            missing.append(
                f"blends, {kind}: corners are {100 * worst:.0f} % of the radius off a parabola, "
                f"and those held out {100 * held:.0f} % off the others: this controller cuts them "
                "in another way than the simulator"
            )
            continue
        reach = mean_of([cut.reach for cut in found], _LEAST[0])
        if played("blends", f"{kind}_reach", reach) is None:
            missing.append(not_played("blends", f"{kind}_reach", reach))
            continue
        values[f"{kind}_reach"] = reach
        notes.append(
            f"{len(found)} corners of {kind} motions, each held out: reach within "
            f"{100 * held:.1f} % of the radius"
        )
        shares = [cut.share for cut in found if cut.share is not None]
        if len(shares) < _CORNERS:
            missing.append(
                f"blends, share of the acceleration, {kind}: the speed was the limit, or not "
                f"reached, in {len(found) - len(shares)} of {len(found)} corners"
            )
        elif _held_out(shares) > _ALIKE:
            missing.append(
                f"blends, share of the acceleration, {kind}: corners differ by up to "
                f"{100 * _held_out(shares):.0f} % of it"
            )
        else:
            values[f"{kind}_share"] = mean_of(shares, _LEAST[1])
    return Findings("blends", values, tuple(notes), tuple(missing))


def _held_out(values: Sequence[float]) -> float:
    """Largest difference of a value from the mean of the others."""
    total, count = sum(values), len(values)
    return max(abs(each - (total - each) / (count - 1)) for each in values)


def _cut(arm: Arm, run: Evidence, corner: Corner) -> _Cut | None:
    """How a corner was cut; None if it was not, or what was recorded does not show it."""
    motions = run.motions
    during = (motions.time > corner.begin) & (motions.time < corner.end)
    wanted, step = motions.wanted[during], _STEP * motions.wanted_speed[during]
    if run.tool is None or len(wanted) < 2 * _FEWEST or np.abs(step[0]).max() > _STEP * _REST:
        return None
    legs = _Legs(arm, run.tool, corner, wanted[0])
    if not legs.apart:
        return None
    before, places, after = (legs.place(wanted + k * step) for k in (-0.5, 0.0, 0.5))
    part, reach = legs.seen(places)
    off = np.linalg.norm(places - legs.parabola(part, reach), axis=1)
    whole = (part > _WHOLE[0]) & (part < _WHOLE[1]) & (off < _OFF * legs.unit)
    middle = whole & (part > _MIDDLE[0]) & (part < _MIDDLE[1])
    if middle.sum() < _FEWEST:
        return None
    found = float(np.median(reach[middle]))
    if not legs.long_enough(found):
        return None
    shape = np.linalg.norm(places - legs.parabola(part, found), axis=1)[whole].max() / legs.unit
    pace = float(np.median((legs.seen(after)[0] - legs.seen(before)[0])[middle]) / _STEP)
    fastest = float(legs.size((after - before) / _STEP).max())
    return _Cut(found, legs.share(pace, found, fastest), float(shape))


class _Legs:
    """The two lines of a corner: of the joints [rad], or of the tip [m]."""

    def __init__(self, arm: Arm, tool: Array, corner: Corner, start: Array) -> None:
        self._arm, self._tool, self._corner = arm, tool, corner
        ends = (corner.place - self.place(start[None])[0], corner.after - corner.place)
        self._lengths = [float(np.linalg.norm(end)) for end in ends]
        self._ways = np.stack(
            [end / max(n, 1e-9) for end, n in zip(ends, self._lengths, strict=True)]
        )
        along = np.linspace(0.0, 1.0, _GRID)
        self._grid = [along * length for length in self._lengths]
        self._away = [
            self._distance(corner.place + sign * grid[:, None] * way)
            for sign, grid, way in zip((-1.0, 1.0), self._grid, self._ways, strict=True)
        ]
        #: whether the tip leaves the corner along both by the radius, and they are not one line
        self.apart = bool(
            abs(self._ways[0] @ self._ways[1]) < _ONE_LINE
            and all(each[-1] > corner.radius and (np.diff(each) > 0).all() for each in self._away)
        )
        #: what the radius is along the lines, about
        self.unit = float(np.mean(self._reaches(np.ones(1))))

    def place(self, joints: Array) -> Array:
        """Joints, or the tip. Shape (n, 6) to (n, 6) or (n, 3)."""
        return joints if self._corner.kind == "joint" else self._tip(joints)

    def size(self, rates: Array) -> Array:
        """Speeds or accelerations as their limits count them. Shape (n, k) to (n,)."""
        joint = self._corner.kind == "joint"
        found: Array = np.abs(rates).max(axis=1) if joint else np.linalg.norm(rates, axis=1)
        return found

    def seen(self, places: Array) -> tuple[Array, Array]:
        """The part of the corner at each place, from 0 to 1, and the reach that it shows."""
        plane = np.stack([-self._ways[0], self._ways[1]], axis=1)
        left = np.maximum((places - self._corner.place) @ np.linalg.pinv(plane).T, 0.0)
        roots, both, reach = left, np.ones(len(places)), np.ones(len(places))
        for _ in range(_ROUNDS):  # the reach of joints is not quite in proportion to the radius
            roots = np.sqrt(left / self._reaches(reach))
            both = np.maximum(roots.sum(axis=1), 1e-6)
            reach = np.clip(reach * both**2, 1e-3, 1e3)
        return roots[:, 1] / both, reach

    def parabola(self, part: Array, reach: Array | float) -> Array:
        """Places of a corner that is cut with a reach. Shape (n,) to (n, k)."""
        one, two = self._reaches(np.broadcast_to(reach, part.shape)).T
        found: Array = (
            self._corner.place
            - (one * (1.0 - part) ** 2)[:, None] * self._ways[0]
            + (two * part**2)[:, None] * self._ways[1]
        )
        return found

    def long_enough(self, reach: float) -> bool:
        """Whether the corner takes less than half of each line, which is the most it may take."""
        reaches = self._reaches(np.array([reach]))[0]
        return bool((reaches < 0.5 * np.array(self._lengths)).all())

    def share(self, pace: float, reach: float, fastest: float) -> float | None:
        """Share of the acceleration that the bend took; None if the speed was the limit.

        Args:
            pace: parts of the corner per second.
            reach: the reach.
            fastest: highest speed of both motions.
        """
        corner = self._corner
        reaches = self._reaches(np.array([reach]))[0]
        ends = 2.0 * pace * reaches[:, None] * self._ways  # velocities at both ends
        if fastest < _CRUISE * corner.speed or self.size(ends).max() > _FREE * corner.speed:
            return None
        bend = pace * (ends[1] - ends[0])
        return float(self.size(bend[None])[0]) / corner.acceleration

    def _tip(self, joints: Array) -> Array:
        found: Array = (self._arm.fkine(joints) @ self._tool)[:, :3, 3]
        return found

    def _distance(self, places: Array) -> Array:
        """Distance of the tip from the corner. Shape (n, k) to (n,)."""
        tips = self._tip(places) if self._corner.kind == "joint" else places
        found: Array = np.linalg.norm(tips - tips[0], axis=1)
        return found

    def _reaches(self, reach: Array) -> Array:
        """Length on each line at which the tip is a share of the radius away. Shape (n, 2)."""
        radius = reach * self._corner.radius
        return np.stack(
            [
                np.interp(radius, away, grid)
                for away, grid in zip(self._away, self._grid, strict=True)
            ],
            axis=1,
        )
