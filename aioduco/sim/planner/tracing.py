"""From curves of the tool to paths of the joints: inverse kinematics along a curve.

Near a singularity (奇异点规避, manual 1.3.11) `pass_singularities` leaves the curve. Outside the
neighbourhood of the singularity the tool follows the curve. From the entry into the neighbourhood
to the exit, all joints move smoothly to the nearest configuration behind it, and the tool is only
near its curve.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.inverse import BRANCHES, closed_form, shortfall, wrap
from aioduco.models.bounds import outside, shown
from aioduco.sim.planner.motion_limits import joint_limits
from aioduco.sim.planner.path import Path, PlanError, differentiate
from aioduco.sim.planner.slices import LONG_SLICE, slices, yield_now

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.planner.curves import Curve
    from aioduco.sim.planner.timing import PathLimits


SINGULAR = 1e-3
"""Singular value (see `Arm.singularity`) below which a path is refused. An assumption."""

STRIDE = 0.35
"""Largest step of a joint between samples: more is a jump to another branch [rad]."""

_EXACT = 1e-5  # largest deviation of the path from the curve [rad of a joint]
_SPACING = 0.01  # initial distance of samples [m]
_TURNING = 0.05  # initial angle between samples [rad]
_FEWEST, _MOST = 24, 3072  # least and largest number of samples, if no bend needs more
_NAMES = ("shoulder", "elbow", "wrist")
NEAR = 0.08
"""Singular value below which a path passes a singularity in joint space. An assumption."""

_SAMPLES = 600  # samples of the search for the neighbourhoods
_LEAST = 4  # least number of samples on the curve between two neighbourhoods
_PIECES = 96  # polynomials of a passage


def follow(
    arm: Arm,
    q0: Array,
    s: Array,
    flange: Callable[[Array], Array],
) -> Array:
    """Give the joints along a sequence of poses, on the branch and the turn of q0.

    Args:
        arm: the arm.
        q0: joints at the first pose [rad]. Shape (6,).
        s: distances at which the poses are. Shape (n,).
        flange: gives poses of the flange in the base frame. Shape (m,) to (m, 4, 4).

    Returns:
        Joint angles [rad]. Shape (n, 6).

    Raises:
        PlanError: a pose cannot be reached, or the path meets a singularity.
    """
    branch = -1
    q = np.empty((len(s), 6))
    lost: list[int] = []
    beyond = False  # a pose is out of reach from every branch
    for part in slices(len(s)):
        poses = flange(s[part])
        yield_now()
        solutions = closed_form(arm.geometry, poses, float(q0[5]))
        yield_now()
        if branch < 0:
            off = _distance(solutions[0], q0)
            branch = int(np.argmin(off))
            _check_singular(arm, q0[None])
            if off[branch] > 1e-6:
                raise PlanError("parameter", "the motion does not begin where the arm is")
        q[part] = solutions[:, branch]
        missed = np.flatnonzero(np.isnan(q[part]).any(axis=-1))
        if len(missed):
            lost += (part.start + missed).tolist()
            beyond |= bool(np.isnan(solutions[missed]).any(axis=-1).all(axis=-1).any())
        elif not lost:
            # Continue from the end of the previous slice, which is already unwrapped.
            begin = max(part.start - 1, 0)
            q[begin : part.stop] = np.unwrap(q[begin : part.stop], axis=0)
    if lost:
        if not beyond:
            # Every pose is in reach, but with another shoulder, elbow or wrist configuration.
            raise PlanError("singular", "the path passes through a singularity")
        ends = flange(s[[lost[0], lost[-1]]])
        missing = max(shortfall(arm.geometry, end) for end in ends)
        by = f"by at least {missing:.4f} m" if missing > 0.0 else "in these orientations"
        raise PlanError("unreachable", f"the path leaves the reach of the arm, {by}")
    turned: Array = q + 2 * math.pi * np.round((q0 - q[0]) / (2 * math.pi))
    return turned


def _check_singular(arm: Arm, q: Array) -> None:
    values = np.empty((len(q), 3))
    for part in slices(len(q), LONG_SLICE):
        values[part] = np.abs(singular_values(arm.geometry, q[part]))
    if values.min() < SINGULAR:
        place, kind = np.unravel_index(int(values.argmin()), values.shape)
        part_of_way = float(place) / max(len(q) - 1, 1)
        raise PlanError(
            "singular", f"{_NAMES[int(kind)]} singularity {part_of_way:.0%} along the path"
        )


def check_limits(arm: Arm, q: Array) -> None:
    """Raise PlanError where joints of shape (n, 6) are outside the arm's limits."""
    beyond = np.zeros(6, dtype=bool)
    for part in slices(len(q), LONG_SLICE):
        beyond |= outside(q[part], arm.lower, arm.upper).any(axis=0)
    if beyond.any():
        joint = int(np.argmax(beyond))
        raise PlanError(
            "limits",
            f"joint {joint + 1} would leave {shown(arm.lower[joint], low=True)} to "
            f"{shown(arm.upper[joint])} rad",
        )


