"""What a recording says about an arm, as arrays: poses at rest, motions, calls, states, torques.

This is the only module here that reads files. Times are seconds since the recording began.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from aioduco.errors import RecordingError
from aioduco.models.enums import RobotState
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, matrix_from_rotvec, rotvec_from_matrix, transform
from aioduco.recording.run import RecordedRun, of_any_maker, read

if TYPE_CHECKING:
    import os
    from collections.abc import Iterator, Sequence


#: joints read before and after a pose may differ by this, else the arm moved [rad]
_SAME: Final = 2e-4
#: time between the reads of joints and of a pose that belong together [s]
_TOGETHER: Final = 0.5
#: change of a joint that makes another stop [rad]
_STOPS: Final = 5e-3
_JOINTS, _TORQUE = "get_actual_joints_position", "get_actual_joints_torque"
_FLANGE, _TIP, _OFFSET = "get_flange_pose", "get_tcp_pose", "get_tcp_offset"
_MOVES: Final = {"movej2": "joint", "movel": "line"}
_POWER: Final = ("power_on", "enable", "disable", "power_off")


class Poses(NamedTuple):
    """Joints and poses that a controller reported while the arm stood, one of each stop.

    Several reads of one stop are averaged: their rounding is the same, so that they are not
    independent.

    Attributes:
        joints: joint angles [rad]. Shape (n, 6).
        poses: poses in the base frame. Shape (n, 4, 4).
        tip: whether they are those of a tool's tip with an unknown offset, not of the flange.
    """

    joints: Array
    poses: Array
    tip: bool = False


class Motions(NamedTuple):
    """Samples of set-points and joints, each pair of one instant.

    Attributes:
        time: times [s]. Shape (n,).
        wanted, wanted_speed: set-points [rad], [rad/s]. Shape (n, 6).
        joints, speed: actual joints [rad], [rad/s]. Shape (n, 6).
    """

    time: Array
    wanted: Array
    wanted_speed: Array
    joints: Array
    speed: Array


class Reads(NamedTuple):
    """Answers to one function that reads six numbers.

    Attributes:
        begin, end: times between which the controller answered [s]. Shape (n,).
        values: the answers. Shape (n, 6).
    """

    begin: Array
    end: Array
    values: Array


class TimedCall(NamedTuple):
    """A call that changes the robot's state, between two times [s]."""

    name: str
    begin: float
    end: float


class StateRead(NamedTuple):
    """The robot's state, as it was at some time between two times [s]."""

    begin: float
    end: float
    state: RobotState


class Corner(NamedTuple):
    """Two joint moves or two lines in a row, of one speed, the first with a blend radius.

    Attributes:
        kind: "joint" or "line".
        begin, end: when the first was sent, and the motion after the second [s].
        place: target of the first: joints [rad], or the tip in the base frame [m].
        after: target of the second.
        radius: the blend radius [m].
        speed, acceleration: of both [rad/s, rad/s²], or [m/s, m/s²].
    """

    kind: str
    begin: float
    end: float
    place: Array
    after: Array
    radius: float
    speed: float
    acceleration: float


@dataclass(frozen=True)
class Evidence:
    """What one recording says.

    Attributes:
        name: the recording's name.
        arm: series and model that the controller reported; empty if it did not.
        poses, motions, joints, torques: see the classes; empty if the recording has none.
        calls, states: calls that change the robot's state, and the states that were read.
        beats: heartbeats, with the time that each announced [s].
        corners: motions that may have blended.
        tool: tip of the tool in the flange's frame, if it was one throughout. Shape (4, 4).
    """

    name: str
    arm: str
    poses: Poses
    motions: Motions
    joints: Reads
    torques: Reads
    calls: tuple[TimedCall, ...]
    states: tuple[StateRead, ...]
    beats: tuple[tuple[TimedCall, float], ...] = ()
    corners: tuple[Corner, ...] = ()
    tool: Array | None = None

    def says_the_same(self, other: Evidence) -> bool:
        """Whether the other one is of the same recording, as a copy with an index is."""
        pairs = (
            (self.motions.time, other.motions.time),
            (self.joints.begin, other.joints.begin),
            (self.poses.joints, other.poses.joints),
        )
        some = any(len(one) for one, _ in pairs)
        return some and all(np.array_equal(one, two) for one, two in pairs)


