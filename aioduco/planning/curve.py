"""The geometric path of a plan: a smooth curve of the joints, and whether all of it is free."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.planning.spaces import JointPathSpace, PathSpace
from aioduco.planning.spline import BSpline

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from aioduco.planning.collision import CollisionChecker

    Points = NDArray[np.float64]


_DEGREE = 3
_WIDEST = 0.3  # longest spans, where nothing is near [m of the arm's furthest point, about]
_NARROWEST = 0.004
_SEEN = 0.06  # largest distance that is measured along a curve [m]
_REACH = 1.9  # between two places, as a multiple of the distance that is kept at both
_LEAST = 5e-5  # between two places of a path on which bodies nearly touch [m]
_FIT = 0.01  # between two configurations that a curve of joints goes through [m, about]


def rounded(corners: Points, space: PathSpace, checker: CollisionChecker) -> BSpline | None:
    """Give a smooth curve along a path with corners, as round as the scene allows.

    Each corner is cut by a cubic B-spline, which keeps straight parts straight. Where the curve
    would touch something, its spans are halved, which brings it closer to the corner.

    Args:
        corners: corners of the path. Shape (n, dimensions).
        space: space of the path.
        checker: collision checker of the scene.

    Returns:
        A curve of points; None if not even the path with its corners is free.
    """
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    corners = corners[np.concatenate([[True], steps > 1e-9])]
    lengths = np.concatenate([[0.0], np.cumsum(steps[steps > 1e-9])])
    total = float(lengths[-1])
    inner = np.linspace(0.0, total, max(int(np.ceil(total / _WIDEST)), 2) + 1)
    known: dict[tuple[float, ...], bool] = {}
    while True:
        knots = np.concatenate([[0.0] * _DEGREE, inner, [total] * _DEGREE])
        middle = np.mean([knots[i : len(knots) - 1 - _DEGREE + i] for i in range(1, 4)], axis=0)
        control = np.column_stack([np.interp(middle, lengths, axis) for axis in corners.T])
        curve = BSpline(knots, control, _DEGREE)
        halved: set[int] = set()
        for span in range(len(inner) - 1):
            # The span depends on these knots alone, so an earlier result is still valid.
            key = tuple(knots[span + 1 : span + 7].tolist())
            if key not in known:
                known[key] = is_free(curve, space, checker, inner[span], inner[span + 1])
            if not known[key]:
                halved |= {span - 1, span, span + 1}
        if not halved:
            return curve
        spans = np.diff(inner)
        chosen = [i for i in sorted(halved) if 0 <= i < len(spans) and spans[i] > _NARROWEST]
        if not any(known_bad in chosen for known_bad in halved) or not chosen:
            return None
        inner = np.sort(np.concatenate([inner, [0.5 * (inner[i] + inner[i + 1]) for i in chosen]]))


def is_free(
    curve: BSpline, space: PathSpace, checker: CollisionChecker, begin: float, end: float
) -> bool:
    """Tell whether a part of a curve is free, also between the places that are checked.

    At each checked place nothing is within the padding, or within what is kept of it near an end.
    Between two consecutive places no point of the arm moves further than twice that, or than the
    sum of the distances measured at both minus twice that, or than 0.05 mm. So few places are
    checked where nothing is near.

    Args:
        curve: curve of points of the space, over a length.
        space: the space.
        checker: collision checker of the scene.
        begin, end: ends of the part.
    """
    reach = _REACH * checker.padding
    count = max(int(np.ceil((end - begin) / reach)), 1) + 1
    while True:
        at = np.linspace(begin, end, count)
        q = space.joints(curve(at))
        if q is None:
            return False
        steps = np.abs(np.diff(q, axis=0)) @ checker.radii
        furthest = float(steps.max())
        if furthest <= reach:
            break
        if furthest > 1.0 and count > 64:
            return False  # a jump, not a curve
        count = int(np.ceil((count - 1) * furthest / reach)) + 2
    moved: list[float] = np.concatenate([[0.0], np.cumsum(steps)]).tolist()
    with checker.looking_within(_SEEN) as distance:

        def look(q: Points, at: float, moved: float) -> _Place:
            return _Place(q, at, moved, distance(q.tolist()), checker.kept(q))

        first, last = (look(q[i], at[i], moved[i]) for i in (0, -1))
        if not (first.free and last.free):
            return False
        todo = deque([(0, first, count - 1, last)])
        # The widest gap first: checks that are far apart find an obstacle soonest.
        while todo:
            low, before, high, after = todo.popleft()
            if _joined(before, after):
                continue
            if high - low < 2:
                if not _free_between(curve, space, look, before, after, checker.radii):
                    return False
                continue
            middle = (low + high) // 2
            there = look(q[middle], at[middle], moved[middle])
            if not there.free:
                return False
            todo += [(low, before, middle, there), (middle, there, high, after)]
    return True


class _Place(NamedTuple):
    """A place of a curve that was checked.

    Attributes:
        q: joints [rad]. Shape (6,).
        at: its length along the curve.
        moved: how far a point of the arm may have moved up to here [m].
        distance: distance to the nearest thing [m].
        kept: distance that has to be kept here [m].
    """

    q: Points
    at: float
    moved: float
    distance: float
    kept: float

    @property
    def free(self) -> bool:
        return self.distance > self.kept


def _joined(before: _Place, after: _Place) -> bool:
    """Whether nothing can be touched between two places, as no point of the arm moves so far."""
    kept = min(before.kept, after.kept)
    return after.moved - before.moved <= max(
        _REACH * kept, before.distance + after.distance - 2.0 * kept, _LEAST
    )


def _free_between(
    curve: BSpline,
    space: PathSpace,
    look: Callable[[Points, float, float], _Place],
    before: _Place,
    after: _Place,
    radii: Points,
) -> bool:
    """Whether a curve is free between two places that are closer than the padding needs."""
    todo = [(before, after)]
    while todo:
        before, after = todo.pop()
        if _joined(before, after):
            continue
        at = 0.5 * (before.at + after.at)
        found = space.joints(curve(np.array([at])))
        if found is None:
            return False
        q = found[0]
        # Measured anew, since the finer steps of a bent path are longer together.
        steps = [float(np.abs(q - place.q) @ radii) for place in (before, after)]
        there = look(q, at, before.moved + steps[0])
        if not there.free:
            return False
        todo += [(before, there), (there, after._replace(moved=there.moved + steps[1]))]
    return True


def joint_curve(curve: BSpline, space: PathSpace) -> BSpline | None:
    """Convert a curve of points to one of joints [rad], over the same length.

    Args:
        curve: curve of points of the space.
        space: the space.

    Returns:
        The curve; None if the arm does not reach all of it.
    """
    if isinstance(space, JointPathSpace):
        return BSpline(curve.knots, space.joints(curve.control), _DEGREE)
    begin, end = curve.begin, curve.end
    at = np.linspace(begin, end, max(int((end - begin) / _FIT), 8) + 1)
    q = space.joints(curve(at))
    return None if q is None else BSpline.through(at, q)