def trace(arm: Arm, q0: Array, curve: Curve, tool: Array) -> Path:
    """Give the joints' path along a curve of the tool centre point.

    Args:
        arm: the arm.
        q0: joints at the beginning of the curve [rad]. Shape (6,).
        curve: curve of the tool centre point in the base frame.
        tool: tool centre point in the frame of the flange. Shape (4, 4).

    Raises:
        PlanError: unreachable, singular or beyond the joint limits.
    """
    back = np.linalg.inv(tool)

    def joints(s: Array) -> Array:
        return follow(arm, q0, s, lambda part: curve.poses(part) @ back)

    length = curve.length
    count = min(max(length / _SPACING, curve.turning / _TURNING), _MOST)
    path, samples = fit(joints, length, max(count, length / curve.detail))
    _check_singular(arm, samples)
    check_limits(arm, samples)
    return path


def fit(joints: Callable[[Array], Array], length: float, count: float) -> tuple[Path, Array]:
    """Give a path through samples of a function, so many that it is exact between them.

    Args:
        joints: joint angles over distance. Shape (n,) to (n, 6).
        length: distance at the end of the path, which begins at zero.
        count: initial number of samples.

    Returns:
        The path, which is within 10 µrad of the function half-way between its samples; and the
        samples, including those half-way.

    Raises:
        PlanError: the function jumps, or it raises this error itself.
    """
    pieces = math.ceil(max(count, _FEWEST))
    most = max(2 * pieces, _MOST)
    while True:
        # Every second sample only checks the path through the others.
        s = np.linspace(0.0, length, 2 * pieces + 1)
        every = joints(s)
        yield_now()
        q = every[::2]
        steps = [
            np.abs(np.diff(q[part.start : part.stop + 1], axis=0)).max()
            for part in slices(pieces, LONG_SLICE)
        ]
        if max(steps) < STRIDE:
            path = Path.through(q, *differentiate(q, length / pieces), length)
            between = path.sample(s[1::2])[:, 0]
            yield_now()
            if np.abs(between - every[1::2]).max() < _EXACT:
                yield_now()
                return path, every
        if 2 * pieces > most:
            raise PlanError("singular", "the path passes through a singularity")
        pieces *= 2


class _Stretch(NamedTuple):
    """A part of the curve away from singularities: samples, and the joints at both ends."""

    first: int
    last: int
    start: Array
    end: Array


def pass_singularities(arm: Arm, q0: Array, curve: Curve, tool: Array) -> Path:
    """Give the joints' path along a curve of the tool centre point, through singularities.

    Args:
        arm: the arm.
        q0: joints at the beginning of the curve [rad]. Shape (6,).
        curve: curve of the tool centre point in the base frame.
        tool: tool centre point in the frame of the flange. Shape (4, 4).

    Raises:
        PlanError: unreachable, or beyond the joint limits.
    """
    back: Array = np.linalg.inv(tool).astype(np.float64)
    s = np.linspace(0.0, curve.length, _SAMPLES + 1)
    solutions = np.empty((len(s), BRANCHES, 6))
    for piece in slices(len(s)):
        solutions[piece] = closed_form(arm.geometry, curve.poses(s[piece]) @ back, float(q0[5]))
    stretches = _stretches(arm, q0, solutions)
    end = _nearest(solutions[-1], stretches[-1].end if stretches else q0)
    path: Path | None = None
    at, q = 0.0, q0
    for stretch in stretches:
        begin, length = float(s[stretch.first]), float(s[stretch.last] - s[stretch.first])
        part = _exact(arm, stretch.start, curve, back, begin, length)
        if begin > at:
            part = _passage(q, part.sample(np.zeros(1))[0, 0], path, part, begin - at).then(part)
        path = part if path is None else path.then(part)
        at, q = begin + length, stretch.end
    if at < curve.length:
        last = _passage(q, end, path, None, curve.length - at)
        path = last if path is None else path.then(last)
    assert path is not None
    check_limits(arm, path.sample(path.nodes())[:, 0])
    return path