class _Call(NamedTuple):
    function: str
    begin: float
    end: float
    result: Any
    arguments: list[Any]


@of_any_maker
def read_evidence(path: str | os.PathLike[str]) -> Evidence:
    """Read what a recording says about its arm.

    Raises:
        RecordingError: the file cannot be read, or has no samples of joints or calls.
        MissingExtra: the extra `record` is not installed.
    """
    run = read(path)
    calls = [] if "/commands" not in run.topics else list(_calls(run))
    motions = _motions(run)
    if not calls and not len(motions.time):
        raise RecordingError(
            f"{Path(path).name} has neither joints nor calls: record the arm with "
            "`aioduco check --motions`"
        )
    return Evidence(
        Path(path).name,
        run.metadata.get("arm", ""),
        _poses(calls),
        motions,
        _reads(calls, _JOINTS),
        _reads(calls, _TORQUE),
        tuple(TimedCall(c.function, c.begin, c.end) for c in calls if c.function in _POWER),
        tuple(_states(run, calls, motions.time)),
        tuple(_beats(calls)),
        tuple(_corners(calls)),
        _tool(calls),
    )


def _calls(run: RecordedRun) -> Iterator[_Call]:
    for message in run.messages("/commands"):
        data = message.data
        if not data.get("error"):
            duration = float(data.get("duration") or 0.0)
            yield _Call(
                str(data.get("function")),
                message.time,
                message.time + duration,
                data.get("result"),
                list(data.get("arguments") or ()),
            )


def _beats(calls: Sequence[_Call]) -> Iterator[tuple[TimedCall, float]]:
    for call in calls:
        if call.function == "rpc_heartbeat" and call.arguments:
            with suppress(TypeError, ValueError):
                milliseconds = float(call.arguments[0])
                yield TimedCall(call.function, call.begin, call.end), milliseconds / 1000.0


def _tool(calls: Sequence[_Call]) -> Array | None:
    offsets = [v for c in calls if c.function == _OFFSET and (v := _six(c.result)) is not None]
    if not offsets or any(np.abs(each - offsets[0]).max() > 1e-9 for each in offsets):
        return None
    return Pose.of(offsets[0]).matrix


def _corners(calls: Sequence[_Call]) -> Iterator[Corner]:
    moves = [call for call in calls if call.function in _MOVES]
    after = [*(call.begin for call in moves[2:]), float("inf")]
    for first, second, end in zip(moves, moves[1:], after, strict=False):
        one, two = _move(first), _move(second)
        if one is None or two is None or first.function != second.function:
            continue
        (place, v, a, r), (target, *pace) = one, two
        if r > 0.0 and [v, a] == pace[:2]:
            yield Corner(_MOVES[first.function], first.begin, end, place, target, r, v, a)


def _move(call: _Call) -> tuple[Array, float, float, float] | None:
    """Target, speed, acceleration and blend radius of a motion."""
    try:
        target, v, a, r, *others = call.arguments
        found, numbers = _six(target), (float(v), float(a), float(r))
    except (TypeError, ValueError):
        return None
    # A line may name a tool and a work object; the last argument lets the controller choose `a`.
    if (
        found is None
        or not others
        or others[-1] is True
        or any(others[1:3] if len(others) > 3 else ())
    ):
        return None
    return (found if call.function == "movej2" else found[:3], *numbers)


def _six(value: Any) -> Array | None:
    try:
        numbers = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return None
    return numbers if numbers.shape == (6,) and np.isfinite(numbers).all() else None


def _reads(calls: Sequence[_Call], function: str) -> Reads:
    found = [
        (call.begin, call.end, value)
        for call in calls
        if call.function == function and (value := _six(call.result)) is not None
    ]
    if not found:
        return Reads(np.zeros(0), np.zeros(0), np.zeros((0, 6)))
    begin, end, values = zip(*found, strict=True)
    return Reads(np.array(begin), np.array(end), np.array(values))


