"""Tip and axes of a tool, found by touching one fixed point with it.

For a tip t in the flange's frame and a point x, each touch says that R t + p = x, where R and p are
the flange's rotation and place. That is linear in t and x, so there is one best answer. Its
uncertainty follows from how far the touches disagree.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.errors import CalibrationError, Described, ParameterError
from aioduco.kinematics.measured import bound, rigid_frames
from aioduco.models.pose import Pose, PoseLike
from aioduco.models.rules import Number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.models.rotation import Array


_LIMIT = Number(0.0, unit="m", open_low=True, source="this package")
_MIN_TOUCHES = 4  # three determine the tip, and the fourth verifies it
_MIN_TURN = 0.2  # smallest root mean square of how far the touches turn the tool [rad]
_MIN_DISTANCE = 0.01  # of the points of the axes from the tip, and from the first axis [m]


class ToolTip(NamedTuple):
    """Tip of a tool, how well the touches agree on it, and how sure it is.

    Attributes:
        tip: the tip in the flange's frame [m]. Shape (3,).
        point: the touched point in the base frame [m]. Shape (3,).
        distances: for each touch, the distance of the tip from the point [m].
        spread: standard deviation of a touch along each axis, from how they disagree [m].
        uncertainty: how far the tip may be from the true one; in 95 of 100 calibrations it is not
            further [m]. Errors that all touches share, such as wrong lengths of the arm, are not
            in it.
    """

    tip: Array
    point: Array
    distances: tuple[float, ...]
    spread: float
    uncertainty: float


class ToolAxes(NamedTuple):
    """Frame of a tool, and how sure its axes are.

    Attributes:
        frame: the tool in the flange's frame [m, rad], as `set_tool_data` takes it.
        uncertainty: by how much the z axis, and the rotation about it, may be off; in 95 of 100
            calibrations they are not further off [rad].
    """

    frame: Pose
    uncertainty: tuple[float, float]


def calibrate_tool_tip(
    flanges: Sequence[PoseLike | Array] | Array, *, limit: float = 0.002
) -> ToolTip:
    """Compute the tip of a tool from touches of one fixed point.

    Touch it six times or more: upright, tilted by 30 to 60 degrees to at least three sides, and
    turned about the tool's own axis in between.

    Args:
        flanges: for each touch, the flange in the base frame, such as
            `await robot.state.get_flange_pose()` or `arm.fkine(q)`: poses [m, rad], or matrices of
            shape (4, 4).
        limit: largest allowed distance of the tip from the point in a touch [m].

    Returns:
        The tip, how well the touches agree on it, and how sure it is.

    Raises:
        ParameterError: an argument has a wrong shape or value, or there are fewer than four
            touches.
        CalibrationError: the touches turn the tool too little, or about one axis alone, or disagree
            by more than `limit`.
    """
    hands = rigid_frames("flanges", flanges, "touch")
    count = len(hands)
    if count < _MIN_TOUCHES:
        raise ParameterError("flanges", Described(f"{count} touches"), f"{_MIN_TOUCHES} or more")
    limit = _LIMIT("limit", limit)
    turns, places = hands[:, :3, :3], hands[:, :3, 3]
    _check_turns(turns)
    rows = np.hstack([turns.reshape(-1, 3), np.tile(-np.eye(3), (count, 1))])
    inverse: Array = np.linalg.inv(rows.T @ rows).astype(np.float64)
    found = -inverse @ rows.T @ places.ravel()
    errors = (rows @ found + places.ravel()).reshape(-1, 3)
    distances = np.linalg.norm(errors, axis=1)
    if distances.max() > limit:
        raise CalibrationError(
            f"the touches disagree on where the tip is: in touch {int(distances.argmax()) + 1} it "
            f"is {distances.max() * 1e3:.2f} mm from the point, at most {limit * 1e3:g} mm are "
            "allowed. Touch again without moving the point, and leave out the touch that slipped"
        )
    freedoms = 3 * count - 6
    spread = float(np.sqrt((errors**2).sum() / freedoms))
    return ToolTip(
        found[:3],
        found[3:],
        tuple(distances.tolist()),
        spread,
        bound(spread**2 * inverse[:3, :3], freedoms),
    )


def calibrate_tool_axes(
    tip: ToolTip, ahead: PoseLike | Array, beside: PoseLike | Array
) -> ToolAxes:
    """Compute the axes of a tool from two more positions of it at the point that was touched.

    First draw the tool back from the point, straight along its axis: the point is then ahead of the
    tip, on the tool's z axis. Then also shift it aside, so that the point is on the side to which
    the tool's x axis shall point. 50 mm or more each are good: the axes are as sure as a touch,
    divided by these distances.

    Args:
        tip: the calibrated tip.
        ahead: the flange in the base frame with the point on the tool's z axis [m, rad]: a pose, or
            a matrix of shape (4, 4).
        beside: the same with the point on the side of the x axis, at any height.

    Returns:
        The tool's frame, and how sure its axes are.

    Raises:
        ParameterError: an argument has a wrong shape or value.
        CalibrationError: the point is less than 10 mm ahead of the tip, or less than 10 mm beside
            the z axis.
    """
    hands = rigid_frames("flanges", [ahead, beside], "position")
    turns, places = hands[:, :3, :3], hands[:, :3, 3]
    # the point as the flange sees it, from the tip
    seen = np.einsum("nji,nj->ni", turns, tip.point - places) - tip.tip
    far = float(np.linalg.norm(seen[0]))
    if far < _MIN_DISTANCE:
        raise CalibrationError(
            f"the tip was drawn back by only {far * 1e3:.1f} mm: draw the tool back along its axis "
            "by 50 mm or more"
        )
    z = seen[0] / far
    aside = seen[1] - (seen[1] @ z) * z
    wide = float(np.linalg.norm(aside))
    if wide < _MIN_DISTANCE:
        raise CalibrationError(
            f"the point is only {wide * 1e3:.1f} mm beside the tool's axis: shift the tool aside "
            "by 50 mm or more"
        )
    x = aside / wide
    rotation = np.column_stack([x, np.cross(z, x), z])
    frame = Pose.from_rotation(tip.tip, rotation)
    freedoms = 3 * len(tip.distances) - 6
    # Tip and point are uncertain, and each position is as exact as a touch.
    off = float(
        np.hypot(tip.uncertainty * np.sqrt(2.0), bound(tip.spread**2 * np.eye(2), freedoms))
    )
    tilted = off / far
    return ToolAxes(frame, (tilted, float(np.hypot(off, tilted * (seen[1] @ z)) / wide)))


def _check_turns(turns: Array) -> None:
    """Refuse touches whose rotations do not determine the tip."""
    around = turns - turns.mean(axis=0)
    sizes = np.linalg.svd(around.reshape(-1, 3), compute_uv=False) / np.sqrt(len(turns))
    if sizes[2] >= _MIN_TURN:
        return
    if sizes[1] < _MIN_TURN:
        raise CalibrationError(
            "the touches hardly turn the tool, so that they say nothing about its tip: tilt it by "
            "30 degrees or more to at least three sides, and turn it about its own axis"
        )
    raise CalibrationError(
        "the touches turn the tool about one axis alone, along which the tip can be anywhere: tilt "
        "it about another axis, too"
    )
