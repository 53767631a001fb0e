"""Friction of the joints, and the load at the flange, from torques that a controller reported.

Friction: while one joint alone turns at constant speed, its torque is its weight, which is a
constant and a sine and a cosine of its angle, plus friction against the motion. Both directions
over the same angles tell them apart, two speeds the viscous part from the dry part. No mass is
needed for it.

Load: at rest, torques are the weight of links and load. The links' masses are the model's: what a
load seems to weigh beyond its interval is in the masses of the links.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np

from aioduco.errors import CalibrationError
from aioduco.kinematics.forward import frames
from aioduco.kinematics.mounting import GRAVITY
from aioduco.kinematics.payload import identify_load_by_torques
from aioduco.sim.calibration.findings import Findings, deviations
from aioduco.sim.profile import Estimate

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.calibration.evidence import Evidence

    Flags: TypeAlias = NDArray[np.bool_]


#: speed below which a joint rests, and above which it turns [rad/s]
_REST: Final = 3e-3
_TURNS: Final = 0.03
#: change of speed within the time around a read that is still constant [rad/s]
_CONSTANT: Final = 5e-3
_AROUND: Final = 0.05
#: reads that are needed
_FEWEST: Final = 20
#: motions that are needed besides one for each value
_SPARE: Final = 2
#: difference of the other joints between two configurations [rad]
_SAME_PLACE: Final = 5e-3
#: pause that ends a motion [s], and the largest rounding of a recorded speed [rad/s]
_PAUSE: Final = 0.3
_ROUNDED: Final = 0.5 * 2.0**-10
#: least half widths of a mass [kg] and its centre [m]: a standing arm's drives swing a little
_LEAST: Final = (1e-3, 2e-4)
#: share of the links' torques that may be left over
_OTHER: Final = 0.02
#: half width beyond which friction is left out: a share of the joint's torques, or this [N m]
_LOOSE: Final = 0.25


class _Torques(NamedTuple):
    """Torques with joints and speeds at the same times. Shapes (n, 6)."""

    torque: Array
    joints: Array
    speed: Array
    steady: Flags  # whether no joint changed its speed. Shape (n,)
    resting: Flags  # whether the arm rested at that time and before. Shape (n,)
    time: Array  # [s]. Shape (n,)


def _torques(runs: Sequence[Evidence]) -> _Torques:
    parts = [part for run in runs if (part := _of(run)) is not None]
    if not parts:
        nothing = np.zeros((0, 6))
        none = np.zeros(0, dtype=bool)
        return _Torques(nothing, nothing, nothing, none, none, np.zeros(0))
    return _Torques(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _of(run: Evidence) -> _Torques | None:
    time = run.motions.time
    if len(time) < 2 or not len(run.torques.begin):
        return None
    at = 0.5 * (run.torques.begin + run.torques.end)
    inside = (at > time[0] + _AROUND) & (at < time[-1] - _AROUND)
    at, torque = at[inside], run.torques.values[inside]

    def sampled(column: Array, shift: float = 0.0) -> Array:
        return np.stack([np.interp(at + shift, time, column[:, i]) for i in range(6)], axis=1)

    before, speed, after = (sampled(run.motions.speed, s) for s in (-_AROUND, 0.0, _AROUND))
    change = np.maximum(np.abs(speed - before), np.abs(after - speed)).max(axis=1)
    resting = np.maximum(np.abs(before), np.abs(speed)).max(axis=1) < _REST
    joints = sampled(run.motions.joints)
    return _Torques(torque, joints, speed, change < _CONSTANT, resting, at)


def estimate_friction(runs: Sequence[Evidence]) -> Findings:
    """Estimate dry and viscous friction of each joint.

    Args:
        runs: what the recordings say.
    """
    data = _torques(runs)
    values: dict[str, Estimate] = {}
    missing: list[str] = []
    for joint in range(6):
        name = f"friction of joint {joint + 1}"
        fast = np.abs(data.speed)
        others = np.delete(fast, joint, axis=1)
        alone = data.steady & (fast[:, joint] > _TURNS) & (others < _REST).all(axis=1)
        q, qd, torque = (a[alone, joint] for a in (data.joints, data.speed, data.torque))
        ways = (qd > 0).sum(), (qd < 0).sum()
        if min(ways) < _FEWEST:
            missing.append(
                f"{name}: {min(ways)} torques at constant speed in one of its directions, "
                f"{_FEWEST} are needed"
            )
            continue
        if np.ptp(np.abs(qd)) < 0.5 * np.abs(qd).max():
            missing.append(f"{name}: it turned at one speed only, two are needed")
            continue
        # Where other joints stand elsewhere, the weight is another one: one for each of them.
        apart = np.abs(np.diff(data.time[alone])) > _PAUSE
        motions = np.concatenate([[0], np.cumsum((np.diff(np.sign(qd)) != 0) | apart)])
        standing = _means(np.delete(data.joints[alone], joint, axis=1), motions)
        near = np.abs(standing[:, None] - standing).max(axis=2) < _SAME_PLACE
        places = np.eye(len(near))[np.unique(near.argmax(axis=1), return_inverse=True)[1][motions]]
        places = places[:, places.any(axis=0)]
        between = np.concatenate([np.sign(qd)[:, None], qd[:, None], places], axis=1)
        within = np.concatenate([places * np.cos(q)[:, None], places * np.sin(q)[:, None]], axis=1)
        fit = fit_by_motion(between, within, torque, motions)
        if fit is None:
            missing.append(f"{name}: too few motions for the configurations")
            continue
        found, halves = fit[0][:2], fit[1][:2]
        # At constant speed, the rounding of the recorded speed is constant, too.
        halves += abs(found[1]) * _ROUNDED * np.array([1.0, 1.0 / np.abs(qd).min()])
        largest = float(abs(found[0]) + abs(found[1]) * np.abs(qd).max())
        if max(halves[0], halves[1] * np.abs(qd).max()) > max(_LOOSE * largest, 0.02):
            missing.append(f"{name}: not above the noise of the torques")
            continue
        for kind, i in (("dry", 0), ("viscous", 1)):
            value, half = float(found[i]), max(float(halves[i]), 1e-4)
            values[f"{kind}{joint + 1}"] = Estimate(
                max(value, 0.0), value - half, max(value + half, 0.0)
            )
    return Findings("friction", values, (), tuple(missing))


def fit_by_motion(
    between: Array, within: Array, torque: Array, motions: NDArray[np.intp]
) -> tuple[Array, Array] | None:
    """Fit torques whose errors are of two kinds: one of each motion, one of each read.

    An arm that still swings or warms up has an error that lasts a motion, so that a motion is one
    observation, however many reads it has: Student's t is that of the motions. What changes within
    motions is found from the differences within them, which these errors leave alone.

    Args:
        between: columns that are constant within a motion. Shape (n, k).
        within: columns that are not. Shape (n, m).
        torque: the torques [N m]. Shape (n,).
        motions: number of the motion of each row, from 0. Shape (n,).

    Returns:
        The k values of `between`, and the half widths of their intervals; None if there are fewer
        than two motions more than values.
    """
    count = np.bincount(motions)
    rows, other = _means(between, motions), _means(within, motions)
    mean = _means(torque[:, None], motions)[:, 0]
    changing = within - other[motions]
    slopes, *_ = np.linalg.lstsq(changing, torque - mean[motions], rcond=None)
    left = torque - mean[motions] - changing @ slopes
    reads = len(torque) - len(count) - int(np.linalg.matrix_rank(changing))
    free = len(count) - int(np.linalg.matrix_rank(rows))
    if free < _SPARE or reads < 1:
        return None
    inverse: Array = np.asarray(np.linalg.pinv(rows), dtype=np.float64)
    found: Array = inverse @ (mean - other @ slopes)
    off = mean - other @ slopes - rows @ found
    of_motions = np.sqrt(off @ off / free * np.square(inverse).sum(axis=1))
    # By chance the few motions may agree better than their reads allow.
    of_reads = np.sqrt(np.square(inverse) @ (left @ left / reads / count))
    halves = [deviations(n) * each for n, each in ((free, of_motions), (reads, of_reads))]
    return found, np.maximum(*halves)


def _means(columns: Array, motions: NDArray[np.intp]) -> Array:
    """Means of the rows of each motion. Shape (n, k) to (motions, k)."""
    count = np.bincount(motions)
    sums = np.zeros((len(count), columns.shape[1]))
    np.add.at(sums, motions, columns)
    mean: Array = sums / count[:, None]
    return mean


def link_torques(arm: Arm, joints: Array) -> Array:
    """Torques that hold the links of an arm on a floor against their weight.

    Args:
        arm: the arm.
        joints: joint angles [rad]. Shape (n, 6).

    Returns:
        Torques [N m]. Shape (n, 6).
    """
    chain = frames(arm.geometry, joints)
    axis, origin = chain[:, :6, :3, 2], chain[:, :6, :3, 3]
    torques = np.zeros((len(joints), 6))
    theta = np.array(arm.geometry.theta) + joints
    for link in range(6):
        # The frame of the modified convention: turned by the joint, moved along its axis.
        c, s = np.cos(theta[:, link]), np.sin(theta[:, link])
        x, y, z = arm.centres[link + 1]
        local = np.stack(
            [c * x - s * y, s * x + c * y, np.full_like(c, z + arm.geometry.d[link])], axis=1
        )
        centre = chain[:, link, :3, 3] + np.einsum("nij,nj->ni", chain[:, link, :3, :3], local)
        lifting = GRAVITY * np.cross(axis, centre[:, None] - origin)[..., 2]
        torques[:, : link + 1] += arm.masses[link + 1] * lifting[:, : link + 1]
    return torques


def estimate_load(arm: Arm, runs: Sequence[Evidence]) -> Findings:
    """Estimate mass and centre of what the flange carries, from torques at rest.

    Args:
        arm: the arm, on a floor.
        runs: what the recordings say.
    """
    rows = [row for run in runs for row in _resting(run)]
    if len(rows) < _FEWEST:
        return Findings.none("load", f"load: {len(rows)} torques at rest, {_FEWEST} are needed")
    joints, torque = (np.array(column) for column in zip(*rows, strict=True))
    links = link_torques(arm, joints)
    try:
        found = identify_load_by_torques(arm, joints, links - torque)
    except CalibrationError as error:
        return Findings.none("load", f"load: {error}; or the masses of the links are others")
    mass, *centre = found.load
    half, spread = (each + least for each, least in zip(found.uncertainty, _LEAST, strict=True))
    rest = float(np.median(found.deviations))
    if rest > _OTHER * float(np.abs(links).max()) or half > max(0.1 * mass, 0.1):
        return Findings.none(
            "load",
            f"load: the torques at rest leave {rest:.2g} N m over, so that its mass is known to "
            f"{half:.2g} kg only: the masses of the links are others, or friction at rest is large",
        )
    values = {"mass": Estimate.around(mass, half)}
    values |= {n: Estimate.around(c, spread) for n, c in zip("xyz", centre, strict=True)}
    return Findings(
        "load", values, (f"load: {len(joints)} configurations, {rest:.2g} N m are left over",)
    )


def _resting(run: Evidence) -> Iterator[tuple[Array, Array]]:
    """Joints and torques at rest, one of each stretch of rest."""
    data = _of(run)
    if data is not None:
        still = data.resting & data.torque.any(axis=1)
        for i in _last_of_each(still, data.joints):
            yield data.joints[i], data.torque[i]


def _last_of_each(still: Flags, joints: Array) -> Iterator[int]:
    last: int | None = None
    for i in np.flatnonzero(still):
        if last is not None and np.abs(joints[i] - joints[last]).max() > 1e-3:
            yield last
        last = int(i)
    if last is not None:
        yield last