def _poses(calls: Sequence[_Call]) -> Poses:
    joints = _reads(calls, _JOINTS)
    # The flange if it was read; else the tip with its offset, if that was one throughout.
    flange = _reads(calls, _FLANGE)
    told, tip = flange, False
    back: Array = np.eye(4)
    if not len(flange.begin):
        told, tool = _reads(calls, _TIP), _tool(calls)
        tip = tool is None
        if tool is not None:
            back = np.asarray(np.linalg.inv(tool), dtype=np.float64)
    qs, poses = [], []
    for begin, end, value in zip(*told, strict=True):
        before = np.flatnonzero(joints.end <= begin)
        after = np.flatnonzero(joints.begin >= end)
        if not len(before) or not len(after):
            continue
        one, two = before[-1], after[0]
        if begin - joints.end[one] > _TOGETHER or joints.begin[two] - end > _TOGETHER:
            continue
        if np.abs(joints.values[one] - joints.values[two]).max() > _SAME:
            continue
        qs.append(0.5 * (joints.values[one] + joints.values[two]))
        poses.append(Pose.of(value).matrix @ back)
    if not qs:
        return Poses(np.zeros((0, 6)), np.zeros((0, 4, 4)), tip)
    moved = np.abs(np.diff(np.array(qs), axis=0)).max(axis=1) > _STOPS
    stops = np.split(np.arange(len(qs)), np.flatnonzero(moved) + 1)
    return Poses(
        np.array([np.mean([qs[i] for i in stop], axis=0) for stop in stops]),
        np.array([_mean_pose(np.array([poses[i] for i in stop])) for stop in stops]),
        tip,
    )


def _mean_pose(poses: Array) -> Array:
    turns = rotvec_from_matrix(poses[:, :3, :3] @ poses[0, :3, :3].T)
    turn = matrix_from_rotvec(turns.mean(axis=0)) @ poses[0, :3, :3]
    return transform(turn, poses[:, :3, 3].mean(axis=0))


def _motions(run: RecordedRun) -> Motions:
    empty = np.zeros((0, 6))
    if not {"/joint_states", "/joint_setpoints"} <= run.topics.keys():
        return Motions(np.zeros(0), empty, empty, empty, empty)
    actual, wanted = run.arrays("/joint_states"), run.arrays("/joint_setpoints")
    # Both are written from one answer of the controller, with one time.
    times, one, two = np.intersect1d(actual["time"], wanted["time"], return_indices=True)
    columns = (
        *(wanted["position"][two], wanted["velocity"][two]),
        *(actual["position"][one], actual["velocity"][one]),
    )
    kept = np.isfinite(np.concatenate(columns, axis=1)).all(axis=1)
    return Motions(times[kept], *(column[kept] for column in columns))


def _states(run: RecordedRun, calls: Sequence[_Call], samples: Array) -> Iterator[StateRead]:
    for call in calls:
        if call.function == "get_robot_state" and isinstance(call.result, list) and call.result:
            state = _state(call.result[0])
            if state is not None:
                yield StateRead(call.begin, call.end, state)
    if "/state" not in run.topics or len(samples) < 2:
        return
    # It is written when it changes; every sample until then has the state before.
    last: RobotState | None = None
    for message in run.messages("/state"):
        state = _state(message.data.get("robot"))
        at = int(np.searchsorted(samples, message.time - 1e-6))
        if state is None or not 2 <= at < len(samples):
            last = state
            continue
        if last is not None and state is not last:
            # A sample was asked for after the one before it had come.
            yield StateRead(float(samples[at - 2]), float(samples[at - 1]), last)
            yield StateRead(float(samples[at - 1]), float(samples[at]), state)
        last = state


def _state(value: Any) -> RobotState | None:
    try:
        return RobotState[value] if isinstance(value, str) else RobotState(int(value))
    except (KeyError, ValueError, TypeError):
        return None
