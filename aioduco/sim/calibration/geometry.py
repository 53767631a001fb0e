"""The Denavit-Hartenberg table of one arm, from joints and poses that its controller reported.

24 parameters: a, d, alpha and theta of six joints, as deviations from the model's. Joints 2, 3 and
4 are parallel, so that poses show d2 + d3 + d4 but hardly how it is divided: the sum is estimated,
and d3 and d4 stand beside it with a wide prior, so that they widen what depends on them. The base
is the controller's own: its z axis is that of joint 1, and its zero is in d1 and theta1. If only a
tool's tip was reported, without its offset, the offset takes the place of a6, d6, alpha6, theta6.

All parameters are estimated together by least squares. Each has a prior as wide as its bound, so
that a parameter that the poses do not show keeps that width, and passes it on to those that cannot
be told from it. What is not known more closely than `LENGTH` and `ANGLE` is left out.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np

from aioduco.errors import CalibrationError
from aioduco.kinematics import DhCorrections
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.forward import fkine, jacobian
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix, transform
from aioduco.sim.calibration.findings import Findings, deviations
from aioduco.sim.profile import ANGLE_BOUND, GEOMETRY, LENGTH_BOUND, Estimate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.sim.calibration.evidence import Poses

    Flags: TypeAlias = NDArray[np.bool_]


#: half widths of intervals beyond which a parameter counts as not shown [m], [rad]
LENGTH: Final = 1e-4
ANGLE: Final = math.radians(0.01)
#: least half widths: reads of joints and pose are not of one instant [m], [rad]
_LEAST_LENGTH: Final = 1e-6
_LEAST_ANGLE: Final = 2e-6
#: noise of poses above which they do not belong to their joints [m], [rad]
_POOR_LENGTH: Final = 2e-4
_POOR_ANGLE: Final = math.radians(0.03)
#: division of d2 + d3 + d4 that is thought possible [m]
_DIVIDED: Final = 0.001
#: poses that are needed, and every how many of them is held out
_FEWEST: Final = 12
_HELD: Final = 5
#: weights of a first fit, for lack of any noise [m, rad]
_FIRST: Final = 1e-5
#: noise of poses beside that of joints that is tried [m/rad]
_SHAPES: Final = (0.03, 0.1, 0.3, 1.0, 3.0)
#: error of a pose that stands out, as a multiple of the median
_OUT: Final = 6.0
#: errors of held-out poses, as a multiple of the noise, that refuse the fit
_WORSE: Final = 3.0

_NAMES: Final = tuple(f"{column}{i}" for column in DhCorrections._fields for i in range(1, 7))
_LENGTHS: Final = np.array([name[:-1] in ("a", "d") for name in _NAMES])
_D2, _D3, _D4 = (_NAMES.index(name) for name in ("d2", "d3", "d4"))
_LAST: Final = [_NAMES.index(name) for name in ("a6", "d6", "alpha6", "theta6")]


class _Fit(NamedTuple):
    """Parameters with their standard deviations, and what is left over.

    Attributes:
        x: deviations from the model.
        deviations: their standard deviations.
        free: degrees of freedom.
        noise: what is left over of positions [m] and rotations [rad], in the mean.
        shape: noise of the poses beside that of the joints: see `_Problem.whitened`.
        scale: noise of the joints [rad].
    """

    x: Array
    deviations: Array
    free: float
    noise: tuple[float, float]
    shape: float
    scale: float


def estimate_geometry(model: str, sets: Sequence[Poses]) -> Findings:
    """Estimate the geometry of an arm.

    Args:
        model: the arm's model.
        sets: poses of one or more recordings.

    Raises:
        CalibrationError: the poses are not those of such an arm.
    """
    chosen = [each for each in sets if len(each.joints) and not each.tip]
    tip = not chosen
    if tip:
        # One tool for all: two recordings may have had different ones.
        chosen = sorted((each for each in sets if len(each.joints)), key=lambda p: -len(p.joints))
        chosen = chosen[:1]
    if not chosen or sum(len(each.joints) for each in chosen) < _FEWEST:
        count = sum(len(each.joints) for each in chosen)
        return Findings.none(
            "geometry",
            f"geometry: {count} poses at rest with joints are too few, {_FEWEST} are needed: "
            "`aioduco check --motions` reads both at many configurations",
        )
    joints = np.concatenate([each.joints for each in chosen])
    poses = np.concatenate([each.poses for each in chosen])
    problem = _Problem(arm_of(model), joints, poses, tip=tip)
    fit, used = problem.solve(np.ones(len(joints), dtype=bool))
    if fit.noise[0] > _POOR_LENGTH or fit.noise[1] > _POOR_ANGLE:
        raise CalibrationError(
            f"the poses do not fit a {model}: the best table is still off by "
            f"{1000 * fit.noise[0]:.2g} mm and {math.degrees(fit.noise[1]):.2g}°. Another model "
            "(--model), a tool that changed, or poses that were read while the arm moved; no "
            "profile was made"
        )
    edge = np.abs(fit.x[:24]) > np.where(_LENGTHS, LENGTH_BOUND, ANGLE_BOUND)
    if edge.any():
        names = ", ".join(name for name, beyond in zip(_NAMES, edge, strict=True) if beyond)
        raise CalibrationError(
            f"the poses fit a {model} only with {names} off by more than "
            f"{1000 * LENGTH_BOUND:g} mm or {math.degrees(ANGLE_BOUND):g}°: probably it is another "
            "model (--model); no profile was made"
        )
    ratio = problem.held_out(used)
    if ratio > _WORSE:
        return Findings.none(
            "geometry",
            f"geometry: poses that were held out are off by {ratio:.1f} times the noise of "
            "the others: more poses, further apart, would help",
        )
    return _judged(model, fit, int(used.sum()), len(joints), ratio, joints, tip=tip)


class _Problem:
    """The least-squares problem of one arm and its poses."""

    def __init__(self, arm: Arm, joints: Array, poses: Array, *, tip: bool) -> None:
        self._geometry = arm.geometry
        self._joints, self._poses = joints, poses
        self._tool = np.eye(4)
        self._count = 24
        self._prior = np.where(_LENGTHS, 0.5 * LENGTH_BOUND, 0.5 * ANGLE_BOUND)
        self._prior[[_D3, _D4]] = _DIVIDED
        if tip:
            self._tool = np.linalg.inv(fkine(self._geometry, joints[0])) @ poses[0]
            self._count = 30
            self._prior = np.concatenate([self._prior, np.full(6, 0.1)])
            self._prior[_LAST] = 1e-9

    def errors(self, x: Array) -> Array:
        """Errors of positions [m] and rotations [rad] for deviations. Shape (n, 6)."""
        table = x[:24].copy()
        table[_D2] -= table[_D3] + table[_D4]
        columns = (tuple(column) for column in table.reshape(4, 6).tolist())
        corrected = self._geometry._replace(corrections=DhCorrections(*columns))
        tool = self._tool
        if self._count == 30:
            tool = tool @ transform(matrix_from_rotvec(x[27:30]), x[24:27])
        there = fkine(corrected, self._joints) @ tool
        turn = self._poses[:, :3, :3] @ np.swapaxes(there[:, :3, :3], -1, -2)
        return np.concatenate(
            [self._poses[:, :3, 3] - there[:, :3, 3], rotvec_from_matrix(turn)], axis=-1
        )

    def whitened(self, shape: float) -> tuple[Array, Array]:
        """Inverse roots of the poses' covariances for a noise of 1 rad of each joint.

        Noise of the joints appears in a pose by the Jacobian, so that its six numbers belong
        together. Besides, a pose has a noise of its own, `shape` times as large (in m).

        Returns:
            Shape (n, 6, 6), and the logarithms of their determinants, shape (n,).
        """
        matrix = jacobian(self._geometry, self._joints)
        lever = np.einsum(
            "nij,j->ni", fkine(self._geometry, self._joints)[:, :3, :3], self._tool[:3, 3]
        )
        matrix[:, :3] += np.cross(matrix[:, 3:], lever[:, :, None], axis=1)
        own = shape**2 * np.diag([1.0, 1.0, 1.0, 4.0, 4.0, 4.0])
        root = np.linalg.cholesky(matrix @ np.swapaxes(matrix, 1, 2) + own)
        inverse: Array = np.asarray(np.linalg.inv(root), dtype=np.float64)
        return inverse, np.log(np.einsum("nii->ni", inverse)).sum(axis=1)

    def solve(self, used: Flags) -> tuple[_Fit, Flags]:
        """Fit the poses that are used, without those that stand out; return which were used."""
        fit = self._fit(used)
        for _ in range(3):
            size = self._sizes(fit)
            # Few may stand out: beyond that it is the model that does not fit.
            out = used & (size > _OUT * float(np.median(size[used])))
            if not out.any() or out.sum() > 0.1 * used.sum():
                break
            used = used & ~out
            fit = self._fit(used)
        return fit, used

    def _sizes(self, fit: _Fit) -> Array:
        """Error of each pose in units of the noise of a fit. Shape (n,)."""
        roots, _ = self.whitened(fit.shape)
        errors = np.einsum("nij,nj->ni", roots, self.errors(fit.x))
        sizes: Array = np.sqrt((errors**2).mean(axis=1)).astype(np.float64) / fit.scale
        return sizes

    def held_out(self, used: Flags) -> float:
        """Error of poses that were not used in a fit of the others, in units of its noise."""
        held = np.zeros(len(used), dtype=bool)
        held[np.flatnonzero(used)[::_HELD]] = True
        fit = self._fit(used & ~held)
        return float(np.sqrt((self._sizes(fit)[held] ** 2).mean()))

    def _fit(self, used: Flags) -> _Fit:
        from scipy.optimize import least_squares  # noqa: PLC0415 - an extra

        def residuals(u: Array) -> Array:
            joined: Array = np.concatenate([self.errors(u * self._prior)[used].ravel() / _FIRST, u])
            return joined

        first = least_squares(residuals, np.zeros(self._count), method="lm", xtol=1e-10, ftol=1e-10)
        x = first.x * self._prior
        # The second step is from where the first has led.
        return self._best(self._best(x, used).x, used)

    def _best(self, x: Array, used: Flags) -> _Fit:
        """The likeliest of the steps with weights for each shape of noise."""
        errors = self.errors(x)[used]
        changes = np.empty((len(errors), 6, self._count))
        for i, size in enumerate(self._prior):
            step = np.zeros(self._count)
            step[i] = 1e-3 * size
            changes[..., i] = (self.errors(x - step) - self.errors(x + step))[used] / 2e-3
        fits = [self._step(x, used, shape, errors, changes) for shape in _SHAPES]
        return max(fits, key=lambda each: each[0])[1]

    def _step(
        self, x: Array, used: Flags, shape: float, errors: Array, changes: Array
    ) -> tuple[float, _Fit]:
        """One linear step with weights for a shape of noise; its likelihood, and the fit."""
        roots, determinants = self.whitened(shape)
        roots, rows = roots[used], 6 * int(used.sum())
        error = np.einsum("nij,nj->ni", roots, errors).ravel()
        slopes = (roots @ changes).reshape(rows, self._count)
        square, drive, prior = slopes.T @ slopes, slopes.T @ error, x / self._prior
        variance, free = float(error @ error) / rows, float(rows)
        information, step, left = np.eye(self._count), np.zeros(self._count), error
        for _ in range(6):
            information = square / variance + np.eye(self._count)
            step = np.linalg.solve(information, drive / variance - prior)
            left = error - slopes @ step
            free = rows - float(np.trace(np.linalg.solve(information, square))) / variance
            variance = max(float(left @ left) / free, 1e-24)
        _, size = np.linalg.slogdet(information)
        inverse = np.asarray(np.linalg.inv(information), dtype=np.float64)
        # Of some poses the errors are larger than by the mean of all: what each does to the
        # parameters counts as well, by its error without itself (CR3), and the larger one is taken.
        moved = [
            inverse @ of_pose.T @ np.linalg.solve(np.eye(6) - of_pose @ inverse @ of_pose.T, own)
            for of_pose, own in zip(
                slopes.reshape(-1, 6, self._count) / math.sqrt(variance),
                left.reshape(-1, 6) / math.sqrt(variance),
                strict=True,
            )
        ]
        spread = np.square([*moved, *inverse]).sum(axis=0)  # by the poses, and by the prior
        likelihood = determinants[used].sum() - 0.5 * (rows * math.log(variance) + size + free)
        found = x + step * self._prior
        rest = self.errors(found)[used]
        share = math.sqrt(rows / free)
        return float(likelihood), _Fit(
            found,
            self._prior * np.sqrt(np.maximum(np.diag(inverse), spread)),
            free,
            (
                share * math.sqrt(float((rest[:, :3] ** 2).mean())),
                share * math.sqrt(float((rest[:, 3:] ** 2).mean())),
            ),
            shape,
            math.sqrt(variance),
        )


def _judged(
    model: str, fit: _Fit, used: int, count: int, ratio: float, joints: Array, *, tip: bool
) -> Findings:
    nominal = arm_of(model).geometry
    half = deviations(fit.free) * fit.deviations[:24]
    half = np.maximum(half, np.where(_LENGTHS, _LEAST_LENGTH, _LEAST_ANGLE))
    values: dict[str, Estimate] = {}
    lost: list[str] = []
    for i, name in enumerate(_NAMES):
        if name not in GEOMETRY:
            continue
        if half[i] > (LENGTH if _LENGTHS[i] else ANGLE) or (tip and i in _LAST):
            lost.append(name)
            continue
        column, number = name[:-1], int(name[-1]) - 1
        values[name] = Estimate.around(getattr(nominal, column)[number] + fit.x[i], float(half[i]))
    noise = f"{1e6 * fit.noise[0]:.2g} µm and {1e6 * fit.noise[1]:.2g} µrad"
    notes = (
        f"{used} of {count} poses, noise {noise}; held-out ones are off by {ratio:.1f} times that",
        "d2 stands for d2 + d3 + d4: joints 2 to 4 are parallel, and poses show only the sum",
    )
    missing = []
    if lost:
        spans = np.degrees(np.ptp(joints, axis=0))
        still = [f"joint {i + 1} by {span:.0f}°" for i, span in enumerate(spans) if span < 25.0]
        why = f": {', '.join(still)} turned too little" if still else ""
        if tip:
            why = ": no pose of the flange and no offset of the tool was recorded"
        missing.append(f"geometry, {', '.join(lost)}: the poses do not show it{why}")
    return Findings("geometry", values, notes, tuple(missing))
