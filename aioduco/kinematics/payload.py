"""Mass and centre of mass of what an arm carries, from readings at several poses at rest.

The weight of a load is known but for its mass m, and its torque but for m times its centre c: both
are linear in m and m c. Each sensor has a constant error besides, which is found with them: the
force sensor's after taring, and for each joint that of friction and of the controller's model.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.errors import CalibrationError, ParameterError
from aioduco.kinematics.catalogue import arm_given
from aioduco.kinematics.measured import bound, rigid_frames
from aioduco.kinematics.mounting import GRAVITY
from aioduco.models.load import Load
from aioduco.models.numpy_on_use import number_array
from aioduco.models.ranges import JOINTS, PAYLOAD
from aioduco.models.rotation import Array, crossing
from aioduco.models.rules import Number, Vector, VectorLike

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics.arm import Arm
    from aioduco.models.pose import JointsLike, PoseLike


MIN_POSES = 6
_DOWN = (0.0, 0.0, -GRAVITY)
_GRAVITY = Vector(Number(unit="m/s²", source="this package"), length=3, source="this package")
_MIN_TURN = 0.2  # smallest root mean square of gravity's turn in the flange's frame [rad]
#: smallest root mean square of how far the torques of 1 kg, and of 1 kg at 0.1 m, differ between
#: poses [N m]
_MIN_CHANGE = 0.15
_ARM = 0.1  # distance of a load's centre that its torque is measured by [m]


class MeasuredLoad(NamedTuple):
    """A load, and how sure it is.

    Attributes:
        load: its mass, and its centre in the flange's frame [kg, m].
        uncertainty: how far mass and centre may be from the true ones; in 95 of 100 measurements
            each is not further [kg, m]. Errors that are proportional to the weight, such as a
            sensor's wrong scale, are not in it.
        deviations: for each pose, how far the reading is from the load's weight: the largest torque
            [N·m]. A pose that stands out was measured with contact, or while the arm moved.
    """

    load: Load
    uncertainty: tuple[float, float]
    deviations: tuple[float, ...]


def identify_load_by_forces(
    flanges: Sequence[PoseLike | Array] | Array,
    wrenches: Sequence[VectorLike] | Array,
    *,
    gravity: VectorLike = _DOWN,
) -> MeasuredLoad:
    """Compute the load on the force sensor at the flange: the tool, and what it holds.

    Measure at rest in six poses or more, with nothing touched, that tilt the flange by 30 degrees
    or more to several sides. The sensor must not be tared in between.

    Args:
        flanges: for each pose, the flange in the base frame, such as
            `await robot.state.get_flange_pose()`: poses [m, rad], or matrices of shape (4, 4).
        wrenches: for each pose, force and torque on the flange along its axes [N, N·m], such as
            the mean of many readings of `await robot.force.fc_get_ft()`. Shape (n, 6). If the
            sensor's axes are turned against the flange's, turn them first.
        gravity: acceleration of gravity along the base's axes [m/s²]. Shape (3,).
            `aioduco.kinematics.gravity` gives it for other mountings than the floor.

    Returns:
        The load, and how sure it is.

    Raises:
        ParameterError: an argument has a wrong shape or value, or there are fewer than six poses.
        CalibrationError: the poses tilt the flange too little, or about one axis alone, or the
            readings show no load.
    """
    hands = rigid_frames("flanges", flanges, "pose")
    count = _enough("flanges", len(hands))
    read = _rows("wrenches", wrenches, count)
    down = np.swapaxes(hands[:, :3, :3], 1, 2) @ _acceleration(gravity)
    _check_tilts(down)
    forces, torques = _centred(read[:, :3]), _centred(read[:, 3:])
    weights, levers = _centred(down), _centred(-crossing(down))
    mass, mass_spread, _ = _solved(weights.reshape(-1, 1), forces.ravel(), 3 * count - 4)
    moment, moment_spread, errors = _solved(levers.reshape(-1, 3), torques.ravel(), 3 * count - 6)
    spread = np.zeros((4, 4))
    spread[:1, :1], spread[1:, 1:] = mass_spread, moment_spread
    return _measured(np.hstack([mass, moment]), spread, errors.reshape(-1, 3), 3 * count - 6)


def identify_load_by_torques(
    arm: Arm | str,
    joints: Sequence[JointsLike] | Array,
    torques: Sequence[VectorLike] | Array,
    *,
    known: Load | None = None,
    gravity: VectorLike = _DOWN,
) -> MeasuredLoad:
    """Compute the load at the flange from the joint torques that it causes.

    Measure at rest in eight poses or more, with nothing touched, that turn the wrist and the elbow
    by 30 degrees or more.

    Args:
        arm: the arm, from `aioduco.kinematics.arm`, or its model.
        joints: for each pose, the joints [rad]. Shape (n, 6).
        torques: for each pose, the torques on the joints by the load [N·m], such as the mean of
            many readings of `await robot.state.get_ext_torque()`, which are those by the load that
            the controller does not know of. Or measure `get_actual_joints_torque()` at the same
            poses without the load and with it, and give the first minus the second: then errors of
            the controller's model do not count. Shape (n, 6).
        known: load that the controller knows of, the tool's and the held one together, with its
            centre in the flange's frame; it is added. None for no load.
        gravity: acceleration of gravity along the base's axes [m/s²]. Shape (3,).

    Returns:
        The load, and how sure it is.

    Raises:
        ParameterError: an argument has a wrong shape or value, or there are fewer than six poses.
        CalibrationError: the poses differ too little, or the readings show no load.
    """
    q = _configurations(joints)
    count = _enough("joints", len(q))
    read = _centred(_rows("torques", torques, count))
    down = _acceleration(gravity)
    if known is not None:
        if not isinstance(known, Load):
            raise ParameterError("known", known, "a Load, or None")
        known = Load(*PAYLOAD("known", known))
    model = arm_given("arm", arm)
    moves = np.swapaxes(model.jacobian(q), 1, 2)
    turns = model.fkine(q)[:, :3, :3]
    levers = -crossing(down) @ turns
    by_mass, by_moment = moves[:, :, :3] @ down, moves[:, :, 3:] @ levers
    slopes = _centred(np.concatenate([by_mass[:, :, None], by_moment], axis=2))
    scaled = slopes.reshape(-1, 4) * (1.0, _ARM, _ARM, _ARM) / np.sqrt(count)
    if np.linalg.svd(scaled, compute_uv=False)[3] < _MIN_CHANGE:
        raise CalibrationError(
            "the poses differ too little to tell a load's mass and centre by its torques: turn the "
            "joints 2, 3, 5 and 6 by 30 degrees or more between poses"
        )
    # Friction and noise grow with a joint's drive: so they are weighed. How far each joint really
    # disagrees is what the uncertainty comes from, so that it holds with other weights, too.
    sizes = np.array(model.effort) / max(model.effort)
    rows = slopes / sizes[:, None]
    inverse = np.linalg.inv(np.einsum("nij,nik->jk", rows, rows))
    pull = inverse @ np.swapaxes(rows, 1, 2)
    found = np.einsum("njk,nk->j", pull, read / sizes)
    errors = read - slopes @ found
    used = np.einsum("nij,nji->i", rows, pull)
    variances = (errors**2).sum(axis=0) / (count - 1 - used) / sizes**2
    spread = np.einsum("njk,k,nlk->jl", pull, variances, pull)
    if known is not None:
        found += known.mass * np.array([1.0, *known[1:]])
    return _measured(found, spread, errors, 2 * count - 6)


def _measured(found: Array, spread: Array, errors: Array, freedoms: int) -> MeasuredLoad:
    """Give the load of a mass and its moment, m and m c, with their covariance."""
    mass = float(found[0])
    about = bound(spread[:1, :1], freedoms)
    if mass < -about:
        raise CalibrationError(
            f"the mass comes out as {mass:.3f} kg: the readings have the opposite sign, or gravity "
            "has another direction. Negate the readings if they are the forces on what is held"
        )
    if mass <= about:
        raise CalibrationError(
            f"the readings show no load: its mass comes out as {mass:.3f} kg, give or take "
            f"{about:.3f} kg. See that nothing touches the arm, that the sensor is not tared "
            "between poses, and that gravity has the right direction"
        )
    centre = found[1:] / mass
    slope = np.column_stack([-centre, np.eye(3)]) / mass
    off = bound(slope @ spread @ slope.T, freedoms)
    worst = np.abs(errors).max(axis=1)
    return MeasuredLoad(Load(mass, *centre.tolist()), (about, off), tuple(worst.tolist()))


def _solved(rows: Array, read: Array, freedoms: int) -> tuple[Array, Array, Array]:
    """Least squares: the result, its covariance, and the errors."""
    inverse = np.linalg.inv(rows.T @ rows)
    found = inverse @ rows.T @ read
    errors = read - rows @ found
    return found, inverse * (errors @ errors) / freedoms, errors


def _check_tilts(down: Array) -> None:
    """Refuse poses in which gravity's direction says too little about the load."""
    unit = _centred(down / np.linalg.norm(down[0]))
    sizes = np.linalg.svd(unit, compute_uv=False) / np.sqrt(len(down))
    if sizes[1] >= _MIN_TURN:
        return
    way = "about one axis alone" if sizes[0] >= _MIN_TURN else "too little"
    raise CalibrationError(
        f"the poses tilt the flange {way}, so that they leave the load's mass or centre open: tilt "
        "it by 30 degrees or more to at least three sides"
    )


