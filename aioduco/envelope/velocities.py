"""The paths of motions at a velocity and of jogs, until a stop can have taken effect.

Such a motion may run on for any time, and is stopped by the watch of the state before it crosses a
limit. So it is checked as far as the arm gets before that stop can have an effect: at the full
velocity at once, for the time within which the watch reacts, and the braking distance after it.
A step of a jog is checked as a whole.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.envelope.checker import STOPPING
from aioduco.envelope.ways import Start, Way, joint_way, line_way
from aioduco.kinematics.forward import jacobian
from aioduco.models.jog import JogFrame
from aioduco.models.rotation import Array, matrix_from_rotvec

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.kinematics import Arm


VELOCITIES = ("speedj", "speedl", "move_jog")
#: speeds of a jog at 100 %: of a joint, of the tool and of its turning. The manual does not say;
#: assumed of the order of the reduced speed of ISO 10218 [rad/s, m/s, rad/s]
_JOG_JOINT, _JOG_LINE, _JOG_TURN = 0.5, 0.25, 0.5
_STEP, _TURN = 0.02, 0.05  # largest step and turn between two positions of a path [m, rad]
_MOST = 1000  # largest number of steps


class Ahead(NamedTuple):
    """A motion at a velocity, as the program asks for it.

    Attributes:
        name: the function of the wire, of `VELOCITIES`.
        args: its arguments.
        sense: direction of a jog, 1 or -1: the number on the wire depends on the controller.
    """

    name: str
    args: tuple[Any, ...]
    sense: int

    @property
    def stands(self) -> bool:
        """Whether the velocity is zero, which moves nothing and may end a motion."""
        return self.name != "move_jog" and not any(self.args[0])


class _Twist(NamedTuple):
    """A velocity of the tool [m/s, rad/s], along and about its axes or those of the base."""

    values: Array
    of_tool: bool


def is_step(name: str, args: Sequence[Any]) -> bool:
    """Whether a motion is a step of a jog, which ends by itself."""
    return name == "move_jog" and bool(args[0].use_step)


def velocity_way(arm: Arm, motion: Ahead, start: Start, reaction: float) -> Way | None:
    """The path of a motion at a velocity until a stop can have taken effect; a step's whole path.

    Args:
        arm: the arm.
        motion: the motion.
        start: position of the arm, the tool and the work object in use.
        reaction: time within which the watch of the state brings a stop to the controller [s].

    Returns:
        The path; None if its direction is not known.
    """
    name, args, _ = motion
    seconds = reaction
    if name != "move_jog" and args[2] >= 0:
        seconds = min(seconds, args[2] / 1000)  # the controller ends it
    jog = args[0] if name == "move_jog" else None
    if name == "speedj" or (jog is not None and jog.jog_type != 1):
        speeds = _joint_speeds(motion)
        v = float(np.abs(speeds).max())
        seconds += v / STOPPING / 2
        if jog is not None and jog.use_step:
            seconds = jog.step_jointValue / v
        end = np.array(start.joints) + seconds * speeds
        return joint_way(start.joints, tuple(end.tolist()), v)
    twist = _twist(motion, start)
    if twist is None:
        return None
    here = arm.fkine(start.joints) @ start.tool.matrix
    length, turn = (float(np.linalg.norm(each)) for each in (twist.values[:3], twist.values[3:]))
    if jog is not None and jog.use_step:
        seconds = jog.step_cartvalue / (length or turn)
    else:
        seconds += _fastest_joint(arm, start, here, twist) / STOPPING / 2
    poses = _poses(here, twist, seconds)
    count = max(1, math.ceil(max(seconds * length / _STEP, seconds * turn / _TURN)))
    return line_way(poses, min(count, _MOST), length, start.joints)


def slower_velocity(motion: Ahead, share: float) -> tuple[Any, ...]:
    """The arguments of a motion at a velocity, with its speed multiplied by `share`."""
    first, *others = motion.args
    if motion.name == "move_jog":
        return (replace(first, vel=first.vel * share), *others)
    return ([share * value for value in first], *others)


def _joint_speeds(motion: Ahead) -> Array:
    if motion.name == "speedj":
        return np.array(motion.args[0], dtype=np.float64)
    jog = motion.args[0]
    speeds = np.zeros(6)
    speeds[jog.axis_num] = motion.sense * jog.vel / 100 * _JOG_JOINT
    return speeds


def _twist(motion: Ahead, start: Start) -> _Twist | None:
    """The velocity of the tool; None if the frame of a jog is not known."""
    if motion.name == "speedl":
        return _Twist(np.array(motion.args[0], dtype=np.float64), of_tool=True)
    jog = motion.args[0]
    values = np.zeros(6)
    top = _JOG_LINE if jog.axis_num < 3 else _JOG_TURN
    values[jog.axis_num] = motion.sense * jog.vel / 100 * top
    if jog.jog_coordinate == JogFrame.TOOL:
        return _Twist(values, of_tool=True)
    if jog.jog_coordinate == JogFrame.WORK_OBJECT:
        return _Twist(_turned(start.wobj.matrix, values), of_tool=False)
    if jog.jog_coordinate == JogFrame.BASE:
        return _Twist(values, of_tool=False)
    return None  # the world's: it depends on how the arm is mounted


def _turned(frame: Array, twist: Array) -> Array:
    return np.concatenate([frame[:3, :3] @ twist[:3], frame[:3, :3] @ twist[3:]])


def _fastest_joint(arm: Arm, start: Start, here: Array, twist: _Twist) -> float:
    """Speed of the fastest joint while the tool moves at a velocity [rad/s]."""
    along = _turned(here, twist.values) if twist.of_tool else twist.values.copy()
    flange = arm.fkine(start.joints)
    along[:3] -= np.cross(along[3:], here[:3, 3] - flange[:3, 3])
    # Near a singularity the solution has no bound, but no joint is faster than it can turn.
    speeds = np.linalg.lstsq(jacobian(arm.geometry, np.array(start.joints)), along, rcond=None)[0]
    return min(float(np.abs(speeds).max()), max(arm.velocity))


def _poses(here: Array, twist: _Twist, seconds: float) -> Any:
    """Function that returns poses of the tip at shares of the path."""
    along, about = twist.values[:3] * seconds, twist.values[3:] * seconds

    def poses(shares: Sequence[float]) -> Array:
        found = np.tile(np.eye(4), (len(shares), 1, 1))
        turns = matrix_from_rotvec(np.outer(shares, about))
        if not twist.of_tool:
            found[:, :3, :3] = turns @ here[:3, :3]
            found[:, :3, 3] = here[:3, 3] + np.outer(shares, along)
            return found
        found[:, :3, :3] = here[:3, :3] @ turns
        shifts = np.array([_shift(share * about) @ (share * along) for share in shares])
        found[:, :3, 3] = here[:3, 3] + shifts @ here[:3, :3].T
        return found

    return poses


def _shift(turn: Array) -> Array:
    """The mean rotation on a turn at a constant rate (the left Jacobian of SO(3)). Shape (3, 3)."""
    angle = float(np.linalg.norm(turn))
    x, y, z = turn
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-6:
        return np.eye(3) + cross / 2
    one = (1 - math.cos(angle)) / angle**2
    two = (angle - math.sin(angle)) / angle**3
    shift: Array = np.eye(3) + one * cross + two * cross @ cross
    return shift