def passing_limits(
    arm: Arm, path: Path, curve: Curve, v: float, a: float, tool: Array
) -> PathLimits:
    """Give the limits of such a path: speed and acceleration along the curve, and the joints' own.

    Where the tool leaves the curve, its way is longer: there it is that much slower along it.

    Args:
        arm: the arm.
        path: result of `pass_singularities`.
        curve: curve of the tool centre point in the base frame.
        v: speed along the curve [m/s].
        a: acceleration along it [m/s²].
        tool: tool centre point in the frame of the flange. Shape (4, 4).
    """
    nodes = path.nodes()
    joints = path.sample(nodes)
    there, meant = np.empty((len(nodes), 3)), np.empty((len(nodes), 3))
    for part in slices(len(nodes), LONG_SLICE):
        there[part] = (arm.fkine(joints[part, 0]) @ tool)[:, :3, 3]
        meant[part] = curve.poses(nodes[part])[:, :3, 3]
    went, way = (np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (there, meant))
    # A curve that only turns has no way: its unit is the radian.
    longer = np.maximum(went / np.maximum(way, np.diff(nodes)), 1.0)
    around = np.maximum(np.append(longer, 1.0), np.append(1.0, longer))
    limits = joint_limits(arm, nodes, joints, math.inf, math.inf, top=(v / around) ** 2)
    return limits._replace(total=(a / longer).tolist())


def _stretches(arm: Arm, q0: Array, solutions: Array) -> list[_Stretch]:
    """Find the parts of a curve that are away from singularities, each on its branch."""
    count = len(solutions)
    away = np.abs(singular_values(arm.geometry, solutions)).min(axis=-1)
    usable = np.nan_to_num(away, nan=0.0) >= NEAR  # (n, 8)
    joined = _distance(solutions[1:], solutions[:-1]) < STRIDE  # (n - 1, 8)
    yield_now()
    found: list[_Stretch] = []
    q, i = q0, 0
    while i < count:
        branch = int(_distance(solutions[i], q).argmin())
        if not usable[i, branch]:
            i += 1  # still near the singularity
            if i % _LEAST == 0:
                yield_now()
            continue
        j = i
        while j + 1 < count and usable[j + 1, branch] and joined[j, branch]:
            j += 1
        if j - i >= _LEAST or (j == count - 1 and j > i):
            track = np.unwrap(solutions[i : j + 1, branch], axis=0)
            track += 2 * math.pi * np.round((q - track[0]) / (2 * math.pi))
            found.append(_Stretch(i, j, track[0], track[-1]))
            q = track[-1]
        i = j + 1
        yield_now()
    return found


def _distance(solutions: Array, q: Array) -> Array:
    """Distance from joints to solutions: the largest turn of a joint [rad]; infinite for none."""
    furthest: Array = np.nan_to_num(np.abs(wrap(solutions - q)).max(axis=-1), nan=np.inf)
    return furthest


def _nearest(solutions: Array, q: Array) -> Array:
    """Give the solution nearest to joints, on their turn."""
    distance = _distance(solutions, q)
    if not np.isfinite(distance).any():
        raise PlanError("unreachable", "the path ends out of the reach of the arm")
    found: Array = q + wrap(solutions[int(distance.argmin())] - q)
    return found


def _exact(
    arm: Arm,
    q: Array,
    curve: Curve,
    back: Array,
    begin: float,
    length: float,
) -> Path:
    """Give the path along a part of the curve; its distances begin at zero."""

    def joints(s: Array) -> Array:
        return follow(arm, q, s, lambda part: curve.poses(begin + part) @ back)

    path, _ = fit(joints, length, length / curve.detail)
    return path


def _passage(q0: Array, q1: Array, before: Path | None, behind: Path | None, length: float) -> Path:
    """Give a smooth joint path from one path to another; straight at an end without a path."""
    straight = (q1 - q0) / length
    q, slope, bend = np.array([q0, q1]), np.array([straight, straight]), np.zeros((2, 6))
    if before is not None:
        slope[0], bend[0] = before.sample(np.array([before.end]))[0, 1:]
    if behind is not None:
        slope[1], bend[1] = behind.sample(np.array([behind.start]))[0, 1:]
    whole = Path.through(q, slope, bend, length)
    samples = whole.sample(np.linspace(0.0, length, _PIECES + 1))
    return Path.through(samples[:, 0], samples[:, 1], samples[:, 2], length)