def _centred(values: Array) -> Array:
    """Differences from the mean over the poses: they do without the sensor's constant error."""
    found: Array = values - values.mean(axis=0)
    return found


def _acceleration(gravity: VectorLike) -> Array:
    down = np.array(_GRAVITY("gravity", gravity))
    if not 1.0 < float(np.linalg.norm(down)) < 100.0:
        raise ParameterError("gravity", gravity, "three numbers [m/s²], such as (0, 0, -9.81)")
    return down


def _enough(name: str, count: int) -> int:
    if count < MIN_POSES:
        raise ParameterError(name, f"{count} poses", f"{MIN_POSES} or more")
    return count


def _configurations(given: Any) -> Array:
    """Joints of each pose [rad]. Shape (n, 6)."""
    if not isinstance(given, Iterable):
        raise ParameterError("joints", given, "six joint positions in rad for each pose")
    found = [JOINTS(f"joints[{number}]", each) for number, each in enumerate(given)]
    return np.array(found).reshape(-1, 6)


def _rows(name: str, given: Any, count: int) -> Array:
    """Readings of six numbers each. Shape (n, 6)."""
    expected = f"six finite numbers for each of {count} poses"
    try:
        found = number_array(name, [[*each] for each in given], expected)
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(name, type(given).__name__, expected) from error
    if found.shape != (count, 6) or not np.isfinite(found).all():
        raise ParameterError(name, f"an array of shape {found.shape}", expected)
    return found
